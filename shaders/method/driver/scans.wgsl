// The bindings of the pass over scans; twin of src/kernels/bindings.rs.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> scans: array<Scan>;
@group(0) @binding(2) var<storage, read> tiles: array<Tile>;
@group(0) @binding(3) var<storage, read> entries: array<Entry>;
// The cells of a chunk, tile by tile, plane by plane, row by row.
@group(0) @binding(4) var<storage, read_write> state: array<u32>;
// The centres of the chunk's columns, then of its rows, µm from the centre of its first cell.
@group(0) @binding(6) var<storage, read> centres: array<i32>;
@group(0) @binding(7) var<storage, read> beams: array<Beam>;
