//! The stored bytes of one file, read again and again while another program may still write it. Its length is fixed when it is
//! opened, and every block must have the checksum that it had when it was first read: all passes read the same.

use crate::support::positioned;
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
    /// Where it lies; `None`: a copy that nobody else knows.
    path: Option<PathBuf>,
    /// How many there were.
    length: u64,
    /// Where its last whole line ends; of what is no text, its length.
    lines: u64,
    /// Whether what follows the last whole line is read, decided when a pass first comes to it.
    tail: OnceLock<bool>,
    /// Checksums of the blocks that were read, by their places.
    sums: Mutex<HashMap<u64, u32>>,
    notes: Mutex<Vec<&'static str>>,
}

/// What a user should know of a file that others change.
pub(super) const NOTE_GROWN: &str =
    "another program is writing it: it is read as it was when it was opened, and its checksum is that of this part";
pub(super) const NOTE_PARTIAL_LINE: &str = "its last line was half written when it was opened, and is left out";
pub(super) const NOTE_MAYBE_PARTIAL_LINE: &str =
    "its last line may have been half written when it was opened: map it again once nothing writes it";
pub(super) const NOTE_REPLACED: &str =
    "it was replaced or removed while it was read: it is read as it was when it was opened";

/// The file was changed after it was opened.
#[derive(Debug, thiserror::Error)]
pub(super) enum FileChanged {
    /// It has become shorter.
    #[error("became shorter while it was read")]
    Shorter,
    /// A part of it has become another.
    #[error("was changed while it was read, after byte {0}")]
    Rewritten(u64),
}

impl FileSnapshot {
    /// Of a file as long as it is now; `path`: where others may write it.
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

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Whether they are gzip.
    pub fn packed(&self) -> io::Result<bool> {
        let mut magic = [0; 2];
        Ok(positioned::read(&self.file, &mut magic, 0)? == 2 && magic == GZIP_MAGIC)
    }

    /// Whether the file is longer by now.
    pub fn grown(&self) -> bool {
        let grown = self.file.metadata().is_ok_and(|now| now.len() > self.length);
        if grown {
            self.note(NOTE_GROWN);
        }
        grown
    }

    /// What a user should know, as far as it has been read.
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

    /// Where the block that begins at `start` ends: there, too, if all has been read.
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

    /// Whether the line at the end goes on behind it by now.
    fn goes_on(&self) -> io::Result<bool> {
        let mut next = [0];
        Ok(positioned::read(&self.file, &mut next, self.length)? == 1 && next != *b"\n" && next != *b"\r")
    }

    /// Reads a block, and holds it against what it was before.
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
    positioned::read_exact(file, buffer, at).map_err(|e| match e.kind() {
        io::ErrorKind::UnexpectedEof => io::Error::other(FileChanged::Shorter),
        _ => e,
    })
}

/// Whether two are one file.
#[cfg(unix)]
fn same(a: &Metadata, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

#[cfg(not(unix))]
fn same(_: &Metadata, _: &Metadata) -> bool {
    true
}
