//! A cone's outline, and whether it may touch a tile, in 64 bits; `shaders/binning/list/meets.wgsl` decides the same in 32 bits.

use crate::binning::snap::{Footprint, SLACK};
use crate::geometry::layout::*;

/// A cone's outline relative to its sensor, in units held as 64-bit integers.
pub(super) struct Shape {
    pub(super) footprint: Footprint,
    pub(super) narrow: bool,
    pub(super) low: [i64; 2],
    pub(super) high: [i64; 2],
    pub(super) inner2: i64,
    pub(super) outer2: i64,
    pub(super) outer: i64,
    pub(super) axis: [i64; 2],
    pub(super) left: [i64; 2],
    pub(super) right: [i64; 2],
}

impl Shape {
    pub(super) fn of(cone: &Cone, footprint: Footprint) -> Shape {
        let wide = |a: [i32; 2]| a.map(i64::from);
        let (axis, left, right) = (wide(cone.axis), wide(cone.left), wide(cone.right));
        let [inner, outer] = wide(cone.reach);
        // The box spans the sensor, the ends of both edges and of the axis, and the circle's extremes that lie between the edges.
        let direction = i64::from(DIRECTION);
        let between = |v: [i64; 2]| cross(left, v) <= 0 && cross(right, v) >= 0 && dot(axis, v) >= 0;
        let compass = [[direction, 0], [0, direction], [-direction, 0], [0, -direction]];
        let tips = [axis, left, right].into_iter().chain(compass.into_iter().filter(|c| between(*c)));
        let (mut low, mut high) = ([0; 2], [0; 2]);
        for tip in tips {
            for k in 0..2 {
                let v = tip[k] * outer / direction;
                low[k] = low[k].min(v);
                high[k] = high[k].max(v);
            }
        }
        let narrow = cone.flags & NARROW_BEAM != 0;
        // A direction is rounded by up to 1/8192, so a far tip is off by more than a unit.
        let slack = 2 + outer / 4096 + if narrow || footprint == Footprint::Axis { SLACK } else { 0 };
        Shape {
            footprint,
            narrow,
            low: low.map(|v| v - slack),
            high: high.map(|v| v + slack),
            inner2: inner * inner,
            outer2: outer * outer,
            outer,
            axis,
            left,
            right,
        }
    }

    /// The part of a tile column (`k` 0) or tile row (1) in its tiles' extremes. It begins at `at`, units from the sensor.
    pub(super) fn extremes(&self, k: usize, at: i64) -> Extremes {
        // The centres of the first and the last cell.
        let low = at + i64::from(CELL / 2);
        let high = low + i64::from(CELL) * (TILE as i64 - 1);
        let by = |factor: i64| if factor < 0 { [factor * high, factor * low] } else { [factor * low, factor * high] };
        // cross(a, v) = a.x·v.y − a.y·v.x; dot(a, v) = a.x·v.x + a.y·v.y.
        let cross = |a: [i64; 2]| by(if k == 0 { -a[1] } else { a[0] });
        Extremes {
            left: cross(self.left),
            right: cross(self.right),
            across: cross(self.axis),
            along: by(self.axis[k]),
            near2: 0.clamp(low, high).pow(2),
            far2: low.abs().max(high.abs()).pow(2),
        }
    }

    /// Tests the tile of this column and row: `None` if the cone can't touch it, else whether the arc may touch it, and whether all
    /// of the tile is interior.
    pub(super) fn meets(&self, column: &Extremes, row: &Extremes) -> Option<(bool, bool)> {
        let sum = |a: [i64; 2], b: [i64; 2]| [a[0] + b[0], a[1] + b[1]];
        let half = i64::from(CELL / 2);
        let (near2, far2) = (column.near2 + row.near2, column.far2 + row.far2);
        let along = sum(column.along, row.along);
        let direction = i64::from(DIRECTION);
        let in_band = |width: i64, before: i64| {
            let across = sum(column.across, row.across);
            across[0] <= width && across[1] >= -width && along[1] >= before && along[0] <= self.outer * direction
        };
        match self.footprint {
            // A cell on the axis lies within half a cell of it along the other world axis, so at most that far from it.
            Footprint::Axis => in_band(half * direction, -SLACK * direction).then_some((true, false)),
            Footprint::Cone | Footprint::Wedge => {
                let (left, right) = (sum(column.left, row.left), sum(column.right, row.right));
                let in_wedge = left[0] <= 0 && right[1] >= 0 && along[1] >= 0;
                if near2 > self.outer2 || !(in_wedge || self.narrow && in_band(half * direction, 0)) {
                    return None;
                }
                let inside = left[1] < 0 && right[0] >= 0 && along[0] >= 0 && far2 < self.inner2;
                Some((far2 >= self.inner2, inside))
            }
        }
    }
}

/// The part of a column or row of tiles in the least and the largest of a cone's products with v over a tile, and in the
/// squares of the tile's nearest and farthest distance.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Extremes {
    pub(super) left: [i64; 2],
    pub(super) right: [i64; 2],
    pub(super) across: [i64; 2],
    pub(super) along: [i64; 2],
    pub(super) near2: i64,
    pub(super) far2: i64,
}

fn cross(a: [i64; 2], v: [i64; 2]) -> i64 {
    a[0] * v[1] - a[1] * v[0]
}

fn dot(a: [i64; 2], v: [i64; 2]) -> i64 {
    a[0] * v[0] + a[1] * v[1]
}
