//! The nearest surface in a cone: what a sonar without specularity measures, and where a rough wall sends sound back.

use super::echo::{Echo, Heard, Ping, loss};
use super::plane::{Point, along, cross, distance, meet, nearest_share, sub, unit};
use super::shape::{Arc, Wall};

/// What a rough wall sends back of what falls on it squarely.
const SCATTER: f64 = 0.3;

/// The nearest distance in the cone. The nearest point is never hidden: what hid it would be nearer.
pub(crate) fn nearest(ping: &Ping, walls: &[Wall], arcs: &[Arc]) -> Heard {
    let wedge = ping.wedge();
    let mut best: Heard = None;
    let mut offer = |d: f64, class: Option<u16>| {
        if d.is_finite() && d >= ping.r_min && d <= ping.r_max && best.is_none_or(|(b, _)| d < b) {
            best = Some((d, class));
        }
    };
    for wall in walls {
        if let Some((t0, t1)) = wedge.clip(wall.a, wall.b) {
            let t = nearest_share(ping.at, wall.a, wall.b).clamp(t0, t1);
            offer(distance(ping.at, along(wall.a, wall.b, t)), wall.class);
        }
    }
    for arc in arcs {
        let out = unit(sub(ping.at, arc.centre));
        let foot = (arc.centre.0 + arc.radius * out.0, arc.centre.1 + arc.radius * out.1);
        let ends = [arc.at(0.0), arc.at(arc.sweep)];
        let foot = arc.spans(out).then_some(foot);
        for p in foot.into_iter().chain(ends) {
            if let Some((d, _)) = ping.towards(p) {
                offer(d, arc.class);
            }
        }
        for side in [wedge.left, wedge.right, ping.axis] {
            for d in arc.meets(ping.at, side) {
                offer(if d > 0.0 { d } else { f64::NAN }, arc.class);
            }
        }
    }
    best
}

/// The echoes that a rough wall scatters: from its nearest point in the beam and from where the axis meets it.
pub(crate) fn scattered(ping: &Ping, wall: &Wall) -> Vec<Echo> {
    let mut echoes = Vec::new();
    let Some((t0, t1)) = ping.wedge().clip(wall.a, wall.b).filter(|_| wall.faces(ping.at)) else { return echoes };
    let ahead: Point = (ping.at.0 + ping.axis.0, ping.at.1 + ping.axis.1);
    let axis = meet(ping.at, ahead, wall.a, wall.b).map(|(_, u)| u).filter(|u| (t0..=t1).contains(u));
    let run = unit(sub(wall.b, wall.a));
    for t in [nearest_share(ping.at, wall.a, wall.b).clamp(t0, t1), axis.unwrap_or(f64::NAN)] {
        let p = along(wall.a, wall.b, t);
        if let Some((d, gain)) = ping.towards(p) {
            let square = cross(run, unit(sub(p, ping.at))).abs();
            let amplitude = gain * gain * loss(d) * SCATTER * square;
            echoes.push(Echo { d, amplitude, way: [p; 3], events: 1, round: false, class: wall.class });
        }
    }
    echoes
}
