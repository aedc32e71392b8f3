//! The variables of a version 5 `.mat` file: found by name, unpacked, and read as arrays.

use super::array::{Array, ArrayHeader, MATRIX, array};
use super::element::{Budget, COMPRESSED, ElementReader, MAX_BYTES, ReadResult};
use flate2::read::ZlibDecoder;
use std::collections::BTreeMap;
use std::io::Read;

/// The variables of a file.
#[derive(Debug, Default)]
pub(super) struct Variables {
    /// The requested variables.
    pub wanted: BTreeMap<String, Array>,
    /// The names of all variables.
    pub names: Vec<String>,
}

const HEADER_BYTES: usize = 128;
/// Unpacked bytes of a variable that hold its name.
const NAME_BYTES: u64 = 4096;
/// Reads every variable; a damaged one becomes [`Array::Other`].
///
/// # Errors
/// A text that doesn't name the file.
pub(super) fn read_all(bytes: &[u8]) -> ReadResult<Vec<(String, Array)>> {
    let mut all = Vec::new();
    let mut budget = Budget(MAX_BYTES);
    budget.take(bytes.len() as u64)?;
    walk(bytes, |name, kind, body| {
        // A damaged or too large variable takes nothing from the budget.
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

/// Reads the variables of these names.
///
/// # Errors
/// A text that doesn't name the file.
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

/// Calls `each` with every variable's name, its element's type and bytes.
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
        // Damage of other variables does not matter.
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
    // The name is at the start; an error after it does not matter.
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
