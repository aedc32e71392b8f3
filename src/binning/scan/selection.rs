//! The parameters that decide which beams may touch which cells.

/// The parameters of a counting sensor model that decide which poses and beams may touch a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Selection {
    /// Number of nearest poses that may update a cell; `None`: all.
    pub neighbours: Option<u16>,
    /// Range from which on readings are ignored, metres.
    pub z_max: f64,
    /// The largest distance beyond a hit, or beside a beam, at which a cell may be touched, µm.
    pub margin: i32,
    /// Width of a beam, radians; `None` if a beam is a line.
    pub beam_width: Option<f64>,
}
