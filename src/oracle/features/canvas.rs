//! Which cells lie in a fan or on a line, in 128-bit integers.

use crate::feature::Fan;
use crate::grid::GridSpec;
use std::ops::Range;

/// A point in 1/32 cell from the grid's anchor.
pub(super) type Point = [i128; 2];

fn cross(a: Point, b: Point) -> i128 {
    a[0] * b[1] - a[1] * b[0]
}

fn dot(a: Point, b: Point) -> i128 {
    a[0] * b[0] + a[1] * b[1]
}

/// b − a.
fn offset(a: Point, b: Point) -> Point {
    [b[0] - a[0], b[1] - a[1]]
}

/// A point in metres, snapped.
pub(super) fn snap(grid: &GridSpec, (x, y): (f64, f64)) -> Point {
    [(x, grid.anchor.0), (y, grid.anchor.1)]
        .map(|(v, anchor)| (32.0 * (v - anchor) / grid.resolution + 0.5).floor() as i128)
}

/// A rectangle of the grid's cells, each with a set of bits.
pub(super) struct Canvas<'a> {
    grid: &'a GridSpec,
    pub columns: Range<usize>,
    pub rows: Range<usize>,
    /// The bits of each cell, row by row.
    pub codes: Vec<u8>,
}

/// The cells along an axis whose centres lie from `low` to `high`.
fn span(first: i64, count: usize, [low, high]: [i128; 2]) -> Range<usize> {
    let at = |v: i128| (v - 16).div_euclid(32) - i128::from(first);
    let within = |v: i128| v.clamp(0, count as i128) as usize;
    let (from, to) = (within(at(low)), within(at(high) + 2));
    from..to.max(from)
}

impl Canvas<'_> {
    /// The grid's cells whose centres lie in a box; no bit is set.
    pub fn new(grid: &GridSpec, low: Point, high: Point) -> Canvas<'_> {
        let (columns, rows) =
            (span(grid.i0, grid.width, [low[0], high[0]]), span(grid.j0, grid.height, [low[1], high[1]]));
        let codes = vec![0; columns.len() * rows.len()];
        Canvas { grid, columns, rows, codes }
    }

    /// Sets bits in the cells whose centre passes a test, within the bounding box of some points.
    fn paint(&mut self, bits: u8, corners: &[Point], holds: impl Fn(Point) -> bool) {
        let reach = |k: usize| {
            let all = || corners.iter().map(|p| p[k]);
            [all().min().unwrap_or(0) - 32, all().max().unwrap_or(0) + 32]
        };
        let grid = self.grid;
        let (columns, rows) = (span(grid.i0, grid.width, reach(0)), span(grid.j0, grid.height, reach(1)));
        for row in rows.start.max(self.rows.start)..rows.end.min(self.rows.end) {
            for column in columns.start.max(self.columns.start)..columns.end.min(self.columns.end) {
                let centre = |first: i64, k: usize| 32 * (i128::from(first) + k as i128) + 16;
                if holds([centre(grid.i0, column), centre(grid.j0, row)]) {
                    let at = (row - self.rows.start) * self.columns.len() + column - self.columns.start;
                    self.codes[at] |= bits;
                }
            }
        }
    }

    /// Sets bits in the cells of a fan of triangles with their apex at the sensor.
    pub fn fan(&mut self, bits: u8, sensor: Point, fan: &Fan) {
        let vertices: Vec<Point> = fan.vertices.iter().map(|v| snap(self.grid, (v.x, v.y))).collect();
        for k in 1..vertices.len() {
            let [a, b] = [vertices[k - 1], vertices[k]];
            let (rays, last) = ([offset(sensor, a), offset(sensor, b)], k + 1 == vertices.len());
            if cross(rays[0], rays[1]) <= 0 {
                continue;
            }
            self.paint(bits, &[sensor, a, b], |centre| {
                let p = offset(sensor, centre);
                let right = cross(p, rays[1]);
                cross(rays[0], p) >= 0
                    && (right > 0 || last && right == 0)
                    && cross(offset(a, b), offset(a, centre)) >= 0
            });
        }
    }

    /// Sets bits in the cells of a segment; of a segment of length 0, within ¾ cell of it.
    pub fn line(&mut self, bits: u8, ends: [(f64, f64); 2]) {
        let [a, b] = ends.map(|p| snap(self.grid, p));
        let d = offset(a, b);
        self.paint(bits, &[a, b], |centre| {
            let p = offset(a, centre);
            match d {
                [0, 0] => dot(p, p) <= 24 * 24,
                _ => cross(d, p).abs() <= 16 * (d[0].abs() + d[1].abs()) && (0..=dot(d, d)).contains(&dot(d, p)),
            }
        });
    }
}
