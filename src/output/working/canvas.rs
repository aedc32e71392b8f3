//! The pixels of a picture in full colour, and their PNG.

use png::{BitDepth, ColorType, Encoder};
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

/// Red, green, blue.
pub(super) type Colour = [u8; 3];

/// An RGB picture, top row first.
pub(super) struct Canvas {
    width: i64,
    height: i64,
    pixels: Vec<u8>,
}

impl Canvas {
    /// A picture of one colour.
    pub fn new(width: i64, height: i64, colour: Colour) -> Canvas {
        Canvas { width, height, pixels: colour.repeat((width * height) as usize) }
    }

    /// Colours a pixel; what lies outside stays undrawn.
    pub fn put(&mut self, x: i64, y: i64, colour: Colour) {
        if (0..self.width).contains(&x) && (0..self.height).contains(&y) {
            let k = 3 * (y * self.width + x) as usize;
            self.pixels[k..k + 3].copy_from_slice(&colour);
        }
    }

    /// Writes it as a PNG.
    pub fn save(&self, path: &Path) -> std::io::Result<()> {
        let file = BufWriter::new(File::create(path)?);
        let mut encoder = Encoder::new(file, self.width as u32, self.height as u32);
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.pixels)?;
        Ok(writer.finish()?)
    }
}
