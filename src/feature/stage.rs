//! The stage: scans in, updates out, each when its features are as good as they get.

use super::corner::{corners, cut};
use super::decide::{Case, decide};
use super::draw::{Cells, draw};
use super::features::Known;
use super::limit::View;
use super::line::lines;
use super::merged::Merged;
use super::near::Near;
use super::phantom::drop_phantoms;
use super::ping::Ping;
use super::rcd::{Rcd, regions};
use super::ring::Runs;
use super::rules::Rules;
use super::update::Update;
use super::vote::vote;
use super::wall::gather;
use crate::world::plane::{Point, distance};
use std::collections::{BTreeMap, BTreeSet, HashSet, VecDeque};

/// Readings of one sensor in a scan from which on it is taken for a circular one.
const CIRCULAR: usize = 8;
/// Held readings are released together, as far as their scans lie within this, metres.
const WINDOW: f64 = 0.5;
/// Features are looked for so much farther than a sensor reaches, metres.
const BEYOND: f64 = 1.0;
/// With more regions than this the features of the whole log are found block by block: so many squares a block, and so much
/// around it, metres.
const LARGE: usize = 2000;
const BLOCK: f64 = 8.0;
const MARGIN: f64 = 6.0;
/// Between scans no farther apart the robot went straight, metres.
const LONGEST_STEP: f64 = 2.0;
/// The most readings that are held.
const MOST: usize = 1 << 17;
/// Regions from one place of one thing tell no more than the first: edges of these places, metres.
const SAME_CENTRE: f64 = 0.3;
const SAME_FOOT: f64 = 0.1;

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
    regions: Near<Rcd>,
    known: HashSet<[i64; 4]>,
    runs: Runs,
    path: Near<[Point; 2]>,
    walked: HashSet<[i64; 4]>,
    last: Option<Point>,
    travelled: f64,
    scans: u64,
    held: VecDeque<Held>,
    count: usize,
    /// What became of the readings so far.
    pub tally: Tally,
}

/// Whole numbers of squares.
fn squares(at: Point, edge: f64) -> [i64; 2] {
    [at.0, at.1].map(|v| (v / edge).floor() as i64)
}

fn both([a, b]: [i64; 2], [c, d]: [i64; 2]) -> [i64; 4] {
    [a, b, c, d]
}

impl Stage {
    /// A stage that knows nothing.
    pub fn new(rules: Rules, cells: Cells) -> Stage {
        Stage {
            rules,
            cells,
            regions: Near::default(),
            known: HashSet::new(),
            runs: Runs::default(),
            path: Near::default(),
            walked: HashSet::new(),
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
        self.walk(at);
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

    /// Every feature of the log so far: of a large one those found square by square.
    pub fn known(&self) -> Known {
        const ALL: [f64; 4] = [f64::NEG_INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY];
        if self.regions.len() <= LARGE {
            return self.around(ALL).0;
        }
        let mut all = Merged::new(self.regions.all().to_vec());
        let (middles, edge) = self.regions.squares();
        // Some squares at a time: most of what is looked at for one is looked at for those beside it, too.
        let block = BLOCK * edge;
        let blocks: BTreeSet<[i64; 2]> = middles.iter().map(|m| squares(*m, block)).collect();
        for [i, j] in blocks {
            let [x, y] = [i, j].map(|v| v as f64 * block);
            let place = [x - MARGIN, y - MARGIN, x + block + MARGIN, y + block + MARGIN];
            let (known, ids) = self.around(place);
            all.add(&known, &ids, |at| squares(at, block) == [i, j]);
        }
        all.known
    }

    fn walk(&mut self, at: Point) {
        if let Some(last) = self.last.replace(at) {
            self.travelled += distance(last, at);
            // Of the way between places far apart nothing is known.
            let near = distance(last, at) <= LONGEST_STEP;
            if near && self.walked.insert(both(squares(last, 0.1), squares(at, 0.1))) {
                self.path.push(at, [last, at]);
            }
        }
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
        if self.known.insert(both(squares(rcd.centre, SAME_CENTRE), squares(rcd.foot, SAME_FOOT))) {
            self.regions.push(rcd.foot, rcd);
        }
    }

    /// The features in a box x0, y0, x1, y1, and which regions their own are.
    fn around(&self, place: [f64; 4]) -> (Known, Vec<u32>) {
        let ids = self.regions.within(place);
        let mut rcds: Vec<Rcd> = ids.iter().map(|k| self.regions.all()[*k as usize].clone()).collect();
        let path: Vec<[Point; 2]> = self.path.within(place).iter().map(|k| self.path.all()[*k as usize]).collect();
        let rules = &self.rules;
        if rules.points && !rules.paper {
            vote(&mut rcds);
        }
        let mut features = gather(&mut rcds, rules);
        if rules.phantoms && !rules.paper {
            drop_phantoms(&mut features, &rcds, &path);
        }
        if rules.corners {
            features.corners = corners(&features, &rcds, &path, rules);
            if rules.phantoms && !rules.paper {
                // Legs hide phantoms, too, which may have stood in the way of corners.
                drop_phantoms(&mut features, &rcds, &path);
                features.corners = corners(&features, &rcds, &path, rules);
            }
            cut(&mut features);
        }
        if rules.lines && !rules.paper {
            features.lines = lines(&features, &rcds, &path);
        }
        (Known { features, regions: rcds }, ids)
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
        let pings = || window.iter().flat_map(|h| &h.pings);
        let reach = pings().map(|p| p.reach + distance(p.at, p.centre())).fold(0.0, f64::max) + BEYOND;
        let mut place = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        for (x, y) in window.iter().map(|h| h.at) {
            place =
                [place[0].min(x - reach), place[1].min(y - reach), place[2].max(x + reach), place[3].max(y + reach)];
        }
        let (Known { features, .. }, _) = self.around(place);
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
