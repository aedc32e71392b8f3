//! No-return codes: the values that a laser writes where nothing came back, found in the histogram of its ranges.
//!
//! The rule, from the largest range downwards. A value is a code if
//! 1. it came at least 4 times, and 6 times as often as all but four of the values just below it (up to 16 of them, within 2 % of the
//!    value or 16 steps of the log's own grid of values, whichever is more; four, because codes have company);
//! 2. it came from directions too far apart for one flat wall to give the same range in all of them, as it does to a parked robot:
//!    among the beams, or in the world, as a beam that is blind for good has it on a robot that turns;
//! 3. ranges between it and the code above it, or the largest range, are at most a quarter as many: it stands at or beyond their end;
//! 4. there are at least five other values below it: a log of one range alone tells nothing.

use std::f64::consts::{PI, TAU};

/// Ranges are kept apart by this, metres.
const BIN: f64 = 0.001;
/// Ranges beyond are counted, but not kept apart, metres.
const FARTHEST: f64 = 100.0;
/// A code came so many times at least …
const FEWEST: u64 = 4;
/// … and so many times as often …
const TIMES: u64 = 6;
/// … as all but these …
const COMPANY: usize = 4;
/// … of the values below it, at most so many.
const BELOW: usize = 16;
/// Directions that are told apart.
const DIRECTIONS: u32 = 64;

/// The readings of one range.
#[derive(Debug, Clone, Copy, Default)]
struct Bin {
    count: u64,
    /// The smallest of them, metres.
    least: f64,
    /// From which directions they came, a bit each: among the beams, and in the world.
    directions: u64,
    bearings: u64,
}

/// A laser's ranges: how often each came, and from where.
#[derive(Debug, Clone)]
pub(super) struct Ranges {
    beams: u32,
    bins: Vec<Bin>,
    /// Readings, those that are not numbers left out.
    pub all: u64,
    /// Readings of 0 or less.
    pub none: u64,
    /// Readings beyond what is kept apart.
    far: u64,
}

/// A value that stands for no return.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Code {
    /// Metres.
    pub range: f64,
    /// How many readings have it.
    pub count: u64,
}

impl Ranges {
    /// None yet, of a laser with so many beams.
    pub fn of(beams: u32) -> Ranges {
        Ranges { beams: beams.max(1), bins: Vec::new(), all: 0, none: 0, far: 0 }
    }

    /// Adds a beam's range, metres; `heading` is the laser's, radians, where it is known.
    pub fn add(&mut self, beam: usize, range: f64, heading: Option<f64>) {
        if range.is_nan() {
            return;
        }
        self.all += 1;
        if range <= 0.0 {
            self.none += 1;
            return;
        }
        if range > FARTHEST {
            self.far += 1;
            return;
        }
        let at = (range / BIN).round() as usize;
        if at >= self.bins.len() {
            self.bins.resize(at + 1, Bin::default());
        }
        if let Some(bin) = self.bins.get_mut(at) {
            bin.least = if bin.count == 0 { range } else { bin.least.min(range) };
            bin.count += 1;
            let direction = beam as u64 * u64::from(self.beams.min(DIRECTIONS)) / u64::from(self.beams);
            bin.directions |= 1 << direction.min(63);
            if let Some(heading) = heading {
                // Half a circle of beams is near enough to tell one wall from many.
                let turns = (heading + PI * beam as f64 / f64::from(self.beams)) / TAU;
                bin.bearings |= 1 << ((turns.rem_euclid(1.0) * f64::from(DIRECTIONS)) as u32).min(63);
            }
        }
    }

    /// The codes, the largest first; `step` is the angle from one beam to the next, radians.
    pub fn codes(&self, step: f64) -> Vec<Code> {
        let values: Vec<(usize, Bin)> = self.bins.iter().copied().enumerate().filter(|(_, b)| b.count > 0).collect();
        let mut gaps: Vec<usize> = values.windows(2).map(|w| w[1].0 - w[0].0).collect();
        gaps.sort_unstable();
        let grid = gaps.get(gaps.len() / 2).copied().unwrap_or(1);
        let apart = step.abs() * f64::from(self.beams) / f64::from(self.beams.min(DIRECTIONS));
        let (mut codes, mut between) = (Vec::new(), 0);
        for (i, (at, bin)) in values.iter().enumerate().skip(COMPANY + 1).rev() {
            let window = (BELOW * grid).max(at / 50);
            let mut below: Vec<u64> =
                values[i.saturating_sub(BELOW)..i].iter().filter(|v| at - v.0 <= window).map(|v| v.1.count).collect();
            below.sort_unstable_by(|a, b| b.cmp(a));
            let usual = below.get(COMPANY).copied().unwrap_or(0);
            // A wall at distance D is met within one step of the grid over ±√(2 step / D); twice that for the noise.
            let wall = 4.0 * (2.0 * grid as f64 / *at as f64).sqrt();
            let directions = u64::from(bin.directions.count_ones());
            let wide = |directions: u64, apart: f64| {
                directions >= ((wall / apart.max(1e-6)) as u64 + 3).min((bin.count / 2).max(3))
            };
            let bearings = u64::from(bin.bearings.count_ones());
            let anywhere = wide(directions, apart) || wide(bearings, TAU / f64::from(DIRECTIONS));
            if bin.count >= FEWEST.max(TIMES * usual) && anywhere && between <= bin.count / 4 {
                codes.push(Code { range: bin.least, count: bin.count });
                between = 0;
            } else {
                between += bin.count;
            }
        }
        codes
    }

    /// How many readings are at or beyond a range, metres, and the commonest of them.
    pub fn beyond(&self, range: f64) -> (u64, f64) {
        let at = self.bins.iter().filter(|b| b.count > 0 && b.least >= range);
        let kept = self.far + at.clone().map(|b| b.count).sum::<u64>();
        (kept, at.max_by_key(|b| b.count).map_or(range, |b| b.least))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Numbers from 0 to 1 that look random and are always the same.
    struct Random(u64);
    impl Random {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 40) as f64 / f64::from(1 << 24)
        }
    }

    /// A room of 12 m × 9 m.
    struct Room {
        beams: u32,
        scans: usize,
        grid: f64,
        parked: bool,
        /// The share of readings that are codes, and these.
        share: f64,
        codes: &'static [f64],
        /// Ranges are clipped to this.
        cap: f64,
        /// Beams that are blind for good.
        blind: &'static [u32],
    }

    const PLAIN: Room =
        Room { beams: 181, scans: 40, grid: 0.001, parked: false, share: 0.0, codes: &[50.0], cap: 1e3, blind: &[] };

    impl Room {
        fn ranges(&self) -> Ranges {
            let mut random = Random(7);
            let mut ranges = Ranges::of(self.beams);
            let (mut x, mut y, mut heading) = (4.0, 3.0, 0.3);
            for scan in 0..self.scans {
                for k in 0..self.beams {
                    let (s, c) = (heading - PI / 2.0 + f64::from(k) * self.step()).sin_cos();
                    let z = f64::min(
                        if c > 0.0 { (12.0 - x) / c } else { -x / c },
                        if s > 0.0 { (9.0 - y) / s } else { -y / s },
                    );
                    let z = ((z + 0.01 * (random.next() - 0.5)) / self.grid).round() * self.grid;
                    let code = self.codes[(random.next() * self.codes.len() as f64) as usize];
                    let blind = self.blind.contains(&k);
                    let z = if blind || random.next() < self.share { code } else { z.min(self.cap) };
                    ranges.add(k as usize, z, Some(heading));
                }
                if !self.parked {
                    let turn = 0.05 * scan as f64;
                    (x, y, heading) = (5.0 + 2.0 * turn.sin(), 4.0 + 1.5 * (1.3 * turn).cos(), 0.3 + turn);
                }
            }
            ranges
        }

        fn step(&self) -> f64 {
            PI / f64::from(self.beams - 1)
        }

        fn found(&self) -> Vec<f64> {
            self.ranges().codes(self.step()).iter().map(|c| (c.range * 1000.0).round() / 1000.0).collect()
        }
    }

    #[test]
    fn codes_of_many_kinds() {
        for codes in [
            &[51.16, 51.15, 51.14, 50.0][..],
            &[32.767, 32.763, 32.759],
            &[81.91, 81.87, 81.83],
            &[81.83],
            &[50.0],
            &[20.47, 16.0],
        ] {
            for scans in [10, 40, 400] {
                assert_eq!(Room { codes, scans, share: 0.1, ..PLAIN }.found(), codes, "{scans} scans");
            }
            assert_eq!(Room { codes, scans: 3, share: 0.2, ..PLAIN }.found(), codes, "3 scans");
        }
    }

    #[test]
    fn on_any_grid_moving_or_parked() {
        for grid in [0.001, 0.01, 0.05, 0.1] {
            for parked in [false, true] {
                for (beams, scans) in [(91, 20), (181, 5), (361, 60)] {
                    let room = Room { grid, parked, beams, scans, ..PLAIN };
                    assert_eq!(room.found(), [] as [f64; 0], "{grid} {parked} {beams} {scans}");
                    let room = Room { share: 0.1, codes: &[32.767, 32.763], ..room };
                    assert_eq!(room.found(), [32.767, 32.763], "{grid} {parked} {beams} {scans}");
                }
            }
        }
    }

    #[test]
    fn blind_beams_of_a_robot_that_turns() {
        let blind = Room { blind: &[40, 41, 42], scans: 60, ..PLAIN };
        assert_eq!(blind.found(), [50.0]);
        // Parked, the same is what a wall behind a gap gives.
        assert_eq!(Room { parked: true, ..blind }.found(), [] as [f64; 0]);
    }

    #[test]
    fn a_clipped_range() {
        assert_eq!(Room { cap: 6.0, grid: 0.01, ..PLAIN }.found(), [6.0]);
        assert_eq!(Room { cap: 8.183, scans: 8, ..PLAIN }.found(), [8.183]);
    }

    #[test]
    fn a_code_below_the_tail() {
        // A few real ranges lie far beyond the code.
        let mut ranges = Room { share: 0.1, codes: &[32.767], ..PLAIN }.ranges();
        for k in 0..60 {
            ranges.add(k, 33.0 + 0.31 * k as f64, None);
        }
        let codes = ranges.codes(PLAIN.step());
        assert_eq!(codes.iter().map(|c| c.range).collect::<Vec<_>>(), [32.767]);
        // As many as its own: then it is not their end.
        for k in 0..2000 {
            ranges.add(k % 181, 33.0 + 0.013 * k as f64, None);
        }
        assert_eq!(ranges.codes(PLAIN.step()), []);
    }

    #[test]
    fn walls_are_no_codes() {
        // One far wall through a door, always in the same few beams.
        let mut ranges = Room { parked: true, scans: 300, ..PLAIN }.ranges();
        for _ in 0..300 {
            for k in 90..93 {
                ranges.add(k, 25.37, Some(0.0));
            }
        }
        assert_eq!(ranges.codes(PLAIN.step()), []);
        // A round tank: nothing but its wall.
        let mut tank = Ranges::of(180);
        for k in 0..3600 {
            tank.add(k % 180, 3.0, Some(0.0));
        }
        assert_eq!(tank.codes(PI / 180.0), []);
        // Nothing, not a number, beyond all scales.
        let mut odd = Ranges::of(2);
        for z in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300] {
            odd.add(0, z, None);
        }
        assert_eq!((odd.all, odd.none, odd.codes(1.0)), (4, 2, vec![]));
    }

    #[test]
    fn how_many() {
        let ranges = Room { share: 0.1, codes: &[81.83], ..PLAIN }.ranges();
        let code = ranges.codes(PLAIN.step())[0];
        assert_eq!(ranges.beyond(80.0), (code.count, 81.83));
        assert!((650..800).contains(&code.count), "{}", code.count);
    }
}
