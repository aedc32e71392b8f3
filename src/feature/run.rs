//! The stage beside the kernels: while a backend applies one window's updates, a thread of its own finds and associates the next.

use super::draw::Cells;
use super::features::Known;
use super::ping::Ping;
use super::rules::Rules;
use super::stage::{MOST, Stage, Tally};
use super::update::Update;
use crate::geometry::plane::distance;
use crate::log::reading::{Record, classify};
use crate::sensor::Sensor;
use crate::{Error, Result};
use serde::Serialize;
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

/// Updates that are handed over together, and how many times as many may wait for the backend.
const TOGETHER: usize = 1024;
const WAITING: usize = 16;
/// What was taken farther apart is no scan, metres.
const MOVED: f64 = 0.5;
/// A backend's windows should be no larger than this, updates: while it applies one the next is found.
pub const WINDOW: usize = 8192;

/// What the stage takes at most for so many readings, bytes: those that it holds, and updates on their way.
pub fn memory(readings: u64) -> u64 {
    let held = readings.min(MOST as u64);
    held * size_of::<Ping>() as u64 + UPDATE * (held + readings.min((TOGETHER * WAITING) as u64))
}

/// An update with its fans, bytes.
const UPDATE: u64 = 1024;

/// How a log's readings were associated.
#[derive(Debug, Clone, Default)]
pub struct Found {
    /// What became of the readings.
    pub tally: Tally,
    /// The features of the whole log.
    pub known: Known,
    /// How long both sides took.
    pub times: Times,
}

/// Seconds of the stage and of the kernels, which run at once.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Times {
    /// Reading the log, finding features, associating.
    pub stage: f64,
    /// Snapping, binning, and the kernels.
    pub kernels: f64,
    /// Both, from the first reading to the last update.
    pub both: f64,
}

/// What is said of it in a report.
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
    /// What they took, bytes.
    pub held_bytes: u64,
    /// Seconds.
    pub seconds: Times,
    /// How much of the shorter of the two ran beside the other, 0 to 1.
    pub overlap: f64,
}

impl Found {
    /// In brief.
    pub fn summary(&self) -> Summary {
        let Known { features, .. } = &self.known;
        let [associated, outliers, behind, routine] = self.tally.cases;
        let Times { stage, kernels, both } = self.times;
        Summary {
            walls: features.walls.len() as u64,
            corners: features.corners.len() as u64,
            points: features.spots.len() as u64,
            regions: self.tally.regions,
            associated,
            outliers,
            behind,
            routine,
            held: self.tally.held,
            held_bytes: self.tally.held * size_of::<Ping>() as u64,
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
    /// Takes a record; `false`: that was enough.
    fn record(&mut self, record: Record, out: &mut Vec<Update>) -> bool {
        let sensor = &self.sensors[record.sensor as usize];
        let other =
            |p: &Ping| p.record.scan != record.scan || distance(p.centre(), (record.robot.x, record.robot.y)) > MOVED;
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

/// Runs the stage over a log's records, up to the `most`-th used one, on a thread; `apply` takes the updates in order on this one.
///
/// # Errors
/// The records', and those of `apply`.
pub fn run<T, I: Iterator<Item = Result<Record>>>(
    records: impl FnOnce() -> Result<I> + Send,
    sensors: &[Sensor],
    (rules, resolution, most): (Rules, f64, u64),
    apply: impl FnOnce(&mut dyn Iterator<Item = Result<Update>>) -> Result<T>,
) -> Result<(T, Found)> {
    let started = Instant::now();
    let epsilon = sensors.iter().map(|s| s.epsilon(resolution)).fold(0.0, f64::max);
    let (send, receive) = sync_channel::<Result<Vec<Update>>>(WAITING);
    std::thread::scope(|scope| {
        let stage = scope.spawn(move || {
            let stage = Stage::new(rules, Cells { resolution, epsilon });
            let mut feed = Feed { stage, sensors, scan: Vec::new(), pings: 0, used: 0, most };
            let (mut busy, mut clock, mut ready) = (Duration::ZERO, Instant::now(), Vec::new());
            // Whether there is somebody to take them.
            let mut give = |ready: &mut Vec<Update>, clock: &mut Instant| {
                busy += clock.elapsed();
                let mut rest = std::mem::take(ready);
                let mut taken = true;
                while taken && !rest.is_empty() {
                    let later = rest.split_off(rest.len().min(TOGETHER));
                    taken = send.send(Ok(std::mem::replace(&mut rest, later))).is_ok();
                }
                *clock = Instant::now();
                taken
            };
            let records = match records() {
                Ok(records) => records,
                Err(e) => return send.send(Err(e)).err().map(|_| Found::default()),
            };
            for record in records {
                let more = match record {
                    Ok(record) => feed.record(record, &mut ready),
                    Err(e) => return send.send(Err(e)).err().map(|_| Found::default()),
                };
                if ready.len() >= TOGETHER && !give(&mut ready, &mut clock) {
                    return None;
                }
                if !more {
                    break;
                }
            }
            feed.finish(&mut ready);
            give(&mut ready, &mut clock);
            // The kernels needn't wait for the whole.
            drop(send);
            let times = Times { stage: busy.as_secs_f64(), ..Times::default() };
            let known = feed.stage.known();
            Some(Found { tally: feed.stage.tally, known, times })
        });
        let mut taken = Taken { receive, ready: Vec::new().into_iter(), waited: Duration::ZERO };
        let applied = apply(&mut taken);
        let (waited, both) = (taken.waited, started.elapsed());
        // A stage that still has something to give learns that nobody takes it.
        drop(taken);
        let died = || Error::Resources("the feature stage died; this is a defect of echogrid: please report it".into());
        let found = stage.join().map_err(|_| died());
        let (applied, mut found) = (applied?, found?.ok_or_else(died)?);
        found.times.kernels = both.saturating_sub(waited).as_secs_f64();
        found.times.both = both.as_secs_f64();
        Ok((applied, found))
    })
}

/// The updates as they come.
struct Taken {
    receive: Receiver<Result<Vec<Update>>>,
    ready: std::vec::IntoIter<Update>,
    waited: Duration,
}

impl Iterator for Taken {
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
