// The sum of each reading's parts, added in tile order to what its share holds; twin of src/kernels/cpu/mod.rs (sums).
//
// A thread a reading.

@group(0) @binding(5) var<storage, read_write> parts: array<f32>;

@compute @workgroup_size(64)
fn sum(@builtin(global_invocation_id) id: vec3<u32>) {
    let reading = id.x;
    if reading >= arrayLength(&cones) {
        return;
    }
    var sum = bitcast<f32>(shares[reading].x);
    for (var k = first_part[reading]; k < first_part[reading + 1u]; k++) {
        sum += parts[k];
    }
    shares[reading] = vec4<u32>(bitcast<u32>(sum), 0u, 0u, 0u);
}
