//! Error levels and zones: how dangerous it is to take one class for another.

use serde::Serialize;

/// The level of a cell that isn't compared.
pub const NOT_COMPARED: u8 = 255;

/// A cell's error level, 0 to 9, from its true and its obtained class (−1 empty, 0 unknown, 1 occupied).
///
/// `obtained_near`: one of the eight neighbours is occupied in the obtained map; `true_near`: in the true one.
pub fn level(actual: i8, obtained: i8, obtained_near: bool, true_near: bool) -> u8 {
    match (actual.signum(), obtained.signum()) {
        (a, o) if a == o => 0,
        (_, 1) if true_near => 1,
        (1, 0) => {
            if obtained_near {
                2
            } else {
                4
            }
        }
        (-1, 0) => 3,
        (0, 1) => 5,
        (-1, 1) => 6,
        (0, -1) => 7,
        // Occupied, shown as empty.
        _ => {
            if obtained_near {
                8
            } else {
                9
            }
        }
    }
}

/// Cells by zone. Z1 + Z3 + Z4 + Z5 are all cells compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Zones {
    /// Accurate: levels 0 and 1.
    pub z1: u64,
    /// Safe: Z1 + Z3 + Z4.
    pub z2: u64,
    /// Exploration overhead: known, but left unknown; levels 2, 3, 4.
    pub z3: u64,
    /// Less accurate: shown occupied, far from anything; levels 5 and 6.
    pub z4: u64,
    /// Danger: shown empty, and isn't known to be; levels 7, 8, 9.
    pub z5: u64,
}

impl Zones {
    /// The zones of the ten levels' counts.
    pub fn of(levels: &[u64; 10]) -> Zones {
        let sum = |which: &[usize]| which.iter().map(|&l| levels[l]).sum::<u64>();
        let (z1, z3, z4, z5) = (sum(&[0, 1]), sum(&[2, 3, 4]), sum(&[5, 6]), sum(&[7, 8, 9]));
        Zones { z1, z2: z1 + z3 + z4, z3, z4, z5 }
    }
}

/// A class layer's value as −1, 0 or 1. (`f64::signum` makes 1 of 0.)
pub(super) fn class_of(value: f64) -> i8 {
    i8::from(value > 0.0) - i8::from(value < 0.0)
}
