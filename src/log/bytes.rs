//! The stored bytes of one file, read again and again while another program may still write it. Its length is fixed when it is
//! opened, and every block must have the checksum that it had when it was first read: all passes read the same.

use super::lines::LONGEST;
use crate::support::positioned;
use flate2::Crc;
use std::collections::HashMap;
use std::fs::{File, Metadata};
use std::io::{self, BufRead, Read};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

/// Bytes of a block.
const BLOCK: u64 = 256 << 10;
/// The first bytes of a gzip member.
pub(super) const GZIP: [u8; 2] = *b"\x1f\x8b";

/// A file's bytes as they were when it was opened.
#[derive(Debug)]
pub(super) struct Bytes {
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
const GROWN: &str =
    "another program is writing it: it is read as it was when it was opened, and its checksum is that of this part";
const CUT: &str = "its last line was half written when it was opened, and is left out";
const MAYBE_CUT: &str =
    "its last line may have been half written when it was opened: map it again once nothing writes it";
const REPLACED: &str = "it was replaced or removed while it was read: it is read as it was when it was opened";

/// The file was changed after it was opened.
#[derive(Debug, thiserror::Error)]
pub(super) enum Changed {
    /// It has become shorter.
    #[error("became shorter while it was read")]
    Shorter,
    /// A part of it has become another.
    #[error("was changed while it was read, after byte {0}")]
    Rewritten(u64),
}

impl Bytes {
    /// Of a file as long as it is now; `path`: where others may write it.
    pub fn new(file: File, path: Option<PathBuf>) -> io::Result<Bytes> {
        let length = file.metadata()?.len();
        let from = length.saturating_sub(LONGEST as u64);
        let mut end = vec![0; (length - from) as usize];
        exactly(&file, &mut end, from)?;
        let is_text = !end.contains(&0);
        let line = end.iter().rposition(|byte| *byte == b'\n').filter(|_| is_text);
        let lines = line.map_or(length, |at| from + at as u64 + 1);
        let mut bytes =
            Bytes { file, path, length, lines, tail: OnceLock::new(), sums: Mutex::default(), notes: Mutex::default() };
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
        Ok(positioned::read(&self.file, &mut magic, 0)? == 2 && magic == GZIP)
    }

    /// Whether the file is longer by now.
    pub fn grown(&self) -> bool {
        let grown = self.file.metadata().is_ok_and(|now| now.len() > self.length);
        if grown {
            self.note(GROWN);
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

    /// Where the block that begins at `start` ends: there, too, if all has been read.
    fn block_end(&self, start: u64) -> io::Result<u64> {
        if start < self.lines {
            return Ok((start + BLOCK).min(self.lines));
        }
        let now = self.file.metadata()?;
        let unfinished = self.grown() && self.lines < self.length && self.goes_on()?;
        let read = *self.tail.get_or_init(|| !unfinished);
        if unfinished {
            self.note(if read { MAYBE_CUT } else { CUT });
        }
        if self.path.as_ref().is_some_and(|path| std::fs::metadata(path).map_or(true, |there| !same(&there, &now))) {
            self.note(REPLACED);
        }
        Ok(if read { self.length } else { self.lines })
    }

    /// Whether the line at the end goes on behind it by now.
    fn goes_on(&self) -> io::Result<bool> {
        let mut next = [0];
        Ok(positioned::read(&self.file, &mut next, self.length)? == 1 && next != *b"\n" && next != *b"\r")
    }

    /// Reads a block, and holds it against what it was before.
    fn read(&self, start: u64, end: u64, buffer: &mut Vec<u8>) -> io::Result<()> {
        buffer.resize((end - start) as usize, 0);
        exactly(&self.file, buffer, start)?;
        let mut sum = Crc::new();
        sum.update(buffer);
        let mut sums = self.sums.lock().unwrap_or_else(PoisonError::into_inner);
        match *sums.entry(start).or_insert(sum.sum()) == sum.sum() {
            true => Ok(()),
            false => Err(io::Error::other(Changed::Rewritten(start))),
        }
    }
}

/// Fills a buffer from a file that was long enough for it.
fn exactly(file: &File, buffer: &mut [u8], at: u64) -> io::Result<()> {
    positioned::read_exact(file, buffer, at).map_err(|e| match e.kind() {
        io::ErrorKind::UnexpectedEof => io::Error::other(Changed::Shorter),
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

/// A pass over the bytes.
pub(super) struct Pass {
    bytes: Arc<Bytes>,
    buffer: Vec<u8>,
    /// Where the buffer stands in the file, and how much of it has been taken.
    start: u64,
    taken: usize,
}

impl Pass {
    /// From the start.
    pub fn new(bytes: Arc<Bytes>) -> Pass {
        Pass { bytes, buffer: Vec::new(), start: 0, taken: 0 }
    }

    /// Whether the bytes that come next are these.
    pub fn begins<const N: usize>(&self, with: &[u8; N]) -> io::Result<bool> {
        let mut next = [0; N];
        let whole = self.left() >= N as u64;
        if whole {
            exactly(&self.bytes.file, &mut next, self.at())?;
        }
        Ok(whole && next == *with)
    }

    /// Bytes that are left.
    pub fn left(&self) -> u64 {
        self.bytes.length - self.at()
    }

    fn at(&self) -> u64 {
        self.start + self.taken as u64
    }
}

impl BufRead for Pass {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.taken == self.buffer.len() {
            let start = self.at();
            let end = self.bytes.block_end(start)?;
            self.bytes.read(start, end, &mut self.buffer)?;
            (self.start, self.taken) = (start, 0);
        }
        Ok(&self.buffer[self.taken..])
    }

    fn consume(&mut self, amount: usize) {
        self.taken = (self.taken + amount).min(self.buffer.len());
    }
}

impl Read for Pass {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let there = self.fill_buf()?;
        let amount = there.len().min(into.len());
        into[..amount].copy_from_slice(&there[..amount]);
        self.consume(amount);
        Ok(amount)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn opened(text: &[u8]) -> (tempfile::NamedTempFile, Arc<Bytes>) {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(text).unwrap();
        let bytes = Bytes::new(file.reopen().unwrap(), Some(file.path().into())).unwrap();
        (file, Arc::new(bytes))
    }

    fn read(bytes: &Arc<Bytes>) -> Result<Vec<u8>, String> {
        let mut all = Vec::new();
        Pass::new(bytes.clone()).read_to_end(&mut all).map_err(|e| e.to_string())?;
        Ok(all)
    }

    #[test]
    fn what_is_appended_is_not_read() {
        let (mut file, bytes) = opened(b"one\ntwo\n");
        assert_eq!((read(&bytes).unwrap(), bytes.notes()), (b"one\ntwo\n".to_vec(), vec![]));
        file.write_all(b"three\n").unwrap();
        assert_eq!((read(&bytes).unwrap(), bytes.notes()), (b"one\ntwo\n".to_vec(), vec![GROWN]));
    }

    #[test]
    fn a_half_written_line_is_left_out_of_every_pass() {
        let (mut file, bytes) = opened(b"one\ntwo");
        file.write_all(b"-and-more\n").unwrap();
        for _ in 0..2 {
            assert_eq!((read(&bytes).unwrap(), bytes.notes()), (b"one\n".to_vec(), vec![GROWN, CUT]));
        }
        // What was whole stays: nothing follows it, or a line's end.
        let (mut file, bytes) = opened(b"one\ntwo");
        assert_eq!((read(&bytes).unwrap(), bytes.notes()), (b"one\ntwo".to_vec(), vec![]));
        file.write_all(b"-and-more\n").unwrap();
        assert_eq!((read(&bytes).unwrap(), bytes.notes()), (b"one\ntwo".to_vec(), vec![GROWN, MAYBE_CUT]));
        let (mut file, bytes) = opened(b"one\ntwo");
        file.write_all(b"\nthree\n").unwrap();
        assert_eq!((read(&bytes).unwrap(), bytes.notes()), (b"one\ntwo".to_vec(), vec![GROWN]));
    }

    #[test]
    fn what_is_no_text_is_read_to_its_end() {
        for start in [&b"MATLAB\n\0\0"[..], b"\x1f\x8b\n--"] {
            let (mut file, bytes) = opened(start);
            file.write_all(b"more").unwrap();
            assert_eq!((read(&bytes).unwrap(), bytes.notes()), (start.to_vec(), vec![GROWN]));
        }
    }

    #[test]
    fn what_is_rewritten_or_cut_off_is_an_error() {
        let mut text = b"0123456789abcde\n".repeat(BLOCK as usize / 8);
        let (file, bytes) = opened(&text);
        assert_eq!(read(&bytes).unwrap(), text);
        text[BLOCK as usize + 5] = b'X';
        std::fs::write(file.path(), &text).unwrap();
        assert_eq!(read(&bytes).unwrap_err(), format!("was changed while it was read, after byte {BLOCK}"));
        std::fs::write(file.path(), &text[..text.len() - 1]).unwrap();
        assert!(read(&bytes).is_err());
        let (file, bytes) = opened(b"one\ntwo\n");
        std::fs::write(file.path(), "one\n").unwrap();
        assert_eq!(read(&bytes).unwrap_err(), "became shorter while it was read");
    }

    #[cfg(unix)]
    #[test]
    fn what_takes_its_place_is_not_read() {
        let (file, bytes) = opened(b"one\n");
        let other = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(other.path(), "something else\n").unwrap();
        std::fs::rename(other.path(), file.path()).unwrap();
        assert_eq!((read(&bytes).unwrap(), bytes.notes()), (b"one\n".to_vec(), vec![REPLACED]));
    }
}
