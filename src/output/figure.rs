//! `figure.svg`: the layers mean, variance and label side by side, each with its scale and the names of its colours, for the methods that
//! have all three. The pictures are embedded in the file.

use super::names::{FIGURE, LAYER_PICTURE};
use super::png::{UNTOUCHED, colour};
use super::svg::escape;
use super::{MapSchema, unwritable};
use crate::Result;
use crate::grid::{Layer, Scale};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use std::path::Path;

/// The names and titles of the layers shown.
const PANELS: [(&str, &str); 3] =
    [("mean", "probability of occupied"), ("variance", "variance"), ("label", "likeliest class")];
/// The longer side of a panel, and the gap between two, pixels.
const EDGE: f64 = 420.0;
/// The gap between panels, pixels.
const GAP: f64 = 24.0;
/// The space above the pictures, the side of a colour sample, and the height of a line below them, pixels.
const TOP: f64 = 34.0;
/// The height of a colour bar, pixels.
const BAR: f64 = 14.0;
/// The distance of two lines of text, pixels.
const LINE: f64 = 18.0;
/// Steps of a colour bar.
const STEPS: usize = 42;

/// Writes the figure from the layers' pictures in a folder; nothing for a method without its layers.
///
/// # Errors
/// [`Error::Resources`](crate::Error::Resources) if a picture can't be read or the figure can't be written.
pub(super) fn write(folder: &Path, schema: &MapSchema, classes: &[String]) -> Result<()> {
    let layers: Vec<&Layer> =
        PANELS.iter().filter_map(|(name, _)| schema.layers.iter().find(|l| l.name == *name)).collect();
    if layers.len() < PANELS.len() {
        return Ok(());
    }
    let grid = &schema.grid;
    let (across, up) = (grid.width as f64 * grid.resolution, grid.height as f64 * grid.resolution);
    let scale = EDGE / across.max(up);
    let (width, height) = (across * scale, up * scale);
    let plain = ["occupied".to_string(), "free".to_string()];
    let names = if classes.is_empty() { &plain } else { classes };
    let lines = names.len() + 2;
    let whole = [3.0 * EDGE + 4.0 * GAP, TOP + height + 3.0 * LINE + lines as f64 * LINE];
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0} {1:.0}\" width=\"{0:.0}\" height=\"{1:.0}\" \
         font-family=\"sans-serif\" font-size=\"13\"><title>{2}</title><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        whole[0],
        whole[1],
        escape(&schema.method)
    );
    for ((k, layer), (_, title)) in layers.iter().enumerate().zip(PANELS) {
        let left = GAP + k as f64 * (EDGE + GAP);
        let path = folder.join(LAYER_PICTURE.of(&layer.name));
        let picture = std::fs::read(&path).map_err(|e| unwritable(&path, e))?;
        let title = if k == 0 { format!("{}: {title}", schema.method) } else { title.to_string() };
        svg += &format!(
            "<text x=\"{left:.0}\" y=\"22\" font-weight=\"bold\">{}</text>\
             <image x=\"{left:.0}\" y=\"{TOP}\" width=\"{width:.1}\" height=\"{height:.1}\" preserveAspectRatio=\"none\" \
             style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{}\"/>\n",
            escape(&title),
            BASE64_STANDARD.encode(&picture)
        );
        svg += &legend(layer.scale, names, left, TOP + height + LINE);
    }
    svg += &format!(
        "<text x=\"{GAP}\" y=\"{:.0}\" fill=\"#555\">{} × {} cells of {} m: x {:.2} to {:.2} m, y {:.2} to {:.2} m</text></svg>\n",
        whole[1] - 10.0,
        grid.width,
        grid.height,
        grid.resolution,
        grid.x0(),
        grid.x0() + across,
        grid.y0(),
        grid.y0() + up
    );
    let path = FIGURE.at(folder);
    std::fs::write(&path, svg).map_err(|e| unwritable(&path, e))
}

/// The legend of a scale; its upper left corner lies at `left`, `top`.
fn legend(scale: Scale, names: &[String], left: f64, top: f64) -> String {
    let hex = |[r, g, b]: [u8; 3]| format!("#{r:02x}{g:02x}{b:02x}");
    let row = |line: usize, colour: [u8; 3], text: &str| {
        let y = top + line as f64 * LINE;
        format!(
            "<rect x=\"{left:.0}\" y=\"{y:.1}\" width=\"{BAR}\" height=\"{BAR}\" fill=\"{}\" stroke=\"#888\"/>\
             <text x=\"{:.0}\" y=\"{:.1}\">{}</text>",
            hex(colour),
            left + BAR + 6.0,
            y + BAR - 2.0,
            escape(text)
        )
    };
    let untouched = |line| row(line, UNTOUCHED, "not seen");
    match scale {
        Scale::Classes(_) => {
            let mut text: String =
                (1..).zip(names).map(|(k, name)| row(k - 1, colour(scale, k as f64), name)).collect();
            text += &row(names.len(), colour(scale, 0.0), "undecided");
            text + &untouched(names.len() + 1) + "\n"
        }
        Scale::Grey { low, high } | Scale::Heat { low, high } => {
            colour_bar(scale, [low, high], left, top) + &untouched(2) + "\n"
        }
        Scale::Signed { limit } => colour_bar(scale, [-limit, limit], left, top) + &untouched(2) + "\n",
    }
}

/// A colour bar, labelled with the values at its ends.
fn colour_bar(scale: Scale, [low, high]: [f64; 2], left: f64, top: f64) -> String {
    let step = EDGE / 2.0 / STEPS as f64;
    let mut text = String::new();
    for k in 0..STEPS {
        let value = low + (high - low) * (k as f64 + 0.5) / STEPS as f64;
        let [r, g, b] = colour(scale, value);
        text += &format!(
            "<rect x=\"{:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{BAR}\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>",
            left + k as f64 * step,
            step + 0.3
        );
    }
    let y = top + BAR + 14.0;
    text + &format!(
        "<rect x=\"{left:.0}\" y=\"{top:.1}\" width=\"{0:.1}\" height=\"{BAR}\" fill=\"none\" stroke=\"#888\"/>\
         <text x=\"{left:.0}\" y=\"{y:.1}\">{low:.4}</text><text x=\"{1:.1}\" y=\"{y:.1}\" text-anchor=\"end\">{high:.4}</text>",
        EDGE / 2.0,
        left + EDGE / 2.0
    )
}
