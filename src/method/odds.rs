//! Log odds as a pair of products, and Murphy's likelihoods (2000, expressions 11.1 and 11.2); twin of
//! `shaders/method/odds.wgsl`.
//!
//! A cell keeps the pair of Murphy's book, not normalised: the products of the likelihoods given occupied and given empty. An
//! update is two products. The log odds are the logarithm of their ratio, taken once, on the host. The exponents of the products
//! are moved to a word of their own before they can leave f32's range.

use super::LayerSpec;
use crate::geometry::layout::Frame;
use crate::geometry::profile::{ONE_BITS, from_one, to_one};
use crate::grid::{Class, Scale};
use crate::method::driver::Plane;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, mask32x16, u32x16};

/// The largest P(s|·). A likelihood of 1 would be a certainty that no later reading could change.
pub const MOST: f32 = 0.98;

/// The bits of a number's fraction.
const MANTISSA: i32 = 0x7f_ffff;

/// The products of a row's likelihoods.
#[derive(Debug, Clone, Copy)]
pub struct CellStates<S: Simd> {
    /// Π P(s|occupied).
    pub occupied: f32x16<S>,
    /// Π P(s|empty).
    pub empty: f32x16<S>,
    /// The power of two by which `occupied` over `empty` is to be multiplied.
    pub scale: i32x16<S>,
}

/// P(s|occupied) on the arc (region I), P(s|empty) in the interior (region II), by Murphy's profile.
#[inline(always)]
pub fn likelihood<S: Simd>(frame: &Frame, near: f32x16<S>, arc: mask32x16<S>) -> f32x16<S> {
    let [[part_one, part_two, floor_one, floor_two], _] = frame.constants;
    let splat = |x: f32| f32x16::splat(near.token(), x);
    let part = arc.select(splat(part_one), splat(part_two));
    let floor = arc.select(splat(floor_one), splat(floor_two));
    (near * part).max(floor).min(MOST)
}

/// Reads a row of a tile from its planes, without those of the two counts.
#[inline(always)]
pub fn load<S: Simd>(simd: S, planes: &[Plane], row: usize) -> CellStates<S> {
    let (occupied, empty) = (u32x16::load_array(simd, planes[0][row]), u32x16::load_array(simd, planes[1][row]));
    CellStates {
        occupied: from_one(occupied),
        empty: from_one(empty),
        scale: u32x16::load_array(simd, planes[2][row]).bitcast(),
    }
}

/// Writes a row of a tile to its planes, without those of the two counts.
#[inline(always)]
pub fn store<S: Simd>(cells: CellStates<S>, planes: &mut [Plane], row: usize) {
    to_one(cells.occupied).store_array(&mut planes[0][row]);
    to_one(cells.empty).store_array(&mut planes[1][row]);
    cells.scale.bitcast::<u32x16<S>>().store_array(&mut planes[2][row]);
}

/// Brings the cells to their canonical form; it is called at least once in 16 updates.
#[inline(always)]
pub fn renormalize<S: Simd>(cells: &mut CellStates<S>) {
    let (occupied, empty) = (cells.occupied.bitcast::<i32x16<S>>(), cells.empty.bitcast::<i32x16<S>>());
    cells.scale = cells.scale + (occupied >> 23) - (empty >> 23);
    cells.occupied = ((occupied & MANTISSA) | ONE_BITS.cast_signed()).bitcast();
    cells.empty = ((empty & MANTISSA) | ONE_BITS.cast_signed()).bitcast();
}

const fn layer(name: &'static str, about: &'static str, fill: f32, scale: Scale) -> LayerSpec {
    LayerSpec { name, about, fill, scale, integer: false }
}

/// The layers of the log odds.
pub const LAYERS: &[LayerSpec] = &[
    layer("log_odds", "log odds of occupied", 0.0, Scale::Signed { limit: 6.0 }),
    layer("p_occ", "probability of occupied", 0.5, Scale::Grey { low: 0.0, high: 1.0 }),
    layer("p_emp", "probability of empty", 0.5, Scale::Grey { low: 0.0, high: 1.0 }),
];

/// The log odds of a cell from its words after the two counts.
pub fn log_odds(words: &[u32]) -> f64 {
    let [occupied, empty] = [words[0], words[1]].map(|word| f64::from(f32::from_bits(word ^ ONE_BITS)));
    (occupied / empty).ln() + f64::from(words[2].cast_signed()) * std::f64::consts::LN_2
}

/// A touched cell's layers, and its class: occupied above a probability, empty below another.
pub fn values(odds: f64, [p_occupied, p_empty]: [f64; 2], layers: &mut [f32]) -> Class {
    let p = 1.0 / (1.0 + (-odds).exp());
    layers.copy_from_slice(&[odds, p, 1.0 / (1.0 + odds.exp())].map(|v| v as f32));
    if p > p_occupied {
        Class::Occupied
    } else if p < p_empty {
        Class::Empty
    } else {
        Class::Unknown
    }
}

/// The value of a cell in the combined picture, from its layers.
pub fn combined(layers: &[f32]) -> f32 {
    layers[1] - layers[2]
}
