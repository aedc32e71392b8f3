//! Pictures of a score as PNG: classes, and error levels from white (right) to black (most dangerous).

use super::ScoredCells;
use super::levels::NOT_COMPARED;
use png::{BitDepth, ColorType, Encoder, Filter};

/// Small maps are enlarged by a whole factor to about this many pixels.
const WANTED: usize = 600;
/// Large maps are reduced to at most this many pixels.
const LARGEST: usize = 4096;
/// The colour of cells that are not compared; bluish, unlike the levels' greys.
const OUTSIDE: [u8; 3] = [168, 180, 196];
/// The levels' colours, from white to dark; those of the danger zone are red.
pub(crate) const LEVELS: [[u8; 3]; 10] =
    [[255; 3], [238; 3], [212; 3], [196; 3], [180; 3], [150; 3], [120; 3], [170, 40, 45], [120, 10, 20], [50, 0, 8]];

/// A level's colour in CSS notation.
pub(super) fn colour(level: usize) -> String {
    let [r, g, b] = LEVELS[level];
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The rectangle that pictures show: the compared cells and a rim. Columns and rows count from the grid's anchor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Window {
    columns: [i64; 2],
    rows: [i64; 2],
}

impl Window {
    /// Cells of rim around the compared ones.
    const RIM: i64 = 3;

    /// Around all compared cells of these maps, so that their pictures can be laid side by side.
    pub fn around<'a>(all: impl Iterator<Item = &'a ScoredCells>) -> Window {
        let mut window = Window { columns: [i64::MAX, i64::MIN], rows: [i64::MAX, i64::MIN] };
        for cells in all {
            for (line, levels) in cells.levels.chunks(cells.grid.width).enumerate() {
                let compared = |l: &u8| *l != NOT_COMPARED;
                let ends = levels.iter().position(compared).zip(levels.iter().rposition(compared));
                let Some((first, last)) = ends else { continue };
                let widen = |span: &mut [i64; 2], low: i64, high: i64| {
                    *span = [span[0].min(low - Window::RIM), span[1].max(high + Window::RIM + 1)];
                };
                widen(&mut window.columns, cells.grid.i0 + first as i64, cells.grid.i0 + last as i64);
                widen(&mut window.rows, cells.grid.j0 + line as i64, cells.grid.j0 + line as i64);
            }
        }
        window
    }
}

/// The error plot as PNG.
pub(super) fn errors(cells: &ScoredCells, window: &Window) -> std::io::Result<Vec<u8>> {
    let entry = |k: usize| if cells.levels[k] == NOT_COMPARED { 0 } else { 1 + cells.levels[k] };
    let palette = [OUTSIDE].into_iter().chain(LEVELS).flatten().collect();
    draw(cells, window, palette, entry)
}

/// Classes as PNG: white empty, black occupied, bluish grey unknown.
pub(super) fn classes(cells: &ScoredCells, window: &Window, class: &[i8]) -> std::io::Result<Vec<u8>> {
    let entry = |k: usize| match class[k] {
        c if c > 0 => 2,
        c if c < 0 => 1,
        _ => 0,
    };
    draw(cells, window, [OUTSIDE, [255; 3], [0; 3]].concat(), entry)
}

/// Draws a window of the cells, +y up. A pixel of a reduced picture shows its block's highest entry.
fn draw(
    cells: &ScoredCells,
    window: &Window,
    palette: Vec<u8>,
    entry: impl Fn(usize) -> u8,
) -> std::io::Result<Vec<u8>> {
    let length = |[low, high]: [i64; 2]| high.saturating_sub(low).max(1) as usize;
    let (width, height) = (length(window.columns), length(window.rows));
    let longest = width.max(height);
    let (reduction, enlargement) = (longest.div_ceil(LARGEST).max(1), (WANTED / longest).clamp(1, 16));
    let (columns, rows) = (width.div_ceil(reduction), height.div_ceil(reduction));
    let cell = |(row, column): (i64, i64)| {
        let (row, column) = (row - cells.grid.j0, column - cells.grid.i0);
        let inside = (0..cells.grid.width as i64).contains(&column) && (0..cells.grid.height as i64).contains(&row);
        if inside { entry(row as usize * cells.grid.width + column as usize) } else { 0 }
    };
    let span = |[low, high]: [i64; 2], k: usize| {
        let first = low + (k * reduction) as i64;
        first..(first + reduction as i64).min(high)
    };
    let block = |column: usize, row: usize| {
        let rows = span(window.rows, row);
        let columns = span(window.columns, column);
        rows.flat_map(|r| columns.clone().map(move |c| (r, c))).map(cell).max().unwrap_or(0)
    };
    let mut pixels = Vec::with_capacity(columns * rows * enlargement * enlargement);
    for row in (0..rows).rev() {
        let line: Vec<u8> = (0..columns).flat_map(|c| std::iter::repeat_n(block(c, row), enlargement)).collect();
        (0..enlargement).for_each(|_| pixels.extend(&line));
    }
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, (columns * enlargement) as u32, (rows * enlargement) as u32);
    encoder.set_color(ColorType::Indexed);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_palette(palette);
    encoder.set_filter(Filter::NoFilter);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels)?;
    writer.finish()?;
    Ok(bytes)
}
