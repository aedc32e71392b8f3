//! Runs the stage in parallel to the kernels: while a backend applies the updates of one window, another thread computes the next.

use super::draw::Cells;
use super::features::FeatureMap;
use super::ping::Ping;
use super::rules::Rules;
use super::stage::{MAX_HELD, Stage, StageCounts};
use super::update::Update;
use crate::log::reading::{Record, classify};
use crate::sensor::Sensor;
use crate::{Error, Result};
use nalgebra::distance;
use serde::Serialize;
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

/// Updates that are sent to the backend at once.
const BATCH: usize = 1024;
/// Most batches that wait for the backend.
const MAX_WAITING: usize = 16;
/// The largest distance that the robot moves within a scan, metres.
const MAX_SCAN_TRAVEL: f64 = 0.5;
/// Most updates that a backend should apply at once, so that the stage computes the next ones meanwhile.
pub const WINDOW: usize = 8192;

/// The largest memory of the stage for a number of readings, bytes: held readings, and updates that wait.
pub fn memory(readings: u64) -> u64 {
    let held = readings.min(MAX_HELD as u64);
    held * size_of::<Ping>() as u64 + UPDATE_BYTES * (held + readings.min((BATCH * MAX_WAITING) as u64))
}

/// Memory of an update with its fans, bytes.
const UPDATE_BYTES: u64 = 1024;

/// The features of a log, and how its readings were associated.
#[derive(Debug, Clone, Default)]
pub struct StageResult {
    /// The number of readings of each case.
    pub counts: StageCounts,
    /// The features of the whole log.
    pub feature_map: FeatureMap,
    /// The times of the stage and of the kernels.
    pub times: Times,
}

/// Times of the stage and of the kernels, which run in parallel, seconds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Times {
    /// Reading the log, finding features, associating.
    pub stage: f64,
    /// Snapping, binning, and the kernels.
    pub kernels: f64,
    /// Both, from the first reading to the last update.
    pub both: f64,
}

/// The summary of the stage for a report.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// Walls, faces counted one by one.
    pub walls: u64,
    /// Concave corners.
    pub corners: u64,
    /// Points.
    pub points: u64,
    /// Regions of constant depth.
    pub regions: u64,
    /// Readings from a feature, case (i).
    pub associated: u64,
    /// Readings from behind a wall, case (ii).
    pub outliers: u64,
    /// Readings from behind a safe line, case (iii).
    pub behind: u64,
    /// Readings with a routine update, or a missing echo that says nothing, case (iv).
    pub routine: u64,
    /// The most readings that were held at once.
    pub held: u64,
    /// Their memory, bytes.
    pub held_bytes: u64,
    /// The times, seconds.
    pub seconds: Times,
    /// The part of the shorter of the two times that ran in parallel to the other, 0 to 1.
    pub overlap: f64,
}

impl StageResult {
    /// The summary for a report.
    pub fn summary(&self) -> Summary {
        let FeatureMap { features, .. } = &self.feature_map;
        let [associated, outliers, behind, routine] = self.counts.cases;
        let Times { stage, kernels, both } = self.times;
        Summary {
            walls: features.walls.len() as u64,
            corners: features.corners.len() as u64,
            points: features.points.len() as u64,
            regions: self.counts.regions,
            associated,
            outliers,
            behind,
            routine,
            held: self.counts.held,
            held_bytes: self.counts.held * size_of::<Ping>() as u64,
            seconds: self.times,
            overlap: ((stage + kernels - both) / stage.min(kernels).max(1e-9)).clamp(0.0, 1.0),
        }
    }
}

/// A stage that takes a log's records one by one.
struct Feed<'a> {
    stage: Stage,
    sensors: &'a [Sensor],
    scan: Vec<Ping>,
    pings: u64,
    used: u64,
    most: u64,
}

impl Feed<'_> {
    /// Takes a record; whether more are wanted.
    fn record(&mut self, record: Record, out: &mut Vec<Update>) -> bool {
        let sensor = &self.sensors[record.sensor as usize];
        let other = |p: &Ping| {
            p.record.scan != record.scan || distance(&p.centre(), &record.robot.position()) > MAX_SCAN_TRAVEL
        };
        if self.scan.first().is_some_and(other) {
            self.stage.scan(std::mem::take(&mut self.scan), out);
        }
        if let Some(ping) = Ping::of(record, self.pings, sensor) {
            self.scan.push(ping);
            self.pings += 1;
        }
        self.used += u64::from(classify(record, sensor).is_ok());
        self.used < self.most
    }

    fn finish(&mut self, out: &mut Vec<Update>) {
        self.stage.scan(std::mem::take(&mut self.scan), out);
        self.stage.finish(out);
    }
}

/// Runs the stage over the records of a log, up to the `most`-th used one, in a thread of its own; `apply` takes the updates in
/// order in this thread.
///
/// # Errors
/// The records', and those of `apply`.
pub fn run<T, I: Iterator<Item = Result<Record>>>(
    records: impl FnOnce() -> Result<I> + Send,
    sensors: &[Sensor],
    (rules, resolution, most): (Rules, f64, u64),
    apply: impl FnOnce(&mut dyn Iterator<Item = Result<Update>>) -> Result<T>,
) -> Result<(T, StageResult)> {
    let started = Instant::now();
    let epsilon = sensors.iter().map(|s| s.epsilon(resolution)).fold(0.0, f64::max);
    let (send, receive) = sync_channel::<Result<Vec<Update>>>(MAX_WAITING);
    std::thread::scope(|scope| {
        let stage = scope.spawn(move || {
            let stage = Stage::new(rules, Cells { resolution, epsilon });
            let mut feed = Feed { stage, sensors, scan: Vec::new(), pings: 0, used: 0, most };
            let (mut busy, mut clock, mut ready) = (Duration::ZERO, Instant::now(), Vec::new());
            // whether the receiver still takes updates
            let mut give = |ready: &mut Vec<Update>, clock: &mut Instant| {
                busy += clock.elapsed();
                let mut rest = std::mem::take(ready);
                let mut taken = true;
                while taken && !rest.is_empty() {
                    let later = rest.split_off(rest.len().min(BATCH));
                    taken = send.send(Ok(std::mem::replace(&mut rest, later))).is_ok();
                }
                *clock = Instant::now();
                taken
            };
            let records = match records() {
                Ok(records) => records,
                Err(e) => return send.send(Err(e)).err().map(|_| StageResult::default()),
            };
            for record in records {
                let more = match record {
                    Ok(record) => feed.record(record, &mut ready),
                    Err(e) => return send.send(Err(e)).err().map(|_| StageResult::default()),
                };
                if ready.len() >= BATCH && !give(&mut ready, &mut clock) {
                    return None;
                }
                if !more {
                    break;
                }
            }
            feed.finish(&mut ready);
            give(&mut ready, &mut clock);
            // the kernels needn't wait for the feature map
            drop(send);
            let times = Times { stage: busy.as_secs_f64(), ..Times::default() };
            let feature_map = feed.stage.feature_map();
            Some(StageResult { counts: feed.stage.counts, feature_map, times })
        });
        let mut taken = UpdateReceiver { receive, ready: Vec::new().into_iter(), waited: Duration::ZERO };
        let applied = apply(&mut taken);
        let (waited, both) = (taken.waited, started.elapsed());
        // a stage that still sends gets an error, and ends
        drop(taken);
        let died = || Error::Resources("the feature stage died; this is a defect of echogrid: please report it".into());
        let found = stage.join().map_err(|_| died());
        let (applied, mut found) = (applied?, found?.ok_or_else(died)?);
        found.times.kernels = both.saturating_sub(waited).as_secs_f64();
        found.times.both = both.as_secs_f64();
        Ok((applied, found))
    })
}

/// The updates as the stage sends them.
struct UpdateReceiver {
    receive: Receiver<Result<Vec<Update>>>,
    ready: std::vec::IntoIter<Update>,
    waited: Duration,
}

impl Iterator for UpdateReceiver {
    type Item = Result<Update>;

    fn next(&mut self) -> Option<Result<Update>> {
        loop {
            if let Some(update) = self.ready.next() {
                return Some(Ok(update));
            }
            let started = Instant::now();
            let received = self.receive.recv();
            self.waited += started.elapsed();
            match received {
                Ok(Ok(ready)) => self.ready = ready.into_iter(),
                Ok(Err(e)) => return Some(Err(e)),
                Err(_) => return None,
            }
        }
    }
}
