//! What a log's ranges say against its sensors' limits: real ranges beyond `r_max`, and heaps of one value at the end of the scale,
//! which are most likely silence in disguise.

use crate::log::reading::{Outcome, Reading, Record, Unused};
use crate::sensor::{Kind, Sensor};
use std::collections::{BTreeMap, BTreeSet};

/// Share of a sensor's ranges from which a doubt is told.
const SHARE: f64 = 0.05;
/// So many readings at least.
const FEWEST: u64 = 20;
/// So many different ranges beyond `r_max` are no codes, but measurements.
const MEASURED: usize = 16;
/// Largest ranges that are kept apart, with how often each came.
const LARGEST: usize = 16;
/// So many times as far as r_max ranges are most likely in another unit.
const OTHER_UNIT: f64 = 10.0;
/// A heap is so many times as high as any of the ranges just below it.
const HEAP: u64 = 5;

/// One sensor's ranges, in brief.
#[derive(Debug, Clone, Default)]
struct Ranges {
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
    /// The largest ranges of hits, bits of metres, with how often each came.
    largest: BTreeMap<u64, u64>,
    /// The least of them once they are as many as are kept; 0 before.
    least: u64,
}

/// What speaks against the limits of a log's sensors.
#[derive(Debug, Clone)]
pub(super) struct Doubts(Vec<Ranges>);

impl Doubts {
    /// For so many sensors.
    pub fn of(sensors: usize) -> Doubts {
        Doubts(vec![Ranges::default(); sensors])
    }

    /// Hears of a record and of what it was judged to be.
    pub fn look(&mut self, record: &Record, sensor: &Sensor, judged: &Result<Reading, Unused>) {
        let Some(ranges) = self.0.get_mut(record.sensor as usize) else { return };
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
            ranges.keep(z);
        }
    }

    /// The doubts, in whole sentences that say what to do. `r_max_set`: the user has decided where the scale ends.
    pub fn tell(&self, sensors: &[Sensor], r_max_set: bool) -> Vec<String> {
        let mut told = Vec::new();
        for (ranges, sensor) in self.0.iter().zip(sensors) {
            told.extend(ranges.exceeded(sensor).filter(|_| !r_max_set));
            told.extend(ranges.heap(sensor));
            told.extend(ranges.none(sensor));
        }
        // A ring of many sensors has one doubt, not one a sensor.
        const TOLD: usize = 3;
        if told.len() > TOLD + 1 {
            let more = told.len() - TOLD;
            told.truncate(TOLD);
            told.push(format!("{more} more sensors are like these"));
        }
        told
    }
}

impl Ranges {
    /// Keeps the largest ranges apart. For positive numbers the order of the bits is that of the values.
    fn keep(&mut self, z: f64) {
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

    fn exceeded(&self, sensor: &Sensor) -> Option<String> {
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

    fn none(&self, sensor: &Sensor) -> Option<String> {
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

    fn heap(&self, sensor: &Sensor) -> Option<String> {
        let mut largest = self.largest.iter().rev();
        let (bits, times) = largest.next()?;
        let next = largest.map(|(_, n)| *n).max()?;
        let heap = self.silent == 0
            && *times >= FEWEST
            && *times as f64 >= SHARE * self.finite as f64
            && *times >= HEAP * next;
        heap.then(|| {
            let (id, top) = (&sensor.id, brief(f64::from_bits(*bits)));
            format!(
                "{times} of {} ranges of sensor {id} are just {top} m, its largest range: most likely they mean that nothing \
                 was heard; if so, say so: --set r_max={top} --set at_r_max=no_echo",
                self.finite
            )
        })
    }
}

/// Metres to the millimetre, without needless zeros.
fn brief(metres: f64) -> String {
    let text = format!("{metres:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}
