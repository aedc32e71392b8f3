//! Makes the layers of a map from the cells' words, or from the oracle's values: the same layers for every backend.

use crate::geometry::layout::{CHUNK, TILE, TILE_CELLS};
use crate::grid::{ChunkId, Class, Data, GridSpec, Layer, Map, Scale};
use crate::kernels::ChunkStates;
use crate::method::{self, Method, Unit, add};
use crate::oracle::OracleMap;
use crate::pipeline::finished::{CellVisits, FinishedMap};
use rayon::prelude::*;

/// The layers of a map while they are filled; cells start untouched.
struct LayerBuilder<'a> {
    grid: &'a GridSpec,
    method: &'a dyn Method,
    values: Vec<Vec<f32>>,
    combined: Vec<f32>,
    touched: Vec<u8>,
    class: Vec<i8>,
    visits: CellVisits,
    increments: Vec<f64>,
}

impl<'a> LayerBuilder<'a> {
    fn new(grid: &'a GridSpec, method: &'a dyn Method) -> Self {
        let cells = grid.cells();
        LayerBuilder {
            grid,
            method,
            values: method.layers().iter().map(|s| vec![s.fill; cells]).collect(),
            combined: vec![0.0; cells],
            touched: vec![0; cells],
            class: vec![0; cells],
            increments: Vec::new(),
            visits: CellVisits {
                interior: vec![0; cells],
                arc: vec![0; cells],
                marks: vec![0; if method.marks().is_some() { cells } else { 0 }],
            },
        }
    }

    /// Splits the layers into bands of so many rows of cells, to be filled in parallel.
    fn row_bands(&mut self, rows: usize) -> Vec<RowBand<'_>> {
        let cells = (rows * self.grid.width).max(1);
        let count = self.combined.len().div_ceil(cells);
        let mut values: Vec<_> = self.values.iter_mut().map(|layer| layer.chunks_mut(cells)).collect();
        let mut combined = self.combined.chunks_mut(cells);
        let (mut touched, mut class) = (self.touched.chunks_mut(cells), self.class.chunks_mut(cells));
        let CellVisits { interior, arc, marks } = &mut self.visits;
        let mut visits = [interior, arc, marks].map(|counts| counts.chunks_mut(cells));
        let band = |_| RowBand {
            method: self.method,
            values: values.iter_mut().map(|layer| layer.next().unwrap_or_default()).collect(),
            combined: combined.next().unwrap_or_default(),
            touched: touched.next().unwrap_or_default(),
            class: class.next().unwrap_or_default(),
            visits: visits.each_mut().map(|counts| counts.next().unwrap_or_default()),
        };
        (0..count).map(band).collect()
    }

    fn finish(self) -> FinishedMap {
        let (visits, increments) = (self.visits, self.increments);
        let updates = visits.interior.iter().chain(&visits.arc).map(|n| u64::from(*n)).sum();
        let data = |integer: bool, values: Vec<f32>| match integer {
            true => Data::U32(values.iter().map(|v| *v as u32).collect()),
            false => Data::F32(values),
        };
        let mut layers: Vec<Layer> = (self.method.layers().iter().zip(self.values))
            .map(|(s, values)| layer(s.name, s.about, data(s.integer, values), f64::from(s.fill), s.scale))
            .collect();
        layers.extend(touched_and_class(self.touched, self.class));
        let combined = "-1 surely empty to 1 surely occupied";
        FinishedMap {
            map: Map { grid: *self.grid, method: method::name(self.method).into(), layers, updates, increments },
            combined: layer("combined", combined, Data::F32(self.combined), 0.0, SIGNED),
            visits,
        }
    }
}

const SIGNED: Scale = Scale::Signed { limit: 1.0 };

/// Consecutive rows of all layers.
struct RowBand<'a> {
    method: &'a dyn Method,
    values: Vec<&'a mut [f32]>,
    combined: &'a mut [f32],
    touched: &'a mut [u8],
    class: &'a mut [i8],
    /// Interior, arc, marks.
    visits: [&'a mut [u32]; 3],
}

impl RowBand<'_> {
    /// Sets the touched cell `k`, counted from the band's first. `visits`: its interior updates, arc updates and marks.
    fn set(&mut self, k: usize, visits: [u32; 3], values: &[f32], class: Class) {
        self.touched[k] = 1;
        self.class[k] = class as i8;
        self.combined[k] = self.method.combined(values, class);
        for (counts, count) in self.visits.iter_mut().zip(visits) {
            // A method without marks has no vector for them.
            if let Some(entry) = counts.get_mut(k) {
                *entry = count;
            }
        }
        for (layer, value) in self.values.iter_mut().zip(values) {
            layer[k] = *value;
        }
    }
}

fn layer(name: &str, about: &'static str, data: Data, fill: f64, scale: Scale) -> Layer {
    Layer { name: name.into(), about, data, fill, scale }
}

/// The layers `touched` and `class`, which every map has.
fn touched_and_class(touched: Vec<u8>, class: Vec<i8>) -> [Layer; 2] {
    let flag = Scale::Grey { low: 0.0, high: 1.0 };
    let about = "1 occupied, 0 unknown, -1 empty, by the method's decision rule";
    [
        layer("touched", "1 where a reading reached the cell", Data::U8(touched), 0.0, flag),
        layer("class", about, Data::I8(class), 0.0, SIGNED),
    ]
}

/// The layers of a method and its combined layer, without values.
pub fn schemas(method: &dyn Method) -> (Vec<Layer>, Layer) {
    let grid = GridSpec { anchor: (0.0, 0.0), resolution: 1.0, i0: 0, j0: 0, width: 0, height: 0 };
    let empty = LayerBuilder::new(&grid, method).finish();
    (empty.map.layers, empty.combined)
}

/// Makes a map of classes alone, such as the true map of a world. A cell of known class counts as touched.
pub fn of_classes(grid: GridSpec, method: &str, class: Vec<i8>) -> Map {
    let touched = class.iter().map(|c| u8::from(*c != 0)).collect();
    Map {
        grid,
        method: method.into(),
        layers: touched_and_class(touched, class).into(),
        updates: 0,
        increments: Vec::new(),
    }
}

/// Makes the map of the chunks of a kernel.
pub fn from_chunks(grid: &GridSpec, method: &dyn Method, chunks: &ChunkStates) -> FinishedMap {
    let mut layers = LayerBuilder::new(grid, method);
    let bands = layers.row_bands(TILE).into_par_iter().enumerate();
    let gains: Vec<Vec<f64>> = bands.map(|(row, band)| fill_tile_row(grid, method, chunks, row, band)).collect();
    let mut increments = Vec::new();
    gains.iter().for_each(|gains| add(gains, &mut increments));
    layers.increments = increments;
    layers.finish()
}

/// Fills the band of a row of tiles; returns the sums of what its cells' α gained.
fn fill_tile_row(
    grid: &GridSpec,
    method: &dyn Method,
    chunks: &ChunkStates,
    row: usize,
    mut band: RowBand,
) -> Vec<f64> {
    let mut cell = vec![0u32; method::planes(method)];
    let mut values = vec![0f32; method.layers().len()];
    // Scans touch cells with evidence that is too small to count as an update.
    let (subthreshold, words, mut gains) = (method.unit() == Unit::Scan, method::tile_words(method), Vec::new());
    let rows = TILE.min(grid.height - row * TILE);
    let chunk_row = (row / CHUNK) as u32;
    for (place, state) in
        chunks.range(ChunkId { row: chunk_row, column: 0 }..=ChunkId { row: chunk_row, column: u32::MAX })
    {
        let tiles = state.chunks_exact(words).skip(row % CHUNK * CHUNK).take(CHUNK);
        for (column, tile) in tiles.enumerate() {
            if subthreshold && tile.iter().all(|word| *word == 0) {
                continue;
            }
            let x0 = (place.column as usize * CHUNK + column) * TILE;
            for y in 0..rows {
                for x in x0..(x0 + TILE).min(grid.width) {
                    let at = y * TILE + x - x0;
                    let updated = tile[at] + tile[TILE_CELLS + at] > 0;
                    if !updated && !subthreshold {
                        continue;
                    }
                    for (p, word) in cell.iter_mut().enumerate() {
                        *word = tile[p * TILE_CELLS + at];
                    }
                    if !updated && !method.has_subthreshold_evidence(&cell) {
                        continue;
                    }
                    method.gains(&cell, &mut gains);
                    let class = method.values(&cell, &mut values);
                    let mark = method.marks().map_or(0, |plane| cell[2 + plane]);
                    band.set(y * grid.width + x, [cell[0], cell[1], mark], &values, class);
                }
            }
        }
    }
    gains
}

/// Makes the map of the oracle's values.
pub fn from_oracle(oracle: &OracleMap, method: &dyn Method) -> FinishedMap {
    let mut layers = LayerBuilder::new(&oracle.grid, method);
    let mut increments = Vec::new();
    let mut bands = layers.row_bands(oracle.grid.height);
    // One band holds all rows; a grid without cells has none.
    let Some(band) = bands.first_mut() else { return layers.finish() };
    for k in 0..oracle.grid.cells() {
        if oracle.is_touched(k) {
            let values: Vec<f32> = oracle.layers.iter().map(|l| l.values[k] as f32).collect();
            let class = match oracle.class[k] {
                1 => Class::Occupied,
                0 => Class::Unknown,
                _ => Class::Empty,
            };
            let gains = oracle.gains.get(k).map_or(&[][..], |g| g);
            add(gains, &mut increments);
            let mark = oracle.marks.get(k).copied().unwrap_or(0);
            band.set(k, [oracle.interior[k], oracle.arc[k], mark], &values, class);
        }
    }
    layers.increments = increments;
    layers.finish()
}
