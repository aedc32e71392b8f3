//! The arrays of a version 5 `.mat` file that a log can consist of; every size is checked before it is used.

use super::element::{Budget, ElementReader, ReadResult, words};
use std::fmt;

/// An array.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Array {
    /// Numbers, column by column.
    Numbers {
        /// Rows.
        rows: usize,
        /// The values.
        values: Vec<f64>,
    },
    /// A cell array, column by column.
    Cells(Vec<Array>),
    /// A struct: its fields; of an array of structs, each field as a cell of the elements' values.
    Struct(Vec<(String, Array)>),
    /// Anything else, by its description.
    Other(&'static str),
}

impl fmt::Display for Array {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Array::Numbers { rows, values } => write!(f, "{rows} × {} numbers", values.len() / (*rows).max(1)),
            Array::Cells(cells) => write!(f, "a cell of {}", cells.len()),
            Array::Struct(fields) => write!(f, "a struct of {} fields", fields.len()),
            Array::Other(what) => write!(f, "{what}"),
        }
    }
}

/// Memory of an array besides its numbers, bytes.
const ARRAY_BYTES: u64 = 64;
/// The deepest nesting of cells and structs.
const MAX_DEPTH: usize = 8;

const INT8: u32 = 1;
const INT32: u32 = 5;
const UINT32: u32 = 6;
pub(super) const MATRIX: u32 = 14;
/// Reads an array.
///
/// # Errors
/// A text about the damage, or that the file is too large.
pub(super) fn array(body: &[u8], budget: &mut Budget) -> ReadResult<Array> {
    let mut body = ElementReader { all: body, at: 0 };
    ArrayHeader::of(&mut body)?.array(&mut body, 0, budget)
}

/// The elements of an array before its values.
pub(super) struct ArrayHeader {
    class: u32,
    complex: bool,
    sizes: Vec<u32>,
    pub name: String,
}

impl ArrayHeader {
    /// Reads the header.
    pub fn of(body: &mut ElementReader) -> ReadResult<ArrayHeader> {
        let flags = words(body.expect(UINT32, "flags")?);
        let flags = *flags.first().ok_or("an array without flags")?;
        let sizes = words(body.expect(INT32, "dimensions")?);
        let name = String::from_utf8_lossy(body.expect(INT8, "name")?).into_owned();
        Ok(ArrayHeader { class: flags & 255, complex: flags & 1 << 11 != 0, sizes, name })
    }

    /// The number of elements.
    fn count(&self) -> ReadResult<usize> {
        let product = self.sizes.iter().try_fold(1usize, |n, s| n.checked_mul(*s as usize));
        product.ok_or_else(|| format!("dimensions {:?} are too large", self.sizes))
    }

    fn array(&self, body: &mut ElementReader, depth: usize, budget: &mut Budget) -> ReadResult<Array> {
        if depth > MAX_DEPTH {
            return Err("cells and structs are nested too deep".into());
        }
        let count = self.count()?;
        let inner = |body: &mut ElementReader, budget: &mut Budget| -> ReadResult<Array> {
            budget.take(ARRAY_BYTES)?;
            let part = body.expect(MATRIX, "element")?;
            if part.is_empty() {
                return Ok(Array::Numbers { rows: 0, values: Vec::new() });
            }
            let mut part = ElementReader { all: part, at: 0 };
            ArrayHeader::of(&mut part)?.array(&mut part, depth + 1, budget)
        };
        match self.class {
            1 => (0..count).map(|_| inner(body, budget)).collect::<ReadResult<_>>().map(Array::Cells),
            2 => {
                let length = words(body.expect(INT32, "field name length")?);
                let length = length.first().map_or(0, |l| *l as usize);
                let names = body.expect(INT8, "field names")?;
                if length == 0 {
                    return Ok(Array::Struct(Vec::new()));
                }
                let name = |part: &[u8]| {
                    String::from_utf8_lossy(part.split(|b| *b == 0).next().unwrap_or_default()).into_owned()
                };
                let mut fields: Vec<(String, Vec<Array>)> =
                    names.chunks_exact(length).map(|part| (name(part), Vec::new())).collect();
                if fields.is_empty() {
                    return Ok(Array::Struct(Vec::new()));
                }
                for _ in 0..count {
                    for (_, values) in &mut fields {
                        values.push(inner(body, budget)?);
                    }
                }
                let whole = |mut values: Vec<Array>| match (count, values.pop()) {
                    (1, Some(value)) => value,
                    (_, last) => {
                        values.extend(last);
                        Array::Cells(values)
                    }
                };
                Ok(Array::Struct(fields.into_iter().map(|(name, values)| (name, whole(values))).collect()))
            }
            6..=15 if self.complex => Ok(Array::Other("an array of complex numbers")),
            6..=15 => {
                let (kind, part) = body.element()?;
                let values = numbers(kind, part, budget)?;
                match values.len() {
                    found if found == count => {
                        Ok(Array::Numbers { rows: self.sizes.first().map_or(0, |r| *r as usize), values })
                    }
                    found => Err(format!("{found} numbers in an array of {count}: the file is damaged")),
                }
            }
            4 => Ok(Array::Other("text")),
            5 => Ok(Array::Other("a sparse array")),
            _ => Ok(Array::Other("an object")),
        }
    }
}

/// Numbers of any type as f64: MATLAB stores them in the smallest that holds them.
fn numbers(kind: u32, part: &[u8], budget: &mut Budget) -> ReadResult<Vec<f64>> {
    macro_rules! all {
        ($t:ty) => {{
            budget.take((part.len() / size_of::<$t>() * size_of::<f64>()) as u64)?;
            part.chunks_exact(size_of::<$t>())
                .map(|b| <$t>::from_le_bytes(b.try_into().unwrap_or_default()) as f64)
                .collect()
        }};
    }
    Ok(match kind {
        1 => all!(i8),
        2 => all!(u8),
        3 => all!(i16),
        4 => all!(u16),
        5 => all!(i32),
        6 => all!(u32),
        7 => all!(f32),
        9 => all!(f64),
        12 => all!(i64),
        13 => all!(u64),
        other => return Err(format!("numbers of data type {other}: the file is damaged")),
    })
}
