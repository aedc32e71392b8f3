//! The snapped cone: which cells a reading frees and which lie on its arc, in integers; twin of `shaders/geometry/cone.wgsl`, and of
//! `shaders/geometry/cone/narrow.wgsl` where no reading reaches far.
//!
//! Membership is exact, so it is the same on every backend. A row of a tile, 16 cells, is classified at once.

mod wide;

pub(crate) use wide::{Wide, on_axis_wide};

use crate::geometry::layout::*;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, mask32x16};
use wide::{wide_axis_cells, wide_row};

/// Distance of each column of a tile from the first one, units.
pub(crate) const STEPS: [i32; TILE] = {
    let (mut steps, mut k) = ([0; TILE], 0);
    while k < TILE {
        steps[k] = CELL * k as i32;
        k += 1;
    }
    steps
};

/// The 16 cells of a row: the region of each, and numbers of its vector v from the sensor.
#[derive(Debug, Clone, Copy)]
pub struct Row<S: Simd> {
    /// Cells in the interior, which the reading frees.
    pub interior: mask32x16<S>,
    /// Cells on the reading's arc.
    pub arc: mask32x16<S>,
    /// Squared distance from the sensor, units².
    pub d2: f32x16<S>,
    /// |cross(axis, v)|.
    pub across: f32x16<S>,
    /// dot(axis, v).
    pub along: f32x16<S>,
}

/// A number of each cell of a tile that is the sum of a part for its column and a part for its row: a product with v, or d².
#[derive(Clone, Copy)]
struct Split<S: Simd> {
    columns: i32x16<S>,
    rows: [i32; TILE],
}

impl<S: Simd> Split<S> {
    #[inline(always)]
    fn of(columns: i32x16<S>, rows: i32x16<S>) -> Self {
        Split { columns, rows: rows.to_array() }
    }

    #[inline(always)]
    fn row(&self, y: usize) -> i32x16<S> {
        self.columns + self.rows[y]
    }
}

/// The cone's edge functions over a tile: products with v, kept as sums, so that a row costs one addition for each.
#[derive(Clone, Copy)]
pub struct EdgeFunctions<S: Simd> {
    simd: S,
    v: [i32; 2],
    /// cross(left, v), cross(right, v), cross(axis, v), dot(axis, v), v·v.
    left: Split<S>,
    right: Split<S>,
    across: Split<S>,
    along: Split<S>,
    d2: Split<S>,
    inner: i32,
    outer: i32,
    left_limit: i32,
    arcs: bool,
}

impl<S: Simd> EdgeFunctions<S> {
    /// The edge functions over a tile whose first cell's centre is at `v`, units from the sensor. Without `arcs` the cone ends
    /// where its arc begins.
    #[inline(always)]
    pub fn of(simd: S, cone: &Cone, v: [i32; 2], arcs: bool) -> Self {
        let steps = i32x16::load_array(simd, STEPS);
        let (x, y) = (steps + v[0], steps + v[1]);
        let (inner, outer) = (cone.reach[0].wrapping_mul(cone.reach[0]), cone.reach[1].wrapping_mul(cone.reach[1]));
        EdgeFunctions {
            simd,
            v,
            left: Split::of(x * -cone.left[1], y * cone.left[0]),
            right: Split::of(x * -cone.right[1], y * cone.right[0]),
            across: Split::of(x * -cone.axis[1], y * cone.axis[0]),
            along: Split::of(x * cone.axis[0], y * cone.axis[1]),
            d2: Split::of(x * x, y * y),
            inner,
            outer: if arcs { outer } else { inner.wrapping_sub(1) },
            arcs,
            left_limit: -i32::from(cone.flags & HALF_OPEN != 0),
        }
    }

    /// A bit mask of the rows that the cone may touch, decided from the ends of the rows alone.
    ///
    /// The edges and the circles are convex. A row therefore has members only if an end of it lies inside each edge and its
    /// nearest point lies within reach.
    #[inline(always)]
    pub fn rows(&self, cone: &Cone, axis_only: bool) -> u32 {
        if cone.flags & WIDE != 0 {
            return 0xffff;
        }
        let simd = self.simd;
        let width = CELL * (TILE as i32 - 1);
        let (x0, x1) = (self.v[0], self.v[0] + width);
        let near = 0.clamp(x0, x1);
        // The least and the largest value of a row lie at its ends. Each is the row's part plus the part of an end's column.
        let rows = |split: &Split<S>| i32x16::load_array(simd, split.rows);
        let least = |step: i32| step * x0 + (step * width).min(0);
        let most = |step: i32| step * x0 + (step * width).max(0);
        let half = CELL / 2 * DIRECTION;
        let wedge = (rows(&self.left) + least(-cone.left[1])).simd_le(self.left_limit)
            & (rows(&self.right) + most(-cone.right[1])).simd_ge(0)
            & (rows(&self.along) + most(cone.axis[0])).simd_ge(0)
            & (rows(&self.d2) + near * near).simd_le(self.outer);
        if !axis_only && cone.flags & NARROW_BEAM == 0 {
            return wedge.to_bitmask() as u32;
        }
        let across = rows(&self.across);
        let strip = (across + least(-cone.axis[1])).simd_le(half) & (across + most(-cone.axis[1])).simd_ge(-half);
        (if axis_only { strip } else { strip | wedge }).to_bitmask() as u32
    }

    /// Classifies the cells of row `y`; without `ARCS` only the interior is found.
    #[inline(always)]
    pub fn cone_row<const ARCS: bool>(&self, cone: &Cone, y: usize) -> Row<S> {
        let (d2, across, along) = (self.d2.row(y), self.across.row(y), self.along.row(y));
        let ahead = along.simd_ge(0);
        let mut inside = self.left.row(y).simd_le(self.left_limit) & self.right.row(y).simd_ge(0) & ahead;
        if cone.flags & NARROW_BEAM != 0 {
            let band = across.abs().simd_le(CELL / 2 * DIRECTION) & along.simd_le(cone.reach[1] * DIRECTION);
            inside |= band & ahead;
        }
        let interior = inside & d2.simd_lt(self.inner);
        if !ARCS {
            return Row { interior, ..self.numbers(y) };
        }
        Row { interior, arc: inside & d2.simd_ge(self.inner) & d2.simd_le(self.outer), ..self.numbers(y) }
    }

    /// [`Self::cone_row`] in 64 bits, for a cone that reaches farther than 1024 cells.
    #[inline(always)]
    pub fn wide_row(&self, cone: &Cone, y: usize) -> Row<S> {
        let mut row = wide_row(self.simd, cone, [self.v[0], self.v[1] + CELL * y as i32]);
        row.arc &= mask32x16::splat(self.simd, self.arcs);
        row
    }

    /// A row whose cells are all interior, without a test.
    #[inline(always)]
    pub fn inside_row(&self, y: usize) -> Row<S> {
        Row { interior: mask32x16::splat(self.simd, true), ..self.numbers(y) }
    }

    /// The numbers of row `y`, with no cell in the interior or on the arc.
    #[inline(always)]
    fn numbers(&self, y: usize) -> Row<S> {
        let none = mask32x16::splat(self.simd, false);
        Row {
            interior: none,
            arc: none,
            d2: self.d2.row(y).to_float(),
            across: self.across.row(y).abs().to_float(),
            along: self.along.row(y).to_float(),
        }
    }

    /// The cone's acoustic axis in the tile.
    #[inline(always)]
    pub fn axis(&self, cone: &Cone) -> Axis<S> {
        let [x, y] = cone.axis;
        let steep = y.abs() > x.abs();
        let c = if steep { y } else { x };
        let (sign, none) = (c.signum(), i32x16::splat(self.simd, 0));
        let steps = i32x16::load_array(self.simd, STEPS);
        let along = (steps + if steep { self.v[1] } else { self.v[0] }) * sign;
        Axis {
            lead: if steep { Split::of(none, along) } else { Split::of(along, none) },
            side: if steep { -sign } else { sign },
            edge: CELL / 2 * c.abs(),
            hit: cone.reach[0].wrapping_mul(c.abs()),
            silent: cone.flags & NO_ECHO != 0,
        }
    }

    /// HIMM's row: the cells on the acoustic axis before the hit (interior) and the hit cell (arc).
    #[inline(always)]
    pub fn axis_row(&self, axis: &Axis<S>, y: usize) -> Row<S> {
        // SPEC's a·sgn(c) and (b·c − a·s)·sgn(c), which is ±cross(axis, v).
        let (lead, side) = (axis.lead.row(y), self.across.row(y) * axis.side);
        let on = lead.simd_ge(0) & side.simd_ge(-axis.edge) & side.simd_lt(axis.edge);
        let past = lead * DIRECTION - axis.hit;
        let half = CELL / 2 * DIRECTION;
        self.axis_regions(axis.silent, y, [on & past.simd_lt(-half), on & past.simd_ge(-half) & past.simd_lt(half)])
    }

    /// [`Self::axis_row`] in 64 bits.
    #[inline(always)]
    pub fn wide_axis_row(&self, cone: &Cone, y: usize) -> Row<S> {
        let [before, hit] = wide_axis_cells(cone, [self.v[0], self.v[1] + CELL * y as i32]);
        let regions = [mask32x16::from_bitmask(self.simd, before), mask32x16::from_bitmask(self.simd, hit)];
        self.axis_regions(cone.flags & NO_ECHO != 0, y, regions)
    }

    /// Builds the row of an axis; without an echo the last cell is empty too.
    #[inline(always)]
    fn axis_regions(&self, silent: bool, y: usize, [before, hit]: [mask32x16<S>; 2]) -> Row<S> {
        let silent = mask32x16::splat(self.simd, silent);
        Row { interior: before | (hit & silent), arc: hit & !silent, ..self.numbers(y) }
    }
}

/// An acoustic axis in a tile (SPEC 4). c is the axis' larger component, and a is a cell's coordinate on the same world axis.
#[derive(Clone, Copy)]
pub struct Axis<S: Simd> {
    /// a·sgn(c) of each cell.
    lead: Split<S>,
    /// Factor, ±1, that turns cross(axis, v) into (b·c − a·s)·sgn(c).
    side: i32,
    /// Limit of (b·c − a·s)·sgn(c) at half a cell beside the axis: half a cell times |c|.
    edge: i32,
    /// R·|c|.
    hit: i32,
    silent: bool,
}
