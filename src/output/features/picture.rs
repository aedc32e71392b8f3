//! `features.svg`: walls, corners and points over the map's picture, +y up, with a scale bar in metres.

use crate::feature::{FeatureMap, Wall};
use crate::geometry::plane::Point;
use crate::grid::GridSpec;
use crate::output::png::{factor, reduced};

/// The longer side of the map, the margin around it, and the height of a line below it, pixels.
const EDGE: f64 = 1200.0;
const GAP: f64 = 24.0;
const LINE: f64 = 20.0;
/// The width of the legend, pixels.
const NARROWEST: f64 = 420.0;
/// Length of the tick that says which way a wall's normal points, and radius of a corner's circle and a point's cross, pixels.
const TICK: f64 = 7.0;
const CIRCLE: f64 = 6.0;
const CROSS: f64 = 4.0;
/// Colours that are not on the map's scale, and a light rim, as a map is blue where it is free.
const WALL: &str = "#e0007a";
const CORNER: &str = "#009a3e";
const POINT: &str = "#111";
const RIM: &str = "filter:drop-shadow(0 0 1px #fff) drop-shadow(0 0 1px #fff)";

/// The transform from the world to the picture.
struct PictureFrame {
    left: f64,
    top: f64,
    /// Pixels per metre.
    scale: f64,
    /// The map's picture, pixels.
    size: [f64; 2],
}

impl PictureFrame {
    /// The transform for a grid. `map.png` shows whole blocks of cells, so it may reach beyond the grid.
    fn of(grid: &GridSpec) -> PictureFrame {
        let factor = factor(grid);
        let metres = reduced(grid, factor).map(|n| (n * factor) as f64 * grid.resolution);
        let scale = EDGE / metres[0].max(metres[1]);
        PictureFrame { left: grid.x0(), top: grid.y0() + metres[1], scale, size: metres.map(|m| m * scale) }
    }

    fn at(&self, p: Point) -> Point {
        Point::new(GAP + (p.x - self.left) * self.scale, GAP + (self.top - p.y) * self.scale)
    }
}

/// The text of the picture; `map`: `map.png` exists beside it.
pub(super) fn svg(known: &FeatureMap, grid: &GridSpec, map: bool) -> String {
    let frame = PictureFrame::of(grid);
    let [width, height] = frame.size;
    let (across, up) = (width.max(NARROWEST) + 2.0 * GAP, GAP + height + 6.0 * LINE);
    let features = &known.features;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {across:.0} {up:.0}\" width=\"{across:.0}\" height=\"{up:.0}\" \
         font-family=\"sans-serif\" font-size=\"13\"><title>walls, corners and points</title>\
         <clipPath id=\"map\"><rect x=\"{GAP}\" y=\"{GAP}\" width=\"{width:.1}\" height=\"{height:.1}\"/></clipPath>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\
         <rect x=\"{GAP}\" y=\"{GAP}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"#eee\"/>\n"
    );
    if map {
        svg += &format!(
            "<image x=\"{GAP}\" y=\"{GAP}\" width=\"{width:.1}\" height=\"{height:.1}\" preserveAspectRatio=\"none\" \
             style=\"image-rendering:pixelated\" href=\"map.png\"/>\n"
        );
    }
    svg += &format!("<g clip-path=\"url(#map)\" fill=\"none\" stroke-width=\"1.5\" style=\"{RIM}\">\n");
    for wall in &features.walls {
        svg += &line(wall, &frame);
    }
    for corner in &features.corners {
        for [a, b] in corner.extrapolated_walls.iter().flatten().map(|leg| leg.map(|p| frame.at(p))) {
            svg += &format!(
                "<path class=\"leg\" d=\"M{:.2} {:.2}L{:.2} {:.2}\" stroke=\"{CORNER}\" stroke-dasharray=\"4 3\"/>\n",
                a.x, a.y, b.x, b.y
            );
        }
        svg += &circle(frame.at(corner.at));
    }
    for spot in &features.points {
        svg += &cross(frame.at(spot.at));
    }
    svg += "</g>\n";
    svg + &legend(known, &frame, GAP + height + LINE) + "</svg>\n"
}

/// A wall, with a tick in its middle along its normal.
fn line(wall: &Wall, frame: &PictureFrame) -> String {
    let [a, b] = wall.ends().map(|p| frame.at(p));
    let middle = wall.middle();
    let (from, to) = (frame.at(middle), frame.at(middle + wall.normal * (TICK / frame.scale)));
    format!(
        "<path class=\"wall\" d=\"M{:.2} {:.2}L{:.2} {:.2}\" stroke=\"{WALL}\" stroke-width=\"2.5\"/>\
         <path d=\"M{:.2} {:.2}L{:.2} {:.2}\" stroke=\"{WALL}\" stroke-width=\"1\"/>\n",
        a.x, a.y, b.x, b.y, from.x, from.y, to.x, to.y
    )
}

fn circle(at: Point) -> String {
    let (x, y) = (at.x, at.y);
    format!("<circle class=\"corner\" cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{CIRCLE}\" stroke=\"{CORNER}\"/>\n")
}

fn cross(at: Point) -> String {
    let (x, y) = (at.x, at.y);
    let (left, right, top, bottom) = (x - CROSS, x + CROSS, y - CROSS, y + CROSS);
    format!(
        "<path class=\"point\" d=\"M{left:.2} {top:.2}L{right:.2} {bottom:.2}M{left:.2} {bottom:.2}L{right:.2} {top:.2}\" \
         stroke=\"{POINT}\"/>\n"
    )
}

/// The legend: the number of features of each kind, and a scale bar.
fn legend(known: &FeatureMap, frame: &PictureFrame, top: f64) -> String {
    let features = &known.features;
    let mut text = String::from("<g fill=\"none\" stroke-width=\"1.5\">\n");
    let symbol = |k: usize| Point::new(GAP + 10.0, top + k as f64 * LINE + 5.0);
    let (x, y) = (symbol(0).x, symbol(0).y);
    text += &format!("<path d=\"M{:.2} {y:.2}h20v-{TICK}\" stroke=\"{WALL}\" stroke-width=\"2.5\"/>", x - 10.0);
    text += &circle(symbol(1)).replace(" class=\"corner\"", "");
    text += &cross(symbol(2)).replace(" class=\"point\"", "");
    text += "</g>\n";
    let counts = [
        (features.walls.len(), "wall", "the tick points away from the robot"),
        (features.corners.len(), "corner", "dashed to walls that end before it"),
        (features.points.len(), "point", "edges and thin things"),
    ];
    for (k, (count, what, about)) in counts.iter().enumerate() {
        let (y, plural) = (top + k as f64 * LINE + 10.0, if *count == 1 { "" } else { "s" });
        text += &format!("<text x=\"{:.0}\" y=\"{y:.1}\">{count} {what}{plural}: {about}</text>\n", GAP + 32.0);
    }
    let (length, y) = (round_length(frame.size[0] / frame.scale / 3.0), top + 3.0 * LINE + 10.0);
    text + &format!(
        "<path class=\"scale\" d=\"M{GAP} {:.1}v6h{:.2}v-6\" fill=\"none\" stroke=\"#000\"/><text x=\"{:.1}\" y=\"{:.1}\">{length} m</text>\n",
        y - 6.0,
        length * frame.scale,
        GAP + length * frame.scale + 6.0,
        y + 2.0
    )
}

/// The largest of 1, 2, 5, 10, … (or .5, .2, …) metres that isn't longer.
fn round_length(most: f64) -> f64 {
    let decade = 10f64.powf(most.log10().floor());
    [5.0, 2.0].into_iter().map(|k| k * decade).find(|l| *l <= most * (1.0 + 1e-9)).unwrap_or(decade)
}
