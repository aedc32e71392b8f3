//! The pictures of a failed comparison: both maps and their difference.

use super::overlap::Overlap;
use super::{Comparison, LayerDifference, differs, distance, tolerance_of};
use crate::grid::{Data, Layer, Map, Scale};
use crate::output::write_picture;
use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// Writes both pictures and their difference for every layer that differs, into a folder that is created if need be. Returns the paths. In
/// the difference red is where the second map is higher; a cell that differs has at least a quarter of the full colour.
///
/// # Errors
/// [`Error::Resources`] where a file can't be written or another file has its name.
pub fn write_pictures(a: &Map, b: &Map, comparison: &Comparison, folder: &Path) -> Result<Vec<PathBuf>> {
    let mut written = Vec::new();
    if comparison.layers.is_empty() || comparison.equal {
        return Ok(written);
    }
    let overlap = Overlap::of(&a.grid, &b.grid)?;
    std::fs::create_dir_all(folder)
        .map_err(|e| Error::Resources(format!("{} can't be made: {e}; give another folder", folder.display())))?;
    let (left, right) = (overlap.crop(a, overlap.a), overlap.crop(b, overlap.b));
    for found in comparison.layers.iter().filter(|l| l.differ > 0) {
        let (Some(from), Some(to)) = (left.layer(&found.name), right.layer(&found.name)) else { continue };
        let difference = difference_layer(from, to, found, comparison.tolerance);
        // Without the layer `touched`, so that a cell that only one map touched shows its colour.
        let bare = Map {
            grid: left.grid,
            method: left.method.clone(),
            layers: Vec::new(),
            updates: 0,
            increments: Vec::new(),
        };
        for (map, layer, suffix) in [(&left, from, "a"), (&right, to, "b"), (&bare, &difference, "difference")] {
            let path = folder.join(format!("{}.{suffix}.png", found.name));
            refuse_other_file(&path)?;
            write_picture(&path, map, layer)?;
            written.push(path);
        }
    }
    Ok(written)
}

/// Refuses to overwrite a file that is no PNG.
fn refuse_other_file(path: &Path) -> Result<()> {
    match std::fs::read(path) {
        Ok(bytes) if !bytes.starts_with(b"\x89PNG") => Err(Error::Resources(format!(
            "{} is there and is no picture, so it is left as it is: give another folder with --pictures",
            path.display()
        ))),
        _ => Ok(()),
    }
}

/// The difference of two layers of the same size, as a layer to draw.
fn difference_layer(from: &Layer, to: &Layer, found: &LayerDifference, tolerance: f64) -> Layer {
    let tolerance = tolerance_of(&found.name, tolerance);
    let full = if found.largest.is_finite() && found.largest > 0.0 { found.largest } else { 1.0 };
    let value = |k: usize| {
        let (a, b) = (from.data.get(k), to.data.get(k));
        let size = (distance(a, b) / full).clamp(0.25, 1.0) as f32;
        match differs(a, b, tolerance) {
            false => 0.0,
            true if b < a || b.is_nan() => -size,
            true => size,
        }
    };
    let data = Data::F32((0..from.data.len()).map(value).collect());
    let scale = Scale::Signed { limit: 1.0 };
    Layer { name: "difference".into(), about: "second minus first", data, fill: 0.0, scale }
}
