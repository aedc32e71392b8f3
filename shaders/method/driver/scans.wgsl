// What a pass over scans binds; twin of src/kernels/gpu/pass.rs.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> scans: array<Scan>;
@group(0) @binding(2) var<storage, read> tiles: array<Tile>;
@group(0) @binding(3) var<storage, read> entries: array<Entry>;
// A chunk's cells, tile by tile, plane by plane, row by row.
@group(0) @binding(4) var<storage, read_write> state: array<u32>;
// µm from the centre of the chunk's first cell: those of its columns, then those of its rows.
@group(0) @binding(6) var<storage, read_write> centres: array<i32>;
@group(0) @binding(7) var<storage, read> beams: array<Beam>;
