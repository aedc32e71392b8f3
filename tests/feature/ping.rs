//! Which records the stage takes, and what the kernels get of them.

use echogrid::feature::Ping;
use echogrid::geometry::plane::Point;
use echogrid::log::reading::{Outcome, Pose, Record};
use echogrid::sensor::{AtMax, Kind, Sensor};

fn of(range: f64) -> Option<Ping> {
    let sensor = Sensor {
        id: "0".into(),
        kind: Kind::Sonar,
        x: 0.0,
        y: 0.0,
        axis: 0.0,
        half_width: 0.25,
        r_min: 0.2,
        r_max: 5.0,
        at_r_max: AtMax::Hit,
        hit_range: 4.0,
        no_echo_range: 0.0,
        epsilon: None,
    };
    let robot = Pose { x: 1.0, y: 2.0, heading: 0.0 };
    let pose = Pose { x: 1.1, y: 2.0, heading: std::f64::consts::FRAC_PI_2 };
    Ping::of(Record { t: 0.0, scan: 0, sensor: 0, robot, pose, range, label: None, line: 1 }, 7, &sensor)
}

#[test]
fn a_sensor_s_limits_hold() {
    for range in [f64::NAN, -1.0, f64::NEG_INFINITY, 0.19, 4.01, 5.0] {
        assert_eq!(of(range), None, "{range}");
    }
    for (range, heard) in [(0.2, Some(0.2)), (4.0, Some(4.0)), (5.01, None), (f64::INFINITY, None)] {
        assert_eq!(of(range).unwrap().range, heard, "{range}");
    }
}

#[test]
fn the_kernels_get_a_missing_echo_as_far_as_echoes_count() {
    let ping = of(f64::INFINITY).unwrap();
    assert_eq!((ping.reading(4.0).outcome, ping.reading(4.0).range, ping.reach), (Outcome::NoEcho, 4.0, 4.0));
    let ping = of(3.0).unwrap();
    assert_eq!((ping.reading(3.0).outcome, ping.reading(3.0).range), (Outcome::Hit, 3.0));
    assert_eq!((ping.at, ping.centre(), ping.number), (Point::new(1.1, 2.0), Point::new(1.0, 2.0), 7));
    assert!((ping.axis.x.abs() < 1e-15) && ping.axis.y == 1.0);
}
