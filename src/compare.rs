//! Two maps, layer by layer: how many cells differ, by how much, and where the worst one is. Nothing is tolerated that
//! wasn't asked for: the default is equality to the bit, and no share of the cells may differ.

use crate::grid::{Data, GridSpec, Layer, Map, Scale};
use crate::output::write_picture;
use crate::{Error, Result};
use serde::Serialize;
use std::fmt;
use std::path::{Path, PathBuf};

/// How to compare.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// Largest |difference| of a value that still counts as equal; 0: equal to the bit. Classes and flags must be equal
    /// whatever it is.
    pub tolerance: f64,
    /// Compare the cells that both maps have, where their grids differ.
    pub common: bool,
}

/// A cell that differs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Worst {
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

/// What became of one layer that both maps have.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LayerDifference {
    /// The layer.
    pub name: String,
    /// Cells that differ by more than the tolerance.
    pub differ: u64,
    /// Largest |difference|, tolerated or not; infinite (`null` in JSON) where only one side is a finite number.
    pub largest: f64,
    /// The cell with the largest difference, of those that differ.
    pub worst: Option<Worst>,
    /// The two data types, where they differ: that is a difference too.
    pub types: Option<[&'static str; 2]>,
}

/// What two maps have in common, and what not.
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
    /// Layers of the first map alone.
    pub only_a: Vec<String>,
    /// Layers of the second map alone.
    pub only_b: Vec<String>,
    /// Cells that only one of the maps has touched.
    pub touched: u64,
    /// Cells of different class.
    pub class: u64,
}

/// Compares two maps. Different grids are a difference, unless `common` asks for the cells that both have; then grids
/// that don't fall on one another are an error.
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
    let shared = Shared::of(&a.grid, &b.grid)?;
    result.cells = (shared.width * shared.height) as u64;
    for layer in &a.layers {
        let Some(other) = b.layer(&layer.name) else { continue };
        let found = difference(&a.grid, &b.grid, &shared, layer, other, options.tolerance);
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

/// Writes, for every layer that differs, both pictures and their difference into `folder`, made if need be, and returns
/// the paths. In the difference red is where the second map is higher; cells that differ are never fainter than a
/// quarter of full colour.
pub fn write_pictures(a: &Map, b: &Map, comparison: &Comparison, folder: &Path) -> Result<Vec<PathBuf>> {
    let mut written = Vec::new();
    if comparison.layers.is_empty() || comparison.equal {
        return Ok(written);
    }
    let shared = Shared::of(&a.grid, &b.grid)?;
    std::fs::create_dir_all(folder)
        .map_err(|e| Error::Resources(format!("{} can't be made: {e}; give another folder", folder.display())))?;
    let (left, right) = (shared.cut(a, shared.a), shared.cut(b, shared.b));
    for found in comparison.layers.iter().filter(|l| l.differ > 0) {
        let (Some(from), Some(to)) = (left.layer(&found.name), right.layer(&found.name)) else { continue };
        let between = between(from, to, found, comparison.tolerance);
        // Without `touched`, so that a cell that only one side touched shows its colour.
        let bare = Map { grid: left.grid, method: left.method.clone(), layers: Vec::new(), updates: 0 };
        for (map, layer, suffix) in [(&left, from, "a"), (&right, to, "b"), (&bare, &between, "difference")] {
            let path = folder.join(format!("{}.{suffix}.png", found.name));
            write_picture(&path, map, layer)?;
            written.push(path);
        }
    }
    Ok(written)
}

/// The rectangle of cells that two grids share.
struct Shared {
    /// Its first column and row in the first grid.
    a: (usize, usize),
    /// Its first column and row in the second grid.
    b: (usize, usize),
    width: usize,
    height: usize,
}

impl Shared {
    fn of(a: &GridSpec, b: &GridSpec) -> Result<Shared> {
        let refuse = |why: &str| {
            Error::Usage(format!("{} and {} can't be compared cell by cell: {why}", describe(a), describe(b)))
        };
        if a.resolution != b.resolution {
            return Err(refuse("make both with one --resolution"));
        }
        // How many cells the second grid starts after the first. Within one anchor that is exact.
        let offset = |anchor: (f64, f64), first: (i64, i64)| {
            let cells = (anchor.1 - anchor.0) / a.resolution;
            let whole = cells.round();
            ((cells - whole).abs() < 1e-6 && whole.abs() < 1e15).then_some(whole as i64 + first.1 - first.0)
        };
        let across = offset((a.anchor.0, b.anchor.0), (a.i0, b.i0));
        let up = offset((a.anchor.1, b.anchor.1), (a.j0, b.j0));
        let (Some(across), Some(up)) = (across, up) else {
            return Err(refuse("their cells don't fall on one another: give both the same --bounds"));
        };
        let span = |offset: i64, a: usize, b: usize| {
            let (low, high) = (offset.max(0), (a as i64).min(offset + b as i64));
            (high > low).then_some((low as usize, (low - offset) as usize, (high - low) as usize))
        };
        match (span(across, a.width, b.width), span(up, a.height, b.height)) {
            (Some(x), Some(y)) => Ok(Shared { a: (x.0, y.0), b: (x.1, y.1), width: x.2, height: y.2 }),
            _ => Err(refuse("they have no cell in common")),
        }
    }

    /// Indices of the shared cells in a grid, row by row.
    fn cells(&self, grid: &GridSpec, first: (usize, usize)) -> impl Iterator<Item = usize> + use<> {
        let (grid_width, width, height) = (grid.width, self.width, self.height);
        (0..height).flat_map(move |r| (0..width).map(move |c| (first.1 + r) * grid_width + first.0 + c))
    }

    /// The shared part of a map.
    fn cut(&self, map: &Map, first: (usize, usize)) -> Map {
        let cells = || self.cells(&map.grid, first);
        let layers = map.layers.iter().map(|layer| {
            let data = match &layer.data {
                Data::F32(v) => Data::F32(cells().map(|k| v[k]).collect()),
                Data::U32(v) => Data::U32(cells().map(|k| v[k]).collect()),
                Data::U8(v) => Data::U8(cells().map(|k| v[k]).collect()),
                Data::I8(v) => Data::I8(cells().map(|k| v[k]).collect()),
            };
            Layer { data, ..layer.clone() }
        });
        let (i0, j0) = (map.grid.i0 + first.0 as i64, map.grid.j0 + first.1 as i64);
        let grid = GridSpec { i0, j0, width: self.width, height: self.height, ..map.grid };
        Map { grid, method: map.method.clone(), layers: layers.collect(), updates: map.updates }
    }
}

/// |b − a|: 0 if both are the same number or both no number, infinite if only one is finite.
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

/// Classes and flags know no tolerance.
fn tolerance_of(layer: &str, tolerance: f64) -> f64 {
    if ["touched", "class"].contains(&layer) { 0.0 } else { tolerance }
}

fn difference(
    grid: &GridSpec,
    other_grid: &GridSpec,
    shared: &Shared,
    layer: &Layer,
    other: &Layer,
    tolerance: f64,
) -> LayerDifference {
    let tolerance = tolerance_of(&layer.name, tolerance);
    let types = [type_of(&layer.data), type_of(&other.data)];
    let types = (types[0] != types[1]).then_some(types);
    let mut found = LayerDifference { name: layer.name.clone(), differ: 0, largest: 0.0, worst: None, types };
    let mut worst: Option<(usize, f64, f64, f64)> = None;
    for (k, m) in shared.cells(grid, shared.a).zip(shared.cells(other_grid, shared.b)) {
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
        Worst { column, row, x, y, a, b }
    });
    found
}

/// The difference of two layers of the same size, as a layer to be shown.
fn between(from: &Layer, to: &Layer, found: &LayerDifference, tolerance: f64) -> Layer {
    let tolerance = tolerance_of(&found.name, tolerance);
    let full = if found.largest.is_finite() && found.largest > 0.0 { found.largest } else { 1.0 };
    let shown = |k: usize| {
        let (a, b) = (from.data.get(k), to.data.get(k));
        let size = (distance(a, b) / full).clamp(0.25, 1.0) as f32;
        match differs(a, b, tolerance) {
            false => 0.0,
            true if b < a || b.is_nan() => -size,
            true => size,
        }
    };
    let data = Data::F32((0..from.data.len()).map(shown).collect());
    let scale = Scale::Signed { limit: 1.0 };
    Layer { name: "difference".into(), about: "second minus first", data, fill: 0.0, scale }
}

fn type_of(data: &Data) -> &'static str {
    match data {
        Data::F32(_) => "float32",
        Data::U32(_) => "uint32",
        Data::U8(_) => "uint8",
        Data::I8(_) => "int8",
    }
}

fn describe(grid: &GridSpec) -> String {
    let GridSpec { resolution, width, height, .. } = grid;
    format!("{width} × {height} cells of {resolution} m from ({}, {})", grid.x0(), grid.y0())
}

impl fmt::Display for Comparison {
    /// A table, a layer a line, and the verdict.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(grids) = &self.grids {
            writeln!(f, "grids differ: {grids}")?;
        }
        if !self.layers.is_empty() {
            writeln!(f, "{:<12} {:>12} {:>12}  worst cell", "layer", "cells differ", "largest")?;
        }
        for layer in &self.layers {
            write!(f, "{:<12} {:>12} {:>12.6e}", layer.name, layer.differ, layer.largest)?;
            if let Some(Worst { column, row, x, y, a, b }) = layer.worst {
                write!(f, "  ({column}, {row}) at {x:.3}, {y:.3} m: {a} and {b}")?;
            }
            if let Some([a, b]) = layer.types {
                write!(f, "  types {a} and {b}")?;
            }
            writeln!(f)?;
        }
        for (names, which) in [(&self.only_a, "first"), (&self.only_b, "second")] {
            if !names.is_empty() {
                writeln!(f, "only in the {which} map: {}", names.join(", "))?;
            }
        }
        match (self.equal, self.tolerance) {
            (true, 0.0) => write!(f, "equal: {} cells, to the bit", self.cells),
            (true, t) => write!(f, "equal: {} cells, within {t}", self.cells),
            (false, _) if self.layers.is_empty() => write!(f, "different"),
            (false, _) => write!(
                f,
                "different: of {} cells {} touched by one map only, {} of another class",
                self.cells, self.touched, self.class
            ),
        }
    }
}
