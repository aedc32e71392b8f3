//! The schema of a map: its grid, its method and its layers without values; and crops of layers.

use crate::grid::{ChunkId, Data, GridSpec, Layer, part};

/// The schema of a map that is written.
#[derive(Debug, Clone)]
pub struct MapSchema {
    /// The cells.
    pub grid: GridSpec,
    /// The method's name.
    pub method: String,
    /// The layers, without values.
    pub layers: Vec<Layer>,
    /// The combined layer, without values.
    pub combined: Layer,
    /// Whether each layer is written as `.npy` too.
    pub npy: bool,
}

/// A layer without its values.
pub fn schema(layer: &Layer) -> Layer {
    let data = match layer.data {
        Data::F32(_) => Data::F32(Vec::new()),
        Data::U32(_) => Data::U32(Vec::new()),
        Data::U8(_) => Data::U8(Vec::new()),
        Data::I8(_) => Data::I8(Vec::new()),
    };
    Layer { data, name: layer.name.clone(), ..*layer }
}

/// The part of a layer of the whole grid that lies in a chunk.
pub fn crop(grid: &GridSpec, layer: &Layer, at: ChunkId) -> Layer {
    let part = part(grid, at);
    let [column, row] = at.first_cell();
    fn rows<T: Copy>(values: &[T], grid: &GridSpec, part: &GridSpec, column: usize, row: usize) -> Vec<T> {
        let line = |r: usize| &values[r * grid.width + column..][..part.width];
        (row..row + part.height).flat_map(|r| line(r).iter().copied()).collect()
    }
    let data = match &layer.data {
        Data::F32(v) => Data::F32(rows(v, grid, &part, column, row)),
        Data::U32(v) => Data::U32(rows(v, grid, &part, column, row)),
        Data::U8(v) => Data::U8(rows(v, grid, &part, column, row)),
        Data::I8(v) => Data::I8(rows(v, grid, &part, column, row)),
    };
    Layer { data, name: layer.name.clone(), ..*layer }
}
