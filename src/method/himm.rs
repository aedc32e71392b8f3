//! Histogrammic in-motion mapping (Borenstein & Koren 1991; Murphy 2000, expression 11.11); twin of
//! `shaders/method/himm.wgsl`.
//!
//! A reading updates only the cells on the acoustic axis: +3 at the hit, −1 before it, kept within 0..15. The growth-rate
//! operator (GRO) reads neighbours, so it can't be a gather: it runs on the CPU, in log order. Counts are in units of
//! 1/65536, so that GRO's halves stay exact integers on every machine.

use super::settings::{Himm, Settings};
use super::{Cost, Entry, Evidence, LayerSpec, Method, Pass, Rounds, Step};
use crate::binning::snap::Footprint;
use crate::geometry::layout::{COUNT, Cone, Frame};
use crate::grid::{Class, Scale};
use crate::method::driver::{Job, Kernel, Plane, Reached, WrongInput, walk};
use fearless_simd::prelude::*;
use fearless_simd::u32x16;

/// The registry entry.
pub const ENTRY: Entry = Entry {
    name: "himm",
    source: "Borenstein & Koren 1991; Murphy 2000",
    about: "a count from 0 to 15 on the acoustic axis: +3 at the hit, -1 before it",
    wgsl: include_str!("../../shaders/method/himm.wgsl"),
    cost: Cost { flop: 0, int: 16 },
    vec4s_per_thread: 4,
    make: |settings| match settings {
        Settings::Himm(h) => Some(Box::new(h)),
        _ => None,
    },
};

/// A count of one, in units of 1/65536.
pub const ONE: u32 = 65536;
/// The increment of a hit.
pub const HIT: u32 = 3 * ONE;
/// The largest count.
pub const MOST: u32 = 15 * ONE;

/// The layers of the method.
const LAYERS: &[LayerSpec] = &[LayerSpec {
    name: "count",
    about: "0 to 15; 3 and more is occupied",
    fill: 0.0,
    scale: Scale::Grey { low: 0.0, high: 15.0 },
    integer: false,
}];

impl Kernel for Himm {
    type CellStates<S: Simd> = u32x16<S>;

    const AXIS: bool = true;

    #[inline(always)]
    fn load<S: Simd>(simd: S, planes: &[Plane], row: usize) -> u32x16<S> {
        u32x16::load_array(simd, planes[0][row])
    }

    #[inline(always)]
    fn store<S: Simd>(cells: u32x16<S>, planes: &mut [Plane], row: usize) {
        cells.store_array(&mut planes[0][row]);
    }

    #[inline(always)]
    fn fuse_cells<S: Simd>(&self, _: &Frame, _: &Cone, row: &Reached<S>, _: &[u32; 4], cells: &mut u32x16<S>) {
        let less = cells.max(ONE) - ONE;
        let more = (*cells + HIT).min(MOST);
        *cells = row.arc.select(more, row.interior.select(less, *cells));
    }
}

impl Method for Himm {
    fn settings(&self) -> Settings {
        Settings::Himm(*self)
    }

    fn evidence(&self) -> Evidence {
        Evidence::magnitude("step of the count: -1 before the hit, +3 at it")
    }

    fn planes(&self) -> usize {
        1
    }

    fn footprint(&self) -> Footprint {
        Footprint::Axis
    }

    fn sweeps(&self) -> &'static [&'static [Step]] {
        &[&[Step::Pass(Pass::Fuse, COUNT)]]
    }

    fn rounds(&self) -> Option<Rounds> {
        if self.gro { None } else { Some(&[&[&[Step::Pass(Pass::Fuse, COUNT)]]]) }
    }

    fn layers(&self) -> Vec<LayerSpec> {
        LAYERS.to_vec()
    }

    fn values(&self, words: &[u32], layers: &mut [f32]) -> Class {
        layers[0] = words[2] as f32 / ONE as f32;
        if words[0] + words[1] == 0 {
            Class::Unknown
        } else if words[2] >= HIT {
            Class::Occupied
        } else {
            Class::Empty
        }
    }

    fn combined(&self, layers: &[f32], class: Class) -> f32 {
        if class == Class::Occupied { 0.4 + (layers[0] - 3.0) / 20.0 } else { layers[0] / 3.0 - 1.0 }
    }

    fn run(&self, pass: Pass, job: &Job, state: &mut [u32]) -> Result<(), WrongInput> {
        walk(self, pass, job, state)
    }

    fn cpu_only(&self) -> Option<&'static str> {
        self.gro.then_some("himm's growth-rate operator reads neighbouring cells in log order, which no gather can")
    }
}
