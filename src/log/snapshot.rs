//! The bytes of one file as they were when it was opened, while another program may still write it. The length is fixed when the
//! file is opened, and every block must keep the checksum of its first read, so all passes read the same bytes.

use crate::support::positional_io;
use flate2::Crc;
use std::collections::HashMap;
use std::fs::{File, Metadata};
use std::io;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

/// The longest line of a log, bytes (the longest real ones, of 361 beams, have 4 KB).
pub(super) const MAX_LINE_BYTES: usize = 1 << 20;
/// Bytes of a block.
pub(super) const BLOCK_BYTES: u64 = 256 << 10;
/// The first bytes of a gzip member.
pub(super) const GZIP_MAGIC: [u8; 2] = *b"\x1f\x8b";

/// A file's bytes as they were when it was opened.
#[derive(Debug)]
pub(super) struct FileSnapshot {
    file: File,
    /// Its path; `None`: a private copy.
    path: Option<PathBuf>,
    /// Bytes of the file when it was opened.
    length: u64,
    /// End of the last whole line, bytes; the length, if the file is not text.
    lines: u64,
    /// Whether the bytes after the last whole line are read; decided when a pass first reaches them.
    tail: OnceLock<bool>,
    /// Checksums of the blocks that were read, by their offsets.
    sums: Mutex<HashMap<u64, u32>>,
    notes: Mutex<Vec<&'static str>>,
}

pub(super) const NOTE_GROWN: &str =
    "another program is writing it: it is read as it was when it was opened, and its checksum is that of this part";
pub(super) const NOTE_PARTIAL_LINE: &str = "its last line was half written when it was opened, and is left out";
pub(super) const NOTE_MAYBE_PARTIAL_LINE: &str =
    "its last line may have been half written when it was opened: map it again once nothing writes it";
pub(super) const NOTE_REPLACED: &str =
    "it was replaced or removed while it was read: it is read as it was when it was opened";

/// A change of the file after it was opened.
#[derive(Debug, thiserror::Error)]
pub(super) enum FileChanged {
    /// The file has become shorter.
    #[error("became shorter while it was read")]
    Shorter,
    /// The block at this offset has changed.
    #[error("was changed while it was read, after byte {0}")]
    Rewritten(u64),
}

impl FileSnapshot {
    /// Takes the file's present length; `path`: where other programs may write it.
    pub fn new(file: File, path: Option<PathBuf>) -> io::Result<FileSnapshot> {
        let length = file.metadata()?.len();
        let from = length.saturating_sub(MAX_LINE_BYTES as u64);
        let mut end = vec![0; (length - from) as usize];
        exactly(&file, &mut end, from)?;
        let is_text = !end.contains(&0);
        let line = end.iter().rposition(|byte| *byte == b'\n').filter(|_| is_text);
        let lines = line.map_or(length, |at| from + at as u64 + 1);
        let mut bytes = FileSnapshot {
            file,
            path,
            length,
            lines,
            tail: OnceLock::new(),
            sums: Mutex::default(),
            notes: Mutex::default(),
        };
        if bytes.packed()? {
            bytes.lines = length;
        }
        Ok(bytes)
    }

    /// Whether the file is empty.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Whether the bytes are gzip.
    pub fn packed(&self) -> io::Result<bool> {
        let mut magic = [0; 2];
        Ok(positional_io::read(&self.file, &mut magic, 0)? == 2 && magic == GZIP_MAGIC)
    }

    /// Whether the file is longer by now.
    pub fn grown(&self) -> bool {
        let grown = self.file.metadata().is_ok_and(|now| now.len() > self.length);
        if grown {
            self.note(NOTE_GROWN);
        }
        grown
    }

    /// Notes for the user, complete after the first pass.
    pub fn notes(&self) -> Vec<&'static str> {
        self.noted().clone()
    }

    fn note(&self, what: &'static str) {
        let mut notes = self.noted();
        if !notes.contains(&what) {
            notes.push(what);
        }
    }

    fn noted(&self) -> MutexGuard<'_, Vec<&'static str>> {
        self.notes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Fills a buffer from byte `at` on.
    pub fn read_exactly(&self, buffer: &mut [u8], at: u64) -> io::Result<()> {
        exactly(&self.file, buffer, at)
    }

    /// How many bytes there were when it was opened.
    pub fn len(&self) -> u64 {
        self.length
    }

    /// The end of the block that begins at `start`; equals `start` at the end of the snapshot.
    pub fn block_end(&self, start: u64) -> io::Result<u64> {
        if start < self.lines {
            return Ok((start + BLOCK_BYTES).min(self.lines));
        }
        let now = self.file.metadata()?;
        let unfinished = self.grown() && self.lines < self.length && self.goes_on()?;
        let read = *self.tail.get_or_init(|| !unfinished);
        if unfinished {
            self.note(if read { NOTE_MAYBE_PARTIAL_LINE } else { NOTE_PARTIAL_LINE });
        }
        if self.path.as_ref().is_some_and(|path| std::fs::metadata(path).map_or(true, |there| !same(&there, &now))) {
            self.note(NOTE_REPLACED);
        }
        Ok(if read { self.length } else { self.lines })
    }

    /// Whether the file's last line has become longer.
    fn goes_on(&self) -> io::Result<bool> {
        let mut next = [0];
        Ok(positional_io::read(&self.file, &mut next, self.length)? == 1 && next != *b"\n" && next != *b"\r")
    }

    /// Reads a block and compares its checksum with that of the first read.
    pub fn read(&self, start: u64, end: u64, buffer: &mut Vec<u8>) -> io::Result<()> {
        buffer.resize((end - start) as usize, 0);
        exactly(&self.file, buffer, start)?;
        let mut sum = Crc::new();
        sum.update(buffer);
        let mut sums = self.sums.lock().unwrap_or_else(PoisonError::into_inner);
        match *sums.entry(start).or_insert(sum.sum()) == sum.sum() {
            true => Ok(()),
            false => Err(io::Error::other(FileChanged::Rewritten(start))),
        }
    }
}

/// Fills a buffer from a file that was long enough for it.
fn exactly(file: &File, buffer: &mut [u8], at: u64) -> io::Result<()> {
    positional_io::read_exact(file, buffer, at).map_err(|e| match e.kind() {
        io::ErrorKind::UnexpectedEof => io::Error::other(FileChanged::Shorter),
        _ => e,
    })
}

/// Whether both are the same file.
#[cfg(unix)]
fn same(a: &Metadata, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

#[cfg(not(unix))]
fn same(_: &Metadata, _: &Metadata) -> bool {
    true
}
