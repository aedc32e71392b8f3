// How fast the adapter reads and writes its memory, sixteen bytes a thread; twin of src/kernels/peak.rs (cpu).

@group(0) @binding(0) var<storage, read> source: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> sink: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    for (var k = 0u; k < 8u; k++) {
        let at = id.x + k * groups.x * 64u;
        sink[at] = source[at];
    }
}
