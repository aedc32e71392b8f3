// The sum of each reading's parts, added in tile order to the reading's share; twin of src/kernels/cpu/mod.rs (sum). What it binds is
// twin of src/kernels/bindings.rs.
//
// A thread handles one reading. Where weigh.wgsl writes a part for each vector of four cells, the parts of a tile are added first:
// down its four columns of vectors, then across.

// Whether a tile's part is one number.
override STAGED: bool = false;

@group(0) @binding(1) var<storage, read> cones: array<Cone>;
@group(0) @binding(5) var<storage, read_write> parts: array<f32>;
@group(0) @binding(6) var<storage, read_write> shares: array<vec4<u32>>;
// Index of the first part of each reading's sum.
@group(0) @binding(7) var<storage, read> first_part: array<u32>;

@compute @workgroup_size(64)
fn sum(@builtin(global_invocation_id) id: vec3<u32>) {
    let reading = id.x;
    if reading >= arrayLength(&cones) {
        return;
    }
    var sum = bitcast<f32>(shares[reading].x);
    for (var k = first_part[reading]; k < first_part[reading + 1u]; k++) {
        if STAGED {
            sum += parts[k];
        } else {
            var columns = vec4<f32>(0.0);
            for (var at = k * 64u; at < k * 64u + 64u; at += 4u) {
                columns += vec4<f32>(parts[at], parts[at + 1u], parts[at + 2u], parts[at + 3u]);
            }
            sum += (columns.x + columns.y) + (columns.z + columns.w);
        }
    }
    shares[reading] = vec4<u32>(bitcast<u32>(sum), 0u, 0u, 0u);
}
