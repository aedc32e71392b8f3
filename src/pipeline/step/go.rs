//! Moves a stepper to another position of the log.

use super::cells::{Tiles, changes, tile_of};
use super::{LogInputs, Stepper};
use crate::geometry::layout::TILE_CELLS;
use crate::method::{self, tile_words};
use crate::pipeline::step::apply;
use crate::{Error, Result};
use std::collections::BTreeMap;

/// The length of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum By {
    /// So many items; negative: back.
    Items(i64),
    /// So many scans: forwards to the end of the last, back (negative) to the beginning of the first.
    Scans(i64),
    /// To a position.
    To(usize),
}

impl Stepper {
    /// The position that a step leads to, within the log.
    pub fn target(&self, by: By) -> usize {
        let total = self.items.len();
        match by {
            By::To(position) => position.min(total),
            By::Items(count) => {
                let to = (self.position as i64).saturating_add(count);
                to.clamp(0, total as i64) as usize
            }
            By::Scans(0) => self.position,
            By::Scans(count) => {
                // On from the scan that the next item belongs to; back from that of the last.
                let here = if count > 0 { self.position + 1 } else { self.position };
                let scan = (self.scans(here) as i64).saturating_add(count);
                let start = |scan: i64| self.starts.get(scan as usize).copied().unwrap_or(total);
                if count > 0 { start(scan - 1) } else { start(scan.max(0)) }
            }
        }
    }

    /// Moves towards a position, window by window, for as long as `more` returns true; it ends on a position from which it can go on.
    /// Returns the tiles that may have changed.
    ///
    /// # Errors
    /// The kernels', and those of spilled scans.
    pub fn go(&mut self, to: usize, more: &mut dyn FnMut() -> bool) -> Result<Tiles> {
        let to = to.min(self.items.len());
        if to == self.position {
            return Ok(Tiles::new());
        }
        let mut reached = Tiles::new();
        match self.items {
            LogInputs::Readings(_) | LogInputs::Updates(..) => self.follow(to, more, &mut reached)?,
            LogInputs::SweptReadings(_) | LogInputs::Scans(_) => self.recompute(to, &mut reached)?,
        }
        Ok(reached)
    }

    /// Applies item after item; a step back starts from a snapshot.
    fn follow(&mut self, to: usize, more: &mut dyn FnMut() -> bool, reached: &mut Tiles) -> Result<()> {
        if to <= self.position {
            // The last item is applied by itself, to see what it does.
            let words = tile_words(self.method());
            let before = to.saturating_sub(1);
            self.position = self.snapshots.restore(before, words, self.cpu.chunks_mut(), reached);
        }
        let mut first = true;
        while self.position + 1 < to && (first || more()) {
            let next = self.snapshots.next(self.position).min(to - 1);
            self.advance(next.min(self.position + apply::WINDOW), reached)?;
            first = false;
        }
        self.touched.clear();
        if self.position < to {
            let mut tiles = apply::tiles(&self.session, &self.items, self.position)?;
            let before = self.copy(&tiles);
            self.advance(self.position + 1, &mut tiles)?;
            self.note_changes(&before);
            reached.append(&mut tiles);
        }
        Ok(())
    }

    /// Applies the items up to a position, and keeps a snapshot where one is due.
    fn advance(&mut self, to: usize, reached: &mut Tiles) -> Result<()> {
        let mut tiles = Tiles::new();
        let from = self.position;
        let shares = apply::items(&self.session, &self.items, from..to, &mut self.cpu, &mut tiles)?;
        self.shares.truncate(from);
        self.shares.extend(shares);
        self.position = to;
        self.snapshots.keep(to, tile_words(self.session.method.as_ref()), self.cpu.chunks(), &tiles);
        reached.append(&mut tiles);
        Ok(())
    }

    /// Computes the state before the last item and the state after it, to see what the item changes.
    fn recompute(&mut self, to: usize, reached: &mut Tiles) -> Result<()> {
        self.touched.clear();
        let before = to.saturating_sub(1);
        for to in [before, to] {
            if to == self.position {
                continue;
            }
            let last = to > before;
            let copy = match &self.items {
                LogInputs::Scans(scans) => {
                    let change = scans.change(&self.session, self.position, to);
                    let tiles = change.reached();
                    let copy = if last { self.copy(&tiles) } else { BTreeMap::new() };
                    scans.apply(&self.session, change, &mut self.cpu)?;
                    reached.extend(tiles);
                    copy
                }
                LogInputs::SweptReadings(all) => {
                    let tiles = if last { apply::tiles(&self.session, &self.items, before)? } else { Tiles::new() };
                    let copy = self.copy(&tiles);
                    self.shares = apply::all_sweeps(&self.session, &all[..to], &mut self.cpu, reached)?;
                    copy
                }
                LogInputs::Readings(_) | LogInputs::Updates(..) => {
                    return Err(Error::Usage("readings and updates are applied one by one".into()));
                }
            };
            self.position = to;
            self.note_changes(&copy);
        }
        Ok(())
    }

    /// Copies the words of tiles.
    fn copy(&self, tiles: &Tiles) -> BTreeMap<[u32; 2], Vec<u32>> {
        let planes = method::planes(self.method());
        let words = |tile: &[u32; 2]| match tile_of(self.chunks(), planes, *tile) {
            Some(words) => words.to_vec(),
            None => vec![0; planes * TILE_CELLS],
        };
        tiles.iter().map(|tile| (*tile, words(tile))).collect()
    }

    /// Lists the cells of tiles that differ from a copy.
    fn note_changes(&mut self, before: &BTreeMap<[u32; 2], Vec<u32>>) {
        let planes = method::planes(self.method());
        let mut touched = Vec::new();
        for (tile, old) in before {
            if let Some(new) = tile_of(self.chunks(), planes, *tile) {
                changes(*tile, planes, old, new, &mut touched);
            }
        }
        self.touched = touched;
    }
}
