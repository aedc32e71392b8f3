//! The map of a log by the f64 oracle, one reading, scan or update at a time.

use super::{MappedLog, Session};
use crate::binning::scan::Scan;
use crate::feature::{Rules, StageResult, Update};
use crate::log::reading::Counts;
use crate::method::Input;
use crate::method::settings::Settings;
use crate::oracle::{self, OracleMap};
use crate::pipeline::batching::BatchStatistics;
use crate::pipeline::layers;
use crate::{Error, Result};

impl Session {
    /// Maps the log by the oracle.
    ///
    /// # Errors
    /// The log's.
    pub fn oracle(&self) -> Result<OracleMap> {
        Ok(self.oracle_and_features()?.0)
    }

    /// Maps the log by the oracle into the layers that every backend gives.
    ///
    /// # Errors
    /// The log's.
    pub fn oracle_map(&self) -> Result<MappedLog> {
        let (map, features) = self.oracle_and_features()?;
        let counts = Counts { outside: map.outside, empty_arc: map.empty_arc, wide: map.wide, ..self.survey.counts };
        let finished = layers::from_oracle(&map, self.method.as_ref());
        Ok(MappedLog { finished, counts, statistics: BatchStatistics::default(), features })
    }

    fn oracle_and_features(&self) -> Result<(OracleMap, Option<StageResult>)> {
        let settings = self.method.settings();
        match self.input() {
            Input::Readings => {
                let (readings, wedges) = self.all_readings()?;
                let map = oracle::map(&self.grid, self.sensors(), &readings, &settings, wedges.as_deref())?;
                Ok((map, None))
            }
            Input::Scans { .. } => Ok((self.oracle_of_scans(&settings)?, None)),
            Input::Updates(rules) => self.oracle_of_updates(rules, &settings).map(|(map, found)| (map, Some(found))),
        }
    }

    fn oracle_of_scans(&self, settings: &Settings) -> Result<OracleMap> {
        let scans: Vec<Scan> = self.scans()?.collect::<Result<_>>()?;
        match settings {
            Settings::Csm(csm) => Ok(oracle::map_scans(&self.grid, &scans, csm)),
            _ => Err(Error::Usage("the oracle maps scans by the counting sensor models alone".into())),
        }
    }

    fn oracle_of_updates(&self, rules: Rules, settings: &Settings) -> Result<(OracleMap, StageResult)> {
        let map = |updates: &mut dyn Iterator<Item = Result<Update>>| {
            oracle::map_updates(&self.grid, self.sensors(), updates, settings)
        };
        self.associate(rules, usize::MAX, map)
    }
}
