//! The views of a lane: what the page draws as tiles.

use super::lane::Lane;
use crate::geometry::layout::{TILE, TILE_CELLS};
use crate::grid::Scale;
use crate::kernels::Chunks;
use crate::method::{self, Method};
use crate::pipeline::step::{Tiles, tile_of};
use crate::view::pyramid::{Pyramid, Shown};
use crate::view::tile::{EDGE, Place};
use crate::view::{Answer, Ask};
use crate::{Error, Result};

/// Where a view's values come from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Of {
    /// A layer.
    Layer(usize),
    /// How surely empty, of the combined picture.
    Empty,
    /// How surely occupied.
    Full,
    /// The combined picture.
    Combined,
    /// 1 occupied, 0 unknown, −1 empty.
    Class,
    /// How many updates.
    Updates,
}

/// A view.
pub struct View {
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub about: &'static str,
    /// Its colours.
    pub scale: Scale,
    /// Whether it is one of the first three.
    pub main: bool,
    /// Its values.
    pub of: Of,
}

const UNIT: Scale = Scale::Grey { low: 0.0, high: 1.0 };
const SIGNED: Scale = Scale::Signed { limit: 1.0 };

/// A method's own layers of empty and of full.
const OWN: [&[&str]; 2] = [&["emp", "empty", "p_emp"], &["occ", "full", "p_occ"]];

/// The views of a method: empty, full, combined, then its other layers, class and updates.
pub fn views(method: &dyn Method) -> Vec<View> {
    let layers = method.layers();
    let place = |names: &[&str]| layers.iter().position(|l| names.contains(&l.name));
    let main = |name, derived: (&'static str, Of), own: Option<usize>| match own {
        Some(k) => View { name, about: layers[k].about, scale: layers[k].scale, main: true, of: Of::Layer(k) },
        None => View { name, about: derived.0, scale: UNIT, main: true, of: derived.1 },
    };
    let [empty, full] = OWN.map(place);
    let about = [
        "how surely empty, 0 to 1, from the combined picture",
        "how surely occupied, 0 to 1, from the combined picture",
    ];
    let mut views = vec![
        main("empty", (about[0], Of::Empty), empty),
        main("full", (about[1], Of::Full), full),
        View {
            name: "combined",
            about: "-1 surely empty to 1 surely occupied",
            scale: SIGNED,
            main: true,
            of: Of::Combined,
        },
    ];
    let others = layers.iter().enumerate().filter(|(k, _)| Some(*k) != empty && Some(*k) != full);
    views.extend(others.map(|(k, l)| View {
        name: l.name,
        about: l.about,
        scale: l.scale,
        main: false,
        of: Of::Layer(k),
    }));
    let class = "1 occupied, 0 unknown, -1 empty, by the method's decision rule";
    views.push(View { name: "class", about: class, scale: SIGNED, main: false, of: Of::Class });
    let updates = Scale::Heat { low: 0.0, high: 50.0 };
    views.push(View {
        name: "updates",
        about: "how often a reading updated the cell",
        scale: updates,
        main: false,
        of: Of::Updates,
    });
    views
}

/// The view of a difference: source 1 less source 0.
pub const DIFFERENCE: View = View {
    name: "difference",
    about: "combined picture of the second less that of the first: red more occupied, blue more empty, full colour from 1 on",
    scale: Scale::Signed { limit: 1.0 },
    main: true,
    of: Of::Combined,
};

/// Keys of the pyramid: a lane's views, those of what the page computed, the difference.
const PAGE: u32 = 8;
const OF_BOTH: u32 = 16;
/// Views of a method at most.
const MOST: u32 = 64;

/// These tiles of 16 × 16 cells of a lane are out of date in all its views.
pub fn forget(pyramid: &Pyramid, lane: usize, lanes: &[Lane], tiles: &Tiles) {
    let blocks = blocks(tiles);
    let views = views(lanes[lane].stepper.method()).len() as u32;
    for view in 0..views {
        pyramid.invalidate([lane as u32, view], &blocks);
        pyramid.invalidate([PAGE + lane as u32, view], &blocks);
    }
    if lanes.len() > 1 {
        pyramid.invalidate([OF_BOTH, 0], &blocks);
        pyramid.invalidate([OF_BOTH, 1], &blocks);
    }
}

/// What a page computed of a lane is out of date: its tiles, and those of the CPU that stood in for them.
pub fn forget_page(pyramid: &Pyramid, lane: usize) {
    (0..MOST).for_each(|view| pyramid.clear([PAGE + lane as u32, view]));
    pyramid.clear([OF_BOTH, 1]);
}

/// All is out of date.
pub fn forget_all(pyramid: &Pyramid) {
    for source in [0, 1, PAGE, PAGE + 1, OF_BOTH] {
        (0..MOST).for_each(|view| pyramid.clear([source, view]));
    }
}

/// Tiles of level 0, by column and row, that hold tiles of 16 × 16 cells.
pub fn blocks(tiles: &Tiles) -> Vec<[usize; 2]> {
    let each = (EDGE / TILE) as u32;
    let mut blocks: Vec<[usize; 2]> =
        tiles.iter().map(|[row, column]| [column / each, row / each].map(|v| v as usize)).collect();
    blocks.sort_unstable();
    blocks.dedup();
    blocks
}

/// What is asked for: its key, the view, the lanes that it is of.
type Asked<'a> = ([u32; 2], View, Vec<&'a Lane>);

fn asked<'a>(lanes: &'a [Lane], ask: &Ask, of_page: bool) -> Result<Asked<'a>> {
    if ask.text("source")? == "difference" {
        return match lanes {
            [_, _] => Ok(([OF_BOTH, u32::from(of_page)], DIFFERENCE, lanes.iter().collect())),
            _ => Err(Error::Usage("there is a difference of two methods only".into())),
        };
    }
    let k = ask.number("source")?;
    let Some(lane) = lanes.get(k) else {
        return Err(Error::Usage(format!("there is no source {k}: there are {}, from 0", lanes.len())));
    };
    let (name, views) = (ask.text("view")?, views(lane.stepper.method()));
    let names: Vec<&str> = views.iter().map(|v| v.name).collect();
    let unknown = || Error::Usage(format!("there is no view {name}: there are {}", names.join(", ")));
    let (n, view) = views.into_iter().enumerate().find(|(_, v)| v.name == name).ok_or_else(unknown)?;
    Ok(([if of_page { PAGE } else { 0 } + k as u32, n as u32], view, vec![lane]))
}

/// The tile that is asked for.
pub fn tile(pyramid: &Pyramid, lanes: &[Lane], ask: &Ask) -> Result<Answer> {
    let grid = lanes[0].stepper.grid();
    let extent = [grid.width, grid.height];
    let at = Place::asked(ask, extent)?;
    let of_page = ask.query.get("backend").is_some_and(|b| b == "webgpu");
    let (key, View { scale, of, .. }, lanes) = asked(lanes, ask, of_page)?;
    let base = |block: [usize; 2]| {
        let part = |lane: &Lane| values(chunks_of(lane, of_page), lane.stepper.method(), of, extent, block);
        Ok(match lanes[..] {
            [first, second] => difference(part(first).as_ref(), part(second).as_ref()),
            _ => lanes.first().and_then(|lane| part(lane)),
        })
    };
    match pyramid.tile(&Shown { key, extent, scale, base: &base }, at)? {
        Some(tile) => Ok(Answer::Bytes("image/png", tile.picture(scale)?)),
        None => Ok(Answer::Nothing),
    }
}

fn chunks_of(lane: &Lane, of_page: bool) -> &Chunks {
    match &lane.page {
        Some(page) if of_page => page,
        _ => lane.stepper.chunks(),
    }
}

/// The values of a tile of level 0; `None`: nothing there was reached.
fn values(
    chunks: &Chunks,
    method: &dyn Method,
    of: Of,
    extent: [usize; 2],
    [column, row]: [usize; 2],
) -> Option<Vec<f32>> {
    let planes = method::planes(method);
    let mut own = vec![0; planes];
    let place = Place { level: 0, column, row };
    let [width, height] = place.extent(extent);
    let (mut values, mut layers): (Option<Vec<f32>>, _) = (None, vec![0.0; method.layers().len()]);
    for y in (0..height).step_by(TILE) {
        for x in (0..width).step_by(TILE) {
            let tile = [(row * EDGE + y) / TILE, (column * EDGE + x) / TILE].map(|t| t as u32);
            let Some(words) = tile_of(chunks, planes, tile).filter(|w| w.iter().any(|w| *w != 0)) else { continue };
            let values = values.get_or_insert_with(|| vec![f32::NAN; width * height]);
            for at in 0..TILE_CELLS {
                let (i, j) = (x + at % TILE, y + at / TILE);
                if i < width && j < height {
                    (0..planes).for_each(|p| own[p] = words[p * TILE_CELLS + at]);
                    values[j * width + i] = value(method, &own, &mut layers, of);
                }
            }
        }
    }
    values
}

/// A cell's value in a view; not a number where no reading reached it.
fn value(method: &dyn Method, words: &[u32], layers: &mut [f32], of: Of) -> f32 {
    let updates = words[0] + words[1];
    if updates == 0 && !method.faint(words) {
        return f32::NAN;
    }
    let class = method.values(words, layers);
    let combined = || method.combined(layers, class);
    match of {
        Of::Layer(k) => layers[k],
        Of::Empty => (-combined()).max(0.0),
        Of::Full => combined().max(0.0),
        Of::Combined => combined(),
        Of::Class => f32::from(class as i8),
        Of::Updates => updates as f32,
    }
}

/// The second less the first; a cell that only one has reached is 0 in the other.
fn difference(first: Option<&Vec<f32>>, second: Option<&Vec<f32>>) -> Option<Vec<f32>> {
    let known = |v: f32| if v.is_nan() { 0.0 } else { v };
    let count = first.or(second)?.len();
    let at = |values: Option<&Vec<f32>>, k: usize| values.map_or(f32::NAN, |v| v[k]);
    let less = |k: usize| match (at(first, k), at(second, k)) {
        (a, b) if a.is_nan() && b.is_nan() => f32::NAN,
        (a, b) => known(b) - known(a),
    };
    Some((0..count).map(less).collect())
}
