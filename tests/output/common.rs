//! A small, deliberately lopsided map that every output test writes.

use echogrid::grid::{Data, GridSpec, Layer, Map, Scale};
use echogrid::log::BadLines;
use echogrid::log::reading::Counts;
use echogrid::output::{Folder, LogInfo, Report, RunInfo, parameters, write_map};
use std::path::Path;

/// The only occupied cell: left of the middle and near the top, so that no flip goes unseen.
pub const OCCUPIED: (usize, usize) = (2, 6);
/// A row of empty cells along the bottom.
pub const EMPTY_ROW: usize = 1;

pub fn layer(name: &str, data: Data, fill: f64, scale: Scale) -> Layer {
    Layer { name: name.into(), about: "made for a test", data, fill, scale }
}

/// 11 × 8 cells of 0.5 m with its lower left corner at (-2, 1), or any wider map with the same pattern.
pub fn map(width: usize, height: usize) -> Map {
    let grid = GridSpec { anchor: (0.0, 0.0), resolution: 0.5, i0: -4, j0: 2, width, height };
    let mut class = vec![0i8; grid.cells()];
    class[OCCUPIED.1 * width + OCCUPIED.0] = 1;
    class[EMPTY_ROW * width..(EMPTY_ROW + 1) * width].fill(-1);
    let odds: Vec<f32> = class.iter().map(|c| f32::from(*c) * 1.5).collect();
    let touched: Vec<u8> = class.iter().map(|c| u8::from(*c != 0)).collect();
    let count = class.iter().map(|c| u32::from(*c > 0) * 70_000).collect();
    let p = class.iter().map(|c| 0.5 + f32::from(*c) * 0.25).collect();
    let layers = vec![
        layer("log_odds", Data::F32(odds), 0.0, Scale::Signed { limit: 3.0 }),
        layer("p_occ", Data::F32(p), 0.5, Scale::Grey { low: 0.0, high: 1.0 }),
        layer("count", Data::U32(count), 0.0, Scale::Grey { low: 0.0, high: 100_000.0 }),
        layer("touched", Data::U8(touched), 0.0, Scale::Grey { low: 0.0, high: 1.0 }),
        layer("class", Data::I8(class), 0.0, Scale::Signed { limit: 1.0 }),
    ];
    Map { grid, method: "bayes".into(), layers, updates: 1234, increments: Vec::new() }
}

pub fn info() -> RunInfo {
    RunInfo {
        parameters: parameters([("model", "murphy".to_string()), ("max_occ", "0.98".to_string())]),
        log: LogInfo { path: "logs/a.csv".into(), sha256: "ab".repeat(32), ..LogInfo::default() },
        sensors: Vec::new(),
        readings: Counts { read: 9, used: 7, ..Counts::default() },
        busy: Vec::new(),
        seconds: vec![("read".into(), 0.25), ("map".into(), 1.5)],
        backend: "cpu".into(),
        adapter: None,
        bad_lines: BadLines { count: 1, first: vec!["logs/a.csv:3: no range".into()] },
        classes: Vec::new(),
        features: None,
    }
}

/// Writes a whole map folder.
pub fn write(path: &Path, map: &Map, npy: bool) -> Report {
    let folder = Folder::prepare(path).unwrap();
    let report = write_map(&folder, map, &map.layers[0], &info(), npy).unwrap();
    folder.finish().unwrap();
    report
}
