//! Snapshots of the map at positions of the log. Each holds only the tiles that changed since the one before.

use super::cells::{Tiles, place};
use crate::kernels::ChunkStates;
use std::collections::BTreeMap;

/// The most snapshots of a log.
const MOST_SNAPSHOTS: usize = 256;
/// The fewest items between two snapshots.
const LEAST: usize = 64;

/// A tile's words at snapshots, by the snapshots' positions in the log.
type Versions = BTreeMap<usize, Box<[u32]>>;

/// The snapshots of one run through a log.
pub struct Snapshots {
    /// The number of items from one snapshot to the next.
    apart: usize,
    /// The positions that have a snapshot; 0 always has one.
    kept: Vec<usize>,
    tiles: BTreeMap<[u32; 2], Versions>,
    /// The tiles that changed after the last snapshot.
    since: Tiles,
    bytes: u64,
    most: u64,
}

impl Snapshots {
    /// Snapshots of a log of so many items, none yet; they take at most `most` bytes.
    pub fn new(items: usize, most: u64) -> Snapshots {
        let apart = items.div_ceil(MOST_SNAPSHOTS).max(LEAST);
        Snapshots { apart, kept: vec![0], tiles: BTreeMap::new(), since: Tiles::new(), bytes: 0, most }
    }

    /// The next position after one that should have a snapshot.
    pub fn next(&self, position: usize) -> usize {
        (position / self.apart + 1) * self.apart
    }

    /// Notes the tiles that changed on the way to a position, and keeps a snapshot there where one is due.
    pub fn keep(&mut self, position: usize, words: usize, chunks: &ChunkStates, changed: &Tiles) {
        let last = self.kept.last().copied().unwrap_or(0);
        if position <= last {
            return;
        }
        self.since.extend(changed);
        if !position.is_multiple_of(self.apart) {
            return;
        }
        for tile in std::mem::take(&mut self.since) {
            let (chunk, slot) = place(tile);
            // A tile of a chunk without memory is all zeros, which needs no copy.
            let Some(state) = chunks.get(&chunk) else { continue };
            let copy: Box<[u32]> = state[slot * words..(slot + 1) * words].into();
            self.bytes += 4 * copy.len() as u64;
            self.tiles.entry(tile).or_default().insert(position, copy);
        }
        self.kept.push(position);
        while self.bytes > self.most && self.kept.len() > 2 {
            self.thin();
        }
    }

    /// Drops every second snapshot.
    fn thin(&mut self) {
        self.apart *= 2;
        let (kept, gone): (Vec<usize>, Vec<usize>) = self.kept.iter().partition(|at| at.is_multiple_of(self.apart));
        for versions in self.tiles.values_mut() {
            for at in &gone {
                // The next snapshot that stays was the same, unless it has its own.
                let Some(words) = versions.remove(at) else { continue };
                let next = kept.iter().find(|k| *k > at);
                match next.filter(|next| !versions.contains_key(next)) {
                    Some(next) => drop(versions.insert(*next, words)),
                    None => self.bytes -= 4 * words.len() as u64,
                }
            }
        }
        // Tiles of a dropped last snapshot have changed since the last one that stays.
        let last = kept.last().copied().unwrap_or(0);
        if gone.iter().any(|at| *at > last) {
            self.since.extend(self.tiles.keys());
        }
        self.kept = kept;
    }

    /// Restores the last snapshot not after a position and returns its position. Adds to `reached` the tiles that may have changed.
    pub fn restore(&mut self, position: usize, words: usize, chunks: &mut ChunkStates, reached: &mut Tiles) -> usize {
        let at = self.kept.iter().copied().rfind(|kept| *kept <= position).unwrap_or(0);
        let changed = |versions: &Versions| versions.range(at + 1..).next().is_some();
        let mut stale: Tiles = self.tiles.iter().filter(|(_, v)| changed(v)).map(|(tile, _)| *tile).collect();
        stale.append(&mut self.since);
        for tile in &stale {
            let (chunk, slot) = place(*tile);
            // A chunk without memory is all zeros at every position.
            let Some(state) = chunks.get_mut(&chunk) else { continue };
            let state = &mut state[slot * words..(slot + 1) * words];
            let version = self.tiles.get(tile).and_then(|v| v.range(..=at).next_back());
            match version {
                Some((_, copy)) => state.copy_from_slice(copy),
                None => state.fill(0),
            }
        }
        reached.extend(stale);
        at
    }
}
