//! Functions that the methods' profiles share: distance and off-axis angle of a row of cells, and the logarithm; twin of
//! `shaders/geometry/profile.wgsl`.
//!
//! They use only + − × ÷ and sqrt, with polynomials for the angle and the logarithm, so that backends agree to a few ULP.
//! The polynomials follow Estrin's scheme (1960), whose chain of dependent operations is half as long as Horner's.

use crate::geometry::cone::Row;
use crate::geometry::layout::{BROAD, Cone, Frame};
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, u32x16};

/// Coefficients of atan(t)/t in powers of t² for |t| ≤ tan 22.6°. The relative error is below 2.2e-8.
const TURN: [f32; 5] = [1.0, -0.333_329_35, 0.199_771_12, -0.138_706_92, 0.080_295_846];

/// Coefficients of 2·atan(t)/t in powers of t² for |t| ≤ tan 30°. The relative error is below 4e-9.
const HALF_TURN: [f32; 7] =
    [2.0, -0.666_665_85, 0.399_958_55, -0.284_939_02, 0.215_172_74, -0.147_496_77, 0.062_183_54];

/// Coefficients of 2·artanh(t)/t in powers of t² for |t| ≤ (√2 − 1)/(√2 + 1). The relative error is below 2e-9.
const LOG: [f32; 4] = [2.0, 0.666_668_2, 0.399_748, 0.299_255_94];

/// ln 2.
const LN_2: f32 = std::f32::consts::LN_2;

/// The bits of 1f32. A plane of numbers that start at 1 stores their bits ⊕ `ONE_BITS`, so that an untouched map is all zeros.
pub const ONE_BITS: u32 = 1f32.to_bits();

/// Decodes numbers that start at 1 from the words of their plane.
#[inline(always)]
pub fn from_one<S: Simd>(words: u32x16<S>) -> f32x16<S> {
    (words ^ ONE_BITS).bitcast()
}

/// Encodes numbers that start at 1 as words of their plane: the inverse of [`from_one`].
#[inline(always)]
pub fn to_one<S: Simd>(numbers: f32x16<S>) -> u32x16<S> {
    numbers.bitcast::<u32x16<S>>() ^ ONE_BITS
}

/// The distance of each cell from the sensor, metres, and its off-axis angle over β (0 for a narrow beam).
#[inline(always)]
pub fn polar<S: Simd>(frame: &Frame, cone: &Cone, row: &Row<S>) -> (f32x16<S>, f32x16<S>) {
    let d = row.d2.sqrt();
    (d * frame.scale, turn(cone, row, d))
}

/// θ/β, where `d` is the distance in units. Neither formula suffers from cancellation, and each takes one division.
#[inline(always)]
fn turn<S: Simd>(cone: &Cone, row: &Row<S>, d: f32x16<S>) -> f32x16<S> {
    if cone.shape[1] == 0.0 {
        f32x16::splat(d.token(), 0.0)
    } else if cone.flags & BROAD != 0 {
        // tan(θ/2) = |a × v| / (|a||v| + a·v).
        let t = row.across / (d * cone.shape[0] + row.along).max(1.0);
        t * cone.shape[1] * half_angle(t * t)
    } else {
        // tan θ = |a × v| / a·v does not depend on the square root.
        let t = row.across / row.along.max(1.0);
        t * cone.shape[1] * angle(t * t)
    }
}

/// θ / tan θ from w = tan²θ, θ ≤ 22.5°.
#[inline(always)]
fn angle<S: Simd>(w: f32x16<S>) -> f32x16<S> {
    let w2 = w * w;
    (w * TURN[1] + TURN[0]) + w2 * ((w * TURN[3] + TURN[2]) + w2 * TURN[4])
}

/// θ / tan(θ/2) from w = tan²(θ/2), θ ≤ 60°. It leaves f32's range far behind a beam, where no cell is a member.
#[inline(always)]
fn half_angle<S: Simd>(w: f32x16<S>) -> f32x16<S> {
    let w2 = w * w;
    let low = (w * HALF_TURN[1] + HALF_TURN[0]) + w2 * (w * HALF_TURN[3] + HALF_TURN[2]);
    let high = (w * HALF_TURN[5] + HALF_TURN[4]) + w2 * HALF_TURN[6];
    low + (w2 * w2) * high
}

/// The natural logarithm of positive normal numbers.
#[inline(always)]
pub fn log<S: Simd>(x: f32x16<S>) -> f32x16<S> {
    // x = m·2^e with m in [√½, √2).
    let bits: i32x16<S> = x.bitcast();
    let e = (bits - 0x3f35_04f3) >> 23;
    let m: f32x16<S> = (bits - (e << 23)).bitcast();
    let t = (m - 1.0) / (m + 1.0);
    let w = t * t;
    e.to_float::<f32x16<S>>() * LN_2 + t * ((w * LOG[1] + LOG[0]) + (w * w) * (w * LOG[3] + LOG[2]))
}

/// Murphy's (R − d)/R + (β − θ)/β (2000, expressions 11.1 and 11.2), not yet halved. R is the sensor's maximum range.
#[inline(always)]
pub fn murphy<S: Simd>(per_range: f32, d: f32x16<S>, turn: f32x16<S>) -> f32x16<S> {
    let one = f32x16::splat(d.token(), 1.0);
    (one - (d * per_range).min(1.0)) + (one - turn).max(0.0)
}
