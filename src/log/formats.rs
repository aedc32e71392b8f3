//! The registry of log formats. **Adding a format is one file and one line here.**

use super::format::Format;
use super::{aria, carmen, cmu, csv, jsonl, matlab, player, rostopic, sonar_ring_8};

/// Every format, in the order in which they are tried.
pub(crate) const FORMATS: &[&dyn Format] = &[
    &sonar_ring_8::SonarRing8,
    &jsonl::JsonLines,
    &csv::Csv,
    &rostopic::RosTopic,
    &aria::Aria,
    &player::Player,
    &cmu::Cmu,
    &carmen::Carmen,
    &matlab::Matlab,
    &matlab::Octave,
];
