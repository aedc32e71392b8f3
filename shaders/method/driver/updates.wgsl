// The bindings of the pass over updates; twin of src/kernels/bindings.rs.

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> cones: array<Cone>;
@group(0) @binding(2) var<storage, read> tiles: array<Tile>;
@group(0) @binding(3) var<storage, read> entries: array<Entry>;
// The cells of a chunk, tile by tile, plane by plane, four cells of a row in a vector.
@group(0) @binding(4) var<storage, read_write> state: array<vec4<u32>>;
// The fans and lines of each update. They are not written, but the browser page has one layout for all passes, in which binding
// 6 is writable.
@group(0) @binding(6) var<storage, read_write> shapes: array<Shapes>;
// The vertices of fans and the ends of lines, units from their sensors.
@group(0) @binding(7) var<storage, read> points: array<vec2<i32>>;
