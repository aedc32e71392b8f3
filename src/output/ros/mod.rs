//! `map.pgm` and `map.yaml`: writes the classes for nav2's map_server (mode trinary), and reads such a pair as map_server does.
//!
//! map_server takes p = 1 − v/255 of a pixel: above `occupied_thresh` it is occupied, below `free_thresh` free, else
//! unknown. 205 gives 0.19608, just above 0.196: unknown. Row 0 of the picture is the top; the origin is the lower left
//! corner of the lower left pixel.

mod picture;
mod settings;
mod yaml;

use super::names::{PGM, YAML};
use super::raster::{Raster, RasterLayout};
use super::report::tidy;
use super::unwritable;
use crate::grid::{Data, GridSpec, Layer, Map, Scale};
use crate::{Error, Result};
use picture::Picture;
use settings::{MapSettings, Mode};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::path::Path;

const OCCUPIED: u8 = 0;
const UNKNOWN: u8 = 205;
const FREE: u8 = 254;

/// The largest shift of a map's far corner by a yaw that is not quite a multiple of a quarter turn, cells.
const MOST_SHIFT: f64 = 0.05;

/// Opens `map.pgm` for a grid's classes, and writes `map.yaml`.
pub(super) fn open(folder: &Path, grid: &GridSpec, resume: bool) -> Result<Raster> {
    let settings = YAML.at(folder);
    std::fs::write(&settings, yaml(grid)).map_err(|e| unwritable(&settings, e))?;
    let header = format!("P5\n{} {}\n255\n", grid.width, grid.height).into_bytes();
    let layout = RasterLayout { header, extent: [grid.width, grid.height], element: 1, top_first: true };
    Raster::open(&PGM.at(folder), layout, resume)
}

/// The pixel of a class.
pub(super) fn pixel(class: f64) -> u8 {
    match class {
        v if v > 0.0 => OCCUPIED,
        v if v < 0.0 => FREE,
        _ => UNKNOWN,
    }
}

fn yaml(grid: &GridSpec) -> String {
    format!(
        "image: map.pgm\nmode: trinary\nresolution: {:?}\norigin: [{:?}, {:?}, 0.0]\nnegate: 0\noccupied_thresh: 0.65\n\
         free_thresh: 0.196\n",
        grid.resolution,
        tidy(grid.x0()),
        tidy(grid.y0())
    )
}

/// A map_server map, and notes on its YAML file.
#[derive(Debug, Clone)]
pub struct RosMap {
    /// Layers `touched` (all that is known), `class`, and in the modes scale and raw `p_occ`, anchored at its origin.
    pub map: Map,
    /// Notes for the user: keys that aren't read, a negate without effect, each with its file and line.
    pub notes: Vec<String>,
}

impl RosMap {
    /// Reads a map by its YAML file.
    ///
    /// # Errors
    /// [`Error::Input`] with the file, the line, the key and the value that isn't understood, or what is wrong with the
    /// picture; [`Error::Resources`] where the picture is larger than memory.
    pub fn open(path: &Path) -> Result<RosMap> {
        let settings = MapSettings::open(path)?;
        let place = path.parent().unwrap_or(Path::new("")).join(&settings.image);
        let picture = Picture::open(&place, settings.resolution, path)?;
        let quarters = quarters(path, &settings, &picture)?;
        let (width, height) = (picture.width, picture.height);
        let cells: Vec<Option<f64>> = (0..height)
            .rev()
            .flat_map(|row| (0..width).map(move |c| row * width + c))
            .map(|k| value(&settings, &picture, k))
            .collect();
        let [x, y, _] = settings.origin;
        let grid = GridSpec { anchor: (x, y), resolution: settings.resolution, i0: 0, j0: 0, width, height };
        let (grid, cells) = (0..quarters).fold((grid, cells), |map, _| turned(map, grid.anchor));
        Ok(RosMap { map: map(grid, &cells, &settings), notes: settings.notes })
    }
}

/// Reads a map_server map by its YAML file as [`RosMap::open`] does, without the notes.
///
/// # Errors
/// As [`RosMap::open`].
pub fn read_ros(path: &Path) -> Result<Map> {
    Ok(RosMap::open(path)?.map)
}

/// The occupancy of a pixel's cell by map_server's rules, 0 to 1; `None`: unknown.
fn value(settings: &MapSettings, picture: &Picture, k: usize) -> Option<f64> {
    let pixel = picture.pixel(k);
    let shade = match settings.mode {
        // map_server averages the alpha in with the colours in this mode alone
        Mode::Trinary => pixel.shade_with_alpha(),
        Mode::Scale | Mode::Raw => pixel.shade(),
    };
    let p = if settings.negate { shade } else { 1.0 - shade };
    match settings.mode {
        Mode::Raw => Some((shade * 255.0).round() / 100.0).filter(|v| *v <= 1.0),
        Mode::Scale if !pixel.is_opaque() => None,
        _ if p > settings.occupied => Some(1.0),
        _ if p < settings.free => Some(0.0),
        Mode::Scale if settings.occupied > settings.free => {
            Some(((p - settings.free) / (settings.occupied - settings.free) * 100.0).round_ties_even() / 100.0)
        }
        _ => None,
    }
}

/// The layers of a map's cells.
fn map(grid: GridSpec, cells: &[Option<f64>], settings: &MapSettings) -> Map {
    let class = |cell: &Option<f64>| match *cell {
        None => 0,
        // percentages as they are: decided by the thresholds
        Some(p) if settings.mode == Mode::Raw => i8::from(p > settings.occupied) - i8::from(p < settings.free),
        Some(p) => i8::from(p == 1.0) - i8::from(p == 0.0),
    };
    let layer = |name: &str, about, data, fill, scale| Layer { name: name.into(), about, data, fill, scale };
    let grey = Scale::Grey { low: 0.0, high: 1.0 };
    let touched = cells.iter().map(|c| u8::from(c.is_some())).collect();
    let classes = cells.iter().map(class).collect();
    let mut layers = vec![
        layer("touched", "known to the map", Data::U8(touched), 0.0, grey),
        layer("class", "1 occupied, 0 unknown, -1 empty", Data::I8(classes), 0.0, Scale::Signed { limit: 1.0 }),
    ];
    if settings.mode != Mode::Trinary {
        let p = cells.iter().map(|c| c.unwrap_or(0.5) as f32).collect();
        layers.push(layer("p_occ", "how occupied the map says it is", Data::F32(p), 0.5, grey));
    }
    Map { grid, method: "ros".into(), layers, updates: 0, increments: Vec::new() }
}

/// The number of quarter turns, counter-clockwise, of the map's yaw about its origin.
///
/// # Errors
/// [`Error::Input`] for a yaw between.
fn quarters(path: &Path, settings: &MapSettings, picture: &Picture) -> Result<usize> {
    let yaw = settings.origin[2];
    let quarters = (yaw / FRAC_PI_2).round();
    let off = (yaw - quarters * FRAC_PI_2).abs() * (picture.width as f64).hypot(picture.height as f64);
    if off <= MOST_SHIFT {
        return Ok(quarters.rem_euclid(4.0) as usize);
    }
    let radians = if yaw.abs() > TAU { " (it is in radians)" } else { "" };
    Err(Error::at(
        path,
        settings.origin_line,
        format!(
            "origin: the yaw {yaw}{radians} turns the map by no whole quarter: turned maps can't be read but by quarters, \
             0, 1.5707963, 3.1415927 or -1.5707963: save the map upright, with yaw 0"
        ),
    ))
}

/// Turns a grid and its cells by a quarter, counter-clockwise, about a point.
fn turned((grid, cells): (GridSpec, Vec<Option<f64>>), (x, y): (f64, f64)) -> (GridSpec, Vec<Option<f64>>) {
    let (width, height) = (grid.height, grid.width);
    // the upper left corner becomes the lower left one
    let top = grid.anchor.1 + width as f64 * grid.resolution;
    let anchor = (x - (top - y), y + (grid.anchor.0 - x));
    let from = |k: usize| (width - 1 - k % width) * grid.width + k / width;
    let cells = (0..cells.len()).map(|k| cells[from(k)]).collect();
    (GridSpec { anchor, width, height, ..grid }, cells)
}
