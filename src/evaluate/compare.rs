//! Compares two maps layer by layer: how many cells differ, by how much, and where the largest difference is. By default cells must be
//! equal to the bit; no fraction of them may differ.

mod overlap;
mod pictures;
mod table;

pub(crate) use overlap::axis_overlap;
pub use pictures::write_pictures;

use crate::Result;
use crate::grid::{Data, Layer, Map};
use overlap::{Overlap, describe};
use serde::Serialize;

/// How to compare.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// The largest |difference| of values that count as equal; 0: equal to the bit. Classes and flags must always be equal.
    pub tolerance: f64,
    /// Whether to compare only the common cells where the grids differ.
    pub common: bool,
}

/// The cell with the largest difference of a layer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LargestDifference {
    /// Column in the first map.
    pub column: usize,
    /// Row in the first map, from the bottom.
    pub row: usize,
    /// World x of its centre, metres.
    pub x: f64,
    /// World y of its centre, metres.
    pub y: f64,
    /// The first map's value.
    pub a: f64,
    /// The second map's value.
    pub b: f64,
}

/// The comparison of one layer that both maps have.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LayerDifference {
    /// The layer's name.
    pub name: String,
    /// Cells that differ by more than the tolerance.
    pub differ: u64,
    /// The largest |difference|, tolerated or not; infinite (`null` in JSON) where only one of the values is finite.
    pub largest: f64,
    /// The cell with the largest difference beyond the tolerance.
    pub worst: Option<LargestDifference>,
    /// The two data types where they differ, which counts as a difference.
    pub types: Option<[&'static str; 2]>,
}

/// The comparison of two maps.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Whether nothing differs.
    pub equal: bool,
    /// The tolerance used.
    pub tolerance: f64,
    /// How the grids differ, where they do.
    pub grids: Option<String>,
    /// Cells compared.
    pub cells: u64,
    /// The layers of both maps, in the first map's order.
    pub layers: Vec<LayerDifference>,
    /// Layers that only the first map has.
    pub only_a: Vec<String>,
    /// Layers that only the second map has.
    pub only_b: Vec<String>,
    /// Cells that only one of the maps has touched.
    pub touched: u64,
    /// Cells of different class.
    pub class: u64,
}

/// Compares two maps. Different grids are a difference, unless the options ask for the common cells.
///
/// # Errors
/// [`crate::Error::Usage`] where the common cells are wanted and the grids' cells do not coincide.
pub fn compare(a: &Map, b: &Map, options: &Options) -> Result<Comparison> {
    let grids = (a.grid != b.grid).then(|| format!("{} and {}", describe(&a.grid), describe(&b.grid)));
    let names = |of: &Map, other: &Map| {
        of.layers.iter().map(|l| l.name.clone()).filter(|n| other.layer(n).is_none()).collect::<Vec<_>>()
    };
    let (only_a, only_b) = (names(a, b), names(b, a));
    let mut result = Comparison {
        equal: only_a.is_empty() && only_b.is_empty(),
        tolerance: options.tolerance,
        grids,
        cells: 0,
        layers: Vec::new(),
        only_a,
        only_b,
        touched: 0,
        class: 0,
    };
    if result.grids.is_some() && !options.common {
        result.equal = false;
        return Ok(result);
    }
    let overlap = Overlap::of(&a.grid, &b.grid)?;
    result.cells = (overlap.width * overlap.height) as u64;
    for layer in &a.layers {
        let Some(other) = b.layer(&layer.name) else { continue };
        let found = Pair { a, b, overlap: &overlap, tolerance: options.tolerance }.compare_layer(layer, other);
        result.equal &= found.differ == 0 && found.types.is_none();
        match found.name.as_str() {
            "touched" => result.touched = found.differ,
            "class" => result.class = found.differ,
            _ => {}
        }
        result.layers.push(found);
    }
    Ok(result)
}

/// |b − a|: 0 where both are the same number or both NaN, infinite where only one is finite.
fn distance(a: f64, b: f64) -> f64 {
    match (a == b || (a.is_nan() && b.is_nan()), (b - a).abs()) {
        (true, _) => 0.0,
        (false, d) if d.is_nan() => f64::INFINITY,
        (false, d) => d,
    }
}

/// Whether two values count as different.
fn differs(a: f64, b: f64, tolerance: f64) -> bool {
    let same = a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
    !same && (tolerance == 0.0 || distance(a, b) > tolerance)
}

/// The tolerance of a layer: classes and flags have none.
fn tolerance_of(layer: &str, tolerance: f64) -> f64 {
    if ["touched", "class"].contains(&layer) { 0.0 } else { tolerance }
}

/// Two maps and how to compare their layers.
struct Pair<'a> {
    a: &'a Map,
    b: &'a Map,
    overlap: &'a Overlap,
    tolerance: f64,
}

impl Pair<'_> {
    fn compare_layer(&self, layer: &Layer, other: &Layer) -> LayerDifference {
        let (grid, tolerance) = (&self.a.grid, tolerance_of(&layer.name, self.tolerance));
        let cells = self.overlap.cells(grid, self.overlap.a).zip(self.overlap.cells(&self.b.grid, self.overlap.b));
        let types = [type_of(&layer.data), type_of(&other.data)];
        let types = (types[0] != types[1]).then_some(types);
        let mut found = LayerDifference { name: layer.name.clone(), differ: 0, largest: 0.0, worst: None, types };
        let mut worst: Option<(usize, f64, f64, f64)> = None;
        for (k, m) in cells {
            let (a, b) = (layer.data.get(k), other.data.get(m));
            let apart = distance(a, b);
            found.largest = found.largest.max(apart);
            if differs(a, b, tolerance) {
                found.differ += 1;
                if worst.is_none_or(|(_, most, ..)| apart > most) {
                    worst = Some((k, apart, a, b));
                }
            }
        }
        found.worst = worst.map(|(k, _, a, b)| {
            let (column, row) = (k % grid.width, k / grid.width);
            let (x, y) = grid.centre(column, row);
            LargestDifference { column, row, x, y, a, b }
        });
        found
    }
}

fn type_of(data: &Data) -> &'static str {
    match data {
        Data::F32(_) => "float32",
        Data::U32(_) => "uint32",
        Data::U8(_) => "uint8",
        Data::I8(_) => "int8",
    }
}
