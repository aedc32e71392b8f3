//! One pass over a file's snapshot, from its start.

use super::snapshot::FileSnapshot;
use std::io::{self, BufRead, Read};
use std::sync::Arc;

/// A pass over the bytes.
pub(super) struct SnapshotReader {
    bytes: Arc<FileSnapshot>,
    buffer: Vec<u8>,
    /// Offset of the buffer in the file, and the bytes of it that were consumed.
    start: u64,
    taken: usize,
}

impl SnapshotReader {
    /// From the start.
    pub fn new(bytes: Arc<FileSnapshot>) -> SnapshotReader {
        SnapshotReader { bytes, buffer: Vec::new(), start: 0, taken: 0 }
    }

    /// Whether the next bytes are `with`.
    pub fn begins<const N: usize>(&self, with: &[u8; N]) -> io::Result<bool> {
        let mut next = [0; N];
        let whole = self.left() >= N as u64;
        if whole {
            self.bytes.read_exactly(&mut next, self.at())?;
        }
        Ok(whole && next == *with)
    }

    /// The number of bytes left.
    pub fn left(&self) -> u64 {
        self.bytes.len() - self.at()
    }

    fn at(&self) -> u64 {
        self.start + self.taken as u64
    }
}

impl BufRead for SnapshotReader {
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

impl Read for SnapshotReader {
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
    use crate::log::snapshot::*;
    use std::io::Write;

    fn opened(text: &[u8]) -> (tempfile::NamedTempFile, Arc<FileSnapshot>) {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(text).unwrap();
        let bytes = FileSnapshot::new(file.reopen().unwrap(), Some(file.path().into())).unwrap();
        (file, Arc::new(bytes))
    }

    fn read(bytes: &Arc<FileSnapshot>) -> Result<Vec<u8>, String> {
        let mut all = Vec::new();
        SnapshotReader::new(bytes.clone()).read_to_end(&mut all).map_err(|e| e.to_string())?;
        Ok(all)
    }

    #[test]
    fn what_is_appended_is_not_read() {
        let (mut file, bytes) = opened(b"one\ntwo\n");
        assert_eq!((read(&bytes).unwrap(), bytes.notes()), (b"one\ntwo\n".to_vec(), vec![]));
        file.write_all(b"three\n").unwrap();
        assert_eq!((read(&bytes).unwrap(), bytes.notes()), (b"one\ntwo\n".to_vec(), vec![NOTE_GROWN]));
    }

    #[test]
    fn a_half_written_line_is_left_out_of_every_pass() {
        let (mut file, bytes) = opened(b"one\ntwo");
        file.write_all(b"-and-more\n").unwrap();
        for _ in 0..2 {
            assert_eq!(
                (read(&bytes).unwrap(), bytes.notes()),
                (b"one\n".to_vec(), vec![NOTE_GROWN, NOTE_PARTIAL_LINE])
            );
        }
        // What was whole stays: nothing follows it, or a line's end.
        let (mut file, bytes) = opened(b"one\ntwo");
        assert_eq!((read(&bytes).unwrap(), bytes.notes()), (b"one\ntwo".to_vec(), vec![]));
        file.write_all(b"-and-more\n").unwrap();
        assert_eq!(
            (read(&bytes).unwrap(), bytes.notes()),
            (b"one\ntwo".to_vec(), vec![NOTE_GROWN, NOTE_MAYBE_PARTIAL_LINE])
        );
        let (mut file, bytes) = opened(b"one\ntwo");
        file.write_all(b"\nthree\n").unwrap();
        assert_eq!((read(&bytes).unwrap(), bytes.notes()), (b"one\ntwo".to_vec(), vec![NOTE_GROWN]));
    }

    #[test]
    fn what_is_no_text_is_read_to_its_end() {
        for start in [&b"MATLAB\n\0\0"[..], b"\x1f\x8b\n--"] {
            let (mut file, bytes) = opened(start);
            file.write_all(b"more").unwrap();
            assert_eq!((read(&bytes).unwrap(), bytes.notes()), (start.to_vec(), vec![NOTE_GROWN]));
        }
    }

    #[test]
    fn what_is_rewritten_or_cut_off_is_an_error() {
        let mut text = b"0123456789abcde\n".repeat(BLOCK_BYTES as usize / 8);
        let (file, bytes) = opened(&text);
        assert_eq!(read(&bytes).unwrap(), text);
        text[BLOCK_BYTES as usize + 5] = b'X';
        std::fs::write(file.path(), &text).unwrap();
        assert_eq!(read(&bytes).unwrap_err(), format!("was changed while it was read, after byte {BLOCK_BYTES}"));
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
        assert_eq!((read(&bytes).unwrap(), bytes.notes()), (b"one\n".to_vec(), vec![NOTE_REPLACED]));
    }
}
