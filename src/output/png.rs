//! A layer as a picture: 8-bit indexed, +y up, on the layer's own fixed scale, so that two pictures of the same layer
//! can be laid side by side. Cells that no reading reached are bluish grey, which is no colour of any scale.

use super::unwritable;
use crate::Result;
use crate::grid::{GridSpec, Layer, Map, Scale};
use png::{BitDepth, ColorType, Compression, Encoder, Filter};
use rayon::prelude::*;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

/// Wider or taller pictures are reduced, so that a viewer can open them.
const LARGEST: usize = 4096;
/// Palette entry 0: cells that no reading reached, and values that are no number.
pub(super) const UNTOUCHED: [u8; 3] = [168, 180, 196];
/// The colour of class 0: cells that readings reached, and that are undecided.
const UNDECIDED: [u8; 3] = [128; 3];
/// Palette entry of a signed scale's zero; entries 1 to 255 are the scale from low to high.
const MIDDLE: u8 = 128;

/// Writes one layer of a map as a PNG. A picture of more than 4096 pixels a side is reduced by a power of two; a pixel then
/// shows the cell of its block with the largest magnitude.
pub fn write_picture(path: &Path, map: &Map, layer: &Layer) -> Result<()> {
    let (extent, mut pixels) = entries(map, layer, factor(&map.grid));
    flip(&mut pixels, extent[0]);
    save(path, extent, layer.scale, &pixels)
}

/// By how much a grid's pictures are reduced: a power of two, so that no block lies in two chunks.
pub(super) fn factor(grid: &GridSpec) -> usize {
    grid.width.max(grid.height).div_ceil(LARGEST).next_power_of_two()
}

/// Columns and rows of a grid reduced by a factor.
pub(super) fn reduced(grid: &GridSpec, factor: usize) -> [usize; 2] {
    [grid.width.div_ceil(factor), grid.height.div_ceil(factor)]
}

/// A layer's palette entries, reduced by a factor, bottom row first, and their extent.
pub(super) fn entries(map: &Map, layer: &Layer, factor: usize) -> ([usize; 2], Vec<u8>) {
    let grid = &map.grid;
    let [width, height] = reduced(grid, factor);
    let touched = map.layer("touched").filter(|_| layer.name != "touched").map(|t| &t.data);
    let value = |k: usize| {
        let seen = touched.is_none_or(|t| t.get(k) != 0.0);
        Some(layer.data.get(k)).filter(|v| seen && !v.is_nan())
    };
    let mut pixels = vec![0; width * height];
    pixels.par_chunks_mut(width).enumerate().for_each(|(line, pixels)| {
        let row = line * factor;
        for (column, pixel) in pixels.iter_mut().enumerate().map(|(c, p)| (c * factor, p)) {
            let rows = row..(row + factor).min(grid.height);
            let columns = column..(column + factor).min(grid.width);
            let block = rows.flat_map(|r| columns.clone().map(move |c| r * grid.width + c)).filter_map(value);
            let strongest = block.reduce(|best, v| if stronger(layer.scale, v, best) { v } else { best });
            *pixel = strongest.map_or(0, |v| entry(layer.scale, v));
        }
    });
    ([width, height], pixels)
}

/// Whether a block of cells shows this value rather than that: the larger magnitude; of classes the lower one, as walls are
/// thinner than what is free, and any rather than none.
fn stronger(scale: Scale, value: f64, than: f64) -> bool {
    match scale {
        Scale::Classes(_) => value != 0.0 && (than == 0.0 || value < than),
        _ => value.abs() > than.abs(),
    }
}

/// Turns rows upside down.
pub(super) fn flip(pixels: &mut [u8], width: usize) {
    let rows = pixels.len() / width.max(1);
    for row in 0..rows / 2 {
        let (low, high) = pixels.split_at_mut((rows - 1 - row) * width);
        low[row * width..][..width].swap_with_slice(&mut high[..width]);
    }
}

/// A value's palette entry, 1 to 255.
fn entry(scale: Scale, value: f64) -> u8 {
    match scale {
        Scale::Grey { low, high } | Scale::Heat { low, high } => {
            1 + ((value - low) / (high - low) * 254.0).round().clamp(0.0, 254.0) as u8
        }
        Scale::Signed { limit } => (f64::from(MIDDLE) + (value / limit * 127.0).round().clamp(-127.0, 127.0)) as u8,
        Scale::Classes(_) => 1 + value.clamp(0.0, 254.0) as u8,
    }
}

/// A value's colour on a scale.
pub(super) fn colour(scale: Scale, value: f64) -> [u8; 3] {
    let (entry, palette) = (usize::from(entry(scale, value)), palette(scale));
    [palette[3 * entry], palette[3 * entry + 1], palette[3 * entry + 2]]
}

/// 256 colours: untouched, then the scale from low to high.
fn palette(scale: Scale) -> Vec<u8> {
    let colour = |entry: u8| match scale {
        Scale::Grey { .. } => [255 - (entry - 1); 3],
        Scale::Signed { .. } => {
            let strength = 2 * (i16::from(entry) - i16::from(MIDDLE)); // -254 blue to 254 red
            let pale = 255 - strength.unsigned_abs() as u8;
            if strength < 0 { [pale, pale, 255] } else { [255, pale, pale] }
        }
        Scale::Heat { .. } => {
            let colour = colorous::VIRIDIS.eval_rational(usize::from(entry) - 1, 255);
            [colour.r, colour.g, colour.b]
        }
        Scale::Classes(palette) => match entry {
            1 => UNDECIDED,
            label => palette.colours().get(usize::from(label) - 2).copied().unwrap_or(UNDECIDED),
        },
    };
    let scale = (1..=255).flat_map(colour);
    UNTOUCHED.into_iter().chain(scale).collect()
}

/// Saves palette entries, top row first.
pub(super) fn save(path: &Path, extent: [usize; 2], scale: Scale, pixels: &[u8]) -> Result<()> {
    encode(path, extent, &palette(scale), pixels).map_err(|e| unwritable(path, e))
}

fn encode(path: &Path, [width, height]: [usize; 2], palette: &[u8], pixels: &[u8]) -> std::io::Result<()> {
    let file = BufWriter::new(File::create(path)?);
    let mut encoder = Encoder::new(file, width as u32, height as u32);
    encoder.set_color(ColorType::Indexed);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_palette(palette);
    encoder.set_compression(Compression::Balanced);
    encoder.set_filter(Filter::NoFilter); // differences of palette entries mean nothing
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    Ok(writer.finish()?)
}
