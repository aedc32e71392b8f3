//! `map.pgm` + `map.yaml`: the classes as nav2's map_server loads them (mode trinary), and reading such a pair, ours or
//! anybody's, as map_server would.
//!
//! map_server takes p = 1 − v/255 of a pixel: above `occupied_thresh` it is occupied, below `free_thresh` free, else
//! unknown. 205 gives 0.19608, just above 0.196: unknown. Row 0 of the picture is the top; the origin is the lower left
//! corner of the lower left pixel.

mod about;
mod picture;
mod yaml;

use super::names::{PGM, YAML};
use super::raster::Raster;
use super::report::tidy;
use super::unwritable;
use crate::grid::{Data, GridSpec, Layer, Map, Scale};
use crate::{Error, Result};
use about::{About, Mode};
use picture::Picture;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::path::Path;

const OCCUPIED: u8 = 0;
const UNKNOWN: u8 = 205;
const FREE: u8 = 254;

/// By how much of a cell a yaw may move a map's far corner from where a quarter turn, or none, puts it.
const OFF: f64 = 0.05;

/// Opens `map.pgm` for a grid's classes, and writes `map.yaml`.
pub(super) fn open(folder: &Path, grid: &GridSpec, resume: bool) -> Result<Raster> {
    let about = YAML.at(folder);
    std::fs::write(&about, yaml(grid)).map_err(|e| unwritable(&about, e))?;
    let header = format!("P5\n{} {}\n255\n", grid.width, grid.height);
    Raster::open(&PGM.at(folder), header.as_bytes(), [grid.width, grid.height], 1, true, resume)
}

/// What a class looks like.
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

/// A map_server map, and what its YAML file says that wasn't followed.
#[derive(Debug, Clone)]
pub struct RosMap {
    /// Layers `touched` (all that is known), `class`, and in the modes scale and raw `p_occ`, anchored at its origin.
    pub map: Map,
    /// What a user should know: keys that aren't read, a negate without effect, each with its file and line.
    pub notes: Vec<String>,
}

impl RosMap {
    /// Reads a map by its YAML file.
    ///
    /// # Errors
    /// [`Error::Input`] with the file, the line, the key and the value that isn't understood, or what is wrong with the
    /// picture; [`Error::Resources`] where the picture is larger than memory.
    pub fn open(path: &Path) -> Result<RosMap> {
        let about = About::open(path)?;
        let place = path.parent().unwrap_or(Path::new("")).join(&about.image);
        let picture = Picture::open(&place, about.resolution, path)?;
        let quarters = quarters(path, &about, &picture)?;
        let (width, height) = (picture.width, picture.height);
        let cells: Vec<Option<f64>> = (0..height)
            .rev()
            .flat_map(|row| (0..width).map(move |c| row * width + c))
            .map(|k| value(&about, &picture, k))
            .collect();
        let [x, y, _] = about.origin;
        let grid = GridSpec { anchor: (x, y), resolution: about.resolution, i0: 0, j0: 0, width, height };
        let (grid, cells) = (0..quarters).fold((grid, cells), |map, _| turned(map, grid.anchor));
        Ok(RosMap { map: map(grid, &cells, &about), notes: about.notes })
    }
}

/// Reads a map_server map by its YAML file, as [`RosMap::open`] does, without what there is to note.
pub fn read_ros(path: &Path) -> Result<Map> {
    Ok(RosMap::open(path)?.map)
}

/// How occupied a pixel's cell is, 0 to 1, as map_server has it (in percent); `None`: unknown.
fn value(about: &About, picture: &Picture, k: usize) -> Option<f64> {
    let pixel = picture.pixel(k);
    let shade = match about.mode {
        // map_server averages the alpha in with the colours in this mode alone
        Mode::Trinary => pixel.shade_with_alpha(),
        Mode::Scale | Mode::Raw => pixel.shade(),
    };
    let p = if about.negate { shade } else { 1.0 - shade };
    match about.mode {
        Mode::Raw => Some((shade * 255.0).round() / 100.0).filter(|v| *v <= 1.0),
        Mode::Scale if !pixel.is_opaque() => None,
        _ if p > about.occupied => Some(1.0),
        _ if p < about.free => Some(0.0),
        Mode::Scale if about.occupied > about.free => {
            Some(((p - about.free) / (about.occupied - about.free) * 100.0).round_ties_even() / 100.0)
        }
        _ => None,
    }
}

/// The layers of a map's cells.
fn map(grid: GridSpec, cells: &[Option<f64>], about: &About) -> Map {
    let class = |cell: &Option<f64>| match *cell {
        None => 0,
        // percentages as they are: decided by the thresholds
        Some(p) if about.mode == Mode::Raw => i8::from(p > about.occupied) - i8::from(p < about.free),
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
    if about.mode != Mode::Trinary {
        let p = cells.iter().map(|c| c.unwrap_or(0.5) as f32).collect();
        layers.push(layer("p_occ", "how occupied the map says it is", Data::F32(p), 0.5, grey));
    }
    Map { grid, method: "ros".into(), layers, updates: 0, increments: Vec::new() }
}

/// By how many quarters of a turn, counter-clockwise, the map's yaw turns it about its origin.
fn quarters(path: &Path, about: &About, picture: &Picture) -> Result<usize> {
    let yaw = about.origin[2];
    let quarters = (yaw / FRAC_PI_2).round();
    let off = (yaw - quarters * FRAC_PI_2).abs() * (picture.width as f64).hypot(picture.height as f64);
    if off <= OFF {
        return Ok(quarters.rem_euclid(4.0) as usize);
    }
    let radians = if yaw.abs() > TAU { " (it is in radians)" } else { "" };
    Err(Error::at(
        path,
        about.origin_line,
        format!(
            "origin: the yaw {yaw}{radians} turns the map by no whole quarter: turned maps can't be read but by quarters, \
             0, 1.5707963, 3.1415927 or -1.5707963: save the map upright, with yaw 0"
        ),
    ))
}

/// A grid and its cells, turned by a quarter counter-clockwise about a point.
fn turned((grid, cells): (GridSpec, Vec<Option<f64>>), (x, y): (f64, f64)) -> (GridSpec, Vec<Option<f64>>) {
    let (width, height) = (grid.height, grid.width);
    // the upper left corner becomes the lower left one
    let top = grid.anchor.1 + width as f64 * grid.resolution;
    let anchor = (x - (top - y), y + (grid.anchor.0 - x));
    let from = |k: usize| (width - 1 - k % width) * grid.width + k / width;
    let cells = (0..cells.len()).map(|k| cells[from(k)]).collect();
    (GridSpec { anchor, width, height, ..grid }, cells)
}
