//! The used readings of a log, in log order, each with the edges of its wedge where the method needs them.

use crate::Result;
use crate::binning::snap::Edges;
use crate::binning::wedge;
use crate::log::reading::{Reading, Record, classify};
use crate::log::{Problem, Records};
use crate::sensor::Sensor;
use std::collections::VecDeque;

/// The input of a method that takes readings: a reading, and the edges of its wedge for a method with [`Footprint::Wedge`](crate::binning::snap::Footprint::Wedge).
pub type ReadingInput = (Reading, Option<Edges>);

/// Iterates over the used readings of a log. Bad lines and unused records are left out.
pub(crate) struct UsedReadings<'a> {
    records: Records,
    sensors: &'a [Sensor],
    /// Whether readings get the edges of their wedges: then records are held back until their scan is complete.
    wedges: bool,
    scan: Vec<Record>,
    ready: VecDeque<ReadingInput>,
}

impl<'a> UsedReadings<'a> {
    /// The used readings of these records.
    pub fn of(records: Records, sensors: &'a [Sensor], wedges: bool) -> UsedReadings<'a> {
        UsedReadings { records, sensors, wedges, scan: Vec::new(), ready: VecDeque::new() }
    }

    /// Gives the readings of the held scan their edges.
    fn complete_scan(&mut self) {
        let edges = wedge::edges(&self.scan, self.sensors);
        for (record, edges) in self.scan.drain(..).zip(edges) {
            if let Ok(reading) = classify(record, &self.sensors[record.sensor as usize]) {
                self.ready.push_back((reading, Some(edges)));
            }
        }
    }
}

impl Iterator for UsedReadings<'_> {
    type Item = Result<ReadingInput>;

    fn next(&mut self) -> Option<Result<ReadingInput>> {
        loop {
            if let Some(reading) = self.ready.pop_front() {
                return Some(Ok(reading));
            }
            match self.records.next() {
                None if self.scan.is_empty() => return None,
                None => self.complete_scan(),
                Some(Err(Problem::Fatal(e))) => return Some(Err(e)),
                Some(Err(Problem::Line(_))) => {}
                Some(Ok(record)) if self.wedges => {
                    if self.scan.last().is_some_and(|last| last.scan != record.scan) {
                        self.complete_scan();
                    }
                    self.scan.push(record);
                }
                Some(Ok(record)) => {
                    if let Ok(reading) = classify(record, &self.sensors[record.sensor as usize]) {
                        return Some(Ok((reading, None)));
                    }
                }
            }
        }
    }
}
