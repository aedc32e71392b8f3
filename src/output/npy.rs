//! One layer as a NumPy file, format version 1.0: rows from the bottom, C order, little endian.

use super::raster::{Raster, RasterLayout};
use crate::Result;
use crate::grid::{Data, GridSpec, Layer};
use std::path::Path;

/// Opens the file of a layer of the grid.
pub(super) fn open(path: &Path, grid: &GridSpec, data: &Data, resume: bool) -> Result<Raster> {
    let extent = [grid.width, grid.height];
    let layout = RasterLayout { header: header(grid, data), extent, element: size(data), top_first: false };
    Raster::open(path, layout, resume)
}

/// Bytes of a value.
pub(super) fn size(data: &Data) -> usize {
    match data {
        Data::F32(_) | Data::U32(_) => 4,
        Data::U8(_) | Data::I8(_) => 1,
    }
}

/// The bytes of values, little endian.
pub(super) fn bytes(data: &Data) -> Vec<u8> {
    match data {
        Data::F32(v) => v.iter().flat_map(|v| v.to_le_bytes()).collect(),
        Data::U32(v) => v.iter().flat_map(|v| v.to_le_bytes()).collect(),
        Data::U8(v) => v.clone(),
        Data::I8(v) => bytemuck::cast_slice(v).to_vec(),
    }
}

/// The bytes of a layer's fill value, little endian.
pub(super) fn fill(layer: &Layer) -> Vec<u8> {
    match layer.data {
        Data::F32(_) => (layer.fill as f32).to_le_bytes().into(),
        Data::U32(_) => (layer.fill as u32).to_le_bytes().into(),
        Data::U8(_) => vec![layer.fill as u8],
        Data::I8(_) => vec![layer.fill as i8 as u8],
    }
}

/// The header: magic, version and a Python dict, padded so that the values start at a multiple of 64 bytes.
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
