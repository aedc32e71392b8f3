//! The truth that a map is scored against: another map, or a world whose true map is drawn on the scored map's cells.

use super::levels::class_of;
use crate::grid::{GridSpec, Map};
use crate::output::{RosMap, read_map};
use crate::world::{Shipped, World, meant, true_map};
use crate::{Error, Result};
use std::fmt;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// Bytes of a compared cell: its classes, probability and level, twice while they are counted.
const CELL_BYTES: u64 = 32;

/// Draws a world's true classes on a grid.
type Draw = Box<dyn Fn(&GridSpec) -> Result<Vec<i8>> + Send + Sync>;

/// A truth, not yet on a grid.
pub enum Truth {
    /// A map: the cells compared are those that the scored map touched and this one knows.
    Map(Map),
    /// A world: all cells of its bounding box and `r_max` around it are compared.
    World {
        /// Its bounding box x0, y0, x1, y1, metres.
        bounds: [f64; 4],
        /// How far its sensors see, metres.
        r_max: f64,
        /// Draws its true classes on a grid.
        draw: Draw,
    },
}

impl fmt::Debug for Truth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Truth::Map(map) => f.debug_tuple("Map").field(&map.method).finish(),
            Truth::World { bounds, r_max, .. } => f.debug_tuple("World").field(bounds).field(r_max).finish(),
        }
    }
}

/// True classes on cells that coincide with the scored map's.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueCells {
    /// The grid of the cells.
    pub grid: GridSpec,
    /// Class of each: 1 occupied, 0 unknown, −1 empty.
    pub class: Vec<i8>,
    /// Whether all of these cells are compared, or only those that the scored map touched and the truth knows.
    pub all: bool,
    /// The world's box and half a metre around it: x0, y0, x1, y1, metres.
    pub near: Option<[f64; 4]>,
}

impl Truth {
    /// Opens a truth: a built-in world by its name, a world's TOML file, a map's folder, or a ROS map by its YAML file.
    /// `r_max` is [`Truth::of_world`]'s. Notes for the user go to `note`.
    pub fn open_with_notes(path: &Path, r_max: Option<f64>, note: &mut dyn FnMut(String)) -> Result<Truth> {
        let is_file = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) && !path.is_dir();
        if let Some(what) = Shipped::beside_file(path) {
            note(what);
        }
        match (is_file || Shipped::named(path).is_some(), r_max) {
            (true, _) => Truth::of_world(World::find(path)?, r_max),
            (false, _) if !path.exists() && path.extension().is_none() => {
                Err(Error::input(path, format!("there is no such map, nor such a world; {}", meant(path))))
            }
            (false, None) => Ok(Truth::Map(open_map_with_notes(path, note)?)),
            (false, Some(_)) => Err(Error::Usage(format!("--r-max is for worlds: {} is a map", path.display()))),
        }
    }

    /// The same as [`Truth::open_with_notes`], without the notes.
    pub fn open(path: &Path, r_max: Option<f64>) -> Result<Truth> {
        Truth::open_with_notes(path, r_max, &mut |_| {})
    }

    /// A world's truth: what an ideal sensor of range `r_max`, metres, would know from its path; by default the farthest
    /// range of its sonars, or 5 m where it has none.
    pub fn of_world(world: World, r_max: Option<f64>) -> Result<Truth> {
        let r_max = sensor_range(&world, r_max)?;
        let bounds = world.bounds();
        // Maps scored side by side mostly have the same grid: the last drawing is cached.
        let last: Mutex<Option<(GridSpec, Vec<i8>)>> = Mutex::new(None);
        let draw = Box::new(move |grid: &GridSpec| {
            let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some((_, class)) = last.as_ref().filter(|(drawn, _)| drawn == grid) {
                return Ok(class.clone());
            }
            let class = true_map(&world, &world.scans(), grid, r_max);
            *last = Some((*grid, class.clone()));
            Ok(class)
        });
        Ok(Truth::World { bounds, r_max, draw })
    }

    /// A description of the truth with its name.
    pub fn describe(&self, name: &str) -> String {
        match self {
            Truth::Map(map) => format!("{name} (a {} map)", map.method),
            Truth::World { r_max, .. } => format!("{name} (a world, seen up to {r_max} m)"),
        }
    }

    /// The sensors' range, metres, where it is a world.
    pub fn r_max(&self) -> Option<f64> {
        match self {
            Truth::Map(_) => None,
            Truth::World { r_max, .. } => Some(*r_max),
        }
    }

    /// `map` or `world`.
    pub fn kind(&self) -> &'static str {
        match self {
            Truth::Map(_) => "map",
            Truth::World { .. } => "world",
        }
    }

    /// The true classes on cells that coincide with those of `scored`.
    ///
    /// # Errors
    /// [`Error::Usage`] where a map has no classes or a world is too far away; [`Error::Resources`] where memory does not suffice.
    pub fn on(&self, scored: &GridSpec) -> Result<TrueCells> {
        match self {
            Truth::Map(map) => {
                let class = map.layer("class").ok_or_else(|| Error::Usage("the true map has no layer class".into()))?;
                let class = (0..class.data.len()).map(|k| class_of(class.data.get(k))).collect();
                Ok(TrueCells { grid: map.grid, class, all: false, near: None })
            }
            Truth::World { bounds, r_max, draw } => {
                let grid = covering_grid(scored, extended_box(*bounds, *r_max))?;
                grid.check_memory(
                    grid.cells() as u64 * CELL_BYTES,
                    None,
                    "map at a coarser --resolution, or a smaller world",
                )?;
                let class = draw(&grid)?;
                if class.len() != grid.cells() {
                    return Err(Error::Usage(format!("{} true classes for {} cells", class.len(), grid.cells())));
                }
                Ok(TrueCells { grid, class, all: true, near: Some(extended_box(*bounds, 0.5)) })
            }
        }
    }
}

/// Opens a map: a folder that echogrid wrote, or a ROS map by its YAML file. Notes on parts of a ROS map that are ignored go to `note`.
pub fn open_map_with_notes(path: &Path, note: &mut dyn FnMut(String)) -> Result<Map> {
    let kind = path.extension().and_then(|e| e.to_str()).map(str::to_lowercase);
    match kind.as_deref() {
        _ if path.is_dir() => Ok(read_map(path)?.map),
        Some("yaml" | "yml") => {
            let RosMap { map, notes } = RosMap::open(path)?;
            notes.into_iter().for_each(note);
            Ok(map)
        }
        _ if !path.exists() => Err(Error::input(path, "there is no such map: give a folder or a ROS map's .yaml file")),
        _ => Err(Error::input(path, "it is no map: give a folder that echogrid map wrote, or a ROS map's .yaml file")),
    }
}

/// The same as [`open_map_with_notes`], without the notes.
pub fn open_map(path: &Path) -> Result<Map> {
    open_map_with_notes(path, &mut |_| {})
}

/// The range of a world's sensors, metres: as given, else the farthest range of its sonars, or of its lasers where it has no sonar, but
/// not beyond the world's diagonal.
pub fn sensor_range(world: &World, given: Option<f64>) -> Result<f64> {
    let [x0, y0, x1, y1] = world.bounds();
    let sonar = world.rig.sonar_reach();
    let laser = world.rig.transducers.iter().map(|t| t.sensor.r_max).fold(0.0, f64::max);
    let r_max = given.unwrap_or(if sonar > 0.0 { sonar } else { laser.min((x1 - x0).hypot(y1 - y0).ceil()) });
    match r_max > 0.0 && r_max <= 1e6 {
        true => Ok(r_max),
        false => Err(Error::Usage(format!("--r-max {r_max} is no range: give metres, more than 0"))),
    }
}

/// A box x0, y0, x1, y1 extended by so many metres on every side.
pub fn extended_box([x0, y0, x1, y1]: [f64; 4], by: f64) -> [f64; 4] {
    [x0 - by, y0 - by, x1 + by, y1 + by]
}

/// The grid that covers a box with whole cells, on another grid's anchor.
fn covering_grid(on: &GridSpec, [x0, y0, x1, y1]: [f64; 4]) -> Result<GridSpec> {
    let (ax, ay) = on.anchor;
    // A box that ends on a cell's edge ends there in spite of rounding.
    let cells = |low: f64, high: f64, anchor: f64| {
        [((low - anchor) / on.resolution + 1e-6).floor(), ((high - anchor) / on.resolution - 1e-6).ceil()]
    };
    let ([i0, i1], [j0, j1]) = (cells(x0, x1, ax), cells(y0, y1, ay));
    let most = f64::from(1 << 24);
    if ![i0, i1, j0, j1].iter().all(|v| v.abs() <= most) {
        return Err(Error::Usage(format!(
            "the world's box {x0},{y0},{x1},{y1} is too far from the map's, or too large"
        )));
    }
    let (width, height) = ((i1 - i0).max(1.0) as usize, (j1 - j0).max(1.0) as usize);
    Ok(GridSpec { i0: i0 as i64, j0: j0 as i64, width, height, ..*on })
}
