//! A layer as a picture: 8-bit indexed, +y up, on the layer's own fixed scale, so that two pictures of the same layer
//! can be laid side by side. Cells that no reading reached are bluish grey, which is no colour of any scale.

use super::unwritable;
use crate::Result;
use crate::grid::{Data, GridSpec, Layer, Map, Scale};
use png::{BitDepth, ColorType, DeflateCompression, Encoder, Filter};
use rayon::prelude::*;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// The longest side of a picture, pixels. Larger ones are reduced, so that a viewer can open them.
const LONGEST_SIDE: usize = 4096;
/// The compression of pictures that are kept.
const BALANCED: DeflateCompression = DeflateCompression::Level(6);
/// The compression of pictures that are shown once.
const QUICK: DeflateCompression = DeflateCompression::Level(1);
/// The colour of palette entry 0: cells that no reading reached, and values that are not a number.
pub(crate) const UNTOUCHED: [u8; 3] = [168, 180, 196];
/// The colour of class 0: undecided cells that readings reached.
pub(crate) const UNDECIDED: [u8; 3] = [128; 3];
/// The palette entry of a signed scale's zero; entries 1 to 255 are the scale from low to high.
const MIDDLE: u8 = 128;

/// Writes one layer of a map as a PNG. A picture of more than 4096 pixels a side is reduced by a power of two; a pixel then
/// shows the cell of its block with the largest magnitude.
///
/// # Errors
/// [`Error::Resources`](crate::Error::Resources) if it can't be written.
pub fn write_picture(path: &Path, map: &Map, layer: &Layer) -> Result<()> {
    let values = PictureValues::of(map, layer).reduced(factor(&map.grid));
    let mut pixels = values.entries();
    flip(&mut pixels, values.extent[0]);
    save(path, values.extent, layer.scale, &pixels)
}

/// The factor by which a grid's pictures are reduced: a power of two, so that no block lies in two chunks.
pub(super) fn factor(grid: &GridSpec) -> usize {
    grid.width.max(grid.height).div_ceil(LONGEST_SIDE).next_power_of_two()
}

/// Columns and rows of a grid reduced by a factor.
pub(super) fn reduced(grid: &GridSpec, factor: usize) -> [usize; 2] {
    [grid.width.div_ceil(factor), grid.height.div_ceil(factor)]
}

/// The values of a layer's picture, bottom row first.
pub(super) struct PictureValues {
    extent: [usize; 2],
    scale: Scale,
    /// NaN where no reading reached the cell.
    values: Vec<f32>,
}

impl PictureValues {
    /// The values of a layer, a pixel for each cell.
    pub fn of(map: &Map, layer: &Layer) -> PictureValues {
        let mut values: Vec<f32> = match &layer.data {
            Data::F32(v) => v.clone(),
            Data::U32(v) => v.par_iter().map(|v| *v as f32).collect(),
            Data::U8(v) => v.par_iter().map(|v| f32::from(*v)).collect(),
            Data::I8(v) => v.par_iter().map(|v| f32::from(*v)).collect(),
        };
        let touched = map.layer("touched").filter(|_| layer.name != "touched").map(|t| &t.data);
        if let Some(Data::U8(touched)) = touched {
            values.par_iter_mut().zip(touched).for_each(|(v, seen)| *v = if *seen != 0 { *v } else { f32::NAN });
        }
        PictureValues { extent: [map.grid.width, map.grid.height], scale: layer.scale, values }
    }

    /// The values at half the size: each pixel shows the strongest of four.
    pub fn half(&self) -> PictureValues {
        let (extent, values) = half(self.scale, self.extent, &self.values);
        PictureValues { extent, scale: self.scale, values }
    }

    /// The values reduced by a power of two.
    pub fn reduced(self, factor: usize) -> PictureValues {
        (0..factor.trailing_zeros()).fold(self, |values, _| values.half())
    }

    /// The palette entries of the values.
    pub fn entries(&self) -> Vec<u8> {
        entries(self.scale, &self.values)
    }
}

/// Values at half the size, rounded up, and their extent: each is the strongest of four, NaN only if all four are.
pub(crate) fn half(scale: Scale, [width, height]: [usize; 2], values: &[f32]) -> ([usize; 2], Vec<f32>) {
    let extent = [width.div_ceil(2), height.div_ceil(2)];
    let mut halved = vec![f32::NAN; extent[0] * extent[1]];
    halved.par_chunks_mut(extent[0].max(1)).zip(values.par_chunks(2 * width.max(1))).for_each(|(line, rows)| {
        for row in rows.chunks(width) {
            for (value, pair) in line.iter_mut().zip(row.chunks(2)) {
                for v in pair {
                    let better = !v.is_nan() && (value.is_nan() || stronger(scale, *v, *value));
                    *value = if better { *v } else { *value };
                }
            }
        }
    });
    (extent, halved)
}

/// The palette entries of values; 0 for NaN.
pub(crate) fn entries(scale: Scale, values: &[f32]) -> Vec<u8> {
    values.par_iter().map(|v| if v.is_nan() { 0 } else { entry(scale, f64::from(*v)) }).collect()
}

/// Whether a block of cells shows `value` rather than `than`. The larger magnitude is stronger, of equal ones the positive (occupied). Of
/// classes the lower label is stronger, as walls are thinner than free space, and any label is stronger than none.
fn stronger(scale: Scale, value: f32, than: f32) -> bool {
    match scale {
        Scale::Classes(_) => value != 0.0 && (than == 0.0 || value < than),
        _ => value.abs() > than.abs() || (value.abs() == than.abs() && value > than),
    }
}

/// Reverses the order of the rows.
pub(crate) fn flip(pixels: &mut [u8], width: usize) {
    let rows = pixels.len() / width.max(1);
    for row in 0..rows / 2 {
        let (low, high) = pixels.split_at_mut((rows - 1 - row) * width);
        low[row * width..][..width].swap_with_slice(&mut high[..width]);
    }
}

/// The palette entry of a value, 1 to 255.
fn entry(scale: Scale, value: f64) -> u8 {
    match scale {
        Scale::Grey { low, high } | Scale::Heat { low, high } => {
            1 + ((value - low) / (high - low) * 254.0).round().clamp(0.0, 254.0) as u8
        }
        Scale::Signed { limit } => (f64::from(MIDDLE) + (value / limit * 127.0).round().clamp(-127.0, 127.0)) as u8,
        Scale::Classes(_) => 1 + value.clamp(0.0, 254.0) as u8,
    }
}

/// The colour of a value on a scale.
pub(crate) fn colour(scale: Scale, value: f64) -> [u8; 3] {
    let (entry, palette) = (usize::from(entry(scale, value)), palette(scale));
    [palette[3 * entry], palette[3 * entry + 1], palette[3 * entry + 2]]
}

/// The palette of a scale: 256 colours, first that of untouched cells, then the scale from low to high.
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
    let file = File::create(path).map(BufWriter::new);
    file.and_then(|file| encode(file, extent, BALANCED, scale, pixels)).map_err(|e| unwritable(path, e))
}

/// Encodes a picture with fast compression. `pixels` are palette entries, top row first.
pub(crate) fn picture(extent: [usize; 2], scale: Scale, pixels: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    encode(&mut bytes, extent, QUICK, scale, pixels)?;
    Ok(bytes)
}

fn encode(
    to: impl Write,
    [width, height]: [usize; 2],
    compression: DeflateCompression,
    scale: Scale,
    pixels: &[u8],
) -> std::io::Result<()> {
    let mut encoder = Encoder::new(to, width as u32, height as u32);
    encoder.set_color(ColorType::Indexed);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_palette(palette(scale));
    encoder.set_deflate_compression(compression);
    encoder.set_filter(Filter::NoFilter); // differences of palette entries mean nothing
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    Ok(writer.finish()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_half_shows_the_strongest_of_four_and_of_equals_the_occupied() {
        let nan = f32::NAN;
        let half =
            |scale, values: [f32; 6]| PictureValues { extent: [3, 2], scale, values: values.to_vec() }.half().entries();
        let signed = Scale::Signed { limit: 1.0 };
        let of = |v: f32| entry(signed, f64::from(v));
        assert_eq!(half(signed, [-1.0, 1.0, nan, 0.5, -1.0, nan]), [of(1.0), 0]);
        assert_eq!(half(signed, [1.0, -1.0, nan, nan, 0.2, -0.3]), [of(1.0), of(-0.3)]);
        let classes = Scale::Classes(crate::grid::Palette::plain());
        assert_eq!(half(classes, [0.0, 2.0, 0.0, 1.0, 2.0, nan]), [2, 1]);
    }
}
