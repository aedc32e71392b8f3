//! The no-return codes of SICK's lasers.

/// The codes that SICK's lasers send in place of a range: of 13 bits in mm or cm, of 15 bits in mm.
pub(super) const SICK_CODES: [std::ops::RangeInclusive<f64>; 2] = [8183.0..=8191.0, 32759.0..=32767.0];

/// The smallest code of a SICK laser whose largest number is `largest`; `None` if `largest` is no code.
pub(super) fn no_return_code(largest: f64) -> Option<f64> {
    SICK_CODES.iter().find(|codes| codes.contains(&largest)).map(|codes| *codes.start())
}
