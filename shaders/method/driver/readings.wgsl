// What a pass over readings binds; twin of src/kernels/gpu/pass.rs.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> cones: array<Cone>;
@group(0) @binding(2) var<storage, read> tiles: array<Tile>;
@group(0) @binding(3) var<storage, read> entries: array<Entry>;
// A chunk's cells, tile by tile, plane by plane, four cells of a row in a vector.
@group(0) @binding(4) var<storage, read_write> state: array<vec4<u32>>;
// Binding 5 is the drivers': parts of the sums over each reading's arc, or its counts.
// What a pass hands to the next, for each reading.
@group(0) @binding(6) var<storage, read_write> shares: array<vec4<u32>>;
// Where each reading's parts begin.
@group(0) @binding(7) var<storage, read> first_part: array<u32>;
