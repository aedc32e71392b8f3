//! The stage: scans in, updates out, each when its features are as good as they get.

use super::atlas::Atlas;
use super::decide::{Case, decide};
use super::draw::{Cells, draw};
use super::features::Known;
use super::limit::View;
use super::ping::Ping;
use super::rcd::{Rcd, regions};
use super::ring::Runs;
use super::rules::Rules;
use super::update::Update;
use crate::geometry::plane::{Point, distance};
use std::collections::{BTreeMap, VecDeque};

/// Readings of one sensor in a scan from which on it is taken for a circular one.
const CIRCULAR: usize = 8;
/// Held readings are released together, as far as their scans lie within this, metres.
const WINDOW: f64 = 0.5;
/// Features are looked for so much farther than a sensor reaches, metres.
const BEYOND: f64 = 1.0;
/// The most readings that are held.
pub const MOST: usize = 1 << 16;
/// What became of the readings, and what was found.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tally {
    /// Readings of cases (i) to (iv).
    pub cases: [u64; 4],
    /// Regions of constant depth.
    pub regions: u64,
    /// The most readings that were held at once.
    pub held: u64,
}

/// Scans for which the paper holds a reading.
const SCANS: u64 = 3;

/// A scan that waits.
struct Held {
    pings: Vec<Ping>,
    at: Point,
    travelled: f64,
    /// Which scan it is.
    number: u64,
}

/// The stage.
pub struct Stage {
    rules: Rules,
    cells: Cells,
    atlas: Atlas,
    runs: Runs,
    last: Option<Point>,
    travelled: f64,
    scans: u64,
    held: VecDeque<Held>,
    count: usize,
    /// What became of the readings so far.
    pub tally: Tally,
}

impl Stage {
    /// A stage that knows nothing.
    pub fn new(rules: Rules, cells: Cells) -> Stage {
        Stage {
            rules,
            cells,
            atlas: Atlas::default(),
            runs: Runs::default(),
            last: None,
            travelled: 0.0,
            scans: 0,
            held: VecDeque::new(),
            count: 0,
            tally: Tally::default(),
        }
    }

    /// Takes a scan; updates that are ready are put out, in log order (but by the paper's rules).
    pub fn scan(&mut self, pings: Vec<Ping>, out: &mut Vec<Update>) {
        let Some(first) = pings.first() else { return };
        let at = first.centre();
        if let Some(last) = self.last.replace(at) {
            self.travelled += distance(last, at);
            self.atlas.walk(last, at);
        }
        self.look(&pings);
        self.scans += 1;
        let mut held = Held { pings, at, travelled: self.travelled, number: self.scans };
        if self.rules.paper {
            held.pings = self.at_once(&held, out);
        }
        self.count += held.pings.len();
        self.tally.held = self.tally.held.max(self.count as u64);
        self.held.push_back(held);
        let hold = self.rules.hold;
        if self.rules.paper {
            self.release(|s, h| s.scans - h.number >= SCANS, out);
        } else if self.held.front().is_some_and(|h| self.travelled - h.travelled >= hold + WINDOW) {
            self.release(|s, h| s.travelled - h.travelled >= hold, out);
        }
        if self.count > MOST {
            self.release(|s, _| s.count > MOST / 2, out);
        }
    }

    /// Lets go of what is left.
    pub fn finish(&mut self, out: &mut Vec<Update>) {
        for rcd in self.runs.finish() {
            self.keep(rcd);
        }
        self.release(|_, _| true, out);
    }

    /// Every feature of the log so far.
    pub fn known(&self) -> Known {
        self.atlas.known(&self.rules)
    }

    /// Finds the scan's regions.
    fn look(&mut self, pings: &[Ping]) {
        let mut sensors: BTreeMap<u32, Vec<Ping>> = BTreeMap::new();
        for ping in pings {
            sensors.entry(ping.record.sensor).or_default().push(*ping);
        }
        for own in sensors.into_values() {
            if own.len() >= CIRCULAR {
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
        self.tally.regions += 1;
        self.atlas.keep(rcd);
    }

    /// Releases the scans that are `ripe`, the oldest first.
    fn release(&mut self, ripe: impl Fn(&Stage, &Held) -> bool, out: &mut Vec<Update>) {
        while let Some(start) = self.held.front().filter(|h| ripe(self, h)).map(|h| h.at) {
            // Scans near each other share their features.
            let mut window = Vec::new();
            while self.held.front().is_some_and(|h| ripe(self, h) && distance(h.at, start) <= 2.0 * WINDOW) {
                let Some(held) = self.held.pop_front() else { break };
                self.count -= held.pings.len();
                window.push(held);
            }
            self.update(&window, &|_| true, out);
        }
    }

    /// The paper's rule: what a feature explains is applied at once. Gives what is left.
    fn at_once(&mut self, scan: &Held, out: &mut Vec<Update>) -> Vec<Ping> {
        self.update(std::slice::from_ref(scan), &|case| case == Case::Associated, out)
    }

    /// Decides the readings of scans near each other, and draws those whose case is `wanted`; gives the others.
    fn update(&mut self, window: &[Held], wanted: &dyn Fn(Case) -> bool, out: &mut Vec<Update>) -> Vec<Ping> {
        let aside = window.iter().flat_map(|h| h.pings.iter().map(|p| p.reach + distance(p.at, h.at)));
        let reach = aside.fold(0.0, f64::max) + BEYOND;
        let mut place = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        for (x, y) in window.iter().map(|h| h.at) {
            place =
                [place[0].min(x - reach), place[1].min(y - reach), place[2].max(x + reach), place[3].max(y + reach)];
        }
        let (Known { features, .. }, _) = self.atlas.around(place, &self.rules);
        let mut rest = Vec::new();
        for held in window {
            let view = View::of(&features, held.at, reach, self.cells.resolution);
            for ping in &held.pings {
                let decision = decide(ping, &features, &view, &self.rules);
                if wanted(decision.case) {
                    self.tally.cases[decision.case as usize] += 1;
                    out.extend(draw(ping, &decision, &features, self.cells));
                } else {
                    rest.push(*ping);
                }
            }
        }
        rest
    }
}
