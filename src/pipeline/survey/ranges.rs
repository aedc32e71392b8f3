//! Checks of a log's ranges against its sensors' limits: measured ranges beyond `r_max`, and many ranges of one value at the end of the
//! scale, which most likely stand for a missing echo.

use crate::log::reading::{Outcome, Reading, Record, Unused};
use crate::sensor::{Kind, Sensor};
use std::collections::{BTreeMap, BTreeSet};

/// The share of a sensor's ranges from which a warning is given.
const SHARE: f64 = 0.05;
/// The number of readings from which a warning is given.
const FEWEST: u64 = 20;
/// So many different ranges beyond `r_max` are measurements, not codes.
const MEASURED: usize = 16;
/// The number of distinct largest ranges that are counted.
const LARGEST: usize = 16;
/// Ranges of so many times `r_max` are most likely in another unit.
const OTHER_UNIT: f64 = 10.0;
/// The largest range is suspect if it is so many times as frequent as any of the next largest.
const PEAK: u64 = 5;

/// Statistics of one sensor's ranges.
#[derive(Debug, Clone, Default)]
struct SensorRanges {
    /// Finite ranges, from `r_min` on.
    finite: u64,
    /// Readings of 0.
    zeros: u64,
    /// Readings that the log itself marks as without echo.
    silent: u64,
    /// Finite ranges beyond `r_max`: how many, the largest, and some of their values, mm.
    beyond: u64,
    farthest: f64,
    values: BTreeSet<u64>,
    /// The largest ranges of hits, as the bits of metres, each with its number of readings.
    largest: BTreeMap<u64, u64>,
    /// The least of `largest` once it is full; 0 before.
    least: u64,
}

/// The checks of all sensors of a log.
#[derive(Debug, Clone)]
pub(super) struct RangeChecks(Vec<SensorRanges>);

impl RangeChecks {
    /// Checks for so many sensors.
    pub fn of(sensors: usize) -> RangeChecks {
        RangeChecks(vec![SensorRanges::default(); sensors])
    }

    /// Adds a record and its judgement. The log's reader has checked that its sensor exists.
    pub fn add(&mut self, record: &Record, sensor: &Sensor, judged: &Result<Reading, Unused>) {
        let ranges = &mut self.0[record.sensor as usize];
        let z = record.range;
        if z == f64::INFINITY {
            ranges.silent += 1;
            return;
        }
        ranges.zeros += u64::from(z == 0.0);
        if !(z.is_finite() && z >= sensor.r_min) {
            return;
        }
        ranges.finite += 1;
        if z > sensor.r_max {
            ranges.beyond += 1;
            ranges.farthest = ranges.farthest.max(z);
            if ranges.values.len() < MEASURED {
                ranges.values.insert((1000.0 * z) as u64);
            }
        } else if matches!(judged, Ok(Reading { outcome: Outcome::Hit, .. }) | Err(Unused::BeyondHitRange)) {
            ranges.count_largest(z);
        }
    }

    /// The warnings, in whole sentences that say what to do. `r_max_set`: the user has set `r_max`.
    pub fn warnings(&self, sensors: &[Sensor], r_max_set: bool) -> Vec<String> {
        let mut warnings = Vec::new();
        for (ranges, sensor) in self.0.iter().zip(sensors) {
            warnings.extend(ranges.beyond_r_max(sensor).filter(|_| !r_max_set));
            warnings.extend(ranges.peak_at_end(sensor));
            warnings.extend(ranges.zeros(sensor));
        }
        // The sensors of a ring mostly share one cause.
        const SHOWN: usize = 3;
        if warnings.len() > SHOWN + 1 {
            let more = warnings.len() - SHOWN;
            warnings.truncate(SHOWN);
            warnings.push(format!("{more} more sensors are like these"));
        }
        warnings
    }
}

impl SensorRanges {
    /// Counts a range among the largest. The bits of positive numbers are ordered as the numbers are.
    fn count_largest(&mut self, z: f64) {
        let bits = z.to_bits();
        if bits < self.least {
            return;
        }
        *self.largest.entry(bits).or_default() += 1;
        if self.largest.len() > LARGEST {
            self.largest.pop_first();
        }
        if self.largest.len() == LARGEST {
            self.least = self.largest.keys().next().copied().unwrap_or_default();
        }
    }

    /// A warning about measured ranges beyond `r_max`.
    fn beyond_r_max(&self, sensor: &Sensor) -> Option<String> {
        let many = self.beyond as f64 >= SHARE * self.finite as f64 && self.values.len() == MEASURED;
        many.then(|| {
            let (id, n, of, far) = (&sensor.id, self.beyond, self.finite, self.farthest);
            if far >= OTHER_UNIT * sensor.r_max {
                return format!(
                    "{n} of {of} ranges of sensor {id} lie beyond its r_max of {} m, up to {far:.0}: most likely they are not metres; \
                     say their unit (range:cm or range:mm in --columns), or convert them",
                    brief(sensor.r_max)
                );
            }
            format!(
                "{n} of {of} ranges of sensor {id} lie beyond its r_max of {} m, up to {far:.1} m, and count as without echo; \
                 if the sensor sees that far, say so: --set r_max={}",
                brief(sensor.r_max),
                far.ceil()
            )
        })
    }

    /// A warning about ranges of 0.
    fn zeros(&self, sensor: &Sensor) -> Option<String> {
        let (zeros, all) = (self.zeros, self.finite + self.zeros);
        let many =
            zeros >= FEWEST && zeros as f64 >= SHARE * all as f64 && sensor.kind == Kind::Sonar && sensor.r_min > 0.0;
        many.then(|| {
            format!(
                "{zeros} of {all} ranges of sensor {} are 0, which many sonars write where nothing was heard: they are rejected, and free \
                 nothing",
                sensor.id
            )
        })
    }

    /// A warning about many readings of just the largest range.
    fn peak_at_end(&self, sensor: &Sensor) -> Option<String> {
        let mut largest = self.largest.iter().rev();
        let (bits, times) = largest.next()?;
        let next = largest.map(|(_, n)| *n).max()?;
        let peak = self.silent == 0
            && *times >= FEWEST
            && *times as f64 >= SHARE * self.finite as f64
            && *times >= PEAK * next;
        peak.then(|| {
            let (id, top) = (&sensor.id, brief(f64::from_bits(*bits)));
            format!(
                "{times} of {} ranges of sensor {id} are just {top} m, its largest range: most likely they mean that nothing \
                 was heard; if so, say so: --set r_max={top} --set at_r_max=no_echo",
                self.finite
            )
        })
    }
}

/// Formats metres to the millimetre, without trailing zeros.
fn brief(metres: f64) -> String {
    let text = format!("{metres:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}
