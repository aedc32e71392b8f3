// The same in 32-bit integers, a multiplication and an addition a step; twin of src/kernels/peak.rs (whole).

@group(0) @binding(0) var<storage, read> source: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> sink: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let x = vec4<i32>(i32(id.x) | 1);
    var a = x;
    var b = x + 1;
    var c = x + 2;
    var d = x + 3;
    for (var k = 0u; k < 128u; k++) {
        // each GROUP
        a = a * x + b;
        b = b * x + c;
        c = c * x + d;
        d = d * x + a;
        // end
    }
    let sum = a + b + c + d;
    if sum.x == 12345 {
        sink[0] = vec4<f32>(sum) + source[0];
    }
}
