//! One layer as a NumPy file, format version 1.0: rows from the bottom, C order, little endian.

use super::unwritable;
use crate::Result;
use crate::grid::{Data, GridSpec};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Writes `data` as an array of shape (height, width); row 0 is the bottom row.
pub(super) fn write(path: &Path, grid: &GridSpec, data: &Data) -> Result<()> {
    save(path, grid, data).map_err(|e| unwritable(path, e))
}

fn save(path: &Path, grid: &GridSpec, data: &Data) -> std::io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    file.write_all(&header(grid, data))?;
    match data {
        Data::F32(v) => v.iter().try_for_each(|v| file.write_all(&v.to_le_bytes()))?,
        Data::U32(v) => v.iter().try_for_each(|v| file.write_all(&v.to_le_bytes()))?,
        Data::U8(v) => file.write_all(v)?,
        Data::I8(v) => file.write_all(bytemuck::cast_slice(v))?,
    }
    file.into_inner().map_err(|e| e.into_error())?.sync_all()
}

/// Magic, version and a Python dict, padded so that the values start at a multiple of 64 bytes.
fn header(grid: &GridSpec, data: &Data) -> Vec<u8> {
    let kind = match data {
        Data::F32(_) => "<f4",
        Data::U32(_) => "<u4",
        Data::U8(_) => "|u1",
        Data::I8(_) => "|i1",
    };
    let mut dict =
        format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({}, {}), }}", grid.height, grid.width);
    const BEFORE: usize = 10;
    while !(BEFORE + dict.len() + 1).is_multiple_of(64) {
        dict.push(' ');
    }
    dict.push('\n');
    let length = dict.len() as u16; // at most 128: the dict holds two numbers of at most 20 digits
    [b"\x93NUMPY\x01\x00".as_slice(), &length.to_le_bytes(), dict.as_bytes()].concat()
}
