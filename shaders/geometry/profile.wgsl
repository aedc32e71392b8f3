// Functions that the profiles share: distance and off-axis angle of four cells, logarithm; twin of src/geometry/profile.rs.
//
// They use only + − × ÷ and sqrt, with polynomials for the angle and the logarithm, so that backends agree to a few ULP.
// The polynomials follow Estrin's scheme (1960), whose chain of dependent operations is half as long as Horner's.

struct Polar {
    // Distance from the sensor, metres.
    distance: vec4<f32>,
    // Off-axis angle over β; 0 for a narrow beam.
    turn: vec4<f32>,
}

// Whether a reading of the batch has a β of more than 22.5°. It is an override because software adapters run both sides of a branch.
override BROAD_BEAMS: bool = true;

// The bits of 1.0. A plane of numbers that start at 1 stores their bits ⊕ ONE_BITS, so that an untouched map is all zeros.
const ONE_BITS: u32 = 0x3f800000u;

// Decodes numbers that start at 1 from the words of their plane.
fn from_one(words: vec4<u32>) -> vec4<f32> {
    return bitcast<vec4<f32>>(words ^ vec4<u32>(ONE_BITS));
}

// Encodes numbers that start at 1 as words of their plane: the inverse of from_one.
fn to_one(numbers: vec4<f32>) -> vec4<u32> {
    return bitcast<vec4<u32>>(numbers) ^ vec4<u32>(ONE_BITS);
}

fn polar(cone: Cone, row: Row) -> Polar {
    let d = sqrt(row.d2);
    return Polar(d * frame.scale, turn(cone, row, d));
}

// θ/β, where d is the distance in units. Neither formula suffers from cancellation, and each takes one division.
fn turn(cone: Cone, row: Row, d: vec4<f32>) -> vec4<f32> {
    if cone.shape.y == 0.0 {
        return vec4<f32>(0.0);
    }
    if BROAD_BEAMS && (cone.flags & BROAD) != 0u {
        // tan(θ/2) = |a × v| / (|a||v| + a·v).
        let t = row.across / max(d * cone.shape.x + row.along, vec4<f32>(1.0));
        return t * cone.shape.y * half_angle(t * t);
    }
    // tan θ = |a × v| / a·v does not depend on the square root.
    let t = row.across / max(row.along, vec4<f32>(1.0));
    return t * cone.shape.y * angle(t * t);
}

// θ / tan θ from w = tan²θ, θ ≤ 22.5°.
fn angle(w: vec4<f32>) -> vec4<f32> {
    let w2 = w * w;
    return (w * -0.33332935 + 1.0) + w2 * ((w * -0.13870692 + 0.19977112) + w2 * 0.080295846);
}

// θ / tan(θ/2) from w = tan²(θ/2), θ ≤ 60°. It leaves f32's range far behind a beam, where no cell is a member.
fn half_angle(w: vec4<f32>) -> vec4<f32> {
    let w2 = w * w;
    let low = (w * -0.66666585 + 2.0) + w2 * (w * -0.28493902 + 0.39995855);
    let high = (w * -0.14749677 + 0.21517274) + w2 * 0.06218354;
    return low + (w2 * w2) * high;
}

// The natural logarithm of positive normal numbers.
fn log_4(x: vec4<f32>) -> vec4<f32> {
    // x = m·2^e with m in [√½, √2).
    let bits = bitcast<vec4<i32>>(x);
    let e = (bits - 0x3f3504f3) >> vec4<u32>(23u);
    let m = bitcast<vec4<f32>>(bits - (e << vec4<u32>(23u)));
    let t = (m - 1.0) / (m + 1.0);
    let w = t * t;
    return vec4<f32>(e) * 0.6931472 + t * ((0.6666682 * w + 2.0) + (w * w) * (0.29925594 * w + 0.399748));
}

// Murphy's (R − d)/R + (β − θ)/β (2000, expressions 11.1 and 11.2), not yet halved. R is the sensor's maximum range.
fn murphy(per_range: f32, d: vec4<f32>, turn: vec4<f32>) -> vec4<f32> {
    return (1.0 - min(d * per_range, vec4<f32>(1.0))) + max(1.0 - turn, vec4<f32>(0.0));
}
