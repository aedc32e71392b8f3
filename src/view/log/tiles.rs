//! `api/tile`: the tiles of a lane's views.

use super::lane::Lane;
use super::views::{DIFFERENCE, LaneView, ViewContent, level0_tiles, views};
use crate::geometry::layout::{TILE, TILE_CELLS};
use crate::kernels::ChunkStates;
use crate::method::{self, Method};
use crate::pipeline::step::{Tiles, tile_of};
use crate::view::pyramid::{LayerKey, Pyramid, PyramidLayer};
use crate::view::tile::{EDGE, TileId};
use crate::view::{Request, Response};
use crate::{Error, Result};

/// First numbers of the pyramid's keys: 0 and 1 are the lanes; then what the page computed of each, and the difference.
const WEBGPU_KEY: u32 = 8;
const DIFFERENCE_KEY: u32 = 16;
/// Largest number of views of a method.
const MOST_VIEWS: u32 = 64;

/// Invalidates these kernel tiles of 16 × 16 cells of a lane in all its views.
pub fn invalidate(pyramid: &Pyramid, lane: usize, lanes: &[Lane], tiles: &Tiles) {
    let tiles = level0_tiles(tiles);
    let views = views(lanes[lane].stepper.method()).len() as u32;
    for view in 0..views {
        pyramid.invalidate([lane as u32, view], &tiles);
        pyramid.invalidate([WEBGPU_KEY + lane as u32, view], &tiles);
    }
    if lanes.len() > 1 {
        pyramid.invalidate([DIFFERENCE_KEY, 0], &tiles);
        pyramid.invalidate([DIFFERENCE_KEY, 1], &tiles);
    }
}

/// Invalidates the tiles of a lane that show what the page computed.
pub fn invalidate_webgpu(pyramid: &Pyramid, lane: usize) {
    (0..MOST_VIEWS).for_each(|view| pyramid.clear([WEBGPU_KEY + lane as u32, view]));
    pyramid.clear([DIFFERENCE_KEY, 1]);
}

/// Invalidates all tiles.
pub fn invalidate_all(pyramid: &Pyramid) {
    for source in [0, 1, WEBGPU_KEY, WEBGPU_KEY + 1, DIFFERENCE_KEY] {
        (0..MOST_VIEWS).for_each(|view| pyramid.clear([source, view]));
    }
}

/// A view with its key and the lanes that it shows: one, or two for a difference.
type RequestedView<'a> = (LayerKey, LaneView, Vec<&'a Lane>);

fn requested_view<'a>(lanes: &'a [Lane], request: &Request, webgpu: bool) -> Result<RequestedView<'a>> {
    if request.query_text("source")? == "difference" {
        return match lanes {
            [_, _] => Ok(([DIFFERENCE_KEY, u32::from(webgpu)], DIFFERENCE, lanes.iter().collect())),
            _ => Err(Error::Usage("there is a difference of two methods only".into())),
        };
    }
    let k = request.query_number("source")?;
    let Some(lane) = lanes.get(k) else {
        return Err(Error::Usage(format!("there is no source {k}: there are {}, from 0", lanes.len())));
    };
    let (name, views) = (request.query_text("view")?, views(lane.stepper.method()));
    let names: Vec<&str> = views.iter().map(|v| v.name).collect();
    let unknown = || Error::Usage(format!("there is no view {name}: there are {}", names.join(", ")));
    let (n, view) = views.into_iter().enumerate().find(|(_, v)| v.name == name).ok_or_else(unknown)?;
    Ok(([if webgpu { WEBGPU_KEY } else { 0 } + k as u32, n as u32], view, vec![lane]))
}

/// The tile that is requested, as PNG.
pub fn tile(pyramid: &Pyramid, lanes: &[Lane], request: &Request) -> Result<Response> {
    let grid = lanes[0].stepper.grid();
    let extent = [grid.width, grid.height];
    let id = TileId::requested(request, extent)?;
    let webgpu = request.query.get("backend").is_some_and(|b| b == "webgpu");
    let (key, LaneView { scale, content, .. }, lanes) = requested_view(lanes, request, webgpu)?;
    let level0 = |[column, row]: [usize; 2]| {
        let id = TileId { level: 0, column, row };
        let part = |lane: &Lane| values(chunks_of(lane, webgpu), lane.stepper.method(), content, extent, id);
        Ok(match lanes[..] {
            [first, second] => difference(part(first).as_ref(), part(second).as_ref()),
            _ => lanes.first().and_then(|lane| part(lane)),
        })
    };
    match pyramid.tile(&PyramidLayer { key, extent, scale, level0: &level0 }, id)? {
        Some(tile) => Ok(Response::Bytes("image/png", tile.to_png(scale)?)),
        None => Ok(Response::NoContent),
    }
}

fn chunks_of(lane: &Lane, webgpu: bool) -> &ChunkStates {
    match &lane.webgpu {
        Some(chunks) if webgpu => chunks,
        _ => lane.stepper.chunks(),
    }
}

/// The values of a tile of level 0; `None` where no reading reached any of it.
fn values(
    chunks: &ChunkStates,
    method: &dyn Method,
    content: ViewContent,
    extent: [usize; 2],
    id: TileId,
) -> Option<Vec<f32>> {
    let planes = method::planes(method);
    let mut own = vec![0; planes];
    let [width, height] = id.extent(extent);
    let (mut values, mut layers): (Option<Vec<f32>>, _) = (None, vec![0.0; method.layers().len()]);
    for y in (0..height).step_by(TILE) {
        for x in (0..width).step_by(TILE) {
            let tile = [(id.row * EDGE + y) / TILE, (id.column * EDGE + x) / TILE].map(|t| t as u32);
            let Some(words) = tile_of(chunks, planes, tile).filter(|w| w.iter().any(|w| *w != 0)) else { continue };
            let values = values.get_or_insert_with(|| vec![f32::NAN; width * height]);
            for at in 0..TILE_CELLS {
                let (i, j) = (x + at % TILE, y + at / TILE);
                if i < width && j < height {
                    (0..planes).for_each(|p| own[p] = words[p * TILE_CELLS + at]);
                    values[j * width + i] = value(method, &own, &mut layers, content);
                }
            }
        }
    }
    values
}

/// A cell's value in a view; NaN where no reading reached it.
fn value(method: &dyn Method, words: &[u32], layers: &mut [f32], content: ViewContent) -> f32 {
    let updates = words[0] + words[1];
    if updates == 0 && !method.has_subthreshold_evidence(words) {
        return f32::NAN;
    }
    let class = method.values(words, layers);
    let combined = || method.combined(layers, class);
    match content {
        ViewContent::Layer(k) => layers[k],
        ViewContent::Empty => (-combined()).max(0.0),
        ViewContent::Full => combined().max(0.0),
        ViewContent::Combined => combined(),
        ViewContent::Class => f32::from(class as i8),
        ViewContent::Updates => updates as f32,
    }
}

/// The second minus the first; a cell that only one reached counts as 0 in the other.
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
