//! How good a map is: backends against the oracle, two maps against each other, a map against the truth.

pub mod compare;
pub mod score;
pub mod verify;
