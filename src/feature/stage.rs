//! The stage: pings in, updates out, each when its features are as good as they get.

use super::corner::{corners, cut};
use super::decide::{Case, decide};
use super::draw::{Cells, draw};
use super::features::Features;
use super::limit::View;
use super::phantom::drop_phantoms;
use super::ping::Ping;
use super::rcd::{Rcd, regions};
use super::rules::Rules;
use super::update::Update;
use super::vote::vote;
use super::wall::gather;
use crate::world::plane::{Point, distance};
use std::collections::VecDeque;

/// What became of the readings.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Cases {
    /// (i) to (iv).
    pub counts: [u64; 4],
}

/// A scan that waits.
struct Held {
    pings: Vec<Ping>,
    at: Point,
    travelled: f64,
}

/// The stage.
pub struct Stage {
    rules: Rules,
    cells: Cells,
    rcds: Vec<Rcd>,
    path: Vec<Point>,
    travelled: f64,
    held: VecDeque<Held>,
    /// What became of the readings.
    pub cases: Cases,
}

impl Stage {
    /// A stage with nothing known.
    pub fn new(rules: Rules, cells: Cells) -> Stage {
        Stage { rules, cells, rcds: Vec::new(), path: Vec::new(), travelled: 0.0, held: VecDeque::new(), cases: Cases::default() }
    }

    /// Takes a scan.
    pub fn scan(&mut self, pings: Vec<Ping>, out: &mut Vec<Update>) {
        let Some(first) = pings.first() else { return };
        let at = first.centre();
        if let Some(last) = self.path.last() {
            self.travelled += distance(*last, at);
        }
        self.path.push(at);
        self.rcds.extend(regions(&pings));
        self.held.push_back(Held { pings, at, travelled: self.travelled });
        if self.held.front().is_some_and(|h| self.travelled - h.travelled >= self.rules.hold + 0.5) {
            self.release(self.rules.hold, out);
        }
    }

    /// Lets go of what is left.
    pub fn finish(&mut self, out: &mut Vec<Update>) {
        self.release(f64::NEG_INFINITY, out);
    }

    /// Everything known now.
    pub fn features(&self) -> (Features, Vec<Rcd>) {
        let mut rcds = self.rcds.clone();
        if self.rules.points {
            vote(&mut rcds);
        }
        let mut features = gather(&mut rcds);
        if self.rules.phantoms {
            drop_phantoms(&mut features, &rcds, &self.path);
        }
        if self.rules.corners {
            features.corners = corners(&features, &rcds, &self.path);
            if self.rules.phantoms {
                drop_phantoms(&mut features, &rcds, &self.path);
                features.corners = corners(&features, &rcds, &self.path);
            }
            cut(&mut features);
        }
        features.lines = super::line::lines(&features, &rcds, &self.path);
        (features, rcds)
    }

    fn release(&mut self, hold: f64, out: &mut Vec<Update>) {
        let (features, _) = self.features();
        while let Some(held) = self.held.front().filter(|h| self.travelled - h.travelled >= hold) {
            let reach = held.pings.iter().map(|p| p.r_max).fold(0.0, f64::max) + 1.0;
            let view = View::of(&features, held.at, reach, self.cells.resolution);
            for ping in &held.pings {
                let decision = decide(ping, &features, &view, &self.rules);
                let case = match decision.case {
                    Case::Associated => 0,
                    Case::Outlier => 1,
                    Case::Behind => 2,
                    Case::Routine => 3,
                };
                self.cases.counts[case] += 1;
                out.extend(draw(ping, &decision, &features, self.cells));
            }
            self.held.pop_front();
        }
    }
}
