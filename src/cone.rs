//! The snapped cone: which cells a reading frees and which lie on its arc, in integers; twin of `shaders/cone.wgsl`,
//! and of `shaders/wide.wgsl` where a reading of the batch reaches far, `shaders/narrow.wgsl` where none does.
//!
//! Membership is exact, so it is the same on every backend. A row of a tile, 16 cells, is classified at once.

use crate::layout::*;

/// 16 cells of a row: the vector from the sensor to each centre, in integers, and each one's region.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// Freed by the reading: 1 or 0.
    pub interior: [u32; TILE],
    /// On its arc: 1 or 0.
    pub arc: [u32; TILE],
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
    for k in 0..TILE {
        let v = [v[0] + CELL * k as i32, v[1]];
        let d2 = dot(v, v);
        let (across, along) = (cross(cone.axis, v), dot(cone.axis, v));
        let wedge = (cross(cone.left, v) <= left_limit) & (cross(cone.right, v) >= 0) & (along >= 0);
        let band = laser & (across.abs() <= CELL / 2 * DIRECTION) & (along >= 0) & (along <= cone.reach[1] * DIRECTION);
        let inside = wedge | band;
        row.interior[k] = u32::from(inside & (d2 < inner));
        row.arc[k] = u32::from(inside & (d2 >= inner) & (d2 <= outer));
        row.d2[k] = d2 as f32;
        row.across[k] = across.abs() as f32;
        row.along[k] = along as f32;
    }
    row.any().then_some(row)
}

/// Which rows of a tile a cone may touch, and which lie wholly in its interior: one bit a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rows {
    /// May have a member.
    pub some: u32,
    /// Interior throughout.
    pub all: u32,
}

/// Looks at a tile's rows from their ends alone; `v` is its first cell's centre from the sensor.
///
/// The edges and the circles are convex: a row has members only if an end lies inside an edge and the nearest point within
/// reach, and it is interior if both its ends are.
#[inline(always)]
pub fn rows(cone: &Cone, v: [i32; 2], axis_only: bool) -> Rows {
    if cone.flags & WIDE != 0 {
        return Rows { some: 0xffff, all: 0 };
    }
    let (x0, x1) = (v[0], v[0] + CELL * (TILE as i32 - 1));
    let near = 0.clamp(x0, x1);
    let far = x0.abs().max(x1.abs());
    let left_limit = -i32::from(cone.flags & HALF_OPEN != 0);
    let band = axis_only || cone.flags & LASER != 0;
    let half = CELL / 2 * DIRECTION;
    let (inner, outer) = (cone.reach[0] * cone.reach[0], cone.reach[1] * cone.reach[1]);
    let (mut some, mut all) = ([0u32; TILE], [0u32; TILE]);
    for y in 0..TILE {
        let vy = v[1] + CELL * y as i32;
        let left = [cross(cone.left, [x0, vy]), cross(cone.left, [x1, vy])];
        let right = [cross(cone.right, [x0, vy]), cross(cone.right, [x1, vy])];
        let along = [dot(cone.axis, [x0, vy]), dot(cone.axis, [x1, vy])];
        let across = [cross(cone.axis, [x0, vy]), cross(cone.axis, [x1, vy])];
        let ahead = along[0].max(along[1]) >= 0;
        let wedge = (left[0].min(left[1]) <= left_limit) & (right[0].max(right[1]) >= 0) & ahead;
        let strip = band & (across[0].min(across[1]) <= half) & (across[0].max(across[1]) >= -half);
        let reached = near * near + vy * vy <= outer;
        some[y] = u32::from((strip | (wedge & reached)) & !(axis_only & !strip));
        let both = (left[0].max(left[1]) <= left_limit) & (right[0].min(right[1]) >= 0) & (along[0].min(along[1]) >= 0);
        all[y] = u32::from(both & !axis_only & (far * far + vy * vy < inner));
    }
    let bits = |flags: [u32; TILE]| (0..TILE).fold(0, |bits, y| bits | (flags[y] << y));
    Rows { some: bits(some), all: bits(all) }
}

/// A row that is interior throughout: no test.
#[inline(always)]
pub fn inside_row(cone: &Cone, v: [i32; 2]) -> Row {
    if cone.flags & WIDE != 0 {
        return wide_row(cone, v).unwrap_or(Row::EMPTY);
    }
    let mut row = Row { interior: [1; TILE], ..Row::EMPTY };
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
    for k in 0..TILE {
        let (before, hit) = if cone.flags & WIDE == 0 {
            on_axis(cone.axis, cone.reach[0], [v[0] + CELL * k as i32, v[1]])
        } else {
            on_axis_wide(cone, [v[0] + CELL * k as i32, v[1]])
        };
        // Without an echo the last cell is empty too.
        let silent = cone.flags & NO_ECHO != 0;
        row.interior[k] = u32::from(before | (hit & silent));
        row.arc[k] = u32::from(hit & !silent);
    }
    row.any().then_some(row)
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
        Row { interior: [0; TILE], arc: [0; TILE], d2: [0.0; TILE], across: [0.0; TILE], along: [0.0; TILE] };

    /// Leaves out the columns that lie beyond the grid.
    #[inline(always)]
    pub fn clip(&mut self, columns: usize) {
        for k in 0..TILE {
            let within = u32::from(k < columns);
            self.interior[k] &= within;
            self.arc[k] &= within;
        }
    }

    /// Whether any cell is a member.
    #[inline(always)]
    fn any(&self) -> bool {
        (0..TILE).fold(0, |any, k| any | self.interior[k] | self.arc[k]) != 0
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
    for k in 0..TILE {
        let v = [v[0] + CELL * k as i32, v[1]];
        let at = Wide::of(cone, v);
        let (interior, arc) = at.regions();
        row.interior[k] = u32::from(interior);
        row.arc[k] = u32::from(arc);
        row.d2[k] = float(at.d2 as u64);
        row.across[k] = float(at.across.unsigned_abs());
        row.along[k] = float(at.along.max(0) as u64);
    }
    row.any().then_some(row)
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
