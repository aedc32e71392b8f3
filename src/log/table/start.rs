//! The start of a table: how its cells are separated, what its columns hold, and where its data begin.

use super::columns::{Column, ColumnRole, Columns};
use super::separator::Separator;
use crate::log::input::Input;
use crate::log::sensor_ids::{MAX_SENSORS, expand_indices};
use crate::log::text::for_each_line;
use crate::log::values::quote;
use crate::{Error, Result};

/// The start of a table.
pub(super) struct TableStart {
    pub rows: Separator,
    pub columns: Vec<Column>,
    /// The first line of data.
    pub line: u64,
    /// Whether numbers have decimal commas.
    pub commas: bool,
}

impl TableStart {
    /// Finds the first row of data.
    pub fn of(input: &Input, columns: &Columns) -> Result<TableStart> {
        let mut found = None;
        let mut headers = 0;
        for_each_line(input, |line, number| {
            let text = line.trim();
            if text.is_empty() || comment(text) {
                return true;
            }
            let rows = Separator::of(text);
            if headers == 0 && rows.is_header(line, columns) {
                headers = 1;
                return true;
            }
            // Blanks at its end may be empty cells between tabs.
            let cells = rows.split(line).len();
            found = Some(match columns.of(cells) {
                Ok(columns) => Ok(TableStart { rows, columns, line: number, commas: rows.has_commas(text) }),
                Err(what) => Err(Error::at(input.path(), number, format!("{what}: {}", quote(text)))),
            });
            false
        })?;
        found.unwrap_or_else(|| Err(Error::input(input.path(), "has no row of numbers")))
    }
}

pub(super) fn comment(text: &str) -> bool {
    text.starts_with('#') || text.starts_with('%') || text.starts_with("//")
}

/// The ids in the column of sensors.
pub(super) fn names(input: &Input, first: &TableStart) -> Result<Vec<String>> {
    let column = first.columns.iter().position(|column| column.role == ColumnRole::Sensor);
    let mut names: Vec<String> = Vec::new();
    for_each_line(input, |line, number| {
        if number < first.line || comment(line.trim()) {
            return true;
        }
        let cells = first.rows.split(line);
        if let Some(name) = column.and_then(|i| cells.get(i)).filter(|name| !name.is_empty())
            && cells.len() == first.columns.len()
            && names.len() < MAX_SENSORS
            && !names.iter().any(|known| known == name)
        {
            names.push(name.to_string());
        }
        true
    })?;
    Ok(expand_indices(names))
}
