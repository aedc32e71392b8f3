//! Reads two files with matching rows: rows match by position, and by time stamp where one file lacks a row.

use crate::log::input::Input;
use crate::log::lines::LineReader;
use crate::log::problem::Problem;
use crate::log::values::parse_number;
use crate::{Error, Result};

/// One row: its time stamp and, unless it is bad, its values.
pub(super) struct Row {
    pub line: u64,
    pub t: f64,
    pub values: std::result::Result<Vec<f64>, String>,
}

/// Reads the rows of one file, with one row of lookahead.
pub(super) struct RowReader {
    input: Input,
    lines: LineReader,
    pub name: String,
    columns: usize,
    now: Option<Row>,
    next: Option<Row>,
    begun: bool,
    fatal: Option<Error>,
}

impl RowReader {
    /// The rows of `input`: a time stamp and `columns` columns.
    pub fn new(input: &Input, columns: usize) -> Result<RowReader> {
        let name = input.path().file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(RowReader {
            input: input.clone(),
            lines: input.lines()?,
            name,
            columns,
            now: None,
            next: None,
            begun: false,
            fatal: None,
        })
    }

    /// Takes the current row.
    fn take(&mut self) -> Option<Row> {
        let row = self.now.take();
        self.now = self.next.take();
        self.next = self.read();
        row
    }

    /// Reads the first two rows.
    fn begin(&mut self) {
        if !self.begun {
            self.begun = true;
            self.now = self.read();
            self.next = self.read();
        }
    }

    /// The error that ended the file early, once all rows before it were taken.
    pub fn fatal(&mut self) -> Option<Error> {
        self.begin();
        if self.now.is_none() { self.fatal.take() } else { None }
    }

    fn read(&mut self) -> Option<Row> {
        loop {
            let line = self.lines.next()?;
            let bad = |line, what| Some(Row { line, t: f64::NAN, values: Err(what) });
            match line {
                Ok(text) if text.trim().is_empty() => {}
                Ok(text) => {
                    let (t, values) = parse(text, self.columns);
                    return Some(Row { line: self.lines.number(), t, values });
                }
                Err(Problem::Line(line)) => return bad(line.line, line.what),
                Err(Problem::Fatal(error)) => {
                    self.fatal = Some(error);
                    return None;
                }
            }
        }
    }
}

fn parse(text: &str, columns: usize) -> (f64, std::result::Result<Vec<f64>, String>) {
    let mut values = Vec::with_capacity(columns);
    let mut found = 0;
    let mut wrong = None;
    let mut t = f64::NAN;
    for field in text.split_ascii_whitespace() {
        found += 1;
        match parse_number(found, field) {
            Ok(value) if found == 1 => t = value,
            Ok(value) => values.push(value),
            Err(what) => wrong = wrong.or(Some(what)),
        }
    }
    let values = match wrong {
        _ if found != columns + 1 => Err(format!("expected {} fields, found {found}", columns + 1)),
        Some(what) => Err(what),
        None if !t.is_finite() => Err(format!("the time stamp is {t}")),
        None => Ok(values),
    };
    (t, values)
}

/// The next row or pair of rows of two files.
pub(super) enum RowMatch {
    /// Both files have ended.
    End,
    /// A row without a match: its line, and the reason.
    Unmatched(u64, String),
    /// The two rows of a scan.
    Pair(Row, Row),
}

/// Matches the next rows of two files. Where time stamps differ, the row after is compared too, so a missing row is one bad line.
pub(super) fn next_match(readings: &mut RowReader, poses: &mut RowReader) -> RowMatch {
    readings.begin();
    poses.begin();
    let t = |row: &Option<Row>| row.as_ref().map_or(f64::NAN, |r| r.t);
    let (reading, pose) = (t(&readings.now), t(&poses.now));
    let (next_reading, next_pose) = (t(&readings.next), t(&poses.next));
    let drop_reading = match (&readings.now, &poses.now) {
        (None, None) => return RowMatch::End,
        // Of two files that are being written, one was opened with more rows.
        (None, _) | (_, None) if readings.input.grown() || poses.input.grown() => return RowMatch::End,
        (Some(_), None) => true,
        (None, Some(_)) => false,
        _ if next_reading == pose && reading != pose => true,
        _ if next_pose == reading && reading != pose => false,
        _ if reading != pose && next_reading != next_pose && !reading.is_nan() && !pose.is_nan() => reading < pose,
        _ => {
            let (Some(reading), Some(pose)) = (readings.take(), poses.take()) else { return RowMatch::End };
            if reading.t == pose.t || reading.values.is_err() || pose.values.is_err() {
                return RowMatch::Pair(reading, pose);
            }
            let what = format!(
                "time stamps differ: {} ms in {}, {} ms in line {} of {}",
                reading.t, readings.name, pose.t, pose.line, poses.name
            );
            return RowMatch::Unmatched(reading.line, what);
        }
    };
    let (rows, other) = if drop_reading { (readings, &poses.name) } else { (poses, &readings.name) };
    let Some(row) = rows.take() else { return RowMatch::End };
    let what = match row.values {
        Err(what) => what,
        Ok(_) => format!("{other} has no row of this time stamp ({} ms)", row.t),
    };
    RowMatch::Unmatched(row.line, format!("{}: {what}", rows.name))
}
