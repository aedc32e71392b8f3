//! Where a log's bytes come from: a file, plain or gzip, or a stream (standard input, a pipe) that is spooled to a
//! temporary file, so that every log can be read twice and hashed. The spool has no name and vanishes with the process.

use super::lines::{Lines, unreadable};
use crate::{Error, Result};
use flate2::bufread::MultiGzDecoder;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How messages and reports call standard input.
pub(crate) const STDIN: &str = "<stdin>";
/// How much of a log is looked at to tell its format, bytes.
const HEAD: u64 = 64 << 10;

/// One file of a log.
#[derive(Debug, Clone)]
pub(crate) struct Input {
    path: PathBuf,
    spool: Option<Arc<File>>,
}

impl Input {
    /// A file that is there and not empty; a pipe is spooled into `folder`.
    pub fn open(path: &Path, folder: Option<&Path>) -> Result<Input> {
        let about = std::fs::metadata(path).map_err(|e| unreadable(path, None, &e))?;
        if !about.is_file() {
            let file = File::open(path).map_err(|e| unreadable(path, None, &e))?;
            return Input::spool(path, file, folder);
        }
        if about.len() == 0 {
            return Err(Error::input(path, "is empty"));
        }
        Ok(Input { path: path.into(), spool: None })
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
        if io::copy(&mut stream, &mut file).map_err(full)? == 0 {
            return Err(Error::input(path, "is empty"));
        }
        Ok(Input { path: path.into(), spool: Some(Arc::new(file)) })
    }

    /// Its path, for messages.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn raw(&self) -> Result<Box<dyn Read + Send>> {
        match &self.spool {
            Some(file) => Ok(Box::new(Spool { file: file.clone(), at: 0 })),
            None => Ok(Box::new(File::open(&self.path).map_err(|e| unreadable(&self.path, None, &e))?)),
        }
    }

    /// Its bytes from the start, unpacked if they are gzip.
    pub fn reader(&self) -> Result<Box<dyn BufRead + Send>> {
        let mut raw = BufReader::with_capacity(256 << 10, self.raw()?);
        let packed = raw.fill_buf().map_err(|e| unreadable(&self.path, None, &e))?.starts_with(b"\x1f\x8b");
        Ok(if packed { Box::new(BufReader::with_capacity(256 << 10, MultiGzDecoder::new(raw))) } else { Box::new(raw) })
    }

    /// Its lines from the start.
    pub fn lines(&self) -> Result<Lines> {
        Ok(Lines::new(self.reader()?, &self.path))
    }

    /// Its first bytes, unpacked.
    pub fn head(&self) -> Result<Vec<u8>> {
        let mut head = Vec::new();
        match self.reader()?.take(HEAD).read_to_end(&mut head) {
            // What there is before the damage may tell the format; the damage is reported when it is reached.
            Err(error) if head.is_empty() => Err(unreadable(&self.path, None, &error)),
            _ if head.is_empty() => Err(Error::input(&self.path, "is empty once unpacked")),
            _ => Ok(head),
        }
    }

    /// Adds its bytes, as they are stored, to a checksum.
    pub fn hash(&self, sum: &mut Sha256) -> Result<()> {
        let mut raw = self.raw()?;
        let mut buffer = vec![0; 256 << 10];
        loop {
            match raw.read(&mut buffer) {
                Ok(0) => return Ok(()),
                Ok(n) => sum.update(&buffer[..n]),
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(unreadable(&self.path, None, &e)),
            }
        }
    }
}

/// A reader of a shared file with a place of its own, so that passes don't disturb each other.
struct Spool {
    file: Arc<File>,
    at: u64,
}

impl Read for Spool {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = crate::positioned::read(&self.file, buffer, self.at)?;
        self.at += n as u64;
        Ok(n)
    }
}
