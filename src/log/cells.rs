//! The cells of one line of delimited text.
//!
//! Lines come one by one from [`LineReader`](super::lines::LineReader), which bounds their length and counts them for messages; so
//! the csv crate parses a line, not a file.

use csv::{ReaderBuilder, Trim};
use std::borrow::Cow;

/// The cells of a line, without blanks around them. A line without quotes has a cell between any two separators, and is not copied;
/// one with quotes is parsed by the csv crate.
pub(super) fn split_cells(line: &str, separator: u8) -> Vec<Cow<'_, str>> {
    if line.contains('"') {
        let mut builder = ReaderBuilder::new();
        builder.has_headers(false).flexible(true).delimiter(separator).trim(Trim::All).buffer_capacity(line.len());
        if let Some(Ok(row)) = builder.from_reader(line.as_bytes()).records().next() {
            return row.iter().map(|cell| Cow::Owned(unquoted(cell).to_string())).collect();
        }
    }
    line.split(char::from(separator)).map(|cell| Cow::Borrowed(cell.trim())).collect()
}

/// A cell without its quotes. To the csv crate a quote after a blank, as in `1, "a"`, is a part of the cell.
fn unquoted(cell: &str) -> &str {
    cell.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')).unwrap_or(cell)
}

#[cfg(test)]
mod tests {
    use super::split_cells;

    #[test]
    fn quotes_and_blanks() {
        assert_eq!(split_cells(" 1, a b ,,2", b','), ["1", "a b", "", "2"]);
        assert_eq!(split_cells("1, \"a\", \"2\"", b','), ["1", "a", "2"]);
        assert_eq!(split_cells("1;\"a; \"\"b\"\"\";2", b';'), ["1", "a; \"b\"", "2"]);
    }
}
