//! The views of a lane: its layers, and what is derived from them.

use crate::geometry::layout::TILE;
use crate::grid::Scale;
use crate::method::Method;
use crate::pipeline::step::Tiles;
use crate::view::tile::EDGE;

/// What a view's values are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ViewContent {
    /// A layer.
    Layer(usize),
    /// The empty part of the combined picture, 0 to 1.
    Empty,
    /// The occupied part of the combined picture, 0 to 1.
    Full,
    /// The combined picture, −1 to 1.
    Combined,
    /// 1 occupied, 0 unknown, −1 empty.
    Class,
    /// The number of updates.
    Updates,
}

/// A view of a lane.
pub struct LaneView {
    /// Its name.
    pub name: &'static str,
    /// What it shows.
    pub about: &'static str,
    /// Its colours.
    pub scale: Scale,
    /// Whether it is one of the three main views.
    pub main: bool,
    /// Its values.
    pub content: ViewContent,
}

const UNIT: Scale = Scale::Grey { low: 0.0, high: 1.0 };
const SIGNED: Scale = Scale::Signed { limit: 1.0 };

/// The names of a method's own layers for the views empty and full.
const OWN_LAYERS: [&[&str]; 2] = [&["emp", "empty", "p_emp"], &["occ", "full", "p_occ"]];

/// The views of a method: empty, full, combined, then its other layers, class and updates.
pub fn views(method: &dyn Method) -> Vec<LaneView> {
    let layers = method.layers();
    let place = |names: &[&str]| layers.iter().position(|l| names.contains(&l.name));
    let main = |name, derived: (&'static str, ViewContent), own: Option<usize>| match own {
        Some(k) => LaneView {
            name,
            about: layers[k].about,
            scale: layers[k].scale,
            main: true,
            content: ViewContent::Layer(k),
        },
        None => LaneView { name, about: derived.0, scale: UNIT, main: true, content: derived.1 },
    };
    let [empty, full] = OWN_LAYERS.map(place);
    let about = [
        "how surely empty, 0 to 1, from the combined picture",
        "how surely occupied, 0 to 1, from the combined picture",
    ];
    let mut views = vec![
        main("empty", (about[0], ViewContent::Empty), empty),
        main("full", (about[1], ViewContent::Full), full),
        LaneView {
            name: "combined",
            about: "-1 surely empty to 1 surely occupied",
            scale: SIGNED,
            main: true,
            content: ViewContent::Combined,
        },
    ];
    let others = layers.iter().enumerate().filter(|(k, _)| Some(*k) != empty && Some(*k) != full);
    views.extend(others.map(|(k, l)| LaneView {
        name: l.name,
        about: l.about,
        scale: l.scale,
        main: false,
        content: ViewContent::Layer(k),
    }));
    let class = "1 occupied, 0 unknown, -1 empty, by the method's decision rule";
    views.push(LaneView { name: "class", about: class, scale: SIGNED, main: false, content: ViewContent::Class });
    let updates = Scale::Heat { low: 0.0, high: 50.0 };
    views.push(LaneView {
        name: "updates",
        about: "how often a reading updated the cell",
        scale: updates,
        main: false,
        content: ViewContent::Updates,
    });
    views
}

/// The view of a difference: source 1 less source 0.
pub const DIFFERENCE: LaneView = LaneView {
    name: "difference",
    about: "combined picture of the second less that of the first: red more occupied, blue more empty, full colour from 1 on",
    scale: Scale::Signed { limit: 1.0 },
    main: true,
    content: ViewContent::Combined,
};

/// The tiles of level 0, by column and row, that contain these kernel tiles of 16 × 16 cells.
pub fn level0_tiles(tiles: &Tiles) -> Vec<[usize; 2]> {
    let each = (EDGE / TILE) as u32;
    let mut blocks: Vec<[usize; 2]> =
        tiles.iter().map(|[row, column]| [column / each, row / each].map(|v| v as usize)).collect();
    blocks.sort_unstable();
    blocks.dedup();
    blocks
}
