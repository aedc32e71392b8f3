//! Feature-based occupancy grid (IJCAI 2007): the weighted evidence of an update; twin of `shaders/method/features.wgsl`.
//!
//! A cell keeps a pair of products, as in `bayes`, and a sum of marks of the updates that changed it. P(occupied) is ½ plus a term
//! for each source; a source without evidence of the cell adds nothing.

use super::odds::{self, CellStates, MOST, likelihood};
use super::settings::{Features, Settings};
use super::{Cost, Entry, Evidence, Input, LayerSpec, Method, Pass, RequiredSensor, Step};
use crate::binning::snap::Snapped;
use crate::geometry::layout::{COUNT, Cone, Frame, Shapes};
use crate::geometry::profile::murphy;
use crate::grid::Class;
use crate::method::driver::{Job, WrongInput, walk_updates};
use crate::sensor::{Kind, Sensor};
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16, u32x16};

/// The registry entry.
pub const ENTRY: Entry = Entry {
    name: "features",
    source: "IJCAI 2007 (feature-based occupancy grid)",
    about: "log odds of occupied from each reading's updates, of the walls and corners it came from",
    wgsl: concat!(
        include_str!("../../shaders/method/odds.wgsl"),
        "\n",
        include_str!("../../shaders/method/features.wgsl")
    ),
    // The cost of a cell in a routine part's cone. The cost of fans and lines depends on their number.
    cost: Cost { flop: 28, int: 32 },
    vec4s_per_thread: 8,
    make: |settings| match settings {
        Settings::Features(f) => Some(Box::new(f)),
        _ => None,
    },
};

/// Index of the plane of marks, counted after the two counts.
pub const MARKS: usize = 3;

/// Bit of a cell's code: the first part occupies the cell. The bits of the second part and of the routine part follow, two
/// positions higher each.
pub const OCCUPIED: u32 = 1;
/// Bit of a cell's code: the first part frees the cell. The other sources' bits follow as for [`OCCUPIED`].
pub const FREED: u32 = 2;

/// The cells of a row that the three sources of an update (two parts and the routine part) occupy or free.
#[derive(Debug, Clone, Copy)]
pub struct Contributions<S: Simd> {
    /// Cells that each source occupies.
    pub occupied: [mask32x16<S>; 3],
    /// Cells that each source frees.
    pub freed: [mask32x16<S>; 3],
    /// Distance from the sensor, metres, and off-axis angle over β, for the cells that the routine part updates.
    pub polar: [f32x16<S>; 2],
}

/// The mark of an update's code for a cell, a number that tells it from other codes and updates.
#[inline(always)]
pub fn mark<S: Simd>(number: u32, code: u32x16<S>) -> u32x16<S> {
    let mixed = (code ^ number.wrapping_mul(0x9e37_79b1)) * 0x85eb_ca6b;
    (mixed ^ (mixed >> 15)) * 0xc2b2_ae35
}

/// The term that a source adds to ½: `weight` where it occupies, −`weight` where it frees.
#[inline(always)]
fn lean<S: Simd>(weight: f32x16<S>, occupied: mask32x16<S>, freed: mask32x16<S>) -> f32x16<S> {
    let none = f32x16::splat(weight.token(), 0.0);
    occupied.select(weight, freed.select(none - weight, none))
}

/// Updates a row's cells. With `ROUTINE` the routine part updates some of them.
#[inline(always)]
pub fn fuse_cells<S: Simd, const ROUTINE: bool>(
    simd: S,
    frame: &Frame,
    cone: &Cone,
    shapes: &Shapes,
    contributions: &Contributions<S>,
    cells: &mut CellStates<S>,
) {
    let Contributions { occupied, freed, polar: [distance, turn] } = *contributions;
    let [first, second, weight, _] = shapes.weights;
    let splat = |x: f32| f32x16::splat(simd, x);
    // The sum starts from ½, because software adapters add a constant first, wherever it is written.
    let mut sum = splat(0.5);
    if ROUTINE {
        let p = likelihood(frame, murphy(cone.profile[0], distance, turn), occupied[2]);
        sum += lean((p - 0.5) * weight, occupied[2], freed[2]);
    }
    sum = (sum + lean(splat(first), occupied[0], freed[0])) + lean(splat(second), occupied[1], freed[1]);
    let p = sum.max(1.0 - MOST).min(MOST);
    let member = occupied[0] | occupied[1] | occupied[2] | freed[0] | freed[1] | freed[2];
    cells.occupied = member.select(cells.occupied * p, cells.occupied);
    cells.empty = member.select(cells.empty * (splat(1.0) - p), cells.empty);
}

impl Method for Features {
    fn settings(&self) -> Settings {
        Settings::Features(*self)
    }

    fn input(&self, _: f64) -> Input {
        Input::Updates(self.rules)
    }

    fn required_sensor(&self) -> Option<RequiredSensor> {
        Some(RequiredSensor {
            kind: Kind::Sonar,
            reason: "tells what a sonar's readings came from",
            instead: Some("finds walls in a sonar's: map it with `method bayes`"),
        })
    }

    fn marks(&self) -> Option<usize> {
        Some(MARKS)
    }

    fn evidence(&self) -> Evidence {
        Evidence::probability("P(occupied) that the update says, its parts together")
    }

    fn planes(&self) -> usize {
        4
    }

    fn sweeps(&self) -> &'static [&'static [Step]] {
        &[&[Step::Pass(Pass::Fuse, COUNT)]]
    }

    fn rounds(&self) -> Option<super::Rounds> {
        None
    }

    fn constants(&self) -> [[f32; 4]; 2] {
        [[0.5 * self.max_occ, 0.5, 0.5, 0.5].map(|v| v as f32), [0.0; 4]]
    }

    fn profile(&self, sensor: &Sensor, _: &Snapped) -> [f32; 4] {
        [(1.0 / sensor.r_max) as f32, 0.0, 0.0, 0.0]
    }

    fn layers(&self) -> Vec<LayerSpec> {
        odds::LAYERS.to_vec()
    }

    fn values(&self, words: &[u32], layers: &mut [f32]) -> Class {
        odds::values(odds::log_odds(&words[2..]), [self.p_occupied, self.p_empty], layers)
    }

    fn combined(&self, layers: &[f32], _: Class) -> f32 {
        odds::combined(layers)
    }

    fn run(&self, _: Pass, job: &Job, state: &mut [u32]) -> Result<(), WrongInput> {
        walk_updates(job, state)
    }
}
