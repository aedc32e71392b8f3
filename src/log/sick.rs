//! The no-return codes of SICK's lasers.

/// SICK's lasers send codes from here on in place of a range: 13 bits in mm or cm, 15 bits in mm.
pub(super) const SICK_CODES: [std::ops::RangeInclusive<f64>; 2] = [8183.0..=8191.0, 32759.0..=32767.0];

/// The first code of a SICK laser whose largest number is this, if it is such a code.
pub(super) fn no_return_code(largest: f64) -> Option<f64> {
    SICK_CODES.iter().find(|codes| codes.contains(&largest)).map(|codes| *codes.start())
}
