//! Pictures of a score as PNG bytes: classes, and error levels from white (right) to black (most dangerous).

use super::Cells;
use super::levels::NOT_COMPARED;
use png::{BitDepth, ColorType, Encoder, Filter};

/// Small maps are enlarged by a whole factor to about this many pixels, large ones reduced to at most `LARGEST`.
const WANTED: usize = 600;
const LARGEST: usize = 4096;
/// Cells that aren't compared; no shade of grey.
const OUTSIDE: [u8; 3] = [168, 180, 196];
/// Each level's colour, ever darker; the danger zone's are red.
const LEVELS: [[u8; 3]; 10] =
    [[255; 3], [238; 3], [212; 3], [196; 3], [180; 3], [150; 3], [120; 3], [170, 40, 45], [120, 10, 20], [50, 0, 8]];

/// A level's colour, as CSS takes it.
pub(super) fn colour(level: usize) -> String {
    let [r, g, b] = LEVELS[level];
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The error plot.
pub(super) fn errors(cells: &Cells) -> std::io::Result<Vec<u8>> {
    let entry = |k: usize| if cells.levels[k] == NOT_COMPARED { 0 } else { 1 + cells.levels[k] };
    let palette = [OUTSIDE].into_iter().chain(LEVELS).flatten().collect();
    draw(cells, palette, entry)
}

/// Classes: white empty, black occupied, bluish grey unknown.
pub(super) fn classes(cells: &Cells, class: &[i8]) -> std::io::Result<Vec<u8>> {
    let entry = |k: usize| match class[k] {
        c if c > 0 => 2,
        c if c < 0 => 1,
        _ => 0,
    };
    draw(cells, [OUTSIDE, [255; 3], [0; 3]].concat(), entry)
}

/// Draws the cells but for the margin, +y up. A pixel of a reduced picture shows its block's highest entry.
fn draw(cells: &Cells, palette: Vec<u8>, entry: impl Fn(usize) -> u8) -> std::io::Result<Vec<u8>> {
    let margin = cells.margin;
    let (width, height) = (cells.grid.width - 2 * margin, cells.grid.height - 2 * margin);
    let longest = width.max(height);
    let (less, more) = (longest.div_ceil(LARGEST).max(1), (WANTED / longest).clamp(1, 16));
    let (columns, rows) = (width.div_ceil(less), height.div_ceil(less));
    let block = |column: usize, row: usize| {
        let rows = row * less..((row + 1) * less).min(height);
        let columns = column * less..((column + 1) * less).min(width);
        let cell = |(r, c): (usize, usize)| entry((r + margin) * cells.grid.width + c + margin);
        rows.flat_map(|r| columns.clone().map(move |c| (r, c))).map(cell).max().unwrap_or(0)
    };
    let mut pixels = Vec::with_capacity(columns * rows * more * more);
    for row in (0..rows).rev() {
        let line: Vec<u8> = (0..columns).flat_map(|c| std::iter::repeat_n(block(c, row), more)).collect();
        (0..more).for_each(|_| pixels.extend(&line));
    }
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, (columns * more) as u32, (rows * more) as u32);
    encoder.set_color(ColorType::Indexed);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_palette(palette);
    encoder.set_filter(Filter::NoFilter);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels)?;
    writer.finish()?;
    Ok(bytes)
}
