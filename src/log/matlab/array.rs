//! The arrays of a version 5 `.mat` file: those that a log is made of, every size checked before it is trusted.

use super::element::{Budget, COMPRESSED, ElementReader, MAX_BYTES, ReadResult, words};
use flate2::read::ZlibDecoder;
use std::collections::BTreeMap;
use std::fmt;
use std::io::Read;

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
    /// Something else, by what it is.
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

/// What a file holds.
#[derive(Debug, Default)]
pub(super) struct Variables {
    /// The variables that were asked for.
    pub wanted: BTreeMap<String, Array>,
    /// The names of all.
    pub names: Vec<String>,
}

const HEADER_BYTES: usize = 128;
/// So much of a packed variable tells what it is.
const NAME_BYTES: u64 = 4096;
/// What an array takes besides its numbers, bytes.
const ARRAY: u64 = 64;
/// Cells in cells, structs in structs.
const MAX_DEPTH: usize = 8;

const INT8: u32 = 1;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const MATRIX: u32 = 14;
/// Reads every variable; one that can't be read is told by what it is. The error doesn't name the file.
pub(super) fn read_all(bytes: &[u8]) -> ReadResult<Vec<(String, Array)>> {
    let mut all = Vec::new();
    let mut budget = Budget(MAX_BYTES);
    budget.take(bytes.len() as u64)?;
    walk(bytes, |name, kind, body| {
        // What a variable that is too large or damaged has taken is given back with it.
        let mut left = Budget(budget.0);
        let array = match variable(kind, body, &mut left) {
            Ok(array) => {
                budget.0 = left.0;
                array
            }
            Err(_) => Array::Other("damaged or too large"),
        };
        all.push((name, array));
        Ok(())
    })?;
    Ok(all)
}

/// Reads the variables of these names; the error doesn't name the file.
pub(super) fn read(bytes: &[u8], wanted: &[&str]) -> ReadResult<Variables> {
    let mut found = Variables::default();
    let mut budget = Budget(MAX_BYTES);
    budget.take(bytes.len() as u64)?;
    walk(bytes, |name, kind, body| {
        if wanted.contains(&name.as_str()) {
            let array = variable(kind, body, &mut budget).map_err(|what| format!("{name}: {what}"))?;
            found.wanted.insert(name.clone(), array);
        }
        found.names.push(name);
        Ok(())
    })?;
    Ok(found)
}

/// Shows each variable: its name, its element's type and bytes.
fn walk(bytes: &[u8], mut each: impl FnMut(String, u32, &[u8]) -> ReadResult<()>) -> ReadResult<()> {
    match bytes.get(124..HEADER_BYTES) {
        None => return Err(format!("ends after {} bytes of its header of {HEADER_BYTES}", bytes.len())),
        Some([_, _, b'M', b'I']) => {
            return Err("was written on a machine of the other byte order: load it in MATLAB and save it anew".into());
        }
        Some(_) => {}
    }
    let mut rest = ElementReader { all: bytes, at: HEADER_BYTES };
    while !rest.ended() {
        let at = rest.at;
        let inside = |what: String| format!("byte {at}: {what}");
        let (kind, body) = rest.element().map_err(inside)?;
        let name = match kind {
            COMPRESSED => packed_name(body),
            MATRIX => ArrayHeader::of(&mut ElementReader { all: body, at: 0 }).map(|head| head.name),
            _ => continue,
        };
        // What is wrong with another variable is none of ours.
        let Ok(name) = name else { continue };
        each(name, kind, body)?;
    }
    Ok(())
}

/// A variable's array, packed or not.
fn variable(kind: u32, body: &[u8], budget: &mut Budget) -> ReadResult<Array> {
    if kind != COMPRESSED {
        return array(body, budget);
    }
    let unpacked = unpack(body, budget)?;
    let (_, body) = ElementReader { all: &unpacked, at: 0 }.element()?;
    array(body, budget)
}

/// The name of a packed variable.
fn packed_name(packed: &[u8]) -> ReadResult<String> {
    let mut first = Vec::new();
    // A stream that is longer, or damaged later on, has told enough by then.
    let _ = ZlibDecoder::new(packed).take(NAME_BYTES).read_to_end(&mut first);
    let mut bytes = ElementReader { all: &first, at: 0 };
    if bytes.word()? != MATRIX {
        return Err("no array".into());
    }
    bytes.word()?;
    Ok(ArrayHeader::of(&mut bytes)?.name)
}

fn unpack(packed: &[u8], budget: &mut Budget) -> ReadResult<Vec<u8>> {
    let mut unpacked = Vec::new();
    let read = ZlibDecoder::new(packed).take(budget.0 + 1).read_to_end(&mut unpacked);
    read.map_err(|e| format!("is packed, and damaged: {e}"))?;
    budget.take(unpacked.len() as u64)?;
    Ok(unpacked)
}

fn array(body: &[u8], budget: &mut Budget) -> ReadResult<Array> {
    let mut body = ElementReader { all: body, at: 0 };
    ArrayHeader::of(&mut body)?.array(&mut body, 0, budget)
}

/// What an array says of itself before its values.
struct ArrayHeader {
    class: u32,
    complex: bool,
    sizes: Vec<u32>,
    name: String,
}

impl ArrayHeader {
    fn of(body: &mut ElementReader) -> ReadResult<ArrayHeader> {
        let flags = words(body.expect(UINT32, "flags")?);
        let flags = *flags.first().ok_or("an array without flags")?;
        let sizes = words(body.expect(INT32, "dimensions")?);
        let name = String::from_utf8_lossy(body.expect(INT8, "name")?).into_owned();
        Ok(ArrayHeader { class: flags & 255, complex: flags & 1 << 11 != 0, sizes, name })
    }

    /// How many elements it has.
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
            budget.take(ARRAY)?;
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
