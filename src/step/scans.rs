//! A log's scans for a counting sensor model. What a cell takes depends on where the robot has been so far: with a scan more or less, the tiles
//! for which that scan may be among the nearest are made anew.

use super::cells::{Tiles, place, tile_at};
use crate::Result;
use crate::batch::Batch;
use crate::kernels::Backend;
use crate::kernels::cpu::Cpu;
use crate::layout::CHUNK;
use crate::mapper::{PAIRS, frame};
use crate::method::settings::Csm;
use crate::method::tile_words;
use crate::scan::{Index, Most, Scan, Store, Tiles as Listing, snap};
use crate::session::Session;
use crate::whole::{Place, places};
use rayon::prelude::*;
use std::ops::Range;

/// The scans of a log, snapped.
pub struct Scanned {
    /// All of them.
    pub all: Vec<Scan>,
    /// The model.
    pub csm: Csm,
    store: Store,
}

/// What a batch may come to.
const MOST: Most = Most { beams: 1 << 20, pairs: PAIRS, one: [1 << 27; 2], turns: usize::MAX };

impl Scanned {
    /// All of a session's.
    pub fn read(session: &Session, csm: Csm) -> Result<Scanned> {
        let all: Vec<Scan> = session.scans()?.collect::<Result<_>>()?;
        let mut store = Store::new(&std::env::temp_dir(), u64::MAX);
        let snapped: Vec<_> = all.par_iter().map(|s| snap(s, &csm, session.grid.resolution)).collect();
        snapped.into_iter().try_for_each(|scan| store.push(scan))?;
        Ok(Scanned { all, csm, store })
    }

    fn index(&self, scans: usize) -> Option<Index> {
        self.csm.neighbours.map(|n| Index::new(&self.store.poses[..scans], usize::from(n)))
    }

    /// The tiles, by chunk, that differ when so many scans are known with these or without.
    fn concerned(&self, session: &Session, scans: Range<usize>, known: usize) -> Vec<(Place, Vec<[usize; 2]>)> {
        let index = self.index(known);
        let range = scans.start as u32..scans.end as u32;
        let of = |chunk: Place| {
            let listing = Listing::of(&session.grid, chunk, &self.store, index.as_ref(), &self.csm);
            (chunk, listing.concerned(range.clone()))
        };
        places(&session.grid).map(of).filter(|(_, tiles)| !tiles.is_empty()).collect()
    }

    /// The same as tiles of the grid.
    pub fn tiles(&self, session: &Session, scans: Range<usize>, known: usize) -> Tiles {
        let mut tiles = Tiles::new();
        for (chunk, own) in self.concerned(session, scans, known) {
            tiles.extend(own.iter().map(|at| tile(chunk, *at)));
        }
        tiles
    }

    /// Brings the cells from one number of scans to another.
    pub fn remake(
        &self,
        session: &Session,
        change: Range<usize>,
        cpu: &mut Cpu,
        reached: &mut Tiles,
    ) -> Result<()> {
        let (from, to) = (change.start, change.end);
        let (scans, known) = (from.min(to)..from.max(to), from.max(to));
        let words = tile_words(session.method.as_ref());
        // Where a cell takes all poses more scans only add to what is there.
        let adds = self.csm.neighbours.is_none() && to > from;
        let index = self.index(to);
        for (chunk, tiles) in self.concerned(session, scans.clone(), known) {
            if let (false, Some(state)) = (adds, cpu.chunks_mut().get_mut(&chunk)) {
                for at in &tiles {
                    let (_, slot) = place(tile(chunk, *at));
                    state[slot * words..(slot + 1) * words].fill(0);
                }
            }
            reached.extend(tiles.iter().map(|at| tile(chunk, *at)));
            let added = if adds { from as u32..to as u32 } else { 0..to as u32 };
            self.batches(session, chunk, index.as_ref(), tiles, added, &mut |batch| {
                let method = session.method.as_ref();
                cpu.apply(method, frame(&session.grid, method), &batch, method.sweeps()[0], &mut Vec::new())
            })?;
        }
        Ok(())
    }

    fn batches(
        &self,
        session: &Session,
        chunk: Place,
        index: Option<&Index>,
        tiles: Vec<[usize; 2]>,
        scans: Range<u32>,
        apply: &mut dyn FnMut(Batch) -> Result<()>,
    ) -> Result<()> {
        let mut failed = None;
        let listing = Listing::of(&session.grid, chunk, &self.store, index, &self.csm);
        listing.batches_of(tiles, scans, MOST, &mut |batch, _| {
            failed = apply(batch).err();
            failed.is_none()
        })?;
        failed.map_or(Ok(()), Err)
    }
}

/// A chunk's tile as one of the grid.
fn tile(chunk: Place, [column, row]: [usize; 2]) -> [u32; 2] {
    tile_at(chunk, (row * CHUNK + column) as u32)
}
