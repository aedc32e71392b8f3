//! The stored bytes of one file, read again and again. Another program may still write it: its length is fixed when it is opened,
//! and every block must have the checksum that it had when it was first read, so that all passes read the same.

use super::lines::LONGEST;
use crate::positioned;
use flate2::Crc;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufRead, Read};
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Bytes of a block.
const BLOCK: u64 = 256 << 10;

/// A file's bytes as they were when it was opened.
#[derive(Debug)]
pub(super) struct Bytes {
    file: File,
    /// How many there were.
    length: u64,
    /// How many of them are read, decided where the first pass ends.
    end: OnceLock<End>,
    /// Checksums of the blocks that were read.
    sums: Mutex<BTreeMap<u64, u32>>,
    notes: Mutex<Vec<String>>,
}

/// Where reading ends.
#[derive(Debug, Clone, Copy)]
struct End {
    at: u64,
    /// Whether the file had become longer by then.
    grown: bool,
}

/// The file was changed after it was opened.
#[derive(Debug, thiserror::Error)]
pub(super) enum Changed {
    /// It has become shorter.
    #[error("it became shorter while it was read")]
    Shorter,
    /// A part of it has become another.
    #[error("it was changed while it was read: what stands after byte {0} was something else before")]
    Rewritten(u64),
}

impl Bytes {
    /// Of a file that holds `length` bytes now.
    pub fn new(file: File, length: u64) -> Bytes {
        Bytes { file, length, end: OnceLock::new(), sums: Mutex::default(), notes: Mutex::default() }
    }

    /// Whether the file had become longer when it was first read to its end.
    pub fn grown(&self) -> bool {
        self.end.get().is_some_and(|end| end.grown)
    }

    /// What a user should know of it, as far as it has been read.
    pub fn notes(&self) -> Vec<String> {
        self.notes.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Notes something; once, however often it is found.
    pub fn note(&self, what: String) {
        let mut notes = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
        if !notes.contains(&what) {
            notes.push(what);
        }
    }

    /// Where reading ends. A text that goes on growing ends with its last whole line, as the line after it may be half written.
    fn end(&self, path: &Path) -> io::Result<u64> {
        if let Some(end) = self.end.get() {
            return Ok(end.at);
        }
        let grown = self.file.metadata()?.len() > self.length;
        let at = if grown { self.last_line()? } else { self.length };
        let end = *self.end.get_or_init(|| End { at, grown });
        if end.grown {
            let half = if end.at < self.length { "; a line that was half written is left out" } else { "" };
            self.note(format!(
                "{}: another program is writing it: it was read as it was when it was opened, its first {} bytes{half}",
                path.display(),
                end.at
            ));
        }
        Ok(end.at)
    }

    /// The end of the last whole line; of what is no text, its end.
    fn last_line(&self) -> io::Result<u64> {
        let from = self.length.saturating_sub(LONGEST as u64);
        // One byte more: a line may end just there.
        let mut tail = vec![0; (self.length - from) as usize + 1];
        positioned::read_exact(&self.file, &mut tail, from)?;
        let next = tail.pop();
        let whole = next == Some(b'\n') || tail.contains(&0) || self.packed()?;
        let last = tail.iter().rposition(|byte| *byte == b'\n').map(|at| from + at as u64 + 1);
        Ok(if whole { self.length } else { last.unwrap_or(self.length) })
    }

    /// Whether they are gzip.
    pub fn packed(&self) -> io::Result<bool> {
        let mut magic = [0; 2];
        let read = positioned::read(&self.file, &mut magic, 0)?;
        Ok(read == 2 && magic == GZIP)
    }

    /// Reads a block whole, and holds it against what it was before.
    fn block(&self, number: u64, path: &Path, buffer: &mut Vec<u8>) -> io::Result<()> {
        let start = number * BLOCK;
        let last = start + BLOCK >= self.length;
        let end = if last { self.end(path)? } else { start + BLOCK };
        buffer.resize(end.saturating_sub(start) as usize, 0);
        positioned::read_exact(&self.file, buffer, start).map_err(|e| match e.kind() {
            io::ErrorKind::UnexpectedEof => io::Error::other(Changed::Shorter),
            _ => e,
        })?;
        let mut sum = Crc::new();
        sum.update(buffer);
        let mut sums = self.sums.lock().unwrap_or_else(PoisonError::into_inner);
        match *sums.entry(number).or_insert(sum.sum()) == sum.sum() {
            true => Ok(()),
            false => Err(io::Error::other(Changed::Rewritten(start))),
        }
    }
}

/// The first bytes of a gzip member.
pub(super) const GZIP: [u8; 2] = *b"\x1f\x8b";

/// A pass over the bytes.
pub(super) struct Pass {
    bytes: Arc<Bytes>,
    path: Arc<Path>,
    buffer: Vec<u8>,
    /// The next block, and how much of the buffer has been taken.
    next: u64,
    taken: usize,
}

impl Pass {
    /// From the start; `path` is for messages.
    pub fn new(bytes: Arc<Bytes>, path: Arc<Path>) -> Pass {
        Pass { bytes, path, buffer: Vec::new(), next: 0, taken: 0 }
    }

    /// The next bytes, as many as there are, without taking them.
    pub fn peek<const N: usize>(&self) -> io::Result<Vec<u8>> {
        let (at, end) = (self.at(), self.bytes.end.get().map_or(self.bytes.length, |end| end.at));
        let mut next = vec![0; (end.saturating_sub(at) as usize).min(N)];
        positioned::read_exact(&self.bytes.file, &mut next, at)?;
        Ok(next)
    }

    /// Bytes that are left.
    pub fn left(&self) -> io::Result<u64> {
        Ok(self.bytes.end(&self.path)?.saturating_sub(self.at()))
    }

    /// Notes what a user should know.
    pub fn note(&self, what: &str) {
        self.bytes.note(format!("{}: {what}", self.path.display()));
    }

    fn at(&self) -> u64 {
        (self.next * BLOCK).saturating_sub((self.buffer.len() - self.taken) as u64)
    }
}

impl BufRead for Pass {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.taken == self.buffer.len() && self.next * BLOCK < self.bytes.length {
            self.bytes.block(self.next, &self.path, &mut self.buffer)?;
            (self.next, self.taken) = (self.next + 1, 0);
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
