//! Reads the lines of a text log in constant memory. A line ends with LF or CRLF; a byte-order mark before the first line is
//! dropped. A line that is too long or not UTF-8 is a bad line, and reading continues with the next one.

use super::problem::{BadLine, Problem};
use super::snapshot::{FileChanged, MAX_LINE_BYTES};
use crate::Error;
use std::io::{self, BufRead, Read};
use std::path::{Path, PathBuf};

/// The lines of one input.
pub(crate) struct LineReader {
    reader: Box<dyn BufRead + Send>,
    path: PathBuf,
    buffer: Vec<u8>,
    number: u64,
    ended: bool,
    /// Whether the file ends within the last line.
    unterminated: bool,
}

impl LineReader {
    /// Lines of `reader`; `path` is for messages.
    pub fn new(reader: Box<dyn BufRead + Send>, path: &Path) -> Self {
        LineReader { reader, path: path.into(), buffer: Vec::new(), number: 0, ended: false, unterminated: false }
    }

    /// The number of the line that [`LineReader::next`] gave last, from 1.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// Whether the file ends within the line that [`LineReader::next`] gave last.
    pub fn is_unterminated(&self) -> bool {
        self.unterminated
    }

    /// The next line, without its end; `None` after the last.
    pub fn next(&mut self) -> Option<Result<&str, Problem>> {
        if self.ended {
            return None;
        }
        self.buffer.clear();
        self.number += 1;
        let mut limited = (&mut self.reader).take(MAX_LINE_BYTES as u64 + 1);
        match limited.read_until(b'\n', &mut self.buffer) {
            Ok(0) => {
                self.ended = true;
                return None;
            }
            Ok(_) => self.unterminated = !self.buffer.ends_with(b"\n"),
            Err(error) => return Some(Err(self.fatal(error))),
        }
        if self.buffer.len() > MAX_LINE_BYTES && !self.buffer.ends_with(b"\n") {
            if let Err(error) = self.reader.skip_until(b'\n') {
                return Some(Err(self.fatal(error)));
            }
            return Some(Err(self.bad("longer than 1 MiB".into())));
        }
        let bytes = self.buffer.strip_suffix(b"\n").unwrap_or(&self.buffer);
        let bytes = bytes.strip_suffix(b"\r").unwrap_or(bytes);
        let bytes = if self.number == 1 { bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes) } else { bytes };
        match std::str::from_utf8(bytes) {
            Ok(line) => Some(Ok(line)),
            Err(error) => {
                let at = error.valid_up_to();
                let byte = bytes.get(at).copied().unwrap_or_default();
                Some(Err(self.bad(format!("not UTF-8 text: byte {} is 0x{byte:02x}", at + 1))))
            }
        }
    }

    fn bad(&self, what: String) -> Problem {
        Problem::Line(BadLine { line: self.number, what })
    }

    fn fatal(&mut self, error: io::Error) -> Problem {
        self.ended = true;
        Problem::Fatal(unreadable(&self.path, Some(self.number), error))
    }
}

/// The error about a log that can't be read on, with what to do about it.
pub(crate) fn unreadable(path: &Path, line: Option<u64>, error: io::Error) -> Error {
    if let Some(changed) = error.get_ref().and_then(|inner| inner.downcast_ref::<FileChanged>()) {
        let what = format!("{changed}: map it again when nothing writes it, or map a copy");
        return Error::caused(path, what, error);
    }
    let what = match error.kind() {
        io::ErrorKind::UnexpectedEof => {
            "the compressed log is truncated here: fetch it again, or save its whole lines \
             with `gzip -dc FILE > part.log` and map those"
                .into()
        }
        io::ErrorKind::InvalidInput | io::ErrorKind::InvalidData => {
            format!("the compressed log is damaged here ({error}): fetch it again")
        }
        io::ErrorKind::NotFound => "no such file or folder".into(),
        _ => format!("can't be read: {error}"),
    };
    Error::Input { path: path.into(), line, what, cause: Some(Box::new(error.into())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(bytes: &'static [u8]) -> Vec<(u64, Result<String, String>)> {
        let mut lines = LineReader::new(Box::new(bytes), Path::new("a.log"));
        let mut all = Vec::new();
        while let Some(line) = lines.next() {
            let line = line.map(str::to_string).map_err(|p| p.to_string());
            all.push((lines.number(), line));
        }
        all
    }

    #[test]
    fn ends_marks_and_text() {
        let all = lines(b"\xef\xbb\xbfone\r\n\ntwo \xff\nthree");
        assert_eq!(all[0], (1, Ok("one".into())));
        assert_eq!(all[1], (2, Ok(String::new())));
        assert_eq!(all[2], (3, Err("line 3: not UTF-8 text: byte 5 is 0xff".into())));
        assert_eq!(all[3], (4, Ok("three".into())));
        assert_eq!(all.len(), 4);
    }

    #[test]
    fn ten_megabytes_in_one_line() {
        let long = Read::chain(io::repeat(b'x').take(10 << 20), &b"\nafter\n"[..]);
        let mut lines = LineReader::new(Box::new(io::BufReader::new(long)), Path::new("a.log"));
        assert_eq!(lines.next().unwrap().unwrap_err().to_string(), "line 1: longer than 1 MiB");
        assert!(lines.buffer.capacity() < 4 << 20);
        assert_eq!(lines.next().unwrap().unwrap(), "after");
        assert!(lines.next().is_none());
    }
}
