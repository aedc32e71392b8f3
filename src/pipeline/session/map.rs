//! The map of a log by a backend, with all chunks resident.

use super::Session;
use crate::Result;
use crate::binning::scan::Selection;
use crate::feature::{self, Rules, StageResult, Update};
use crate::kernels::Backend;
use crate::log::reading::Counts;
use crate::method::Input;
use crate::pipeline::batching::{BatchStatistics, take_map};
use crate::pipeline::finished::FinishedMap;
use crate::pipeline::mapper::Mapper;
use crate::pipeline::scans::{ChunkedScans, Spill};
use crate::pipeline::updates;

/// The map of a log, and the statistics of the run.
#[derive(Debug, Clone)]
pub struct MappedLog {
    /// The map.
    pub finished: FinishedMap,
    /// What became of the log's records.
    pub counts: Counts,
    /// The size of the batches.
    pub statistics: BatchStatistics,
    /// The features of the log, for a method that takes updates.
    pub features: Option<StageResult>,
}

/// How a backend takes a log.
pub(super) struct MapRun<'a> {
    pub backend: &'a mut dyn Backend,
    /// Readings at a time.
    pub batch: usize,
    /// Receives the number of readings done since its last call.
    pub progress: &'a dyn Fn(u64),
}

impl Session {
    /// Maps the log on a backend, `batch` readings at a time; `progress` receives the number of readings done since its last call.
    ///
    /// # Errors
    /// The log's and the backend's.
    pub fn map(&self, backend: &mut dyn Backend, batch: usize, progress: &dyn Fn(u64)) -> Result<MappedLog> {
        self.map_first(usize::MAX, backend, batch, progress)
    }

    /// Maps the first `count` used readings of the log, as [`Session::map`] does all of them.
    ///
    /// # Errors
    /// The log's and the backend's.
    pub fn map_first(
        &self,
        count: usize,
        backend: &mut dyn Backend,
        batch: usize,
        progress: &dyn Fn(u64),
    ) -> Result<MappedLog> {
        let run = MapRun { backend, batch, progress };
        match self.input() {
            Input::Readings => self.map_readings(count, run),
            Input::Scans { selection, .. } => self.map_scans(count, selection, run),
            Input::Updates(rules) => self.map_updates(count, rules, run),
        }
    }

    fn map_readings(&self, count: usize, run: MapRun) -> Result<MappedLog> {
        let mut mapper = Mapper::new(self.grid, self.sensors(), self.method.as_ref(), run.backend, run.batch)?;
        for sweep in 0..self.method.sweeps().len() {
            mapper.sweep(sweep, self.readings()?.take(count).inspect(|_| (run.progress)(1)))?;
        }
        let (reached, statistics) = (mapper.counts, mapper.statistics);
        Ok(MappedLog { finished: mapper.finish()?, counts: self.counts(reached), statistics, features: None })
    }

    fn map_scans(&self, count: usize, selection: Selection, run: MapRun) -> Result<MappedLog> {
        let (method, scans) = (self.method.as_ref(), self.scans_first(count as u64)?);
        let scans = ChunkedScans::read(&self.grid, selection, scans, &Spill::never(), &|_| {})?;
        let statistics = scans.apply(method, run.backend, run.batch, run.progress)?;
        let finished = take_map(&self.grid, method, run.backend)?;
        Ok(MappedLog { finished, counts: self.survey.counts, statistics, features: None })
    }

    fn map_updates(&self, count: usize, rules: Rules, run: MapRun) -> Result<MappedLog> {
        let (grid, method) = (&self.grid, self.method.as_ref());
        let MapRun { backend, batch, progress } = run;
        let apply = |updates: &mut dyn Iterator<Item = Result<Update>>| {
            let mut updater = updates::Updater::new(grid, self.sensors(), method, backend, batch.min(feature::WINDOW));
            updater.apply(updates, progress)?;
            Ok((updater.counts, updater.statistics))
        };
        let ((reached, statistics), features) = self.associate(rules, count, apply)?;
        let finished = take_map(grid, method, backend)?;
        Ok(MappedLog { finished, counts: self.counts(reached), statistics, features: Some(features) })
    }

    /// The log's counts, with those that are known only once readings are mapped.
    fn counts(&self, reached: Counts) -> Counts {
        let Counts { outside, empty_arc, wide, .. } = reached;
        Counts { outside, empty_arc, wide, ..self.survey.counts }
    }
}
