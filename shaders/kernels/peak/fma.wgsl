// How fast the adapter multiplies and adds: a thread's sixteen chains of fused f32 operations; twin of src/kernels/peak.rs (fused).

@group(0) @binding(0) var<storage, read> source: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> sink: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let x = vec4<f32>(0.999 + f32(id.x) * 1e-9);
    let y = vec4<f32>(0.001);
    var a = x;
    var b = x + 0.1;
    var c = x + 0.2;
    var d = x + 0.3;
    for (var k = 0u; k < 128u; k++) {
        // each GROUP
        a = fma(a, x, y);
        b = fma(b, x, y);
        c = fma(c, x, y);
        d = fma(d, x, y);
        // end
    }
    let sum = a + b + c + d;
    // Never so, but no compiler knows.
    if sum.x == 12345.0 {
        sink[0] = sum + source[0];
    }
}
