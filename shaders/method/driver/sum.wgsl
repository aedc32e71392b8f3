// The sum of each reading's parts, added in tile order to what its share holds; twin of src/kernels/cpu/mod.rs (sums).
//
// A thread a reading. Where weigh.wgsl leaves a tile's groups apart it adds them up first: down the four columns, then across.

// Whether a part is one number.
override STAGED: bool = false;

@group(0) @binding(5) var<storage, read_write> parts: array<f32>;

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
