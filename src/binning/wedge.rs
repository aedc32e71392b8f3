//! The wedges of a laser scan, for the laser truth: a beam's wedge holds the bearings to which the beam is nearest.
//!
//! A beam's wedge ends at the bisectors with its neighbours, or 0.51 beam spacings from the beam where it has no neighbour. The
//! common edge of two neighbours is computed as one number, so their snapped edges coincide and a cell belongs to one beam.

use crate::binning::snap::Edges;
use crate::log::reading::Record;
use crate::sensor::Sensor;

/// The largest distance between neighbouring beams, in beam spacings.
const GAP: f64 = 1.02;
/// Distance from a beam to its wedge's edge where it has no neighbour, in beam spacings.
const ALONE: f64 = 0.51;

/// The (left, right) edges of each record of one scan, radians in the world frame, in the records' order. A record whose
/// reading is not used still bounds the wedges of its neighbours.
pub fn edges(scan: &[Record], sensors: &[Sensor]) -> Vec<Edges> {
    // Bearings are relative to the robot. The records are sorted by sensor, then by bearing from right to left.
    let bearing = |k: usize| {
        (scan[k].pose.heading - scan[k].robot.heading + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
    };
    let mut order: Vec<usize> = (0..scan.len()).collect();
    order.sort_by(|&a, &b| scan[a].sensor.cmp(&scan[b].sensor).then(bearing(a).total_cmp(&bearing(b))));
    let mut edges = vec![(0.0, 0.0); scan.len()];
    for (at, &k) in order.iter().enumerate() {
        let spacing = 2.0 * sensors[scan[k].sensor as usize].half_width;
        let heading = scan[k].pose.heading;
        let edge = |other: Option<&usize>, side: f64| {
            let near = other.filter(|&&o| scan[o].sensor == scan[k].sensor).map(|&o| (bearing(o) - bearing(k)) * side);
            match near {
                // The edge is always computed from the right beam of the two, so that both beams get the same number.
                Some(gap) if gap <= GAP * spacing => {
                    let (right, left) = if side > 0.0 { (k, other) } else { (other.copied().unwrap_or(k), Some(&k)) };
                    let gap = left.map_or(0.0, |&l| bearing(l) - bearing(right));
                    scan[right].pose.heading + gap / 2.0
                }
                _ => heading + side * ALONE * spacing,
            }
        };
        edges[k] = (edge(order.get(at + 1), 1.0), edge(at.checked_sub(1).and_then(|p| order.get(p)), -1.0));
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::reading::Pose;
    use crate::sensor::{AtMax, Kind};

    fn fan(bearings: &[f64]) -> (Vec<Record>, Vec<Sensor>) {
        let sensor = Sensor {
            id: "laser".into(),
            kind: Kind::Laser,
            x: 0.0,
            y: 0.0,
            axis: 0.0,
            half_width: 0.05,
            r_min: 0.05,
            r_max: 20.0,
            at_r_max: AtMax::NoEcho,
            hit_range: 20.0,
            no_echo_range: 0.0,
            epsilon: None,
        };
        let robot = Pose { x: 0.0, y: 0.0, heading: 3.0 };
        let record = |b: &f64| Record {
            t: 0.0,
            scan: 0,
            sensor: 0,
            robot,
            pose: robot.compose(0.0, 0.0, *b),
            range: 1.0,
            label: None,
            line: 1,
        };
        (bearings.iter().map(record).collect(), vec![sensor])
    }

    #[test]
    fn neighbours_share_an_edge_and_ends_reach_out() {
        // The bearings are out of order on purpose, with a gap between 0.1 and 0.3.
        let (scan, sensors) = fan(&[0.1, -0.1, 0.0, 0.3]);
        let edges = edges(&scan, &sensors);
        let near = |a: f64, b: f64| assert!((a - 3.0 - b).abs() < 1e-12, "{a} {b}");
        near(edges[1].0, -0.05);
        near(edges[2].1, -0.05);
        assert_eq!(edges[1].0.to_bits(), edges[2].1.to_bits());
        assert_eq!(edges[2].0.to_bits(), edges[0].1.to_bits());
        near(edges[1].1, -0.1 - 0.051);
        near(edges[0].0, 0.1 + 0.051);
        near(edges[3].1, 0.3 - 0.051);
        near(edges[3].0, 0.3 + 0.051);
    }
}
