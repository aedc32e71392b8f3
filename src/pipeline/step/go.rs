//! Getting from one place of the log to another.

use super::cells::{Tiles, changes, tile_of};
use super::{Items, Stepper};
use crate::Result;
use crate::geometry::layout::TILE_CELLS;
use crate::method::{self, tile_words};
use crate::pipeline::step::apply;
use std::collections::BTreeMap;

/// By what a step goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum By {
    /// So many items: readings, or what the method takes.
    Items(i64),
    /// So many scans, to their end; back to their beginning.
    Scans(i64),
    /// To a position.
    To(usize),
}

impl Stepper {
    /// Where a step leads from here, within the log.
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

    /// Goes to a position for as long as `more` says so, window by window; what of the map may differ from what it was. Ends on a
    /// position from which it can go on.
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
            Items::Readings(_) | Items::Updates(..) => self.follow(to, more, &mut reached)?,
            Items::Anew(_) | Items::Scans(_) => self.remake(to, &mut reached)?,
        }
        Ok(reached)
    }

    /// Item after item, from a snapshot where it goes back.
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
            self.note(&before);
            reached.append(&mut tiles);
        }
        Ok(())
    }

    /// Applies the items from the position to another, and keeps a snapshot where one is due.
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

    /// The state of a position by itself, in two steps, to see what the last item does.
    fn remake(&mut self, to: usize, reached: &mut Tiles) -> Result<()> {
        self.touched.clear();
        let before = to.saturating_sub(1);
        for to in [before, to] {
            if to == self.position {
                continue;
            }
            let last = to > before;
            let copy = match &self.items {
                Items::Scans(scans) => {
                    let change = scans.change(&self.session, self.position, to);
                    let tiles = change.reached();
                    let copy = if last { self.copy(&tiles) } else { BTreeMap::new() };
                    scans.apply(&self.session, change, &mut self.cpu)?;
                    reached.extend(tiles);
                    copy
                }
                items => {
                    let tiles = if last { apply::tiles(&self.session, items, before)? } else { Tiles::new() };
                    let copy = self.copy(&tiles);
                    self.shares = apply::anew(&self.session, items, to, &mut self.cpu, reached)?;
                    copy
                }
            };
            self.position = to;
            self.note(&copy);
        }
        Ok(())
    }

    /// Copies of tiles.
    fn copy(&self, tiles: &Tiles) -> BTreeMap<[u32; 2], Vec<u32>> {
        let planes = method::planes(self.method());
        let words = |tile: &[u32; 2]| match tile_of(self.chunks(), planes, *tile) {
            Some(words) => words.to_vec(),
            None => vec![0; planes * TILE_CELLS],
        };
        tiles.iter().map(|tile| (*tile, words(tile))).collect()
    }

    /// Notes the cells that differ from what they were.
    fn note(&mut self, before: &BTreeMap<[u32; 2], Vec<u32>>) {
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
