//! The cells to compare: the truth and the map on one grid. A margin of cells that are not compared surrounds them, so that every compared
//! cell has its neighbours.

use super::levels::{NOT_COMPARED, class_of, level};
use super::probability::probabilities;
use super::{Options, TrueCells};
use crate::evaluate::compare::axis_overlap;
use crate::grid::{GridSpec, Map};
use crate::output::tidy;
use crate::{Error, Result};
use rayon::prelude::*;

/// The truth and the map on one grid, row by row from the bottom.
#[derive(Debug, Clone)]
pub struct ScoredCells {
    /// The grid, with the margin.
    pub grid: GridSpec,
    /// Cells of margin on each side.
    pub margin: usize,
    /// True classes: 1 occupied, 0 unknown, −1 empty.
    pub actual: Vec<i8>,
    /// The map's classes; unknown outside the map.
    pub obtained: Vec<i8>,
    /// The map's probability of occupied; 0.5 where nothing is known.
    pub probability: Vec<f32>,
    /// Error level of each cell, 0 to 9, or [`NOT_COMPARED`].
    pub levels: Vec<u8>,
    /// Cells by which an occupied cell may be displaced and still match.
    pub tolerance: usize,
}

impl ScoredCells {
    /// Puts a map and its truth on one grid.
    ///
    /// # Errors
    /// [`Error::Usage`] where their cells do not coincide, there is nothing to compare, or the map lacks a layer.
    pub fn of(map: &Map, truth: &TrueCells, options: &Options) -> Result<ScoredCells> {
        let offset = cell_offset(&truth.grid, &map.grid)?;
        let (Some(class), Some(touched)) = (map.layer("class"), map.layer("touched")) else {
            return Err(Error::Usage(format!("the {} map has no layers class and touched", map.method)));
        };
        let rectangle = if truth.all { truth.grid } else { overlap(&truth.grid, &map.grid, offset)? };
        let margin = options.tolerance.max(1);
        let grid = with_margin(&rectangle, margin);
        let probability = probabilities(map);
        let decided = |k: usize| match options.decide {
            None => class_of(class.data.get(k)),
            Some(_) if touched.data.get(k) == 0.0 => 0,
            Some((high, low)) => {
                let p = probability[k];
                i8::from(p > high as f32) - i8::from(p < low as f32)
            }
        };
        // The first cell of this grid in the truth's grid, and in the map's.
        let in_truth = (grid.i0 - truth.grid.i0, grid.j0 - truth.grid.j0);
        let in_map = (in_truth.0 - offset.0, in_truth.1 - offset.1);
        let actual = resample(&grid, &truth.grid, in_truth, 0, |k| truth.class[k].signum());
        let obtained = resample(&grid, &map.grid, in_map, 0, decided);
        let seen = resample(&grid, &map.grid, in_map, false, |k| touched.data.get(k) != 0.0);
        let probability = resample(&grid, &map.grid, in_map, 0.5, |k| probability[k]);
        let tolerance = options.tolerance;
        let mut cells = ScoredCells { grid, margin, actual, obtained, probability, levels: Vec::new(), tolerance };
        cells.levels = cells.find_levels(|k| truth.all || (seen[k] && cells.actual[k] != 0));
        if cells.levels.iter().all(|l| *l == NOT_COMPARED) {
            return Err(Error::Usage(
                "the map and its truth have no cell in common that both have seen: are they of the same place?".into(),
            ));
        }
        Ok(cells)
    }

    fn find_levels(&self, compared: impl Fn(usize) -> bool + Sync) -> Vec<u8> {
        let (width, margin) = (self.grid.width, self.margin);
        let rows = margin..self.grid.height - margin;
        let mut levels = vec![NOT_COMPARED; self.grid.cells()];
        levels.par_chunks_mut(width).enumerate().filter(|(row, _)| rows.contains(row)).for_each(|(row, levels)| {
            for column in margin..width - margin {
                let k = row * width + column;
                if compared(k) {
                    let near = |class: &[i8]| self.has_occupied_neighbour(class, k, 1);
                    levels[column] = level(self.actual[k], self.obtained[k], near(&self.obtained), near(&self.actual));
                }
            }
        });
        levels
    }

    /// Whether another cell within `reach` of cell `k` is occupied. `k` is not in the margin.
    fn has_occupied_neighbour(&self, class: &[i8], k: usize, reach: usize) -> bool {
        let width = self.grid.width;
        let first = k - reach * width - reach;
        (0..=2 * reach).any(|row| {
            let start = first + row * width;
            (start..=start + 2 * reach).any(|m| m != k && class[m] > 0)
        })
    }

    /// Whether cell `k` or one within the tolerance is truly occupied.
    pub(super) fn is_near_true_wall(&self, k: usize) -> bool {
        self.actual[k] > 0 || self.has_occupied_neighbour(&self.actual, k, self.tolerance)
    }

    /// Whether cell `k` or one within the tolerance is occupied in the map.
    pub(super) fn is_near_shown_wall(&self, k: usize) -> bool {
        self.obtained[k] > 0 || self.has_occupied_neighbour(&self.obtained, k, self.tolerance)
    }
}

/// The values of a grid on the cells of `frame`, whose first cell is `first` in that grid.
fn resample<T: Copy + Send + Sync>(
    frame: &GridSpec,
    grid: &GridSpec,
    first: (i64, i64),
    outside: T,
    value: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    let mut values = vec![outside; frame.cells()];
    values.par_chunks_mut(frame.width).enumerate().for_each(|(line, values)| {
        let row = first.1 + line as i64;
        if !(0..grid.height as i64).contains(&row) {
            return;
        }
        for (column, cell) in (first.0..).zip(values) {
            if (0..grid.width as i64).contains(&column) {
                *cell = value(row as usize * grid.width + column as usize);
            }
        }
    });
    values
}

/// The number of cells from the truth's first cell to the map's, in x and y; an error where the cells do not coincide.
fn cell_offset(truth: &GridSpec, map: &GridSpec) -> Result<(i64, i64)> {
    // Over the whole map the two may drift apart by a hundredth of a cell.
    let largest = [map.width, map.height, truth.width, truth.height].into_iter().fold(1, usize::max);
    if (truth.resolution / map.resolution - 1.0).abs() * largest as f64 > 0.01 {
        return Err(Error::Usage(format!(
            "the truth has cells of {} m, the map of {} m: make both with one --resolution",
            truth.resolution, map.resolution
        )));
    }
    let offset = |anchor: (f64, f64), first: (i64, i64)| {
        let cells = (anchor.1 - anchor.0) / map.resolution;
        let whole = cells.round();
        ((cells - whole).abs() < 1e-4 && whole.abs() < 1e15).then(|| whole as i64 + first.1 - first.0)
    };
    let across = offset((truth.anchor.0, map.anchor.0), (truth.i0, map.i0));
    let up = offset((truth.anchor.1, map.anchor.1), (truth.j0, map.j0));
    across.zip(up).ok_or_else(|| {
        Error::Usage(format!(
            "the truth's cells start at ({0}, {1}) and the map's at ({2}, {3}), which is no whole number of cells of {4} m \
             apart: map both with the same --bounds, or the scored map with --bounds {0},{1},X1,Y1",
            tidy(truth.x0()),
            tidy(truth.y0()),
            tidy(map.x0()),
            tidy(map.y0()),
            map.resolution
        ))
    })
}

/// The rectangle that both grids have in common, on the truth's anchor.
fn overlap(truth: &GridSpec, map: &GridSpec, (across, up): (i64, i64)) -> Result<GridSpec> {
    match (axis_overlap(across, truth.width, map.width), axis_overlap(up, truth.height, map.height)) {
        (Some(x), Some(y)) => Ok(GridSpec {
            i0: truth.i0 + x.a as i64,
            j0: truth.j0 + y.a as i64,
            width: x.length,
            height: y.length,
            ..*truth
        }),
        _ => Err(Error::Usage("the map and its truth have no cell in common: are they of the same place?".into())),
    }
}

/// A grid with a margin of so many cells.
fn with_margin(grid: &GridSpec, by: usize) -> GridSpec {
    let (i0, j0) = (grid.i0 - by as i64, grid.j0 - by as i64);
    GridSpec { i0, j0, width: grid.width + 2 * by, height: grid.height + 2 * by, ..*grid }
}
