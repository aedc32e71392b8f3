// The bindings of the passes over readings; twin of src/kernels/bindings.rs.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> cones: array<Cone>;
@group(0) @binding(2) var<storage, read> tiles: array<Tile>;
@group(0) @binding(3) var<storage, read> entries: array<Entry>;
// The cells of a chunk, tile by tile, plane by plane, four cells of a row in a vector.
@group(0) @binding(4) var<storage, read_write> state: array<vec4<u32>>;
// Binding 5, where a driver declares it: the parts of the sums over each reading's arc, or the readings' counts.
// The share of each reading, which one pass finds and the next one needs.
@group(0) @binding(6) var<storage, read_write> shares: array<vec4<u32>>;
