//! The histogram of error levels as SVG.

use super::picture::colour;
use crate::output::svg::escape;

const WIDTH: f64 = 520.0;
const HEIGHT: f64 = 260.0;
const LEFT: f64 = 46.0;
const TOP: f64 = 34.0;
const BOTTOM: f64 = 44.0;
/// Zone of each level.
const ZONES: [&str; 10] = ["Z1", "Z1", "Z3", "Z3", "Z3", "Z4", "Z4", "Z5", "Z5", "Z5"];

/// The cells of each level on a logarithmic scale, as most cells of any map have level 0. `title` is plain text.
pub(super) fn histogram(title: &str, levels: &[u64; 10]) -> String {
    let decades = levels.iter().max().map_or(1, |&m| (m.max(1) as f64).log10().floor() as usize + 1);
    let (base, scale) = (HEIGHT - BOTTOM, (HEIGHT - BOTTOM - TOP) / decades as f64);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" \
         height=\"{HEIGHT}\" font-family=\"sans-serif\" font-size=\"11\"><title>{0}: cells of each error level</title>\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/><text x=\"{LEFT}\" y=\"16\" font-size=\"13\">{0}</text>",
        escape(title)
    );
    for decade in 0..=decades {
        let y = base - decade as f64 * scale;
        svg += &format!(
            "<path d=\"M{LEFT} {y:.1}H{WIDTH}\" stroke=\"#ddd\"/><text x=\"{:.1}\" y=\"{:.1}\" \
             text-anchor=\"end\">10<tspan dy=\"-4\" font-size=\"8\">{decade}</tspan></text>",
            LEFT - 6.0,
            y + 4.0
        );
    }
    let step = (WIDTH - LEFT) / 10.0;
    for (level, &cells) in levels.iter().enumerate() {
        let x = LEFT + level as f64 * step;
        let middle = x + step / 2.0;
        // One cell is still visible; none is not drawn.
        let height = if cells == 0 { 0.0 } else { ((cells as f64).log10() * scale).max(2.0) };
        if cells > 0 {
            svg += &format!(
                "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{height:.1}\" fill=\"{}\" stroke=\"#555\"/>",
                x + 4.0,
                base - height,
                step - 8.0,
                colour(level)
            );
        }
        svg += &format!(
            "<text x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\" font-size=\"9\">{cells}</text>\
             <text x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{level}</text>\
             <text x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#777\">{}</text>",
            base - height - 4.0,
            base + 15.0,
            base + 30.0,
            ZONES[level]
        );
    }
    svg += &format!(
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"#777\">error level, and its zone</text>\
         <text x=\"{LEFT}\" y=\"28\" fill=\"#777\">cells</text>",
        WIDTH - 4.0,
        HEIGHT - 2.0
    );
    svg + "</svg>\n"
}
