//! Hand-made maps and truths of 5 × 5 cells.

use echogrid::evaluate::score::{Options, Score, Truth, score};
use echogrid::grid::{Data, GridSpec, Layer, Map, Scale};

pub const O: i8 = 1;
pub const U: i8 = 0;
pub const E: i8 = -1;

pub fn layer(name: &str, data: Data) -> Layer {
    Layer { name: name.into(), about: "", data, fill: 0.0, scale: Scale::Signed { limit: 1.0 } }
}

/// A map of classes, every cell of it touched, its lower left cell at column `i0`, row `j0`.
pub fn map_at(i0: i64, j0: i64, width: usize, class: &[i8]) -> Map {
    let grid = GridSpec { anchor: (0.0, 0.0), resolution: 0.1, i0, j0, width, height: class.len() / width };
    let touched = layer("touched", Data::U8(vec![1; class.len()]));
    let layers = vec![touched, layer("class", Data::I8(class.to_vec()))];
    Map { grid, method: "hand".into(), layers, updates: 0, increments: Vec::new() }
}

pub fn map(class: &[i8]) -> Map {
    map_at(0, 0, 5, class)
}

/// A truth of all cells of the 5 × 5 grid.
pub fn world(class: &[i8]) -> Truth {
    let whole = class.to_vec();
    let draw = Box::new(move |grid: &GridSpec| {
        assert_eq!((grid.width, grid.height), (5, 5));
        Ok(whole.clone())
    });
    Truth::World { bounds: [0.0, 0.0, 0.5, 0.5], r_max: 0.0, draw }
}

pub fn scored(map: &Map, truth: &Truth) -> Score {
    score("m", map, truth, &Options::default()).unwrap()
}

/// 5 × 5 cells of `rest`, but for the centre and, if given, its upper right neighbour.
pub fn five(rest: i8, centre: i8, neighbour: Option<i8>) -> Vec<i8> {
    let mut cells = vec![rest; 25];
    cells[12] = centre;
    cells[18] = neighbour.unwrap_or(rest);
    cells
}
