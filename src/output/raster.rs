//! A picture or an array on disk that is written block by block: rows of equal length after a header.

use super::unwritable;
use crate::Result;
use crate::support::positional_io;
use std::fs::File;
use std::path::{Path, PathBuf};

/// A block of a raster: its first column and row, counted from the lower left, and the number of each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Block {
    pub column: usize,
    pub row: usize,
    pub width: usize,
    pub height: usize,
}

/// The layout of a raster's file.
pub(super) struct RasterLayout {
    /// The bytes before the first row.
    pub header: Vec<u8>,
    /// Columns and rows.
    pub extent: [usize; 2],
    /// Bytes of an element.
    pub element: usize,
    /// Whether the top row comes first, as in pictures.
    pub top_first: bool,
}

/// An open raster.
pub(super) struct Raster {
    file: File,
    path: PathBuf,
    layout: RasterLayout,
}

impl Raster {
    /// Creates the file with elements of 0; with `resume` opens it as it is, if it is there.
    ///
    /// # Errors
    /// [`Error::Resources`](crate::Error::Resources) if it can't be written.
    pub fn open(path: &Path, layout: RasterLayout, resume: bool) -> Result<Raster> {
        let [width, height] = layout.extent;
        let length = layout.header.len() as u64 + (width * layout.element) as u64 * height as u64;
        let file = File::options().read(true).write(true).create(true).truncate(!resume).open(path);
        let file = file.and_then(|file| {
            if file.metadata()?.len() != length {
                file.set_len(length)?;
                positional_io::write_all(&file, &layout.header, 0)?;
            }
            Ok(file)
        });
        let file = file.map_err(|e| unwritable(path, e))?;
        Ok(Raster { file, path: path.into(), layout })
    }

    /// Columns and rows.
    pub fn extent(&self) -> [usize; 2] {
        self.layout.extent
    }

    /// The offset of an element in the file, bytes.
    fn at(&self, column: usize, row: usize) -> u64 {
        let RasterLayout { ref header, extent: [width, height], element, top_first } = self.layout;
        let line = if top_first { height - 1 - row } else { row };
        header.len() as u64 + (line as u64 * width as u64 + column as u64) * element as u64
    }

    /// Writes a block; its bottom row comes first.
    pub fn write(&self, block: Block, bytes: &[u8]) -> Result<()> {
        let row = block.width * self.layout.element;
        for (k, bytes) in bytes.chunks_exact(row).take(block.height).enumerate() {
            let at = self.at(block.column, block.row + k);
            positional_io::write_all(&self.file, bytes, at).map_err(|e| unwritable(&self.path, e))?;
        }
        Ok(())
    }

    /// Fills a block with one element.
    pub fn fill(&self, block: Block, element: &[u8]) -> Result<()> {
        self.write(block, &element.repeat(block.width * block.height))
    }

    /// Reads a block; its bottom row comes first.
    pub fn read(&self, block: Block) -> Result<Vec<u8>> {
        let row = block.width * self.layout.element;
        let mut bytes = vec![0; row * block.height];
        for (k, bytes) in bytes.chunks_exact_mut(row).enumerate() {
            let at = self.at(block.column, block.row + k);
            positional_io::read_exact(&self.file, bytes, at).map_err(|e| unwritable(&self.path, e))?;
        }
        Ok(bytes)
    }

    /// Removes the file, for a raster that is only an intermediate step.
    pub fn remove(self) -> Result<()> {
        std::fs::remove_file(&self.path).map_err(|e| unwritable(&self.path, e))
    }

    /// Flushes the bytes to disk.
    pub fn close(self) -> Result<()> {
        self.file.sync_all().map_err(|e| unwritable(&self.path, e))
    }
}
