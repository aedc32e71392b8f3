// What the methods' profiles share: distance and off-axis angle of four cells, logarithms; twin of src/profile.rs.
//
// Only + − × ÷ and sqrt, one polynomial for the angle and one for the logarithm, so that backends agree to a few ULP. The
// polynomials go by Estrin's scheme (1960): their chain of dependent operations is half as long as Horner's.

struct Polar {
    // Metres.
    distance: vec4<f32>,
    // Off-axis angle over β; 0 for a laser.
    turn: vec4<f32>,
}

fn polar(cone: Cone, row: Row) -> Polar {
    let d = sqrt(row.d2);
    // tan(θ/2) = |a × v| / (|a||v| + a·v): no cancellation anywhere, and one division.
    let t = row.across / max(cone.shape.x * d + row.along, vec4<f32>(1.0));
    return Polar(d * frame.scale, angle(t) * cone.shape.y);
}

// θ from tan(θ/2), |t| ≤ tan 30°.
fn angle(t: vec4<f32>) -> vec4<f32> {
    let w = t * t;
    let w2 = w * w;
    let low = (-0.66666585 * w + 2.0) + w2 * (-0.28493902 * w + 0.39995855);
    let high = (-0.14749677 * w + 0.21517274) + w2 * 0.06218354;
    return t * (low + (w2 * w2) * high);
}

// Natural logarithm of positive normal numbers.
fn log_4(x: vec4<f32>) -> vec4<f32> {
    // x = m·2^e with m in [√½, √2).
    let bits = bitcast<vec4<i32>>(x);
    let e = (bits - 0x3f3504f3) >> vec4<u32>(23u);
    let m = bitcast<vec4<f32>>(bits - (e << vec4<u32>(23u)));
    let t = (m - 1.0) / (m + 1.0);
    let w = t * t;
    return vec4<f32>(e) * 0.6931472 + t * ((0.6666682 * w + 2.0) + (w * w) * (0.29925594 * w + 0.399748));
}

// Murphy's ½[(R − d)/R + (β − θ)/β] (2000, expressions 11.1 and 11.2), R the sensor's maximum range.
fn murphy(per_range: f32, d: vec4<f32>, turn: vec4<f32>) -> vec4<f32> {
    return 0.5 * ((1.0 - min(d * per_range, vec4<f32>(1.0))) + max(1.0 - turn, vec4<f32>(0.0)));
}
