//! The arrays of a version 5 `.mat` file: those that a log is made of, every size checked before it is trusted.

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
    /// A struct of one element: its fields.
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

type Read_<T> = Result<T, String>;

const HEADER: usize = 128;
/// A variable may unpack to so much, bytes.
const LARGEST: u64 = 1 << 30;
/// Cells in cells, structs in structs.
const DEEPEST: usize = 8;

const INT8: u32 = 1;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// Reads the variables of these names; the error doesn't name the file.
pub(super) fn read(bytes: &[u8], wanted: &[&str]) -> Read_<Variables> {
    let mut found = Variables::default();
    match bytes.get(124..HEADER) {
        None => return Err(format!("ends after {} bytes of its header of {HEADER}", bytes.len())),
        Some([_, _, b'M', b'I']) => {
            return Err("was written on a machine of the other byte order: load it in MATLAB and save it anew".into());
        }
        Some(_) => {}
    }
    let mut rest = Bytes { all: bytes, at: HEADER };
    while !rest.ended() {
        let at = rest.at;
        let inside = |what: String| format!("byte {at}: {what}");
        let (kind, body) = rest.element().map_err(inside)?;
        let mut unpacked = Vec::new();
        let body = match kind {
            COMPRESSED => {
                let mut unpack = ZlibDecoder::new(body).take(LARGEST);
                unpack.read_to_end(&mut unpacked).map_err(|e| inside(format!("a packed variable is damaged: {e}")))?;
                if unpacked.len() as u64 == LARGEST {
                    return Err(inside("a variable of more than 1 GiB".into()));
                }
                let mut inner = Bytes { all: &unpacked, at: 0 };
                match inner.element().map_err(inside)? {
                    (MATRIX, body) => body,
                    _ => continue,
                }
            }
            MATRIX => body,
            _ => continue,
        };
        let mut body = Bytes { all: body, at: 0 };
        let head = Head::of(&mut body).map_err(inside)?;
        if wanted.contains(&head.name.as_str()) {
            let array = head.array(&mut body, 0).map_err(|what| format!("{}: {what}", head.name))?;
            found.wanted.insert(head.name.clone(), array);
        }
        found.names.push(head.name);
    }
    Ok(found)
}

/// Bytes being read.
struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    fn ended(&self) -> bool {
        self.at >= self.all.len()
    }

    fn take(&mut self, count: usize) -> Read_<&'a [u8]> {
        let part = self.at.checked_add(count).and_then(|end| self.all.get(self.at..end));
        let left = self.all.len() - self.at.min(self.all.len());
        let part =
            part.ok_or_else(|| format!("the file is cut off or damaged: {count} bytes are wanted, {left} are left"))?;
        self.at += count;
        Ok(part)
    }

    fn word(&mut self) -> Read_<u32> {
        Ok(u32::from_le_bytes(self.take(4)?.try_into().unwrap_or_default()))
    }

    /// A data element: its type and its bytes.
    fn element(&mut self) -> Read_<(u32, &'a [u8])> {
        let first = self.word()?;
        // Up to four bytes lie in the tag itself.
        if first >> 16 != 0 {
            let part = self.take(4)?;
            let size = (first >> 16) as usize;
            let part = part.get(..size).ok_or_else(|| format!("a small element of {size} bytes"))?;
            return Ok((first & 0xffff, part));
        }
        let size = self.word()? as usize;
        let part = self.take(size)?;
        if first != COMPRESSED {
            self.at = self.at.next_multiple_of(8).min(self.all.len());
        }
        Ok((first, part))
    }

    /// A data element of this type.
    fn expect(&mut self, kind: u32, what: &str) -> Read_<&'a [u8]> {
        match self.element()? {
            (found, part) if found == kind => Ok(part),
            (found, _) => Err(format!("its {what} has data type {found}, not {kind}: the file is damaged")),
        }
    }
}

fn words(part: &[u8]) -> Vec<u32> {
    part.chunks_exact(4).map(|b| u32::from_le_bytes(b.try_into().unwrap_or_default())).collect()
}

/// What an array says of itself before its values.
struct Head {
    class: u32,
    complex: bool,
    sizes: Vec<u32>,
    name: String,
}

impl Head {
    fn of(body: &mut Bytes) -> Read_<Head> {
        let flags = words(body.expect(UINT32, "flags")?);
        let flags = *flags.first().ok_or("an array without flags")?;
        let sizes = words(body.expect(INT32, "dimensions")?);
        let name = String::from_utf8_lossy(body.expect(INT8, "name")?).into_owned();
        Ok(Head { class: flags & 255, complex: flags & 1 << 11 != 0, sizes, name })
    }

    /// How many elements it has.
    fn count(&self) -> Read_<usize> {
        let product = self.sizes.iter().try_fold(1usize, |n, s| n.checked_mul(*s as usize));
        product.ok_or_else(|| format!("dimensions {:?} are too large", self.sizes))
    }

    fn array(&self, body: &mut Bytes, depth: usize) -> Read_<Array> {
        if depth > DEEPEST {
            return Err("cells and structs are nested too deep".into());
        }
        let count = self.count()?;
        let inner = |body: &mut Bytes| -> Read_<Array> {
            let part = body.expect(MATRIX, "element")?;
            if part.is_empty() {
                return Ok(Array::Numbers { rows: 0, values: Vec::new() });
            }
            let mut part = Bytes { all: part, at: 0 };
            Head::of(&mut part)?.array(&mut part, depth + 1)
        };
        match self.class {
            1 => (0..count).map(|_| inner(body)).collect::<Read_<_>>().map(Array::Cells),
            2 if count == 1 => {
                let length = words(body.expect(INT32, "field name length")?);
                let length = length.first().map_or(0, |l| *l as usize);
                let names = body.expect(INT8, "field names")?;
                if length == 0 {
                    return Ok(Array::Struct(Vec::new()));
                }
                let name = |part: &[u8]| {
                    String::from_utf8_lossy(part.split(|b| *b == 0).next().unwrap_or_default()).into_owned()
                };
                let fields = names.chunks_exact(length).map(|part| Ok((name(part), inner(body)?)));
                fields.collect::<Read_<_>>().map(Array::Struct)
            }
            2 => Ok(Array::Other("an array of structs")),
            6..=15 if self.complex => Ok(Array::Other("an array of complex numbers")),
            6..=15 => {
                let (kind, part) = body.element()?;
                let values = numbers(kind, part)?;
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
fn numbers(kind: u32, part: &[u8]) -> Read_<Vec<f64>> {
    macro_rules! all {
        ($t:ty) => {
            part.chunks_exact(size_of::<$t>())
                .map(|b| <$t>::from_le_bytes(b.try_into().unwrap_or_default()) as f64)
                .collect()
        };
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
