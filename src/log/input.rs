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

/// The name of standard input in messages and reports.
pub(crate) const STDIN: &str = "<stdin>";
/// Bytes of a log by which its format is recognised.
const HEAD_BYTES: u64 = 64 << 10;

/// One file of a log.
#[derive(Debug, Clone)]
pub(crate) struct Input {
    path: PathBuf,
    bytes: Arc<FileSnapshot>,
    /// The bytes after the gzip data, once the file was read to its end.
    trailing: Arc<OnceLock<TrailingData>>,
}

impl Input {
    /// Opens a file at its present length; a pipe is spooled into `folder`.
    ///
    /// # Errors
    /// [`Error::Input`] if the file is missing or empty; [`Error::Resources`] if a pipe can't be spooled.
    pub fn open(path: &Path, folder: Option<&Path>) -> Result<Input> {
        let unreadable = |e: io::Error| unreadable(path, None, e);
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

    /// Notes for the user, as sentences; complete after the first whole pass.
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
        let packed = self.bytes.packed().map_err(|e| unreadable(&self.path, None, e))?;
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
            // The bytes before the damage may show the format; the damage is reported when a pass reaches it.
            Err(error) if head.is_empty() => Err(unreadable(&self.path, None, error)),
            _ if head.is_empty() => Err(Error::input(&self.path, "is empty once unpacked")),
            _ => Ok(head),
        }
    }

    /// Adds its bytes, as they are stored, to a checksum.
    pub fn hash(&self, sum: &mut Sha256) -> Result<()> {
        let mut pass = SnapshotReader::new(self.bytes.clone());
        loop {
            let block = pass.fill_buf().map_err(|e| unreadable(&self.path, None, e))?;
            if block.is_empty() {
                return Ok(());
            }
            sum.update(block);
            let taken = block.len();
            pass.consume(taken);
        }
    }
}
