//! `map.pgm` + `map.yaml`: the classes as nav2's map_server loads them (mode trinary), and reading such a pair back.
//!
//! map_server takes p = (255 − v)/255 of a pixel: above `occupied_thresh` it is occupied, below `free_thresh` free, else
//! unknown. 205 gives 0.19608, just above 0.196: unknown. Row 0 of the picture is the top; the origin is the lower left
//! corner of the lower left pixel.

use super::names::{PGM, YAML};
use super::raster::Raster;
use super::report::tidy;
use super::unwritable;
use crate::grid::{Data, GridSpec, Layer, Map, Scale};
use crate::{Error, Result};
use std::path::Path;

const OCCUPIED: u8 = 0;
const UNKNOWN: u8 = 205;
const FREE: u8 = 254;

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

/// Reads a map_server map by its YAML file: layers `touched` (all but unknown) and `class`, anchored at its origin.
pub fn read_ros(path: &Path) -> Result<Map> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::input(path, format!("{e}: give a map.yaml")))?;
    let about = Yaml::parse(path, &text)?;
    let picture = path.parent().unwrap_or(Path::new("")).join(&about.image);
    let bytes = std::fs::read(&picture)
        .map_err(|e| Error::input(&picture, format!("can't be read: {e}; {} names it as its image", path.display())))?;
    let (width, height, top, pixels) = read_pgm(&bytes).map_err(|what| Error::input(&picture, what))?;
    let grid = GridSpec { anchor: about.origin, resolution: about.resolution, i0: 0, j0: 0, width, height };
    let class_of = |v: u8| {
        let light = f64::from(v) / top;
        let p = if about.negate { light } else { 1.0 - light };
        if p > about.occupied { 1 } else { -i8::from(p < about.free) }
    };
    let rows = pixels.chunks_exact(width).rev();
    let class: Vec<i8> = rows.flat_map(|row| row.iter().map(|&v| class_of(v))).collect();
    let touched = class.iter().map(|&c| u8::from(c != 0)).collect();
    let layer = |name: &str, about, data, scale| Layer { name: name.into(), about, data, fill: 0.0, scale };
    let layers = vec![
        layer("touched", "known to the map", Data::U8(touched), Scale::Grey { low: 0.0, high: 1.0 }),
        layer("class", "1 occupied, 0 unknown, -1 empty", Data::I8(class), Scale::Signed { limit: 1.0 }),
    ];
    Ok(Map { grid, method: "ros".into(), layers, updates: 0, increments: Vec::new() })
}

/// The keys of a map.yaml that matter here.
struct Yaml {
    image: String,
    resolution: f64,
    origin: (f64, f64),
    negate: bool,
    occupied: f64,
    free: f64,
}

impl Yaml {
    /// Reads the flat `key: value` lines that map_server's files consist of.
    fn parse(path: &Path, text: &str) -> Result<Yaml> {
        let value = |key: &str| {
            let of = |line: &str| Some(line.strip_prefix(key)?.trim_start().strip_prefix(':')?.to_string());
            let (line, found) = text.lines().enumerate().find_map(|(k, l)| Some((k, of(l)?)))?;
            let bare = found.split(" #").next().unwrap_or_default();
            if bare.trim().is_empty() {
                // a list, an item a line
                let items = text.lines().skip(line + 1).map_while(|l| l.trim_start().strip_prefix('-'));
                return Some(items.map(str::trim).collect::<Vec<_>>().join(", "));
            }
            Some(bare.trim().trim_matches(['"', '\'']).to_string())
        };
        let missing = |key: &str| Error::input(path, format!("it has no \"{key}\": not a map_server map.yaml"));
        let wrong = |key: &str, v: &str| Error::input(path, format!("{key} \"{v}\" is no number that makes sense"));
        let number = |key: &str, default: Option<f64>| match (value(key), default) {
            (Some(v), _) => v.parse::<f64>().ok().filter(|n| n.is_finite()).ok_or_else(|| wrong(key, &v)),
            (None, Some(default)) => Ok(default),
            (None, None) => Err(missing(key)),
        };
        let resolution = number("resolution", None)?;
        if resolution <= 0.0 {
            return Err(wrong("resolution", &resolution.to_string()));
        }
        let origin = value("origin").ok_or_else(|| missing("origin"))?;
        let parts: Vec<f64> =
            origin.trim_matches(['[', ']']).split(',').filter_map(|v| v.trim().parse().ok()).collect();
        let origin = match parts[..] {
            [x, y] if x.is_finite() && y.is_finite() => (x, y),
            // less than a micrometre over a metre is no turn
            [x, y, yaw] if x.is_finite() && y.is_finite() && yaw.abs() < 1e-6 => (x, y),
            _ => {
                return Err(Error::input(path, format!("origin {origin} is not [x, y, 0]: turned maps can't be read")));
            }
        };
        if value("mode").is_some_and(|mode| mode == "raw") {
            return Err(Error::input(path, "mode raw can't be read: save the map as trinary or scale"));
        }
        Ok(Yaml {
            image: value("image").filter(|v| !v.is_empty()).ok_or_else(|| missing("image"))?,
            resolution,
            origin,
            negate: value("negate").is_some_and(|v| ["1", "true", "True"].contains(&v.as_str())),
            occupied: number("occupied_thresh", Some(0.65))?,
            free: number("free_thresh", Some(0.196))?,
        })
    }
}

/// Width, height, largest value and pixels of a binary PGM, or what is wrong with it.
fn read_pgm(bytes: &[u8]) -> std::result::Result<(usize, usize, f64, &[u8]), String> {
    let mut at = 0;
    let mut word = || -> Option<&str> {
        loop {
            while bytes.get(at)?.is_ascii_whitespace() {
                at += 1;
            }
            if bytes[at] != b'#' {
                break;
            }
            at += bytes[at..].iter().position(|b| *b == b'\n')?;
        }
        let start = at;
        at += bytes[at..].iter().position(|b| b.is_ascii_whitespace())?;
        std::str::from_utf8(&bytes[start..at]).ok()
    };
    if word() != Some("P5") {
        return Err("it is no binary PGM (P5): convert the picture, and name it in the YAML file".into());
    }
    let mut number = || word().and_then(|w| w.parse::<usize>().ok()).filter(|n| (1..=1 << 24).contains(n));
    let (Some(width), Some(height), Some(top @ 1..=255)) = (number(), number(), number()) else {
        return Err("its header is not P5, width, height and a largest value of at most 255".into());
    };
    let rest = &bytes[(at + 1).min(bytes.len())..];
    match rest.get(..width * height) {
        Some(pixels) => Ok((width, height, top as f64, pixels)),
        None => Err(format!("it ends after {} of {} pixels", rest.len(), width * height)),
    }
}
