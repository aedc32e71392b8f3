//! The snapped cone: which cells a reading frees and which lie on its arc, in integers; twin of `shaders/cone.wgsl`,
//! and of `shaders/wide.wgsl` where a reading reaches far.
//!
//! Membership is exact, so it is the same on every backend. A row of a tile, 16 cells, is classified at once.

use crate::layout::*;

/// 16 cells of a row: the vector from the sensor to each centre, in integers, and each one's region.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// Freed by the reading.
    pub interior: [bool; TILE],
    /// On its arc.
    pub arc: [bool; TILE],
    /// Squared distance from the sensor, units².
    pub d2: [f32; TILE],
    /// |cross(axis, v)|.
    pub across: [f32; TILE],
    /// dot(axis, v).
    pub along: [f32; TILE],
}

/// a × v.
#[inline(always)]
fn cross(a: [i32; 2], v: [i32; 2]) -> i32 {
    a[0] * v[1] - a[1] * v[0]
}

/// a · v.
#[inline(always)]
fn dot(a: [i32; 2], v: [i32; 2]) -> i32 {
    a[0] * v[0] + a[1] * v[1]
}

/// Classifies the row of cells whose first centre lies at `v` from the sensor; `None` if no cell is a member.
#[inline(always)]
pub fn cone_row(cone: &Cone, v: [i32; 2]) -> Option<Row> {
    if cone.flags & WIDE != 0 {
        return wide_row(cone, v);
    }
    let left_limit = -i32::from(cone.flags & HALF_OPEN != 0);
    let laser = cone.flags & LASER != 0;
    let (inner, outer) = (cone.reach[0] * cone.reach[0], cone.reach[1] * cone.reach[1]);
    let mut row = Row::EMPTY;
    let mut any = false;
    for k in 0..TILE {
        let v = [v[0] + CELL * k as i32, v[1]];
        let d2 = dot(v, v);
        let (across, along) = (cross(cone.axis, v), dot(cone.axis, v));
        let wedge = (cross(cone.left, v) <= left_limit) & (cross(cone.right, v) >= 0) & (along >= 0);
        let band = laser & (across.abs() <= CELL / 2 * DIRECTION) & (along >= 0) & (along <= cone.reach[1] * DIRECTION);
        let inside = wedge | band;
        row.interior[k] = inside & (d2 < inner);
        row.arc[k] = inside & (d2 >= inner) & (d2 <= outer);
        row.d2[k] = d2 as f32;
        row.across[k] = across.abs() as f32;
        row.along[k] = along as f32;
        any |= row.interior[k] | row.arc[k];
    }
    any.then_some(row)
}

/// A row that is interior throughout: no test.
#[inline(always)]
pub fn inside_row(cone: &Cone, v: [i32; 2]) -> Row {
    if cone.flags & WIDE != 0 {
        return wide_row(cone, v).unwrap_or(Row::EMPTY);
    }
    let mut row = Row { interior: [true; TILE], ..Row::EMPTY };
    for k in 0..TILE {
        let v = [v[0] + CELL * k as i32, v[1]];
        row.d2[k] = dot(v, v) as f32;
        row.across[k] = cross(cone.axis, v).abs() as f32;
        row.along[k] = dot(cone.axis, v) as f32;
    }
    row
}

/// HIMM's row: the cells on the acoustic axis before the hit (interior) and the hit cell (arc).
#[inline(always)]
pub fn axis_row(cone: &Cone, v: [i32; 2]) -> Option<Row> {
    let mut row = Row::EMPTY;
    let mut any = false;
    for k in 0..TILE {
        let (before, hit) = if cone.flags & WIDE == 0 {
            on_axis(cone.axis, cone.reach[0], [v[0] + CELL * k as i32, v[1]])
        } else {
            on_axis_wide(cone, [v[0] + CELL * k as i32, v[1]])
        };
        // Without an echo the last cell is empty too.
        let silent = cone.flags & NO_ECHO != 0;
        row.interior[k] = before | (hit & silent);
        row.arc[k] = hit & !silent;
        any |= before | hit;
    }
    any.then_some(row)
}

/// Whether a cell lies on the axis before the hit, and whether it is the hit cell (SPEC: c is the axis' larger component).
#[inline(always)]
fn on_axis(axis: [i32; 2], range: i32, v: [i32; 2]) -> (bool, bool) {
    let steep = axis[1].abs() > axis[0].abs();
    let (c, s, a, b) = if steep { (axis[1], axis[0], v[1], v[0]) } else { (axis[0], axis[1], v[0], v[1]) };
    let sign = c.signum();
    let side = (b * c - a * s) * sign;
    let on = (a * sign >= 0) & (side >= -CELL / 2 * c.abs()) & (side < CELL / 2 * c.abs());
    let past = DIRECTION * a * sign - range * c.abs();
    let half = CELL / 2 * DIRECTION;
    (on & (past < -half), on & (past >= -half) & (past < half))
}

impl Row {
    /// No cell at all.
    pub const EMPTY: Row =
        Row { interior: [false; TILE], arc: [false; TILE], d2: [0.0; TILE], across: [0.0; TILE], along: [0.0; TILE] };

    /// Leaves out the columns that lie beyond the grid.
    #[inline(always)]
    pub fn clip(&mut self, columns: usize) {
        for k in 0..TILE {
            self.interior[k] &= k < columns;
            self.arc[k] &= k < columns;
        }
    }
}

/// A 64-bit magnitude as the kernels convert it.
#[inline(always)]
fn float(magnitude: u64) -> f32 {
    (magnitude >> 32) as u32 as f32 * 4_294_967_296.0 + magnitude as u32 as f32
}

/// [`cone_row`] in 64 bits, for readings that reach farther than 1024 cells.
#[inline(never)]
fn wide_row(cone: &Cone, v: [i32; 2]) -> Option<Row> {
    let mut row = Row::EMPTY;
    let mut any = false;
    for k in 0..TILE {
        let v = [v[0] + CELL * k as i32, v[1]];
        let at = Wide::of(cone, v);
        row.interior[k] = at.inside & (at.d2 < at.inner);
        row.arc[k] = at.inside & (at.d2 >= at.inner) & (at.d2 <= at.outer);
        row.d2[k] = float(at.d2 as u64);
        row.across[k] = float(at.across.unsigned_abs());
        row.along[k] = float(at.along.max(0) as u64);
        any |= row.interior[k] | row.arc[k];
    }
    any.then_some(row)
}

/// Membership of one cell in 64 bits; also what the host asks of single cells.
pub(crate) struct Wide {
    inside: bool,
    d2: i64,
    inner: i64,
    outer: i64,
    across: i64,
    along: i64,
}

impl Wide {
    pub(crate) fn of(cone: &Cone, v: [i32; 2]) -> Wide {
        let wide = |a: [i32; 2]| [i64::from(a[0]), i64::from(a[1])];
        let cross = |a: [i64; 2], v: [i64; 2]| a[0] * v[1] - a[1] * v[0];
        let (v, axis, reach) = (wide(v), wide(cone.axis), wide(cone.reach));
        let (across, along) = (cross(axis, v), axis[0] * v[0] + axis[1] * v[1]);
        let left_limit = -i64::from(cone.flags & HALF_OPEN != 0);
        let wedge = cross(wide(cone.left), v) <= left_limit && cross(wide(cone.right), v) >= 0 && along >= 0;
        let band = cone.flags & LASER != 0
            && across.abs() <= i64::from(CELL / 2 * DIRECTION)
            && along >= 0
            && along <= reach[1] * i64::from(DIRECTION);
        Wide {
            inside: wedge || band,
            d2: v[0] * v[0] + v[1] * v[1],
            inner: reach[0] * reach[0],
            outer: reach[1] * reach[1],
            across,
            along,
        }
    }

    /// (interior, arc).
    pub(crate) fn regions(&self) -> (bool, bool) {
        (self.inside && self.d2 < self.inner, self.inside && self.d2 >= self.inner && self.d2 <= self.outer)
    }
}

/// [`on_axis`] in 64 bits.
pub(crate) fn on_axis_wide(cone: &Cone, v: [i32; 2]) -> (bool, bool) {
    let wide = |a: [i32; 2]| [i64::from(a[0]), i64::from(a[1])];
    let (axis, v, range) = (wide(cone.axis), wide(v), i64::from(cone.reach[0]));
    let steep = axis[1].abs() > axis[0].abs();
    let (c, s, a, b) = if steep { (axis[1], axis[0], v[1], v[0]) } else { (axis[0], axis[1], v[0], v[1]) };
    let (half, sign) = (i64::from(CELL / 2), c.signum());
    let side = (b * c - a * s) * sign;
    let on = a * sign >= 0 && side >= -half * c.abs() && side < half * c.abs();
    let past = i64::from(DIRECTION) * a * sign - range * c.abs();
    let half = half * i64::from(DIRECTION);
    (on && past < -half, on && past >= -half && past < half)
}
