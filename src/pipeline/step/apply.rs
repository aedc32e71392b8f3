//! Readings and updates to the CPU's kernels, some at a time, with the tiles that they reach.

use super::Items;
use super::cells::{Tiles, tile_at};
use crate::Result;
use crate::binning::batch::PAIRS;
use crate::binning::batch::{Batch, Binning};
use crate::binning::update::{Bins, Snapped, snapped};
use crate::feature::Update;
use crate::geometry::layout::Cone;
use crate::kernels::Backend;
use crate::kernels::cpu::Cpu;
use crate::method::{Step, tile_words};
use crate::pipeline::mapper::{Item, frame, snap_item};
use crate::pipeline::session::Session;
use rayon::prelude::*;
use std::ops::Range;

/// Items that are applied together, at most: a fraction of a second's work.
pub const WINDOW: usize = 2048;

/// A sweep's steps, which hand what they found for each reading to the host.
fn handing(steps: &[Step]) -> Vec<Step> {
    let hand = |step: &Step| match step {
        Step::Sum | Step::NormalizeByCount => vec![*step, Step::ReadBack],
        _ => vec![*step],
    };
    steps.iter().flat_map(hand).collect()
}

/// How a session's readings are binned in a sweep.
pub(super) fn binning(session: &Session, steps: &[Step]) -> Binning {
    Binning {
        size: [session.grid.width, session.grid.height],
        footprint: session.method.footprint(),
        no_echo_arcs: steps.contains(&Step::NormalizeByCount),
        only: None,
    }
}

/// A reading's cone; `None`: it doesn't reach the grid.
pub(super) fn cone(session: &Session, item: &Item) -> Option<Cone> {
    snap_item(&session.grid, session.sensors(), session.method.as_ref(), item)
}

/// An update in integers; `None`: it doesn't reach the grid.
pub(super) fn snap_update(session: &Session, update: &Update) -> Result<Option<Snapped>> {
    snapped(&session.grid, session.sensors(), &|s, cone| session.method.profile(s, cone), update)
}

/// Adds a batch's tiles.
fn add(batch: &Batch, tiles: &mut Tiles) {
    for list in &batch.chunks {
        tiles.extend(list.tiles.iter().map(|t| tile_at([list.place[1], list.place[0]], t.slot)));
    }
}

/// Applies some items; of each what its steps found for it.
pub(super) fn items(
    session: &Session,
    items: &Items,
    range: Range<usize>,
    cpu: &mut Cpu,
    tiles: &mut Tiles,
) -> Result<Vec<[u32; 4]>> {
    match items {
        Items::Readings(all) => readings(session, 0, &all[range], cpu, tiles),
        Items::Updates(all, _) => updates(session, &all[range.clone()], cpu, tiles).map(|()| vec![[0; 4]; range.len()]),
        Items::Anew(_) | Items::Scans(_) => Ok(Vec::new()),
    }
}

fn readings(
    session: &Session,
    sweep: usize,
    items: &[Item],
    cpu: &mut Cpu,
    tiles: &mut Tiles,
) -> Result<Vec<[u32; 4]>> {
    let steps = session.method.sweeps()[sweep];
    let binning = binning(session, steps);
    let cones: Vec<Option<Cone>> = items.par_iter().with_min_len(64).map(|item| cone(session, item)).collect();
    let pairs: usize = cones.iter().flatten().map(|c| binning.at_most(c)).sum();
    if pairs > PAIRS && items.len() > 1 {
        let (first, last) = items.split_at(items.len() / 2);
        let mut shares = readings(session, sweep, first, cpu, tiles)?;
        shares.extend(readings(session, sweep, last, cpu, tiles)?);
        return Ok(shares);
    }
    let batch = rayon::scope(|_| binning.bin(cones.iter().flatten().copied().collect()));
    add(&batch, tiles);
    let method = session.method.as_ref();
    let mut found = Vec::new();
    cpu.apply(method, frame(&session.grid, method), &batch, &handing(steps), &mut found)?;
    let mut found = found.into_iter();
    Ok(cones.iter().map(|cone| cone.and_then(|_| found.next()).unwrap_or_default()).collect())
}

fn updates(session: &Session, updates: &[Update], cpu: &mut Cpu, tiles: &mut Tiles) -> Result<()> {
    let found: Vec<Option<Snapped>> =
        updates.par_iter().with_min_len(64).map(|u| snap_update(session, u)).collect::<Result<_>>()?;
    let snapped: Vec<Snapped> = found.into_iter().flatten().collect();
    let batch = Bins { size: [session.grid.width, session.grid.height] }.bin(&snapped).batch;
    add(&batch, tiles);
    let method = session.method.as_ref();
    cpu.apply(method, frame(&session.grid, method), &batch, method.sweeps()[0], &mut Vec::new())
}

/// The map of the first `to` readings, from nothing, sweep after sweep; of each reading what the last found for it.
pub(super) fn anew(
    session: &Session,
    items: &Items,
    to: usize,
    cpu: &mut Cpu,
    tiles: &mut Tiles,
) -> Result<Vec<[u32; 4]>> {
    let Items::Anew(all) = items else { return Ok(Vec::new()) };
    // What was there and isn't any more has changed, too.
    let words = tile_words(session.method.as_ref());
    for (place, state) in cpu.chunks_mut() {
        for (slot, tile) in (0..).zip(state.chunks_exact_mut(words)).filter(|(_, t)| t.iter().any(|w| *w != 0)) {
            tiles.insert(tile_at(*place, slot));
            tile.fill(0);
        }
    }
    let mut shares = Vec::new();
    for sweep in 0..session.method.sweeps().len() {
        shares.clear();
        for window in all[..to].chunks(WINDOW) {
            shares.extend(readings(session, sweep, window, cpu, tiles)?);
        }
    }
    Ok(shares)
}

/// The tiles that an item may change.
pub(super) fn tiles(session: &Session, items: &Items, k: usize) -> Result<Tiles> {
    let mut tiles = Tiles::new();
    match items {
        Items::Updates(all, _) => {
            if let Some(snapped) = snap_update(session, &all[k])? {
                let bins = Bins { size: [session.grid.width, session.grid.height] };
                add(&bins.bin(&[snapped]).batch, &mut tiles);
            }
        }
        _ => {
            let cone = items.reading(k).and_then(|item| cone(session, &item));
            if let Some(cone) = cone {
                let binning = binning(session, session.method.sweeps()[0]);
                binning.tiles_of(&cone, &mut |[column, row], _| {
                    tiles.insert([row as u32, column as u32]);
                });
            }
        }
    }
    Ok(tiles)
}
