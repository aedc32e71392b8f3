//! Packs items for a GPU elsewhere, such as a browser's: the same batch that a backend takes.

use super::apply::{binning, cone, snap_update};
use super::{LogInputs, Stepper};
use crate::binning::batch::Batch;
use crate::binning::update::Bins;
use crate::geometry::layout::{BROAD, Cone, Frame, WIDE};
use crate::method::{Method, Step};
use crate::pipeline::batching::frame;
use crate::{Error, Result};
use std::ops::Range;

/// A batch of items, with what a kernel needs to know of it.
pub struct Packed {
    /// The batch.
    pub batch: Batch,
    /// The frame, its mode still to be set.
    pub frame: Frame,
    /// Whether one of the readings reaches farther than 1024 cells.
    pub wide: bool,
    /// Whether one of the readings has a half width β of more than 22.5°.
    pub broad: bool,
}

/// The steps that apply a batch of items to the cells.
///
/// # Errors
/// [`Error::Usage`] where batches of items can't be applied one after the other.
pub fn steps(method: &dyn Method, items: &LogInputs) -> Result<&'static [Step]> {
    let why = match items {
        LogInputs::Scans(_) => "a cell takes its nearest poses in the whole log, so that no batch in time updates it",
        LogInputs::SweptReadings(_) => "in the 1985 order every reading changes what the others say",
        _ => match method.cpu_only() {
            None => return Ok(method.sweeps()[0]),
            Some(why) => why,
        },
    };
    Err(Error::Usage(format!("the kernels don't run step by step on another's GPU: {why}")))
}

impl Stepper {
    /// Packs a range of items.
    ///
    /// # Errors
    /// As [`steps`]; the updates'.
    pub fn pack(&self, range: Range<usize>) -> Result<Packed> {
        let steps = steps(self.method(), self.items())?;
        let session = self.session();
        let batch = match self.items() {
            LogInputs::Updates(all, _) => {
                let snapped = all[range].iter().map(|u| snap_update(session, u)).collect::<Result<Vec<_>>>()?;
                let snapped: Vec<_> = snapped.into_iter().flatten().collect();
                Bins { size: [self.grid().width, self.grid().height] }.bin(&snapped).batch
            }
            items => {
                let cones = range.filter_map(|k| items.reading(k)).filter_map(|item| cone(session, &item));
                binning(session, steps).bin(cones.collect())
            }
        };
        let any = |flag: u32| batch.cones().iter().any(|c: &Cone| c.flags & flag != 0);
        let (wide, broad) = (any(WIDE), any(BROAD));
        Ok(Packed { batch, frame: frame(self.grid(), self.method()), wide, broad })
    }
}
