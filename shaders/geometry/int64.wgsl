// 64-bit integers as two u32, two's complement, (low, high): WGSL has none; twin of src/geometry/cone/wide.rs (Wide).

fn wide_from(a: i32) -> vec2<u32> {
    return vec2<u32>(bitcast<u32>(a), select(0u, 0xffffffffu, a < 0));
}

fn wide_neg(a: vec2<u32>) -> vec2<u32> {
    let low = ~a.x + 1u;
    return vec2<u32>(low, ~a.y + select(0u, 1u, low == 0u));
}

fn wide_add(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = a.x + b.x;
    return vec2<u32>(low, a.y + b.y + select(0u, 1u, low < a.x));
}

fn wide_sub(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    return wide_add(a, wide_neg(b));
}

fn wide_negative(a: vec2<u32>) -> bool {
    return bitcast<i32>(a.y) < 0;
}

fn wide_less(a: vec2<u32>, b: vec2<u32>) -> bool {
    return select(a.x < b.x, bitcast<i32>(a.y) < bitcast<i32>(b.y), a.y != b.y);
}

fn wide_abs(a: vec2<u32>) -> vec2<u32> {
    return select(a, wide_neg(a), wide_negative(a));
}

// The 64-bit product of two 32-bit integers.
fn wide_mul(a: i32, b: i32) -> vec2<u32> {
    let p = u32(abs(a));
    let q = u32(abs(b));
    let ll = (p & 0xffffu) * (q & 0xffffu);
    let lh = (p & 0xffffu) * (q >> 16u);
    let hl = (p >> 16u) * (q & 0xffffu);
    let hh = (p >> 16u) * (q >> 16u);
    let middle = (ll >> 16u) + (lh & 0xffffu) + (hl & 0xffffu);
    let product = vec2<u32>((ll & 0xffffu) | (middle << 16u), hh + (lh >> 16u) + (hl >> 16u) + (middle >> 16u));
    return select(product, wide_neg(product), (a < 0) != (b < 0));
}

fn wide_cross(a: vec2<i32>, v: vec2<i32>) -> vec2<u32> {
    return wide_sub(wide_mul(a.x, v.y), wide_mul(a.y, v.x));
}

fn wide_dot(a: vec2<i32>, v: vec2<i32>) -> vec2<u32> {
    return wide_add(wide_mul(a.x, v.x), wide_mul(a.y, v.y));
}

// Converts a magnitude to f32 with the same roundings as the CPU.
fn wide_float(a: vec2<u32>) -> f32 {
    return f32(a.y) * 4294967296.0 + f32(a.x);
}
