//! What the methods' profiles share: distance and off-axis angle of a row of cells, logarithms; twin of
//! `shaders/profile.wgsl`.
//!
//! Only + − × ÷ and sqrt, one polynomial for the angle and one for the logarithm, so that backends agree to a few ULP. The
//! polynomials go by Estrin's scheme (1960): their chain of dependent operations is half as long as Horner's.

use crate::cone::Row;
use crate::layout::{Cone, Frame, TILE};

/// 2·atan(t)/t in powers of t², |t| ≤ tan 30°: relative error below 4e-9.
const TURN: [f32; 7] = [2.0, -0.666_665_85, 0.399_958_55, -0.284_939_02, 0.215_172_74, -0.147_496_77, 0.062_183_54];

/// Twice artanh(t)/t in powers of t², |t| ≤ (√2 − 1)/(√2 + 1): relative error below 2e-9.
const LOG: [f32; 4] = [2.0, 0.666_668_2, 0.399_748, 0.299_255_94];

/// ln 2.
const LN_2: f32 = std::f32::consts::LN_2;

/// The larger; one instruction where `f32::max` takes three to mind NaN.
#[inline(always)]
pub fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller, likewise.
#[inline(always)]
pub fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Distance of each cell, metres, and its off-axis angle over β (0 for a laser).
#[inline(always)]
pub fn polar(frame: &Frame, cone: &Cone, row: &Row) -> ([f32; TILE], [f32; TILE]) {
    let (mut distance, mut turn) = ([0.0; TILE], [0.0; TILE]);
    for k in 0..TILE {
        let d = row.d2[k].sqrt();
        // tan(θ/2) = |a × v| / (|a||v| + a·v): no cancellation anywhere, and one division.
        let t = row.across[k] / max(cone.shape[0] * d + row.along[k], 1.0);
        distance[k] = d * frame.scale;
        turn[k] = angle(t) * cone.shape[1];
    }
    (distance, turn)
}

/// θ from tan(θ/2).
#[inline(always)]
pub fn angle(t: f32) -> f32 {
    let w = t * t;
    let w2 = w * w;
    let low = (TURN[1] * w + TURN[0]) + w2 * (TURN[3] * w + TURN[2]);
    let high = (TURN[5] * w + TURN[4]) + w2 * TURN[6];
    t * (low + (w2 * w2) * high)
}

/// Natural logarithm of a positive normal number.
#[inline(always)]
pub fn log(x: f32) -> f32 {
    // x = m·2^e with m in [√½, √2).
    let bits = x.to_bits() as i32;
    let e = (bits - 0x3f35_04f3) >> 23;
    let m = f32::from_bits((bits - (e << 23)) as u32);
    let t = (m - 1.0) / (m + 1.0);
    let w = t * t;
    e as f32 * LN_2 + t * ((LOG[1] * w + LOG[0]) + (w * w) * (LOG[3] * w + LOG[2]))
}

/// Murphy's ½[(R − d)/R + (β − θ)/β] (2000, expressions 11.1 and 11.2), R the sensor's maximum range.
#[inline(always)]
pub fn murphy(per_range: f32, d: f32, turn: f32) -> f32 {
    0.5 * ((1.0 - min(d * per_range, 1.0)) + max(1.0 - turn, 0.0))
}
