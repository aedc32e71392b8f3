//! Rows of a table: the separator of their cells, and the form of their numbers.

use super::columns::{ColumnRole, Columns};
use crate::log::cells::split_cells;
use crate::log::reading::Pose;
use crate::log::values::{parse_real, quote};
use std::borrow::Cow;

/// The separator of a table's cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Separator {
    /// A character, with or without blanks around it.
    Character(u8),
    /// White space.
    Whitespace,
}

impl Separator {
    /// The separator of a line.
    pub fn of(line: &str) -> Separator {
        let two_numbers = |cell: &str| {
            let mut parts = cell.split_ascii_whitespace();
            parts.clone().count() > 1 && parts.all(|part| parse_real(part).is_some())
        };
        match line {
            _ if line.contains(';') => Separator::Character(b';'),
            _ if line.trim().contains('\t') => Separator::Character(b'\t'),
            // Blanks between numbers with decimal commas.
            _ if line.contains(',') && !line.split(',').any(two_numbers) => Separator::Character(b','),
            _ => Separator::Whitespace,
        }
    }

    /// The cells of a line.
    pub fn split<'a>(self, line: &'a str) -> Vec<Cow<'a, str>> {
        let Separator::Character(separator) = self else { return line.split_whitespace().map(Cow::Borrowed).collect() };
        split_cells(line, separator)
    }

    /// A cell's number; with a decimal comma, if commas do not separate cells.
    pub fn number(self, cell: &str) -> Option<f64> {
        parse_real(cell).or_else(|| match self {
            Separator::Character(b',') if !cell.contains(',') => None,
            _ if cell.matches(',').count() == 1 && !cell.contains('.') => cell.replace(',', ".").parse().ok(),
            _ => None,
        })
    }

    /// Whether a row has numbers with a decimal comma.
    pub fn has_commas(self, line: &str) -> bool {
        self.split(line).iter().any(|cell| cell.contains(',') && self.number(cell).is_some())
    }

    /// Whether a line holds names: a cell that should be a number is not one.
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
    ///
    /// # Errors
    /// A text with the column's name and the cell.
    pub fn value(self, cell: &str, scale: f64, name: &str) -> Result<f64, String> {
        self.number(cell).map(|v| v * scale).ok_or_else(|| format!("{name} is {}, not a number", quote(cell)))
    }

    /// The time, seconds, and the pose of a row of poses.
    ///
    /// # Errors
    /// A text with the column's name and the cell.
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
