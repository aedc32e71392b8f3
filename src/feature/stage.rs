//! The stage of the feature-based grid: it takes scans and gives updates, each after the robot has seen enough of its surroundings.

use super::decide::{Case, decide};
use super::draw::{Cells, draw};
use super::features::FeatureMap;
use super::limit::Obstacles;
use super::observations::Observations;
use super::ping::Ping;
use super::rcd::{Rcd, regions};
use super::ring::Runs;
use super::rules::Rules;
use super::update::Update;
use crate::geometry::plane::Point;
use nalgebra::distance;
use std::collections::{BTreeMap, VecDeque};

/// Fewest readings of one sensor in a circular scan.
const MIN_CIRCULAR: usize = 8;
/// Held scans are released together while the robot travels this distance, metres.
const WINDOW: f64 = 0.5;
/// Features are computed this far beyond the range of the sensors, metres.
const MARGIN: f64 = 1.0;
/// Most readings that are held.
pub const MAX_HELD: usize = 1 << 16;
/// The number of readings and of regions.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StageCounts {
    /// Readings of cases (i) to (iv).
    pub cases: [u64; 4],
    /// Regions of constant depth.
    pub regions: u64,
    /// The most readings that were held at once.
    pub held: u64,
}

/// Scans for which a reading is held by the paper's rules.
const PAPER_SCANS: u64 = 3;

/// A scan whose readings are held.
struct HeldScan {
    pings: Vec<Ping>,
    at: Point,
    /// The robot's travel up to it, metres.
    travelled: f64,
    /// Counted from 1.
    number: u64,
}

/// The stage, with the scans that it holds.
pub struct Stage {
    rules: Rules,
    cells: Cells,
    observations: Observations,
    runs: Runs,
    last: Option<Point>,
    travelled: f64,
    scans: u64,
    held: VecDeque<HeldScan>,
    count: usize,
    /// The number of readings of each case so far.
    pub counts: StageCounts,
}

impl Stage {
    /// A stage without features.
    pub fn new(rules: Rules, cells: Cells) -> Stage {
        Stage {
            rules,
            cells,
            observations: Observations::default(),
            runs: Runs::default(),
            last: None,
            travelled: 0.0,
            scans: 0,
            held: VecDeque::new(),
            count: 0,
            counts: StageCounts::default(),
        }
    }

    /// Takes a scan, and appends the updates that are ready to `out`; in log order, except by the paper's rules.
    pub fn scan(&mut self, pings: Vec<Ping>, out: &mut Vec<Update>) {
        let Some(first) = pings.first() else { return };
        let at = first.centre();
        if let Some(last) = self.last.replace(at) {
            self.travelled += distance(&last, &at);
            self.observations.walk(last, at);
        }
        self.find_regions(&pings);
        self.scans += 1;
        let mut held = HeldScan { pings, at, travelled: self.travelled, number: self.scans };
        if self.rules.paper {
            held.pings = self.update_associated(&held, out);
        }
        self.count += held.pings.len();
        self.counts.held = self.counts.held.max(self.count as u64);
        self.held.push_back(held);
        let hold = self.rules.hold;
        if self.rules.paper {
            self.release(|s, h| s.scans - h.number >= PAPER_SCANS, out);
        } else if self.held.front().is_some_and(|h| self.travelled - h.travelled >= hold + WINDOW) {
            self.release(|s, h| s.travelled - h.travelled >= hold, out);
        }
        if self.count > MAX_HELD {
            self.release(|s, _| s.count > MAX_HELD / 2, out);
        }
    }

    /// Ends the log: appends the updates of all readings that are still held.
    pub fn finish(&mut self, out: &mut Vec<Update>) {
        for rcd in self.runs.finish() {
            self.keep(rcd);
        }
        self.release(|_, _| true, out);
    }

    /// All features of the log so far.
    pub fn feature_map(&self) -> FeatureMap {
        self.observations.feature_map(&self.rules)
    }

    /// Finds the regions of a scan.
    fn find_regions(&mut self, pings: &[Ping]) {
        let mut sensors: BTreeMap<u32, Vec<Ping>> = BTreeMap::new();
        for ping in pings {
            sensors.entry(ping.record.sensor).or_default().push(*ping);
        }
        for own in sensors.into_values() {
            if own.len() >= MIN_CIRCULAR {
                regions(&own).into_iter().for_each(|rcd| self.keep(rcd));
            } else {
                for ping in &own {
                    if let Some(rcd) = self.runs.push(ping) {
                        self.keep(rcd);
                    }
                }
            }
        }
    }

    fn keep(&mut self, rcd: Rcd) {
        self.counts.regions += 1;
        self.observations.keep(rcd);
    }

    /// Releases the scans that are `due`, the oldest first.
    fn release(&mut self, due: impl Fn(&Stage, &HeldScan) -> bool, out: &mut Vec<Update>) {
        while let Some(start) = self.held.front().filter(|h| due(self, h)).map(|h| h.at) {
            // scans close to each other share their features
            let mut window = Vec::new();
            while self.held.front().is_some_and(|h| due(self, h) && distance(&h.at, &start) <= 2.0 * WINDOW) {
                let Some(held) = self.held.pop_front() else { break };
                self.count -= held.pings.len();
                window.push(held);
            }
            self.update(&window, &|_| true, out);
        }
    }

    /// The paper's rule: readings that a feature explains are updated at once. Gives the others.
    fn update_associated(&mut self, scan: &HeldScan, out: &mut Vec<Update>) -> Vec<Ping> {
        self.update(std::slice::from_ref(scan), &|case| case == Case::Associated, out)
    }

    /// Decides the readings of scans close to each other, and appends the updates of those whose case is `wanted`; gives the others.
    fn update(&mut self, window: &[HeldScan], wanted: &dyn Fn(Case) -> bool, out: &mut Vec<Update>) -> Vec<Ping> {
        let aside = window.iter().flat_map(|h| h.pings.iter().map(|p| p.reach + distance(&p.at, &h.at)));
        let reach = aside.fold(0.0, f64::max) + MARGIN;
        let mut area = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        for at in window.iter().map(|h| h.at) {
            area[0] = area[0].min(at.x - reach);
            area[1] = area[1].min(at.y - reach);
            area[2] = area[2].max(at.x + reach);
            area[3] = area[3].max(at.y + reach);
        }
        let (FeatureMap { features, .. }, _) = self.observations.around(area, &self.rules);
        let mut rest = Vec::new();
        for held in window {
            let obstacles = Obstacles::near(&features, held.at, reach, self.cells.resolution);
            for ping in &held.pings {
                let decision = decide(ping, &features, &obstacles, &self.rules);
                if wanted(decision.case) {
                    self.counts.cases[decision.case as usize] += 1;
                    out.extend(draw(ping, &decision, &features, self.cells));
                } else {
                    rest.push(*ping);
                }
            }
        }
        rest
    }
}
