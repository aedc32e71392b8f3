//! Statistics of a part of a map, which add up to those of the whole map. They are kept in the progress file of a run, so that a resumed
//! run need not read the parts again.

use crate::grid::{Data, Layer, Map};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Statistics of a chunk of a map. The names of the fields are those of the progress file.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::output) struct ChunkStatistics {
    /// Cells touched, occupied, empty, unknown.
    pub(super) cells: [u64; 4],
    /// Cell updates.
    pub(super) updates: u64,
    /// Sums of what the cells' α gained.
    pub(super) increments: Vec<F64Bits>,
    /// Sum, least and largest value of each layer.
    pub(super) layers: Vec<[F64Bits; 3]>,
}

/// An f64 that JSON keeps to the bit, infinities included.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct F64Bits(u64);

impl F64Bits {
    fn of(value: f64) -> F64Bits {
        F64Bits(value.to_bits())
    }

    /// The number.
    pub fn value(self) -> f64 {
        f64::from_bits(self.0)
    }
}

impl ChunkStatistics {
    /// The statistics of a chunk's part of a map.
    pub fn of(part: &Map) -> ChunkStatistics {
        fn fold(values: impl Iterator<Item = f64>) -> [f64; 3] {
            let start = [0.0, f64::INFINITY, f64::NEG_INFINITY];
            values.fold(start, |[s, a, b], v| [s + v, a.min(v), b.max(v)])
        }
        let layer = |l: &Layer| match &l.data {
            Data::F32(v) => fold(v.iter().map(|v| f64::from(*v))),
            Data::U32(v) => fold(v.iter().map(|v| f64::from(*v))),
            Data::U8(v) => fold(v.iter().map(|v| f64::from(*v))),
            Data::I8(v) => fold(v.iter().map(|v| f64::from(*v))),
        };
        let count = |name: &str, value: i8| match part.layer(name).map(|l| &l.data) {
            Some(Data::U8(v)) => v.iter().filter(|v| i16::from(**v) == i16::from(value)).count() as u64,
            Some(Data::I8(v)) => v.iter().filter(|v| **v == value).count() as u64,
            _ => 0,
        };
        ChunkStatistics {
            cells: [count("touched", 1), count("class", 1), count("class", -1), count("class", 0)],
            updates: part.updates,
            increments: part.increments.iter().map(|v| F64Bits::of(*v)).collect(),
            layers: part.layers.par_iter().map(|l| layer(l).map(F64Bits::of)).collect(),
        }
    }

    /// The sum, the least and the largest value of the first layer.
    pub fn first_layer(&self) -> [f64; 3] {
        self.layers.first().map_or([0.0; 3], |l| l.map(F64Bits::value))
    }

    /// The statistics of a chunk of so many cells that no reading reached.
    pub fn unreached(layers: &[Layer], cells: usize) -> ChunkStatistics {
        let layer = |l: &Layer| [l.fill * cells as f64, l.fill, l.fill].map(F64Bits::of);
        ChunkStatistics {
            cells: [0, 0, 0, cells as u64],
            updates: 0,
            increments: Vec::new(),
            layers: layers.iter().map(layer).collect(),
        }
    }
}
