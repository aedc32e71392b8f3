//! Rows of a table: how their cells are separated, and what numbers look like in them.

use super::columns::{ColumnRole, Columns};
use crate::log::reading::Pose;
use crate::log::values::{parse_real, quote};
use std::borrow::Cow;

/// What stands between cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Separator {
    /// A character, with blanks around it or not.
    Character(char),
    /// White space.
    Whitespace,
}

impl Separator {
    /// As one of its lines shows.
    pub fn of(line: &str) -> Separator {
        let two_numbers = |cell: &str| {
            let mut parts = cell.split_ascii_whitespace();
            parts.clone().count() > 1 && parts.all(|part| parse_real(part).is_some())
        };
        match line {
            _ if line.contains(';') => Separator::Character(';'),
            _ if line.trim().contains('\t') => Separator::Character('\t'),
            // Blanks between numbers with decimal commas.
            _ if line.contains(',') && !line.split(',').any(two_numbers) => Separator::Character(','),
            _ => Separator::Whitespace,
        }
    }

    /// The cells of a line.
    pub fn split<'a>(self, line: &'a str) -> Vec<Cow<'a, str>> {
        let Separator::Character(separator) = self else { return line.split_whitespace().map(Cow::Borrowed).collect() };
        if line.contains('"') {
            let mut reader = ::csv::ReaderBuilder::new();
            let reader = reader.has_headers(false).delimiter(separator as u8);
            if let Some(Ok(row)) = reader.from_reader(line.as_bytes()).records().next() {
                return row.iter().map(|cell| Cow::Owned(cell.trim().to_string())).collect();
            }
        }
        line.split(separator).map(|cell| Cow::Borrowed(cell.trim())).collect()
    }

    /// Whether numbers may have a comma before their decimals.
    pub fn number(self, cell: &str) -> Option<f64> {
        parse_real(cell).or_else(|| match self {
            Separator::Character(',') if !cell.contains(',') => None,
            _ if cell.matches(',').count() == 1 && !cell.contains('.') => cell.replace(',', ".").parse().ok(),
            _ => None,
        })
    }

    /// Whether a row has numbers with a decimal comma.
    pub fn has_commas(self, line: &str) -> bool {
        self.split(line).iter().any(|cell| cell.contains(',') && self.number(cell).is_some())
    }

    /// Whether a line is one of names: a cell that should be a number is none.
    pub fn is_header(self, line: &str, columns: &Columns) -> bool {
        let cells = self.split(line);
        let words = |cell: &str| !cell.is_empty() && cell != "null" && self.number(cell).is_none();
        match columns.of(cells.len()) {
            Ok(columns) => cells
                .iter()
                .zip(&columns)
                .any(|(cell, column)| !matches!(column.role, ColumnRole::Skip | ColumnRole::Sensor) && words(cell)),
            Err(_) => cells.iter().any(|cell| words(cell)),
        }
    }

    /// A cell's number in metres, radians or seconds.
    pub fn value(self, cell: &str, scale: f64, name: &str) -> Result<f64, String> {
        self.number(cell).map(|v| v * scale).ok_or_else(|| format!("{name} is {}, not a number", quote(cell)))
    }

    /// The time and the pose of a row of poses.
    pub fn pose(self, line: &str, columns: &Columns) -> Result<(f64, Pose), String> {
        let cells = self.split(line);
        let columns = columns.of(cells.len())?;
        let find = |role, name: &str| {
            let at = columns.iter().position(|column| column.role == role).ok_or("no pose")?;
            self.value(cells.get(at).map_or("", |cell| cell), columns[at].scale, name)
        };
        let t = find(ColumnRole::T, "t")?;
        let pose = Pose {
            x: find(ColumnRole::Px, "x")?,
            y: find(ColumnRole::Py, "y")?,
            heading: find(ColumnRole::Ph, "heading")?,
        };
        if t.is_finite() { Ok((t, pose)) } else { Err(format!("t is {t}")) }
    }
}
