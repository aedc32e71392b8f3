//! Unpacks gzip: one member after the other, as `gzip -dc` does. What follows the last one and is none is passed over and counted:
//! zeros, with which tapes and some loggers fill a block, or other bytes.

use super::snapshot::GZIP_MAGIC;
use super::snapshot_reader::SnapshotReader;
use flate2::bufread::GzDecoder;
use std::io::{self, BufRead, Read};
use std::sync::{Arc, OnceLock};

/// What follows the gzip data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TrailingData {
    /// So many zeros.
    Zeros(u64),
    /// So many bytes that are no gzip.
    Other(u64),
}

/// The unpacked bytes of a gzip file.
pub(super) struct GzipReader {
    /// None after the end.
    member: Option<GzDecoder<SnapshotReader>>,
    trailing: Arc<OnceLock<TrailingData>>,
}

impl GzipReader {
    /// From the start of `packed`; `trailing` hears of what follows the last member, if anything does.
    pub fn new(packed: SnapshotReader, trailing: Arc<OnceLock<TrailingData>>) -> GzipReader {
        GzipReader { member: Some(GzDecoder::new(packed)), trailing }
    }

    /// The member after this one, if there is one.
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

/// Takes the zeros that come next, and says how many.
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
