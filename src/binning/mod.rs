//! Snaps readings to cones, scans to beams and updates to shapes, and lists for each tile the inputs that may touch it, in log order.

pub mod batch;
pub mod scan;
pub mod snap;
pub mod update;
pub mod wedge;
