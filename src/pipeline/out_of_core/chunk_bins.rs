//! Snapped readings binned to chunks, each chunk's in log order. Readings that outgrow their share of memory are spilled to a file,
//! in one run of cones per chunk.

use crate::geometry::layout::Cone;
use crate::grid::ChunkId;
use crate::support::positional_io;
use crate::{Error, Result};
use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

/// Snapped readings by chunk. A cone's `index` is its reading's number in the log.
pub struct ChunkBins {
    buckets: BTreeMap<ChunkId, Bucket>,
    /// Cones in memory, and their limit.
    held: usize,
    most: usize,
    /// The folder of the spill file, which is made when it is needed.
    folder: PathBuf,
    spill: Option<File>,
    /// Length of the spill file, bytes.
    end: u64,
}

#[derive(Default)]
struct Bucket {
    held: Vec<Cone>,
    /// Runs in the spill file: offset in bytes, number of cones.
    runs: Vec<(u64, usize)>,
    count: u64,
}

impl ChunkBins {
    /// Creates empty bins. Cones that take more than `memory` bytes are spilled to a nameless file in `folder`.
    pub fn new(folder: &Path, memory: u64) -> ChunkBins {
        // A vector grows by doubling.
        let most = ((memory / 2) as usize / size_of::<Cone>()).max(1024);
        ChunkBins { buckets: BTreeMap::new(), held: 0, most, folder: folder.into(), spill: None, end: 0 }
    }

    /// Adds a reading to a chunk.
    ///
    /// # Errors
    /// [`Error::Resources`] where readings can't be spilled.
    pub fn push(&mut self, place: ChunkId, cone: Cone) -> Result<()> {
        let bucket = self.buckets.entry(place).or_default();
        bucket.held.push(cone);
        bucket.count += 1;
        self.held += 1;
        if self.held >= self.most { self.flush() } else { Ok(()) }
    }

    /// Moves the cones in memory to the spill file.
    fn flush(&mut self) -> Result<()> {
        let full = |e: std::io::Error| {
            Error::Resources(format!(
                "the readings can't be spilled to {}: {e}; free space there",
                self.folder.display()
            ))
        };
        let file = match self.spill.take() {
            Some(file) => file,
            None => tempfile::tempfile_in(&self.folder).map_err(full)?,
        };
        for bucket in self.buckets.values_mut().filter(|b| !b.held.is_empty()) {
            let bytes: &[u8] = bytemuck::cast_slice(&bucket.held);
            positional_io::write_all(&file, bytes, self.end).map_err(full)?;
            bucket.runs.push((self.end, bucket.held.len()));
            self.end += bytes.len() as u64;
            bucket.held = Vec::new();
        }
        self.held = 0;
        self.spill = Some(file);
        Ok(())
    }

    /// The chunks that readings reach, row by row, each with its number of readings.
    pub fn chunks(&self) -> Vec<(ChunkId, u64)> {
        self.buckets.iter().map(|(place, bucket)| (*place, bucket.count)).collect()
    }

    /// The readings that were spilled, bytes.
    pub fn spilled(&self) -> u64 {
        self.end
    }

    /// Reads at most `count` readings of a chunk, from its `first` on; none for a chunk that no reading reaches.
    ///
    /// # Errors
    /// [`Error::Resources`] where spilled readings can't be read back.
    pub fn read(&self, place: ChunkId, first: usize, count: usize) -> Result<Vec<Cone>> {
        let Some(bucket) = self.buckets.get(&place) else { return Ok(Vec::new()) };
        let mut cones: Vec<Cone> = Vec::with_capacity(count.min(bucket.count as usize - first));
        let mut before = 0;
        for (at, length) in &bucket.runs {
            let skip = first.saturating_sub(before).min(*length);
            let take = (length - skip).min(count - cones.len());
            if take > 0 {
                let start = cones.len();
                cones.resize(start + take, bytemuck::Zeroable::zeroed());
                let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut cones[start..]);
                let from = at + (skip * size_of::<Cone>()) as u64;
                let file = self.spill.as_ref().ok_or_else(|| unreadable("the spill file isn't open"))?;
                positional_io::read_exact(file, bytes, from).map_err(unreadable)?;
            }
            before += length;
        }
        let skip = first.saturating_sub(before).min(bucket.held.len());
        let rest = &bucket.held[skip..];
        cones.extend_from_slice(&rest[..rest.len().min(count - cones.len())]);
        Ok(cones)
    }
}

fn unreadable(cause: impl std::fmt::Display) -> Error {
    Error::Resources(format!("spilled readings can't be read back: {cause}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn in_memory_or_spilled_every_chunk_keeps_its_order() {
        let folder = tempfile::tempdir().unwrap();
        for memory in [0, 400_000, 1 << 30] {
            let mut bins = ChunkBins::new(folder.path(), memory);
            let mut want: BTreeMap<ChunkId, Vec<u32>> = BTreeMap::new();
            for index in 0..20_000u32 {
                let place = ChunkId { row: index % 3, column: index * 7 % 5 };
                want.entry(place).or_default().push(index);
                bins.push(place, Cone { index, ..Cone::zeroed() }).unwrap();
            }
            assert_eq!(bins.spilled() > 0, memory < 1 << 20);
            for (place, count) in bins.chunks() {
                let all = &want[&place];
                assert_eq!(count as usize, all.len());
                for step in [1, 7, 1000, 30_000] {
                    let numbers = (0..all.len())
                        .step_by(step)
                        .take(40)
                        .flat_map(|first| bins.read(place, first, step).unwrap().into_iter().map(|c| c.index));
                    assert!(numbers.eq(all.iter().copied().take(40 * step)), "{place:?} by {step}");
                }
            }
            assert_eq!(bins.read(ChunkId { row: 9, column: 9 }, 0, 10).unwrap().len(), 0);
        }
    }
}
