//! Octave's text files (`save -text`): each variable with lines `# name:` and `# type:` before its values.

use super::array::Array;
use super::element::{MAX_BYTES, ReadResult};
use crate::log::values::{parse_real, quote};

/// The deepest nesting of cells and structs.
const MAX_DEPTH: usize = 8;

/// Whether a text begins like an Octave file.
pub(super) fn is_octave_text(text: &str) -> bool {
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let name = lines.by_ref().take(4).any(|line| attribute(line).is_some_and(|(key, _)| key == "name"));
    name && lines.next().is_some_and(|line| attribute(line).is_some_and(|(key, _)| key == "type"))
}

/// `# key: value`.
fn attribute(line: &str) -> Option<(&str, &str)> {
    let (key, value) = line.trim().strip_prefix(['#', '%'])?.split_once(':')?;
    Some((key.trim(), value.trim()))
}

/// Reads all variables.
pub(super) fn read(text: &str) -> ReadResult<Vec<(String, Array)>> {
    let mut lines = OctaveReader { rest: text.lines(), number: 0, left: MAX_BYTES / 8 };
    let mut found = Vec::new();
    while let Some(line) = lines.next() {
        if let Some(("name", name)) = attribute(line) {
            let value = lines.variable(0).map_err(|what| format!("{name}, near line {}: {what}", lines.number))?;
            found.push((name.to_string(), value));
        }
    }
    Ok(found)
}

struct OctaveReader<'a> {
    rest: std::str::Lines<'a>,
    number: u64,
    /// The numbers that may still be read.
    left: u64,
}

impl<'a> OctaveReader<'a> {
    fn next(&mut self) -> Option<&'a str> {
        loop {
            self.number += 1;
            let line = self.rest.next()?;
            if !line.trim().is_empty() {
                return Some(line);
            }
        }
    }

    fn peek(&self) -> Option<&'a str> {
        self.rest.clone().find(|line| !line.trim().is_empty())
    }

    fn need(&mut self) -> ReadResult<&'a str> {
        self.next().ok_or_else(|| "the file is cut off".to_string())
    }

    /// The value of an attribute that must come next.
    fn expect(&mut self, key: &str) -> ReadResult<&'a str> {
        let line = self.need()?;
        match attribute(line) {
            Some((found, value)) if found == key => Ok(value),
            _ => Err(format!("expected # {key}:, found {}", quote(line))),
        }
    }

    fn count(&mut self, key: &str) -> ReadResult<usize> {
        let value = self.expect(key)?;
        value.parse().map_err(|_| format!("# {key}: {} is no count", quote(value)))
    }

    fn take(&mut self, numbers: usize) -> ReadResult<()> {
        self.left =
            self.left.checked_sub(numbers as u64).ok_or("is more than 512 MiB to read: save fewer scans in a file")?;
        Ok(())
    }

    /// Rows and columns, or a line of dimensions.
    fn sizes(&mut self) -> ReadResult<(usize, usize)> {
        let ndims = self.peek().and_then(attribute).is_some_and(|(key, _)| key == "ndims");
        if !ndims {
            return Ok((self.count("rows")?, self.count("columns")?));
        }
        self.count("ndims")?;
        let line = self.need()?;
        let sizes: Result<Vec<usize>, _> =
            line.trim_start_matches('#').split_ascii_whitespace().map(str::parse).collect();
        let sizes = sizes.map_err(|_| format!("{} are no dimensions", quote(line)))?;
        let columns =
            sizes.iter().skip(1).try_fold(1usize, |n, s| n.checked_mul(*s)).ok_or("its dimensions are too large")?;
        Ok((sizes.first().copied().unwrap_or(0), columns))
    }

    /// Reads `count` numbers, over any number of lines.
    fn numbers(&mut self, count: usize) -> ReadResult<Vec<f64>> {
        self.take(count)?;
        let mut values = Vec::new();
        while values.len() < count {
            let line = self.need()?;
            for field in line.split_ascii_whitespace() {
                let value = parse_real(field).or(match field {
                    "true" => Some(1.0),
                    "false" => Some(0.0),
                    _ => None,
                });
                values.push(value.ok_or_else(|| format!("{} is no number", quote(field)))?);
            }
        }
        match values.len() {
            found if found == count => Ok(values),
            found => Err(format!("{found} numbers where {count} are wanted")),
        }
    }

    /// The variable after a line `# name:`.
    fn variable(&mut self, depth: usize) -> ReadResult<Array> {
        if depth > MAX_DEPTH {
            return Err("cells and structs are nested too deep".into());
        }
        let kind = self.expect("type")?.trim_start_matches("global ");
        if kind.contains("complex") {
            return self.other("complex numbers");
        }
        match kind {
            "cell" => {
                let (rows, columns) = self.sizes()?;
                let count = rows.checked_mul(columns).ok_or("its dimensions are too large")?;
                (0..count)
                    .map(|_| self.inner(depth).map(|(_, value)| value))
                    .collect::<ReadResult<_>>()
                    .map(Array::Cells)
            }
            "scalar struct" | "struct" => {
                if self.peek().and_then(attribute).is_some_and(|(key, _)| key == "ndims") {
                    self.sizes()?;
                }
                let count = self.count("length")?;
                (0..count).map(|_| self.inner(depth)).collect::<ReadResult<_>>().map(Array::Struct)
            }
            "range" | "double_range" => {
                self.need()?;
                let v = self.numbers(3)?;
                let steps = ((v[1] - v[0]) / v[2]).floor();
                let count = if steps.is_finite() && (0.0..1e9).contains(&steps) { steps as usize + 1 } else { 0 };
                self.take(count)?;
                Ok(Array::Numbers { rows: 1, values: (0..count).map(|k| v[0] + k as f64 * v[2]).collect() })
            }
            "string" | "sq_string" => {
                let count = self.count("elements")?;
                for _ in 0..count {
                    let length = self.count("length")?;
                    if length > 0 {
                        self.rest.next();
                        self.number += 1;
                    }
                }
                Ok(Array::Other("text"))
            }
            "bool" => Ok(Array::Numbers { rows: 1, values: self.numbers(1)? }),
            scalar if scalar.ends_with("scalar") => Ok(Array::Numbers { rows: 1, values: self.numbers(1)? }),
            matrix if matrix.ends_with("matrix") && !matrix.contains("sparse") && !matrix.contains("diagonal") => {
                let by_rows = self.peek().and_then(attribute).is_some_and(|(key, _)| key == "rows");
                let (rows, columns) = self.sizes()?;
                let count = rows.checked_mul(columns).ok_or("its dimensions are too large")?;
                let values = self.numbers(count)?;
                let values = match by_rows {
                    // Written row by row, kept column by column.
                    true => (0..count).map(|i| values[(i % rows) * columns + i / rows]).collect(),
                    false => values,
                };
                Ok(Array::Numbers { rows, values })
            }
            _ => self.other("an object"),
        }
    }

    /// A named part of a cell or struct.
    fn inner(&mut self, depth: usize) -> ReadResult<(String, Array)> {
        self.take(8)?;
        let name = self.expect("name")?.to_string();
        Ok((name, self.variable(depth + 1)?))
    }

    /// Skips a variable of a type that is not read.
    fn other(&mut self, what: &'static str) -> ReadResult<Array> {
        while self.peek().is_some_and(|line| attribute(line).is_none_or(|(key, _)| key != "name")) {
            self.next();
        }
        Ok(Array::Other(what))
    }
}
