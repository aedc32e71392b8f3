//! Which beams may touch which cells.

/// What of a counting sensor model decides which poses and beams may touch a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Selection {
    /// How many of the nearest poses speak of a cell; `None`: all.
    pub neighbours: Option<u16>,
    /// Readings from here on say nothing, metres.
    pub z_max: f64,
    /// How far beyond a hit, or beside a beam, a cell may be touched, µm.
    pub margin: i32,
    /// Width of a beam, radians; `None`: a beam is a line.
    pub beam_width: Option<f64>,
}
