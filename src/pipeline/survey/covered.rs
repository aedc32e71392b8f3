//! The box that the cones of readings cover: their edges and the extreme points of their arcs. It is the default for the bounds of a
//! grid.

use crate::log::reading::Reading;
use crate::method::Spread;
use crate::sensor::Sensor;
use std::f64::consts::FRAC_PI_2;

/// A box that grows with the readings added to it: x0, y0, x1, y1, metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct CoveredBox([f64; 4]);

impl CoveredBox {
    /// The empty box.
    pub fn empty() -> CoveredBox {
        CoveredBox([f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY])
    }

    /// Its corners: x0, y0, x1, y1, metres.
    pub fn corners(self) -> [f64; 4] {
        self.0
    }

    /// Grows to the cone of a reading, up to R + ε, and to the method's `spread` around it. A narrow beam is at least a cell wide on
    /// either side of its axis.
    pub fn add(&mut self, reading: &Reading, sensor: &Sensor, resolution: f64, spread: Spread) {
        let (pose, beta) = (reading.record.pose, sensor.half_width.max(spread.half_width));
        let reach = reading.range + sensor.epsilon(resolution);
        let beside = spread.beside.max(if sensor.narrow() { resolution } else { 0.0 });
        let most = reach.max(0.0) + beside;
        if self.holds([pose.x - most, pose.y - most, pose.x + most, pose.y + most]) {
            return;
        }
        // No point of the cone is farther from its axis than the arc from the axis to an edge is long.
        let (sine, cosine) = pose.heading.sin_cos();
        let (tip, around) = ((pose.x + reach * cosine, pose.y + reach * sine), reach.max(0.0) * beta + beside);
        let (low, high) = ((pose.x.min(tip.0), pose.y.min(tip.1)), (pose.x.max(tip.0), pose.y.max(tip.1)));
        if self.holds([low.0 - around, low.1 - around, high.0 + around, high.1 + around]) {
            return;
        }
        self.grow(pose.x, pose.y, beside);
        self.grow(tip.0, tip.1, beside);
        let mut ray =
            |(sine, cosine): (f64, f64)| self.grow(pose.x + reach * cosine, pose.y + reach * sine, spread.beside);
        ray((pose.heading - beta).sin_cos());
        ray((pose.heading + beta).sin_cos());
        // Where the arc crosses a direction of the axes it goes farthest.
        let first = ((pose.heading - beta) / FRAC_PI_2).ceil() as i64;
        let last = ((pose.heading + beta) / FRAC_PI_2).floor() as i64;
        for quarter in first..=last {
            ray([(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][quarter.rem_euclid(4) as usize]);
        }
    }

    fn holds(&self, other: [f64; 4]) -> bool {
        let (a, b) = (self.0, other);
        a[0] <= b[0] && a[1] <= b[1] && a[2] >= b[2] && a[3] >= b[3]
    }

    fn grow(&mut self, x: f64, y: f64, beside: f64) {
        let [x0, y0, x1, y1] = self.0;
        self.0 = [x0.min(x - beside), y0.min(y - beside), x1.max(x + beside), y1.max(y + beside)];
    }
}
