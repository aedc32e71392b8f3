//! Stores the snapped scans of a log. Poses stay in memory; beams are spilled to an unnamed temporary file when they outgrow
//! their share of memory.

use super::Snapped;
use crate::geometry::layout::Beam;
use crate::support::positional_io;
use crate::{Error, Result};
use std::fs::File;
use std::path::{Path, PathBuf};

/// The snapped scans of a log, in log order.
pub struct Store {
    /// Position of each scan's pose, µm in the world frame.
    pub poses: Vec<[i64; 2]>,
    /// The largest distance at which each scan may touch a cell, µm.
    pub reaches: Vec<i32>,
    /// Index of each scan's first beam, with one more element than there are scans.
    starts: Vec<u64>,
    held: Vec<Beam>,
    /// The largest number of beams in memory.
    most: usize,
    folder: PathBuf,
    spill: Option<File>,
    /// Number of beams in the file.
    spilled: u64,
}

impl Store {
    /// An empty store. Its beams may take `memory` bytes before they are spilled to a file in `folder`.
    pub fn new(folder: &Path, memory: u64) -> Store {
        // A vector grows by doubling.
        let most = usize::try_from(memory / 2).unwrap_or(usize::MAX) / size_of::<Beam>();
        Store {
            poses: Vec::new(),
            reaches: Vec::new(),
            starts: vec![0],
            held: Vec::new(),
            most: most.max(1024),
            folder: folder.into(),
            spill: None,
            spilled: 0,
        }
    }

    /// Adds a scan.
    ///
    /// # Errors
    /// [`Error::Resources`] if its beams can't be spilled, or there are too many scans.
    pub fn push(&mut self, scan: Snapped) -> Result<()> {
        if self.poses.len() >= 1 << 30 {
            return Err(Error::Resources("more than 1073741824 scans: map the log in parts".into()));
        }
        self.poses.push(scan.pose);
        self.reaches.push(scan.reach);
        self.held.extend(scan.beams);
        self.starts.push(self.spilled + self.held.len() as u64);
        if self.held.len() >= self.most { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<()> {
        let full = |e: std::io::Error| {
            Error::Resources(format!("the beams can't be spilled to {}: {e}; free space there", self.folder.display()))
        };
        let file = match self.spill.take() {
            Some(file) => file,
            None => tempfile::tempfile_in(&self.folder).map_err(full)?,
        };
        let at = self.spilled * size_of::<Beam>() as u64;
        positional_io::write_all(&file, bytemuck::cast_slice(&self.held), at).map_err(full)?;
        self.spilled += self.held.len() as u64;
        self.held = Vec::new();
        self.spill = Some(file);
        Ok(())
    }

    /// Number of bytes that were spilled.
    pub fn spilled(&self) -> u64 {
        self.spilled * size_of::<Beam>() as u64
    }

    /// Number of beams of a scan.
    pub fn count(&self, scan: u32) -> usize {
        let k = scan as usize;
        (self.starts[k + 1] - self.starts[k]) as usize
    }

    /// Appends a scan's beams to `beams`.
    ///
    /// # Errors
    /// [`Error::Resources`] if spilled beams can't be read back.
    pub fn read(&self, scan: u32, beams: &mut Vec<Beam>) -> Result<()> {
        let (start, count) = (self.starts[scan as usize], self.count(scan));
        if start >= self.spilled {
            let from = (start - self.spilled) as usize;
            beams.extend_from_slice(&self.held[from..from + count]);
            return Ok(());
        }
        let before = beams.len();
        beams.resize(before + count, bytemuck::Zeroable::zeroed());
        let Some(file) = &self.spill else { return Ok(()) };
        positional_io::read_exact(
            file,
            bytemuck::cast_slice_mut(&mut beams[before..]),
            start * size_of::<Beam>() as u64,
        )
        .map_err(|e| Error::Resources(format!("spilled beams can't be read back: {e}")))
    }
}
