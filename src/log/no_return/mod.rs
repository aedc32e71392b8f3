//! No-return codes: the values that a laser writes for a missing return, found in the histogram of its ranges.
//!
//! The rule, from the largest range downwards. A value is a code if
//! 1. it came at least 4 times, and 6 times as often as all but four of the values just below it (up to 16 of them, within 2 % of the
//!    value or 16 steps of the log's own grid of values, whichever is more; four, because codes have company);
//! 2. it came from directions too far apart for one flat wall to give the same range in all of them, as it does to a parked robot:
//!    among the beams, or in the world, as a beam that is blind for good has it on a robot that turns;
//! 3. ranges between it and the code above it, or the largest range, are at most a quarter as many: it stands at or beyond their end;
//! 4. there are at least five other values below it: a log of one range alone tells nothing.

use std::f64::consts::{PI, TAU};

/// Width of a bin, metres.
const BIN_WIDTH: f64 = 0.001;
/// Ranges beyond this are counted together, metres.
const MAX_BIN_RANGE: f64 = 100.0;
/// The smallest count of a code.
const MIN_COUNT: u64 = 4;
/// The smallest ratio of a code's count to those of its neighbours, …
const MIN_RATIO: u64 = 6;
/// … all but this number of them, …
const EXCEPTIONS: usize = 4;
/// … of the nearest values below it, at most this number.
const NEIGHBOURS: usize = 16;
/// Sectors of directions that are distinguished.
const SECTORS: u32 = 64;

/// The readings of one range.
#[derive(Debug, Clone, Copy, Default)]
struct Bin {
    count: u64,
    /// The smallest of them, metres.
    least: f64,
    /// Bit sets of their sectors: among the beams, and in the world.
    directions: u64,
    bearings: u64,
}

/// A histogram of a laser's ranges, with the directions of each range.
#[derive(Debug, Clone)]
pub(super) struct RangeHistogram {
    beams: u32,
    bins: Vec<Bin>,
    /// Readings that are numbers.
    pub all: u64,
    /// Readings of 0 or less.
    pub none: u64,
    /// Readings beyond the last bin.
    far: u64,
}

/// A range that means no return.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NoReturnCode {
    /// Metres.
    pub range: f64,
    /// Readings of this range.
    pub count: u64,
}

impl RangeHistogram {
    /// An empty histogram of a laser with `beams` beams.
    pub fn of(beams: u32) -> RangeHistogram {
        RangeHistogram { beams: beams.max(1), bins: Vec::new(), all: 0, none: 0, far: 0 }
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
        if range > MAX_BIN_RANGE {
            self.far += 1;
            return;
        }
        let at = (range / BIN_WIDTH).round() as usize;
        if at >= self.bins.len() {
            self.bins.resize(at + 1, Bin::default());
        }
        if let Some(bin) = self.bins.get_mut(at) {
            bin.least = if bin.count == 0 { range } else { bin.least.min(range) };
            bin.count += 1;
            let direction = beam as u64 * u64::from(self.beams.min(SECTORS)) / u64::from(self.beams);
            bin.directions |= 1 << direction.min(63);
            if let Some(heading) = heading {
                // Half a circle of beams is near enough to tell one wall from many.
                let turns = (heading + PI * beam as f64 / f64::from(self.beams)) / TAU;
                bin.bearings |= 1 << ((turns.rem_euclid(1.0) * f64::from(SECTORS)) as u32).min(63);
            }
        }
    }

    /// The codes, the largest first; `step` is the angle from one beam to the next, radians.
    pub fn codes(&self, step: f64) -> Vec<NoReturnCode> {
        let values: Vec<(usize, Bin)> = self.bins.iter().copied().enumerate().filter(|(_, b)| b.count > 0).collect();
        let mut gaps: Vec<usize> = values.windows(2).map(|w| w[1].0 - w[0].0).collect();
        gaps.sort_unstable();
        let grid = gaps.get(gaps.len() / 2).copied().unwrap_or(1);
        let apart = step.abs() * f64::from(self.beams) / f64::from(self.beams.min(SECTORS));
        let (mut codes, mut between) = (Vec::new(), 0);
        for (i, (at, bin)) in values.iter().enumerate().skip(EXCEPTIONS + 1).rev() {
            let window = (NEIGHBOURS * grid).max(at / 50);
            let mut below: Vec<u64> = values[i.saturating_sub(NEIGHBOURS)..i]
                .iter()
                .filter(|v| at - v.0 <= window)
                .map(|v| v.1.count)
                .collect();
            below.sort_unstable_by(|a, b| b.cmp(a));
            let usual = below.get(EXCEPTIONS).copied().unwrap_or(0);
            // A wall at distance D is met within one step of the grid over ±√(2 step / D); twice that for the noise.
            let wall = 4.0 * (2.0 * grid as f64 / *at as f64).sqrt();
            let directions = u64::from(bin.directions.count_ones());
            let wide = |directions: u64, apart: f64| {
                directions >= ((wall / apart.max(1e-6)) as u64 + 3).min((bin.count / 2).max(3))
            };
            let bearings = u64::from(bin.bearings.count_ones());
            let anywhere = wide(directions, apart) || wide(bearings, TAU / f64::from(SECTORS));
            if bin.count >= MIN_COUNT.max(MIN_RATIO * usual) && anywhere && between <= bin.count / 4 {
                codes.push(NoReturnCode { range: bin.least, count: bin.count });
                between = 0;
            } else {
                between += bin.count;
            }
        }
        codes
    }

    /// The number of readings at or beyond a range, metres, and the most frequent of these ranges.
    pub fn beyond(&self, range: f64) -> (u64, f64) {
        let at = self.bins.iter().filter(|b| b.count > 0 && b.least >= range);
        let kept = self.far + at.clone().map(|b| b.count).sum::<u64>();
        (kept, at.max_by_key(|b| b.count).map_or(range, |b| b.least))
    }
}

#[cfg(test)]
mod tests;
