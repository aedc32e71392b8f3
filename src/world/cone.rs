//! The nearest surface in a cone: what a sonar without specularity measures, and where a rough wall sends sound back.

use super::echo::{Echo, Heard, Ping, loss};
use super::shape::{Arc, Wall};
use crate::geometry::plane::{Point, along, cross, distance, dot, nearest_share, sub, unit};

/// What a rough surface sends back of what falls on it squarely.
const SCATTER: f64 = 0.3;
/// Steps along a rough wall's part in the beam.
const PLACES: u32 = 32;

/// The nearest distance in the cone. The nearest point is never hidden: what hid it would be nearer.
pub(crate) fn nearest(ping: &Ping, walls: &[Wall], arcs: &[Arc]) -> Heard {
    let wedge = ping.wedge();
    let mut best: Heard = None;
    let mut offer = |d: f64, class: Option<u16>| {
        if d.is_finite() && best.is_none_or(|(b, _)| d < b) {
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
    // what is nearer than r_min still hides what is behind it
    best.filter(|(d, _)| *d >= ping.r_min && *d <= ping.r_max)
}

/// Where a rough wall may send sound back: places along its part in the beam.
pub(crate) fn on_wall(ping: &Ping, wall: &Wall) -> Vec<Echo> {
    let Some((t0, t1)) = ping.wedge().clip(wall.a, wall.b).filter(|_| wall.faces(ping.at)) else { return Vec::new() };
    let run = unit(sub(wall.b, wall.a));
    // the place of the nearest point, then evenly along
    let nearest = nearest_share(ping.at, wall.a, wall.b).clamp(t0, t1);
    let even = (0..=PLACES).map(|k| t0 + (t1 - t0) * f64::from(k) / f64::from(PLACES));
    let answer = |t: f64| {
        let p = along(wall.a, wall.b, t);
        place(ping, p, cross(run, unit(sub(p, ping.at))).abs(), wall.class)
    };
    std::iter::once(nearest).chain(even).filter_map(answer).collect()
}

/// The same of a rough arc.
pub(crate) fn on_arc(ping: &Ping, arc: &Arc) -> Vec<Echo> {
    let out = unit(sub(ping.at, arc.centre));
    let within = distance(ping.at, arc.centre) <= arc.radius;
    if arc.whole() && within != arc.inside {
        return Vec::new();
    }
    let nearest = (arc.centre.0 + arc.radius * out.0, arc.centre.1 + arc.radius * out.1);
    let nearest = Some(nearest).filter(|_| arc.spans(out));
    let even = (0..=4 * PLACES).map(|k| arc.at(arc.sweep * f64::from(k) / f64::from(4 * PLACES)));
    let answer = |p: Point| {
        let normal = unit(sub(p, arc.centre));
        let square = dot(normal, unit(sub(ping.at, p)));
        // a whole circle answers on its free side only
        let faces = !arc.whole() || (square > 0.0) != arc.inside;
        faces.then(|| place(ping, p, square.abs(), arc.class)).flatten()
    };
    nearest.into_iter().chain(even).filter_map(answer).collect()
}

/// What a rough place sends back: [`SCATTER`] of what falls on it, times the cosine of its slant.
fn place(ping: &Ping, p: Point, square: f64, class: Option<u16>) -> Option<Echo> {
    let (d, gain) = ping.towards(p)?;
    let amplitude = gain * gain * loss(d) * SCATTER * square;
    Some(Echo { d, amplitude, way: [p; 3], events: 1, round: false, corner: false, class })
}
