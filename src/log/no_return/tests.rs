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
    fn ranges(&self) -> RangeHistogram {
        let mut random = Random(7);
        let mut ranges = RangeHistogram::of(self.beams);
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
    let mut tank = RangeHistogram::of(180);
    for k in 0..3600 {
        tank.add(k % 180, 3.0, Some(0.0));
    }
    assert_eq!(tank.codes(PI / 180.0), []);
    // Nothing, not a number, beyond all scales.
    let mut odd = RangeHistogram::of(2);
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
