//! Where a log's bytes come from: a file, plain or gzip, or a stream (standard input, a pipe) that is spooled to a
//! temporary file, so that every log can be read twice and hashed. The spool has no name and vanishes with the process.

use super::gzip::{GzipReader, TrailingData};
use super::lines::{LineReader, unreadable};
use super::snapshot::FileSnapshot;
use super::snapshot_reader::SnapshotReader;
use crate::{Error, Result};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// How messages and reports call standard input.
pub(crate) const STDIN: &str = "<stdin>";
/// How much of a log is looked at to tell its format, bytes.
const HEAD_BYTES: u64 = 64 << 10;

/// One file of a log.
#[derive(Debug, Clone)]
pub(crate) struct Input {
    path: PathBuf,
    bytes: Arc<FileSnapshot>,
    /// What follows the gzip data, once it was read to its end.
    trailing: Arc<OnceLock<TrailingData>>,
}

impl Input {
    /// A file that is there and not empty, at the length that it has now; a pipe is spooled into `folder`.
    pub fn open(path: &Path, folder: Option<&Path>) -> Result<Input> {
        let unreadable = |e: io::Error| unreadable(path, None, &e);
        let file = File::open(path).map_err(unreadable)?;
        if !file.metadata().map_err(unreadable)?.is_file() {
            return Input::spool(path, file, folder);
        }
        Input::of(path, FileSnapshot::new(file, Some(path.into())).map_err(unreadable)?)
    }

    /// A stream, copied to a nameless temporary file in `folder` (the system's, if `None`).
    pub fn spool(path: &Path, mut stream: impl Read, folder: Option<&Path>) -> Result<Input> {
        let system = std::env::temp_dir();
        let folder = folder.unwrap_or(&system);
        let full = |e: io::Error| {
            Error::Resources(format!(
                "{}: can't be copied to a temporary file in {}: {e}",
                path.display(),
                folder.display()
            ))
        };
        let mut file = tempfile::tempfile_in(folder).map_err(full)?;
        io::copy(&mut stream, &mut file).map_err(full)?;
        Input::of(path, FileSnapshot::new(file, None).map_err(full)?)
    }

    fn of(path: &Path, bytes: FileSnapshot) -> Result<Input> {
        if bytes.is_empty() {
            return Err(Error::input(path, "is empty"));
        }
        Ok(Input { path: path.into(), bytes: Arc::new(bytes), trailing: Arc::default() })
    }

    /// Its path, for messages.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What a user should know of it, in whole sentences; complete after the first pass to its end.
    pub fn notes(&self) -> Vec<String> {
        let trailing = self.trailing.get().map(|trailing| match trailing {
            TrailingData::Zeros(n) => format!("zeros after its gzip data are passed over ({n} B)"),
            TrailingData::Other(n) => {
                format!("what follows its gzip data ({n} B) is no gzip and is passed over: if it belongs to the log, fetch it again")
            }
        });
        self.bytes.notes().into_iter().map(String::from).chain(trailing).collect()
    }

    /// Whether another program has appended to it since it was opened.
    pub fn grown(&self) -> bool {
        self.bytes.grown()
    }

    /// Its bytes from the start, unpacked if they are gzip.
    pub fn reader(&self) -> Result<Box<dyn BufRead + Send>> {
        let packed = self.bytes.packed().map_err(|e| unreadable(&self.path, None, &e))?;
        let pass = SnapshotReader::new(self.bytes.clone());
        Ok(match packed {
            true => Box::new(BufReader::with_capacity(256 << 10, GzipReader::new(pass, self.trailing.clone()))),
            false => Box::new(pass),
        })
    }

    /// Its lines from the start.
    pub fn lines(&self) -> Result<LineReader> {
        Ok(LineReader::new(self.reader()?, &self.path))
    }

    /// Its first bytes, unpacked.
    pub fn head(&self) -> Result<Vec<u8>> {
        let mut head = Vec::new();
        match self.reader()?.take(HEAD_BYTES).read_to_end(&mut head) {
            // What there is before the damage may tell the format; the damage is reported when it is reached.
            Err(error) if head.is_empty() => Err(unreadable(&self.path, None, &error)),
            _ if head.is_empty() => Err(Error::input(&self.path, "is empty once unpacked")),
            _ => Ok(head),
        }
    }

    /// Adds its bytes, as they are stored, to a checksum.
    pub fn hash(&self, sum: &mut Sha256) -> Result<()> {
        let mut pass = SnapshotReader::new(self.bytes.clone());
        loop {
            let block = pass.fill_buf().map_err(|e| unreadable(&self.path, None, &e))?;
            if block.is_empty() {
                return Ok(());
            }
            sum.update(block);
            let taken = block.len();
            pass.consume(taken);
        }
    }
}
