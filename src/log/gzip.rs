//! Unpacks gzip, member by member, as `gzip -dc` does. Bytes after the last member are skipped and counted: zeros, with which tapes
//! and some loggers fill a block, or other bytes.

use super::snapshot::GZIP_MAGIC;
use super::snapshot_reader::SnapshotReader;
use flate2::bufread::GzDecoder;
use std::io::{self, BufRead, Read};
use std::sync::{Arc, OnceLock};

/// The bytes after the gzip data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TrailingData {
    /// This number of zeros.
    Zeros(u64),
    /// This number of bytes, not gzip and not all zero.
    Other(u64),
}

/// The unpacked bytes of a gzip file.
pub(super) struct GzipReader {
    /// `None` after the end.
    member: Option<GzDecoder<SnapshotReader>>,
    trailing: Arc<OnceLock<TrailingData>>,
}

impl GzipReader {
    /// From the start of `packed`; `trailing` is set if bytes follow the last member.
    pub fn new(packed: SnapshotReader, trailing: Arc<OnceLock<TrailingData>>) -> GzipReader {
        GzipReader { member: Some(GzDecoder::new(packed)), trailing }
    }

    /// The next member, if there is one.
    fn next(&self, mut packed: SnapshotReader) -> io::Result<Option<GzDecoder<SnapshotReader>>> {
        let zeros = skip_zeros(&mut packed)?;
        if packed.begins(&GZIP_MAGIC)? {
            return Ok(Some(GzDecoder::new(packed)));
        }
        let trailing = match packed.left() {
            0 if zeros == 0 => return Ok(None),
            0 => TrailingData::Zeros(zeros),
            left => TrailingData::Other(zeros + left),
        };
        self.trailing.get_or_init(|| trailing);
        Ok(None)
    }
}

impl Read for GzipReader {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        while let Some(member) = &mut self.member {
            let read = member.read(into)?;
            if read > 0 || into.is_empty() {
                return Ok(read);
            }
            let packed = self.member.take().map(GzDecoder::into_inner);
            self.member = packed.map(|packed| self.next(packed)).transpose()?.flatten();
        }
        Ok(0)
    }
}

/// Skips zeros and returns their number.
fn skip_zeros(packed: &mut SnapshotReader) -> io::Result<u64> {
    let mut all = 0;
    loop {
        let next = packed.fill_buf()?;
        let zeros = next.iter().take_while(|byte| **byte == 0).count();
        let on = zeros > 0 && zeros == next.len();
        packed.consume(zeros);
        all += zeros as u64;
        if !on {
            return Ok(all);
        }
    }
}
