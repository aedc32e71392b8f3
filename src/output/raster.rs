//! A picture or an array on disk that is written block by block: rows of equal length behind a header, the bottom row first
//! or last.

use super::unwritable;
use crate::Result;
use crate::support::positional_io;
use std::fs::File;
use std::path::{Path, PathBuf};

/// Where in a raster: its first column and row, counted from the lower left, and how many of each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Block {
    pub column: usize,
    pub row: usize,
    pub width: usize,
    pub height: usize,
}

/// A raster under way.
pub(super) struct Raster {
    file: File,
    path: PathBuf,
    /// Bytes before the first row.
    start: u64,
    width: usize,
    height: usize,
    /// Bytes an element.
    size: usize,
    /// Whether the top row comes first, as in pictures.
    flip: bool,
}

impl Raster {
    /// Makes the file, its elements 0; or, to go on with one, opens it as it is.
    pub fn open(
        path: &Path,
        header: &[u8],
        [width, height]: [usize; 2],
        size: usize,
        flip: bool,
        resume: bool,
    ) -> Result<Raster> {
        let length = header.len() as u64 + (width * size) as u64 * height as u64;
        let file = File::options().read(true).write(true).create(true).truncate(!resume).open(path);
        let file = file.and_then(|file| {
            if file.metadata()?.len() != length {
                file.set_len(length)?;
                positional_io::write_all(&file, header, 0)?;
            }
            Ok(file)
        });
        let file = file.map_err(|e| unwritable(path, e))?;
        Ok(Raster { file, path: path.into(), start: header.len() as u64, width, height, size, flip })
    }

    /// Columns and rows.
    pub fn extent(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    fn at(&self, column: usize, row: usize) -> u64 {
        let line = if self.flip { self.height - 1 - row } else { row };
        self.start + (line as u64 * self.width as u64 + column as u64) * self.size as u64
    }

    /// Writes a block, its rows from the bottom.
    pub fn write(&self, block: Block, bytes: &[u8]) -> Result<()> {
        let row = block.width * self.size;
        for (k, bytes) in bytes.chunks_exact(row).take(block.height).enumerate() {
            let at = self.at(block.column, block.row + k);
            positional_io::write_all(&self.file, bytes, at).map_err(|e| unwritable(&self.path, e))?;
        }
        Ok(())
    }

    /// Writes one element throughout a block.
    pub fn fill(&self, block: Block, element: &[u8]) -> Result<()> {
        self.write(block, &element.repeat(block.width * block.height))
    }

    /// Reads a block, its rows from the bottom.
    pub fn read(&self, block: Block) -> Result<Vec<u8>> {
        let row = block.width * self.size;
        let mut bytes = vec![0; row * block.height];
        for (k, bytes) in bytes.chunks_exact_mut(row).enumerate() {
            let at = self.at(block.column, block.row + k);
            positional_io::read_exact(&self.file, bytes, at).map_err(|e| unwritable(&self.path, e))?;
        }
        Ok(bytes)
    }

    /// Removes the file: it was only a step.
    pub fn remove(self) -> Result<()> {
        std::fs::remove_file(&self.path).map_err(|e| unwritable(&self.path, e))
    }

    /// Sees to it that the bytes are on disk.
    pub fn close(self) -> Result<()> {
        self.file.sync_all().map_err(|e| unwritable(&self.path, e))
    }
}
