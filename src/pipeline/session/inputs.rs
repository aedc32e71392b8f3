//! The inputs that methods take of a log: readings, scans, or updates of the feature stage.

use super::Session;
use crate::binning::scan::{Scan, Scans};
use crate::binning::snap::{Edges, Footprint};
use crate::feature::{self, Rules, StageResult, Update};
use crate::log::Problem;
use crate::log::reading::{Reading, Record};
use crate::method::{self, Input};
use crate::pipeline::readings::{ReadingInput, UsedReadings};
use crate::{Error, Result};

impl Session {
    /// The readings to map, in log order.
    ///
    /// # Errors
    /// The log's.
    pub fn readings(&self) -> Result<impl Iterator<Item = Result<ReadingInput>> + '_> {
        let wedges = self.method.footprint() == Footprint::Wedge;
        let readings = UsedReadings::of(self.log.records()?, self.sensors(), wedges);
        Ok(readings.take(usize::try_from(self.until).unwrap_or(usize::MAX)))
    }

    /// All readings to map, and the edges of their wedges where the method needs them, as the oracle takes them.
    ///
    /// # Errors
    /// The log's.
    pub fn all_readings(&self) -> Result<(Vec<Reading>, Option<Vec<Edges>>)> {
        let inputs: Vec<ReadingInput> = self.readings()?.collect::<Result<_>>()?;
        let readings = inputs.iter().map(|input| input.0).collect();
        Ok((readings, inputs.iter().map(|input| input.1).collect()))
    }

    /// The scans to map, in log order, for a method that takes them.
    ///
    /// # Errors
    /// The log's.
    pub fn scans(&self) -> Result<impl Iterator<Item = Result<Scan>> + '_> {
        self.scans_first(u64::MAX)
    }

    /// The scans up to the `count`-th used reading.
    pub(super) fn scans_first(&self, count: u64) -> Result<impl Iterator<Item = Result<Scan>> + '_> {
        let labels = match self.input() {
            Input::Scans { labels, .. } => labels,
            Input::Readings | Input::Updates(_) => 0,
        };
        Ok(Scans::new(self.records()?, self.sensors(), labels, self.until.min(count), self.log.path()))
    }

    /// The updates of the first `count` used readings, in order, all at once, and the features of the log.
    ///
    /// # Errors
    /// The log's; [`Error::Usage`] for a method that takes no updates.
    pub fn updates(&self, count: usize) -> Result<(Vec<Update>, StageResult)> {
        match self.input() {
            Input::Updates(rules) => self.associate(rules, count, |updates| updates.collect::<Result<Vec<_>>>()),
            Input::Readings | Input::Scans { .. } => {
                Err(Error::Usage(format!("{} takes no features", method::name(self.method.as_ref()))))
            }
        }
    }

    /// Associates the first `count` used readings with features by `rules`, while `apply` takes the updates.
    pub(super) fn associate<T>(
        &self,
        rules: Rules,
        count: usize,
        apply: impl FnOnce(&mut dyn Iterator<Item = Result<Update>>) -> Result<T>,
    ) -> Result<(T, StageResult)> {
        let most = self.until.min(count as u64);
        feature::run(|| self.records(), self.sensors(), (rules, self.grid.resolution, most), apply)
    }

    /// The log's records, in order, bad lines left out.
    fn records(&self) -> Result<impl Iterator<Item = Result<Record>> + '_> {
        Ok(self.log.records()?.filter_map(|record| match record {
            Ok(record) => Some(Ok(record)),
            Err(Problem::Fatal(e)) => Some(Err(e)),
            Err(Problem::Line(_)) => None,
        }))
    }
}
