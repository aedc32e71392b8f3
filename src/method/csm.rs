//! Counting sensor models (Doherty, Shan, Wang & Englot 2019; Gan et al. 2020): a Dirichlet over classes in each cell, from
//! the beams of its nearest poses; twin of `shaders/method/csm.wgsl`.
//!
//! A cell's words count free and occupied increments, sum marks of the beams they came from, and hold the increments
//! of α: counts, or sums of the sparse kernel (Melkumyan & Ramos 2009).

mod complete;
mod layers;
mod model;

pub(crate) use layers::ALPHA;
pub use model::{CONTINUOUS, DISCRETE, SEMANTIC_CONTINUOUS, SEMANTIC_DISCRETE, reach};

use super::settings::{Csm, FreeRule};
use crate::geometry::layout::{Beam, Frame, IDLE, TILE, UNIT, YIELD};
use crate::method::driver::Plane;

/// Index of the plane of marks, counted after the two counts.
const MARKS: usize = 0;
/// k(d)/σ0 = s⁵ Σ K[n] s²ⁿ with s = 1 − d/l, of Melkumyan & Ramos 2009: in s the kernel is odd and starts with s⁵, so that no
/// digits cancel where it ends. To 32 units of rounding.
const K: [f32; 9] = [
    8.658_586,
    -16.277_489,
    13.387_694,
    -6.406_328_7,
    2.026_378,
    -0.456_719_5,
    0.076_694_27,
    -0.009_528_071,
    0.000_712_918_5,
];

/// The kernel at a distance, µm.
#[inline(always)]
pub fn kernel(frame: &Frame, d: f32) -> f32 {
    let [per_l, sigma0, ..] = frame.constants[0];
    let s = (1.0 - d * per_l).max(0.0);
    let y = s * s;
    let mut sum = K[8];
    for n in (0..8).rev() {
        sum = sum * y + K[n];
    }
    sigma0 * ((y * y * s) * sum)
}

/// A row of a tile's cells relative to one scan's pose.
pub struct Row {
    /// The x coordinate of each cell centre from the pose, µm; whole numbers.
    pub x: [f64; TILE],
    /// The y coordinate of the row's cell centres from the pose, µm; a whole number.
    pub y: f64,
    /// The squared distance of each cell from the pose, x² + y², µm².
    pub squares: [f64; TILE],
    /// 1 where the cell takes the beam, else 0.
    pub taken: [u32; TILE],
    /// Index of the row in the tile.
    pub line: usize,
}

/// The mark of a scan's beam, a number that tells it, including its label, from others.
#[inline(always)]
pub fn mark(scan: u32, id: u32) -> u32 {
    let mixed = (scan.wrapping_mul(0x9e37_79b1) ^ (id & !(IDLE | YIELD))).wrapping_mul(0x85eb_ca6b);
    (mixed ^ mixed >> 15).wrapping_mul(0xc2b2_ae35)
}

/// Updates the cells that take a beam of a scan; `planes` are the tile's.
#[inline(always)]
pub fn update(csm: &Csm, frame: &Frame, scan: u32, beam: &Beam, row: &Row, planes: &mut [Plane]) {
    if beam.id & IDLE != 0 {
        return;
    }
    if csm.continuous {
        continuous(csm, frame, scan, beam, row, planes);
    } else {
        discrete(csm, frame, scan, beam, row, planes);
    }
}

/// Computes two vectors in f64. It uses no closures, because they would be compiled without the processor's vectors.
#[inline(always)]
fn floats([[a, b], [c, d]]: [[i32; 2]; 2]) -> [[f64; 2]; 2] {
    [[f64::from(a), f64::from(b)], [f64::from(c), f64::from(d)]]
}

/// Adds to each cell of a row of a plane.
#[inline(always)]
fn add(planes: &mut [Plane], plane: usize, line: usize, values: &[u32; TILE]) {
    let words = &mut planes[plane][line];
    for k in 0..TILE {
        words[k] = words[k].wrapping_add(values[k]);
    }
}

/// Adds f32 numbers to each cell of a row of a plane; adding 0 leaves the bits as they are.
#[inline(always)]
fn add_float(planes: &mut [Plane], plane: usize, line: usize, values: &[f32; TILE]) {
    let words = &mut planes[plane][line];
    for k in 0..TILE {
        words[k] = (f32::from_bits(words[k]) + values[k]).to_bits();
    }
}

/// Marks the cells where `touched` is not 0.
#[inline(always)]
fn add_marks(planes: &mut [Plane], line: usize, mark: u32, touched: &[u32; TILE]) {
    let words = &mut planes[2 + MARKS][line];
    for k in 0..TILE {
        words[k] = words[k].wrapping_add(if touched[k] != 0 { mark } else { 0 });
    }
}

#[inline(always)]
fn discrete(csm: &Csm, frame: &Frame, scan: u32, beam: &Beam, row: &Row, planes: &mut [Plane]) {
    let line = row.line;
    let [right, left] = floats(beam.ray);
    let half = frame.limits[1];
    let (inner, outer) = (f64::from((beam.range - half).max(0)), f64::from(beam.range + half));
    let (inner, outer, label) = (inner * inner, outer * outer, beam.id & 255);
    let (mut hits, mut passes) = ([0u32; TILE], [0u32; TILE]);
    for k in 0..TILE {
        let within = (right[0] * row.y - right[1] * row.x[k] >= 0.0) & (left[0] * row.y - left[1] * row.x[k] <= 0.0);
        let before = row.squares[k] <= inner;
        passes[k] = row.taken[k] & u32::from(within & before);
        hits[k] = row.taken[k] & u32::from(within & !before & (row.squares[k] < outer) & (label > 0));
    }
    add(planes, 0, line, &passes);
    add(planes, 1, line, &hits);
    if csm.semantic && label > 0 {
        add(planes, 2 + label as usize, line, &hits);
    }
    for k in 0..TILE {
        hits[k] |= passes[k];
    }
    add_marks(planes, line, mark(scan, beam.id), &hits);
}

/// Units of a distance across a beam per µm.
const FINE: f64 = 1024.0;

/// The position of a row's cells relative to a beam.
struct Sides {
    /// Distance across the beam, in whole units of 1/1024 µm; [`FAR`] where the beam frees nothing.
    across: [f64; TILE],
    /// Distance along the beam, whole µm.
    along: [f64; TILE],
}

/// A distance across the beam that no kernel reaches.
const FAR: f64 = 1e15;

/// Adds the evidence of free space from points of the beam, `offset` µm along it from each cell, and notes the cells touched.
#[inline(always)]
fn free(
    frame: &Frame,
    sides: &Sides,
    offset: &[f64; TILE],
    planes: &mut [Plane],
    line: usize,
    touched: &mut [u32; TILE],
) {
    let reach = f64::from(frame.limits[1]);
    let (mut gains, mut near) = ([0f32; TILE], [0u32; TILE]);
    for k in 0..TILE {
        let (p, o) = (sides.across[k] as f32 * (1.0 / FINE as f32), offset[k] as f32);
        let whole = (sides.across[k] / FINE).floor();
        let frees = sides.across[k] < FAR;
        near[k] = u32::from(frees & touches(whole, offset[k], reach));
        let gain = kernel(frame, (p * p + o * o).sqrt());
        gains[k] = if frees { gain } else { 0.0 };
        touched[k] |= near[k];
    }
    add_float(planes, 3, line, &gains);
    add(planes, 0, line, &near);
}

/// Whether the kernel at this offset, µm, is more than 1e-6, so that the cell is within its reach.
#[inline(always)]
fn touches(x: f64, y: f64, reach: f64) -> bool {
    x * x + y * y < reach * reach
}

#[inline(always)]
fn continuous(csm: &Csm, frame: &Frame, scan: u32, beam: &Beam, row: &Row, planes: &mut [Plane]) {
    let line = row.line;
    let [unit, hit] = floats(beam.ray);
    let [reach, step, l] = [f64::from(frame.limits[1]), f64::from(frame.limits[2]), f64::from(frame.limits[3])];
    let (range, label, projected) = (f64::from(beam.range), beam.id & 255, csm.free == FreeRule::Projection);
    let (mut touched, mut gains, mut near) = ([0u32; TILE], [0f32; TILE], [0u32; TILE]);
    let mut sides = Sides { across: [FAR; TILE], along: [0.0; TILE] };
    let length = f64::from(UNIT);
    for k in 0..TILE {
        let along = unit[0] * row.x[k] + unit[1] * row.y;
        let takes = (row.taken[k] != 0) & !(projected & (along < 0.0));
        let (x, y) = (row.x[k] - hit[0], row.y - hit[1]);
        let hits = takes & (label > 0) & (x.abs() < l) & (y.abs() < l);
        let (p, q) = (x as f32, y as f32);
        let gain = kernel(frame, (p * p + q * q).sqrt());
        gains[k] = if hits { gain } else { 0.0 };
        near[k] = u32::from(hits & touches(x, y, reach));
        let across = ((unit[0] * row.y - unit[1] * row.x[k]).abs() * (FINE / length)).floor();
        let frees = takes & (across < l * FINE) & !(projected & (along > range * length));
        sides.across[k] = if frees { across } else { FAR };
        sides.along[k] = (along / length).floor();
        touched[k] = near[k];
    }
    if label > 0 {
        add_float(planes, 3 + label as usize, line, &gains);
        add(planes, 1, line, &near);
    }
    match csm.free {
        FreeRule::Projection => free(frame, &sides, &[0.0; TILE], planes, line, &mut touched),
        FreeRule::Clamp => {
            let mut offset = [0.0; TILE];
            for k in 0..TILE {
                offset[k] = sides.along[k] - sides.along[k].max(0.0).min((range - l).max(0.0));
                sides.across[k] = if offset[k].abs() < l { sides.across[k] } else { FAR };
            }
            free(frame, &sides, &offset, planes, line, &mut touched);
        }
        FreeRule::Sample => samples(frame, &sides, [range, step, l], planes, line, &mut touched),
    }
    add_marks(planes, line, mark(scan, beam.id), &touched);
}

/// Adds the evidence of free space from samples of the beam, from the sensor to the hit.
#[inline(always)]
fn samples(
    frame: &Frame,
    sides: &Sides,
    [range, step, l]: [f64; 3],
    planes: &mut [Plane],
    line: usize,
    touched: &mut [u32; TILE],
) {
    // Only samples near one of the cells are visited.
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..TILE {
        if sides.across[k] < FAR {
            (low, high) = (low.min(sides.along[k]), high.max(sides.along[k]));
        }
    }
    let mut at = ((low - l).max(0.0) / step).floor() * step;
    while at <= (high + l).min(range) {
        let (mut offset, mut one) = ([0.0; TILE], Sides { across: sides.across, along: sides.along });
        for k in 0..TILE {
            offset[k] = sides.along[k] - at;
            one.across[k] = if offset[k].abs() < l { one.across[k] } else { FAR };
        }
        free(frame, &one, &offset, planes, line, touched);
        at += step;
    }
}
