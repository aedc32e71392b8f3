//! Readings binned to chunks, once, each chunk's in log order. What outgrows its share of memory is spilled to a file, a
//! run of cones a chunk at a time.

use crate::geometry::layout::Cone;
use crate::grid::Place;
use crate::support::positional_io;
use crate::{Error, Result};
use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

/// Snapped readings by chunk. A cone's `index` is its reading's number in the log.
pub struct Bins {
    buckets: BTreeMap<Place, Bucket>,
    /// Cones in memory, and the most of them.
    held: usize,
    most: usize,
    /// Where the file is made when it is needed.
    folder: PathBuf,
    spill: Option<File>,
    end: u64,
}

#[derive(Default)]
struct Bucket {
    held: Vec<Cone>,
    /// Runs in the file: from where, how many cones.
    runs: Vec<(u64, usize)>,
    count: u64,
}

impl Bins {
    /// None yet; `memory` is what they may take, bytes, before they are spilled into a nameless file in `folder`.
    pub fn new(folder: &Path, memory: u64) -> Bins {
        // A vector grows by doubling.
        let most = ((memory / 2) as usize / size_of::<Cone>()).max(1024);
        Bins { buckets: BTreeMap::new(), held: 0, most, folder: folder.into(), spill: None, end: 0 }
    }

    /// Adds a reading to a chunk.
    pub fn push(&mut self, place: Place, cone: Cone) -> Result<()> {
        let bucket = self.buckets.entry(place).or_default();
        bucket.held.push(cone);
        bucket.count += 1;
        self.held += 1;
        if self.held >= self.most { self.flush() } else { Ok(()) }
    }

    /// Writes what is held to the file.
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

    /// The chunks that readings reach, row by row, and how many readings each has.
    pub fn places(&self) -> Vec<(Place, u64)> {
        self.buckets.iter().map(|(place, bucket)| (*place, bucket.count)).collect()
    }

    /// Bytes that were spilled.
    pub fn spilled(&self) -> u64 {
        self.end
    }

    /// A chunk's readings from number `first` of them on, at most `count`.
    pub fn read(&self, place: Place, first: usize, count: usize) -> Result<Vec<Cone>> {
        let Some(bucket) = self.buckets.get(&place) else { return Ok(Vec::new()) };
        let mut cones: Vec<Cone> = Vec::with_capacity(count.min(bucket.count as usize - first));
        let mut before = 0;
        for (at, length) in &bucket.runs {
            let skip = first.saturating_sub(before).min(*length);
            let take = (length - skip).min(count - cones.len());
            if let (true, Some(file)) = (take > 0, &self.spill) {
                let start = cones.len();
                cones.resize(start + take, bytemuck::Zeroable::zeroed());
                let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut cones[start..]);
                let from = at + (skip * size_of::<Cone>()) as u64;
                positional_io::read_exact(file, bytes, from)
                    .map_err(|e| Error::Resources(format!("spilled readings can't be read back: {e}")))?;
            }
            before += length;
        }
        let skip = first.saturating_sub(before).min(bucket.held.len());
        let rest = &bucket.held[skip..];
        cones.extend_from_slice(&rest[..rest.len().min(count - cones.len())]);
        Ok(cones)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn in_memory_or_spilled_every_chunk_keeps_its_order() {
        let folder = tempfile::tempdir().unwrap();
        for memory in [0, 400_000, 1 << 30] {
            let mut bins = Bins::new(folder.path(), memory);
            let mut want: BTreeMap<Place, Vec<u32>> = BTreeMap::new();
            for index in 0..20_000u32 {
                let place = [index % 3, index * 7 % 5];
                want.entry(place).or_default().push(index);
                bins.push(place, Cone { index, ..Cone::zeroed() }).unwrap();
            }
            assert_eq!(bins.spilled() > 0, memory < 1 << 20);
            for (place, count) in bins.places() {
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
            assert_eq!(bins.read([9, 9], 0, 10).unwrap().len(), 0);
        }
    }
}
