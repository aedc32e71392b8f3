//! Applies windows of readings and updates by the CPU's kernels, and lists the tiles that they reach.

use super::LogInputs;
use super::cells::{Tiles, tile_at};
use crate::binning::batch::{Batch, Binning, PAIRS};
use crate::binning::update::{Bins, Snapped, snapped};
use crate::feature::Update;
use crate::geometry::layout::Cone;
use crate::kernels::Backend;
use crate::kernels::cpu::Cpu;
use crate::method::{Step, tile_words};
use crate::pipeline::batching::{self, frame, snap_reading};
use crate::pipeline::readings::ReadingInput;
use crate::pipeline::session::Session;
use crate::{Error, Result};
use rayon::prelude::*;
use std::ops::Range;

/// The most items that are applied together: a fraction of a second's work.
pub const WINDOW: usize = 2048;

/// The steps of a sweep, with each reading's share read back to the host.
fn with_shares_read_back(steps: &[Step]) -> Vec<Step> {
    let hand = |step: &Step| match step {
        Step::Sum | Step::NormalizeByCount => vec![*step, Step::ReadBack],
        _ => vec![*step],
    };
    steps.iter().flat_map(hand).collect()
}

/// The binning of a session's readings in a sweep of these steps.
pub(super) fn binning(session: &Session, steps: &[Step]) -> Binning {
    batching::binning(&session.grid, session.method.as_ref(), steps)
}

/// Snaps a reading to a cone; `None`: it doesn't reach the grid.
pub(super) fn cone(session: &Session, item: &ReadingInput) -> Option<Cone> {
    snap_reading(&session.grid, session.sensors(), session.method.as_ref(), item)
}

/// Snaps an update to integers; `None`: it doesn't reach the grid.
pub(super) fn snap_update(session: &Session, update: &Update) -> Result<Option<Snapped>> {
    snapped(&session.grid, session.sensors(), &|s, cone| session.method.profile(s, cone), update)
}

/// Adds the tiles of a batch.
fn add_tiles(batch: &Batch, tiles: &mut Tiles) {
    for list in &batch.chunks {
        tiles.extend(list.tiles.iter().map(|t| tile_at(list.place, t.slot)));
    }
}

/// Applies a range of items that are added to the state one by one, and returns the share of each.
///
/// # Errors
/// The kernels'; [`Error::Usage`] for items that are not applied one by one.
pub(super) fn items(
    session: &Session,
    items: &LogInputs,
    range: Range<usize>,
    cpu: &mut Cpu,
    tiles: &mut Tiles,
) -> Result<Vec<[u32; 4]>> {
    match items {
        LogInputs::Readings(all) => readings(session, 0, &all[range], cpu, tiles),
        LogInputs::Updates(all, _) => {
            updates(session, &all[range.clone()], cpu, tiles).map(|()| vec![[0; 4]; range.len()])
        }
        LogInputs::SweptReadings(_) | LogInputs::Scans(_) => {
            Err(Error::Usage("scans, and readings of several sweeps, are not applied one by one".into()))
        }
    }
}

fn readings(
    session: &Session,
    sweep: usize,
    items: &[ReadingInput],
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
    add_tiles(&batch, tiles);
    let method = session.method.as_ref();
    let mut shares = Vec::new();
    cpu.apply(method, frame(&session.grid, method), &batch, &with_shares_read_back(steps), &mut shares)?;
    let mut shares = shares.into_iter();
    Ok(cones.iter().map(|cone| cone.and_then(|_| shares.next()).unwrap_or_default()).collect())
}

fn updates(session: &Session, updates: &[Update], cpu: &mut Cpu, tiles: &mut Tiles) -> Result<()> {
    let snapped: Vec<Option<Snapped>> =
        updates.par_iter().with_min_len(64).map(|u| snap_update(session, u)).collect::<Result<_>>()?;
    let snapped: Vec<Snapped> = snapped.into_iter().flatten().collect();
    let batch = Bins { size: [session.grid.width, session.grid.height] }.bin(&snapped).batch;
    add_tiles(&batch, tiles);
    let method = session.method.as_ref();
    cpu.apply(method, frame(&session.grid, method), &batch, method.sweeps()[0], &mut Vec::new())
}

/// Computes the map of these readings from nothing, sweep after sweep; returns the share of each from the last sweep.
pub(super) fn all_sweeps(
    session: &Session,
    items: &[ReadingInput],
    cpu: &mut Cpu,
    tiles: &mut Tiles,
) -> Result<Vec<[u32; 4]>> {
    // Tiles of the old state that get cleared have changed, too.
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
        for window in items.chunks(WINDOW) {
            shares.extend(readings(session, sweep, window, cpu, tiles)?);
        }
    }
    Ok(shares)
}

/// The tiles that an item may change.
pub(super) fn tiles(session: &Session, items: &LogInputs, k: usize) -> Result<Tiles> {
    let mut tiles = Tiles::new();
    match items {
        LogInputs::Updates(all, _) => {
            if let Some(snapped) = snap_update(session, &all[k])? {
                let bins = Bins { size: [session.grid.width, session.grid.height] };
                add_tiles(&bins.bin(&[snapped]).batch, &mut tiles);
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
