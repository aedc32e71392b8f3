// The sum of each reading's parts, in tile order; twin of src/kernels/cpu/mod.rs (sums).
//
// A thread a reading.

@compute @workgroup_size(64)
fn sum(@builtin(global_invocation_id) id: vec3<u32>) {
    let reading = id.x;
    if reading >= arrayLength(&cones) {
        return;
    }
    var sum = 0.0;
    for (var k = first_part[reading]; k < first_part[reading + 1u]; k++) {
        sum += bitcast<f32>(atomicLoad(&parts[k]));
    }
    shares[reading] = vec4<u32>(bitcast<u32>(sum), 0u, 0u, 0u);
}
