//! The elements of a version 5 `.mat` file; every size is checked before it is used.

/// A value, or a text that says why it can't be read.
pub(super) type ReadResult<T> = Result<T, String>;

/// The largest memory that a file may take, bytes: packed, unpacked, and as numbers.
pub(super) const MAX_BYTES: u64 = 1 << 29;
/// Data type of a packed element.
pub(super) const COMPRESSED: u32 = 15;

/// The memory that may still be used, bytes.
pub(super) struct Budget(pub u64);

impl Budget {
    pub fn take(&mut self, bytes: u64) -> ReadResult<()> {
        self.0 = self.0.checked_sub(bytes).ok_or("is more than 512 MiB to read: save fewer scans in a file")?;
        Ok(())
    }
}

/// Reads elements from bytes.
pub(super) struct ElementReader<'a> {
    /// All bytes.
    pub all: &'a [u8],
    /// The number of bytes read.
    pub at: usize,
}

impl<'a> ElementReader<'a> {
    pub fn ended(&self) -> bool {
        self.at >= self.all.len()
    }

    pub fn take(&mut self, count: usize) -> ReadResult<&'a [u8]> {
        let part = self.at.checked_add(count).and_then(|end| self.all.get(self.at..end));
        let left = self.all.len() - self.at.min(self.all.len());
        let part =
            part.ok_or_else(|| format!("the file is cut off or damaged: {count} bytes are wanted, {left} are left"))?;
        self.at += count;
        Ok(part)
    }

    pub fn word(&mut self) -> ReadResult<u32> {
        Ok(u32::from_le_bytes(self.take(4)?.try_into().unwrap_or_default()))
    }

    /// A data element: its type and its bytes.
    pub fn element(&mut self) -> ReadResult<(u32, &'a [u8])> {
        let first = self.word()?;
        // Up to four bytes lie in the tag itself.
        if first >> 16 != 0 {
            let part = self.take(4)?;
            let size = (first >> 16) as usize;
            let part = part.get(..size).ok_or_else(|| format!("a small element of {size} bytes"))?;
            return Ok((first & 0xffff, part));
        }
        let size = self.word()? as usize;
        let part = self.take(size)?;
        if first != COMPRESSED {
            self.at = (self.at + size.next_multiple_of(8) - size).min(self.all.len());
        }
        Ok((first, part))
    }

    /// A data element of this type.
    pub fn expect(&mut self, kind: u32, what: &str) -> ReadResult<&'a [u8]> {
        match self.element()? {
            (found, part) if found == kind => Ok(part),
            (found, _) => Err(format!("its {what} has data type {found}, not {kind}: the file is damaged")),
        }
    }
}

/// The 32-bit words of an element.
pub(super) fn words(part: &[u8]) -> Vec<u32> {
    part.chunks_exact(4).map(|b| u32::from_le_bytes(b.try_into().unwrap_or_default())).collect()
}
