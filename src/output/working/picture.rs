//! The picture of one reading: its cells as squares, +y up, over the map before it, and the cone's outline as lines.
//!
//! Blue cells lie in the interior, red ones on the arc, the darker the stronger their evidence; a shade is relative to the
//! strongest of its region. A certainty grid's hit is drawn three times: own evidence, cancelled, normalised.

use super::canvas::{Canvas, Colour};
use super::cone_outline::{ConeOutline, Point};
use crate::grid::{GridSpec, Map};
use crate::oracle::{CellTrace, ReadingTrace, Region};
use serde::Serialize;

/// The longest side of a picture, pixels, about.
const LONGEST: f64 = 1200.0;
/// The most pixels a cell's side gets.
const LARGEST_CELL: f64 = 64.0;
/// Cells shown around the cone.
const MARGIN: i64 = 2;
/// Pixels between two panels.
const GAP: i64 = 12;
/// Interior and arc, from no evidence to the strongest.
const BLUE: [Colour; 2] = [[214, 226, 248], [16, 60, 176]];
const RED: [Colour; 2] = [[252, 220, 214], [190, 16, 20]];
/// The map behind: occupied, empty, unknown or not seen.
const OCCUPIED: Colour = [90, 90, 90];
const EMPTY: Colour = [250, 250, 250];
const UNKNOWN: Colour = [206, 206, 206];
/// The space outside the grid, and between panels.
const OUTSIDE: Colour = [150, 152, 158];
/// Lines between cells; edges and arcs; axis and sensor.
const BETWEEN: Colour = [184, 184, 188];
const EDGE: Colour = [24, 24, 24];
const AXIS: Colour = [0, 128, 64];

/// The evidence that a panel shows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Panel {
    /// The reading's own evidence.
    Own,
    /// After cancelling by what is known to be empty.
    Cancelled,
    /// After normalising over the arc.
    Normalised,
}

impl Panel {
    fn value(self, cell: &CellTrace) -> f64 {
        match self {
            Panel::Own => cell.own,
            Panel::Cancelled => cell.cancelled,
            Panel::Normalised => cell.normalised,
        }
    }
}

/// The position of a panel, and the evidence of its strongest shades.
#[derive(Serialize)]
pub(super) struct PanelPlacement {
    shows: Panel,
    /// Its upper left pixel.
    x: i64,
    y: i64,
    /// Strength shown in full blue and in full red.
    full: [f64; 2],
}

/// The cells that the picture shows, and the panels that show them.
#[derive(Serialize)]
pub(super) struct Layout {
    /// The lower left cell: column and row, outside the grid if negative.
    first: [i64; 2],
    /// Columns and rows.
    cells: [i64; 2],
    pixels_per_cell: f64,
    panels: Vec<PanelPlacement>,
}

impl Layout {
    /// The layout of the cone's neighbourhood, as large as it fits.
    pub fn of(outline: &ConeOutline, trace: &ReadingTrace, panels: &[Panel], weigh: &dyn Fn(f64) -> f64) -> Layout {
        let mut low = [i64::MAX; 2];
        let mut high = [i64::MIN; 2];
        let mut take = |x: f64, y: f64| {
            for (k, v) in [x, y].into_iter().enumerate() {
                (low[k], high[k]) = (low[k].min(v.floor() as i64), high[k].max(v.floor() as i64));
            }
        };
        outline.points().for_each(|(x, y)| take(x, y));
        trace.cells.iter().for_each(|c| take(c.update.column as f64, c.update.row as f64));
        let first = low.map(|v| v - MARGIN);
        let cells = [0, 1].map(|k| high[k] - low[k] + 1 + 2 * MARGIN);
        // Panels lie along the picture's shorter side.
        let across = usize::from(cells[0] > cells[1]);
        let count = panels.len() as i64;
        let longest = cells[1 - across].max(count * cells[across]) as f64;
        let fit = LONGEST / longest;
        let scale = if fit < 1.0 { fit } else { fit.floor().min(LARGEST_CELL) };
        let step = pixel(cells[across], scale) + GAP;
        let strongest = |panel: Panel, region| {
            let of_region = trace.cells.iter().filter(|c| c.update.region == region);
            of_region.map(|c| weigh(panel.value(c))).fold(0.0, f64::max)
        };
        let place = |(k, panel): (i64, &Panel)| {
            let at = [0, 1].map(|side| if side == across { k * step } else { 0 });
            // Cancelled evidence has the shades of the own evidence, so that the picture shows the loss.
            let full = if *panel == Panel::Cancelled { Panel::Own } else { *panel };
            let full = [Region::Interior, Region::Arc].map(|region| strongest(full, region));
            PanelPlacement { shows: *panel, x: at[0], y: at[1], full }
        };
        Layout { first, cells, pixels_per_cell: scale, panels: (0..).zip(panels).map(place).collect() }
    }
}

/// The pixel where a coordinate begins, cells from the picture's first.
fn pixel(cells: i64, scale: f64) -> i64 {
    (cells as f64 * scale).floor() as i64
}

/// A picture to be drawn.
pub(super) struct Drawing<'a> {
    pub grid: &'a GridSpec,
    pub outline: &'a ConeOutline,
    pub trace: &'a ReadingTrace,
    pub layout: &'a Layout,
    /// The strength of a value of evidence, 0 or more.
    pub weigh: &'a dyn Fn(f64) -> f64,
    /// The map behind the cone.
    pub map: Option<&'a Map>,
}

impl Drawing<'_> {
    /// Draws all panels.
    pub fn draw(&self) -> Canvas {
        let Drawing { grid, outline, trace, layout, weigh, map } = *self;
        let size = layout.cells.map(|n| pixel(n, layout.pixels_per_cell).max(1));
        let last = layout.panels.iter().fold([0, 0], |m, p| [p.x.max(m[0]), p.y.max(m[1])]);
        let mut canvas = Canvas::new(last[0] + size[0], last[1] + size[1], OUTSIDE);
        for place in &layout.panels {
            let mut view = View { canvas: &mut canvas, layout, place, size };
            view.background(grid, map);
            for cell in &trace.cells {
                let (shades, full) = match cell.update.region {
                    Region::Interior => (BLUE, place.full[0]),
                    Region::Arc => (RED, place.full[1]),
                };
                let strength = if full > 0.0 { weigh(place.shows.value(cell)) / full } else { 0.0 };
                view.cell(cell.update.column as i64, cell.update.row as i64, shade(shades, strength));
            }
            view.line(&outline.axis, AXIS);
            outline.lines.iter().for_each(|line| view.line(line, EDGE));
            view.sensor(outline.sensor);
        }
        canvas
    }
}

/// The colour between two, by a strength of 0 to 1.
fn shade([from, to]: [Colour; 2], strength: f64) -> Colour {
    let mix = |k: usize| f64::from(from[k]) + (f64::from(to[k]) - f64::from(from[k])) * strength.clamp(0.0, 1.0);
    [0, 1, 2].map(|k| mix(k).round() as u8)
}

/// One panel of the canvas, in cells of the grid.
struct View<'a> {
    canvas: &'a mut Canvas,
    layout: &'a Layout,
    place: &'a PanelPlacement,
    size: [i64; 2],
}

impl View<'_> {
    /// Sets a pixel of the panel, y up from its lower left.
    fn put(&mut self, x: i64, y: i64, colour: Colour) {
        if (0..self.size[0]).contains(&x) && (0..self.size[1]).contains(&y) {
            self.canvas.put(self.place.x + x, self.place.y + self.size[1] - 1 - y, colour);
        }
    }

    /// Draws every cell of the grid in its class's grey.
    fn background(&mut self, grid: &GridSpec, map: Option<&Map>) {
        let class = map.and_then(|m| m.layer("class")).map(|l| &l.data);
        let scale = self.layout.pixels_per_cell;
        let step = if scale < 1.0 { 1.0 / scale } else { 1.0 };
        let steps = |k: usize| (0..).map(move |n| (n as f64 * step).ceil() as i64).take_while(move |c| *c < k as i64);
        let [columns, rows] = self.layout.cells.map(|n| n as usize);
        for row in steps(rows).map(|r| r + self.layout.first[1]) {
            for column in steps(columns).map(|c| c + self.layout.first[0]) {
                let within = (0..grid.width as i64).contains(&column) && (0..grid.height as i64).contains(&row);
                let colour = match class
                    .map(|c| if within { c.get(row as usize * grid.width + column as usize) } else { 0.0 })
                {
                    _ if !within => OUTSIDE,
                    Some(c) if c > 0.0 => OCCUPIED,
                    Some(0.0) => UNKNOWN,
                    _ => EMPTY,
                };
                self.cell(column, row, colour);
            }
        }
    }

    /// Draws a cell as a square; a large one leaves a line to its left and below.
    fn cell(&mut self, column: i64, row: i64, colour: Colour) {
        let scale = self.layout.pixels_per_cell;
        let (c, r) = (column - self.layout.first[0], row - self.layout.first[1]);
        let (x, y) = (pixel(c, scale), pixel(r, scale));
        let (right, top) = (pixel(c + 1, scale).max(x + 1), pixel(r + 1, scale).max(y + 1));
        for py in y..top {
            for px in x..right {
                let between = scale >= 5.0 && (px == x || py == y) && colour != OUTSIDE;
                self.put(px, py, if between { BETWEEN } else { colour });
            }
        }
    }

    /// A point of the grid, in pixels of the panel.
    fn at(&self, (x, y): Point) -> Point {
        let scale = self.layout.pixels_per_cell;
        ((x - self.layout.first[0] as f64) * scale, (y - self.layout.first[1] as f64) * scale)
    }

    /// Draws a line through points, two pixels wide.
    fn line(&mut self, points: &[Point], colour: Colour) {
        for (from, to) in points.iter().zip(points.iter().skip(1)) {
            let (from, to) = (self.at(*from), self.at(*to));
            let steps = (2.0 * (to.0 - from.0).hypot(to.1 - from.1)).ceil().max(1.0) as i64;
            for k in 0..=steps {
                let part = k as f64 / steps as f64;
                let (x, y) = (from.0 + part * (to.0 - from.0), from.1 + part * (to.1 - from.1));
                let (x, y) = (x.round() as i64, y.round() as i64);
                [(0, 0), (-1, 0), (0, -1), (-1, -1)].iter().for_each(|(i, j)| self.put(x + i, y + j, colour));
            }
        }
    }

    /// Draws the sensor: a green disc with a dark rim.
    fn sensor(&mut self, at: Point) {
        let radius = (self.layout.pixels_per_cell * 0.3).clamp(4.0, 9.0);
        let (x, y) = self.at(at);
        let reach = radius as i64 + 2;
        for j in -reach..=reach {
            for i in -reach..=reach {
                let r = (i as f64).hypot(j as f64);
                if r <= radius + 1.5 {
                    self.put(x as i64 + i, y as i64 + j, if r <= radius - 1.0 { AXIS } else { EDGE });
                }
            }
        }
    }
}
