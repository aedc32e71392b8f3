//! The laser truth: hits and passes of the nearest beam of each scan; twin of `shaders/method/truth.wgsl`.
//!
//! A beam's wedge ends at the bisectors with its neighbours, so a cell takes one beam of a scan. A hit is |d − z| ≤ ¾ cell,
//! a pass is d < z − ¾ cell. They are the two counts that every method keeps, so a cell has no other state.

use super::settings::Settings;
use super::{Cost, Entry, Evidence, LayerSpec, Method, Pass, RequiredSensor, Step};
use crate::binning::snap::Footprint;
use crate::geometry::layout::{COUNT, Cone, Frame};
use crate::grid::{Class, Scale};
use crate::method::driver::{Job, Kernel, Plane, Reached, WrongInput, walk};
use crate::sensor::{Kind, Overrides, Sensor};
use fearless_simd::Simd;

/// The registry entry.
pub const ENTRY: Entry = Entry {
    name: "truth",
    source: "echogrid",
    about: "laser logs: hits and passes of each scan's nearest beam, a true map to score sonar maps against",
    wgsl: include_str!("../../shaders/method/truth.wgsl"),
    cost: Cost { flop: 0, int: 24 },
    vec4s_per_thread: 8,
    make: |settings| match settings {
        Settings::Truth => Some(Box::new(Truth)),
        _ => None,
    },
};

/// The method; it has no parameters.
#[derive(Debug, Clone, Copy)]
pub struct Truth;

const fn layer(name: &'static str, about: &'static str) -> LayerSpec {
    LayerSpec { name, about, fill: 0.0, scale: Scale::Grey { low: 0.0, high: 20.0 }, integer: true }
}

/// The layers of the method.
const LAYERS: &[LayerSpec] =
    &[layer("hits", "scans whose nearest beam ends in the cell"), layer("passes", "scans whose nearest beam passes")];

impl Kernel for Truth {
    type CellStates<S: Simd> = ();

    #[inline(always)]
    fn load<S: Simd>(_: S, _: &[Plane], _: usize) {}

    #[inline(always)]
    fn store<S: Simd>((): (), _: &mut [Plane], _: usize) {}

    #[inline(always)]
    fn fuse_cells<S: Simd>(&self, _: &Frame, _: &Cone, _: &Reached<S>, _: &[u32; 4], (): &mut ()) {}
}

impl Method for Truth {
    fn settings(&self) -> Settings {
        Settings::Truth
    }

    fn evidence(&self) -> Evidence {
        Evidence::magnitude("count: 1 pass in the interior, 1 hit on the arc")
    }

    fn planes(&self) -> usize {
        0
    }

    fn required_sensor(&self) -> Option<RequiredSensor> {
        Some(RequiredSensor { kind: Kind::Laser, reason: "takes the nearest beam of each laser scan", instead: None })
    }

    /// The laser truth trusts ranges from 5 cm to 20 m within the sensor's own limits.
    fn limit_sensor(&self, sensor: &mut Sensor, set: &Overrides) {
        if set.r_min.is_none() {
            sensor.r_min = sensor.r_min.max(0.05);
        }
        if set.r_max.is_none() {
            sensor.r_max = sensor.r_max.min(20.0);
        }
        if set.hit_range.is_none() {
            sensor.hit_range = sensor.hit_range.min(sensor.r_max);
        }
    }

    fn footprint(&self) -> Footprint {
        Footprint::Wedge
    }

    fn sweeps(&self) -> &'static [&'static [Step]] {
        &[&[Step::Pass(Pass::Fuse, COUNT)]]
    }

    fn layers(&self) -> Vec<LayerSpec> {
        LAYERS.to_vec()
    }

    fn values(&self, words: &[u32], layers: &mut [f32]) -> Class {
        let (passes, hits) = (words[0], words[1]);
        layers.copy_from_slice(&[hits as f32, passes as f32]);
        if hits + passes < 2 {
            Class::Unknown
        } else if hits >= 2 && 10 * u64::from(hits) >= 3 * (u64::from(hits) + u64::from(passes)) {
            Class::Occupied
        } else {
            Class::Empty
        }
    }

    fn combined(&self, layers: &[f32], class: Class) -> f32 {
        let hits = layers[0] / (layers[0] + layers[1]);
        match class {
            Class::Unknown => 0.0,
            Class::Occupied => 0.3 + 0.7 * hits,
            Class::Empty => hits - 1.0,
        }
    }

    fn run(&self, pass: Pass, job: &Job, state: &mut [u32]) -> Result<(), WrongInput> {
        walk(self, pass, job, state)
    }
}
