//! Made-up worlds, where the truth is known: where a log comes from when no robot is at hand.

pub mod room;

pub mod random;
