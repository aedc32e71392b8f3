//! Reads a map's picture: PGM (P2, P5) or PPM (P3, P6) of any maxval, without rounding a sample, and PNG or BMP. The number of pixels is
//! checked before memory is taken for them.

use crate::grid::GridSpec;
use crate::support::memory;
use crate::{Error, Result};
use image::{ColorType, ImageDecoder, ImageFormat, ImageReader};
use std::io::Cursor;
use std::path::Path;

/// The most pixels along a side, and of a picture.
const LONGEST: usize = 1 << 24;
const MOST: usize = 1 << 32;
/// The memory of a pixel while it becomes a map, without its samples, bytes.
const PIXEL: u64 = 48;
const KINDS: &str = "give a PNG, a PGM (P2, P5), a PPM or a BMP, and name it in the YAML file";

/// A picture's samples, row by row from the top.
pub(super) struct Picture {
    pub width: usize,
    pub height: usize,
    /// Samples of a pixel: grey, grey and alpha, RGB, RGBA.
    channels: usize,
    /// The largest value of a sample.
    top: f64,
    samples: Samples,
}

enum Samples {
    Bytes(Vec<u8>),
    Words(Vec<u16>),
}

/// A pixel: the sum of red, green and blue, and alpha, each of `top`.
pub(super) struct Pixel {
    colour: u32,
    alpha: Option<u32>,
    top: f64,
}

impl Pixel {
    /// The brightness, 0 to 1: the mean of its colours.
    pub fn shade(&self) -> f64 {
        f64::from(self.colour) / 3.0 / self.top
    }

    /// The mean of its colours and of its alpha, where it has one.
    pub fn shade_with_alpha(&self) -> f64 {
        self.alpha.map_or_else(|| self.shade(), |alpha| f64::from(self.colour + alpha) / 4.0 / self.top)
    }

    /// Whether it is opaque.
    pub fn is_opaque(&self) -> bool {
        self.alpha.is_none_or(|alpha| f64::from(alpha) == self.top)
    }
}

type Read<T> = std::result::Result<T, Fault>;

/// A fault of the picture, or too little memory for it.
enum Fault {
    Picture(String),
    Memory(Error),
}

impl From<String> for Fault {
    fn from(what: String) -> Fault {
        Fault::Picture(what)
    }
}

impl Picture {
    /// Reads a picture that the YAML file `named` names, of `resolution` metres a pixel.
    pub fn open(path: &Path, resolution: f64, named: &Path) -> Result<Picture> {
        let unreadable = |what: String| {
            Error::input(path, format!("can't be read: {what}; {} names it as its image", named.display()))
        };
        let file = std::fs::metadata(path).map_err(|e| unreadable(e.to_string()))?;
        if !file.is_file() {
            return Err(unreadable("it is no file".into()));
        }
        if memory::available().is_some_and(|free| file.len() > free) {
            let what =
                format!("{} is {}, more than this machine has free", path.display(), memory::format_size(file.len()));
            return Err(Error::Resources(what));
        }
        let bytes = std::fs::read(path).map_err(|e| unreadable(e.to_string()))?;
        let fits = |width, height, sample| fits(path, resolution, width, height, sample);
        let read = match bytes.get(..2) {
            Some(b"P2" | b"P3" | b"P5" | b"P6") => Picture::netpbm(&bytes, fits),
            _ => Picture::other(&bytes, fits),
        };
        read.map_err(|fault| match fault {
            Fault::Picture(what) => Error::input(path, what),
            Fault::Memory(error) => error,
        })
    }

    /// A PNG or a BMP.
    fn other(bytes: &[u8], fits: impl Fn(usize, usize, u64) -> Read<()>) -> Read<Picture> {
        let format = image::guess_format(bytes).ok().filter(|f| [ImageFormat::Png, ImageFormat::Bmp].contains(f));
        let Some(format) = format else { return Err(format!("it is no picture that can be read: {KINDS}").into()) };
        let damaged = |e: image::ImageError| Fault::Picture(format!("it is damaged: {e}: save it anew"));
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
        reader.no_limits();
        let decoder = reader.into_decoder().map_err(damaged)?;
        let (width, height) = decoder.dimensions();
        let (width, height, colour) = (width as usize, height as usize, decoder.color_type());
        fits(width, height, u64::from(colour.bytes_per_pixel()))?;
        let mut pixels = vec![0; width * height * usize::from(colour.bytes_per_pixel())];
        decoder.read_image(&mut pixels).map_err(damaged)?;
        let channels = usize::from(colour.channel_count());
        let (top, samples) = match colour {
            ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => (255.0, Samples::Bytes(pixels)),
            ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
                let words = pixels.chunks_exact(2).map(|w| u16::from_ne_bytes([w[0], w[1]])).collect();
                (65535.0, Samples::Words(words))
            }
            other => return Err(format!("its pixels are {other:?}: {KINDS}").into()),
        };
        Ok(Picture { width, height, channels, top, samples })
    }

    /// A PGM or a PPM, as text or in bytes.
    fn netpbm(bytes: &[u8], fits: impl Fn(usize, usize, u64) -> Read<()>) -> Read<Picture> {
        let kind = bytes[1];
        let (plain, channels) = (kind < b'4', if kind == b'2' || kind == b'5' { 1 } else { 3 });
        let mut words = NumberReader { bytes, at: 2 };
        let mut number = |most| words.number().filter(|n| (1..=most).contains(n));
        let (Some(width), Some(height), Some(top)) = (number(LONGEST), number(LONGEST), number(65535)) else {
            let kind = char::from(kind);
            return Err(format!("its header is not P{kind}, width, height and a largest value of at most 65535").into());
        };
        fits(width, height, channels as u64 * 4)?;
        let count = width * height * channels;
        let ends = |n: usize| Fault::Picture(format!("it ends after {} of {} pixels", n / channels, width * height));
        let samples: Samples = if plain {
            let mut samples = Vec::new();
            while samples.len() < count {
                match words.number() {
                    Some(n) if n <= top => samples.push(n as u16),
                    Some(n) => {
                        return Err(format!(
                            "its pixel {} is {n}, more than its largest value {top}",
                            samples.len() / channels
                        )
                        .into());
                    }
                    None if words.ended() => return Err(ends(samples.len())),
                    None => return Err(format!("its pixel {} is no number", samples.len() / channels).into()),
                }
            }
            Samples::Words(samples)
        } else {
            let wide = 1 + usize::from(top > 255);
            // one blank ends the header; an editor may have made two bytes of it
            let mut rest = bytes.get(words.at + 1..).unwrap_or_default();
            if bytes.get(words.at..words.at + 2) == Some(b"\r\n") && rest.len() > count * wide {
                rest = &rest[1..];
            }
            let Some(rest) = rest.get(..count * wide) else { return Err(ends(rest.len() / wide)) };
            match wide {
                1 => Samples::Bytes(rest.to_vec()),
                _ => Samples::Words(rest.chunks_exact(2).map(|w| u16::from_be_bytes([w[0], w[1]])).collect()),
            }
        };
        let picture = Picture { width, height, channels, top: top as f64, samples };
        match (0..count).find(|k| picture.sample(*k) > top as u32) {
            Some(k) => {
                let what = picture.sample(k);
                Err(format!("its pixel {} is {what}, more than its largest value {top}", k / channels).into())
            }
            None => Ok(picture),
        }
    }

    fn sample(&self, k: usize) -> u32 {
        match &self.samples {
            Samples::Bytes(bytes) => u32::from(bytes[k]),
            Samples::Words(words) => u32::from(words[k]),
        }
    }

    /// Pixel `k`, counted from the upper left.
    pub fn pixel(&self, k: usize) -> Pixel {
        let at = k * self.channels;
        let sample = |n: usize| self.sample(at + n);
        let (colour, alpha) = match self.channels {
            1 => (3 * sample(0), None),
            2 => (3 * sample(0), Some(sample(1))),
            3 => (sample(0) + sample(1) + sample(2), None),
            _ => (sample(0) + sample(1) + sample(2), Some(sample(3))),
        };
        Pixel { colour, alpha, top: self.top }
    }
}

/// Checks that a picture's pixels, each with `bytes` of samples, fit in memory.
fn fits(path: &Path, resolution: f64, width: usize, height: usize, bytes: u64) -> Read<()> {
    if width == 0 || height == 0 || width > LONGEST || height > LONGEST || width * height > MOST {
        return Err(format!("it has {width} × {height} pixels: no map has so many, or none").into());
    }
    let grid = GridSpec { anchor: (0.0, 0.0), resolution, i0: 0, j0: 0, width, height };
    let remedy = format!("{} is too large: cut out the part that matters", path.display());
    grid.check_memory((width * height) as u64 * (PIXEL + 2 * bytes), None, &remedy).map_err(Fault::Memory)
}

/// Reads the numbers of a text, between blanks and comments.
struct NumberReader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl NumberReader<'_> {
    /// The next number; `None` at the end, or where there is something else.
    fn number(&mut self) -> Option<usize> {
        while let Some(byte) = self.bytes.get(self.at) {
            match byte {
                b'#' => {
                    self.at +=
                        self.bytes[self.at..].iter().position(|b| *b == b'\n').unwrap_or(self.bytes.len() - self.at)
                }
                byte if byte.is_ascii_whitespace() => self.at += 1,
                _ => break,
            }
        }
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(|b| !b.is_ascii_digit()).unwrap_or(rest.len());
        self.at += end;
        std::str::from_utf8(&rest[..end]).ok()?.parse().ok()
    }

    fn ended(&self) -> bool {
        self.at == self.bytes.len()
    }
}
