//! The values of all scans of a log, from a matrix or a cell array.

use super::array::Array;
use super::element::ReadResult;

/// The values of all scans, as they are stored.
pub(super) enum ScanValues {
    /// A matrix with a scan in each row.
    Rows(usize, Vec<f64>),
    /// A matrix with a scan in each column.
    Columns(usize, Vec<f64>),
    /// A cell for each scan.
    Cells(Vec<Array>),
}

impl ScanValues {
    /// From an array, for `scans` scans.
    pub fn of(array: Array, scans: usize, by_columns: bool, key: &str) -> ReadResult<ScanValues> {
        match array {
            Array::Cells(cells) if cells.len() == scans => Ok(ScanValues::Cells(cells)),
            Array::Numbers { rows, values } => {
                let columns = values.len() / rows.max(1);
                match (rows == scans, columns == scans) {
                    (true, true) if by_columns => Ok(ScanValues::Columns(rows, values)),
                    (true, _) => Ok(ScanValues::Rows(rows, values)),
                    (false, true) => Ok(ScanValues::Columns(rows, values)),
                    (false, false) => Err(format!(
                        "{key} has {rows} × {columns} numbers for {scans} poses: one of the two must be as many"
                    )),
                }
            }
            other => Err(format!("{key} is {other} for {scans} poses: as many are wanted")),
        }
    }

    /// The values of scan `i`.
    ///
    /// # Errors
    /// A text that says what the cell holds instead.
    pub fn scan(&self, i: usize) -> ReadResult<Vec<f64>> {
        match self {
            ScanValues::Rows(rows, values) => Ok(values.iter().skip(i).step_by((*rows).max(1)).copied().collect()),
            ScanValues::Columns(rows, values) => Ok(values.get(i * rows..(i + 1) * rows).unwrap_or_default().to_vec()),
            ScanValues::Cells(cells) => match cells.get(i) {
                Some(Array::Numbers { values, .. }) => Ok(values.clone()),
                Some(other) => Err(format!("it is {other}, not numbers")),
                None => Ok(Vec::new()),
            },
        }
    }
}
