//! Which tile gets which input: readings snapped to cones, scans to beams, updates to shapes, and the lists of each tile, in
//! log order.

pub mod batch;
pub mod scan;
pub mod snap;
pub mod update;
pub mod wedge;
