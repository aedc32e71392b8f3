//! The nearest surface in a cone: what a sonar measures in a world without mirrors, and where rough surfaces scatter sound.

use super::shape::{Arc, Wall};
use super::sonar::{Beam, Detection, Echo, attenuation};
use crate::geometry::plane::{Point, lerp, nearest_parameter, unit};
use nalgebra::distance;

/// The part of an amplitude that a rough surface returns at normal incidence.
const SCATTER: f64 = 0.3;
/// Steps along the part of a rough wall in the beam.
const SAMPLES: u32 = 32;

/// The nearest surface in the cone. Nothing can hide it: what hid it would be nearer.
pub(crate) fn nearest_surface(beam: &Beam, walls: &[Wall], arcs: &[Arc]) -> Option<Detection> {
    let wedge = beam.wedge();
    let mut best: Option<Detection> = None;
    let mut offer = |distance: f64, class: Option<u16>| {
        if distance.is_finite() && best.is_none_or(|b| distance < b.distance) {
            best = Some(Detection { distance, class });
        }
    };
    for wall in walls {
        if let Some((t0, t1)) = wedge.clip(wall.a, wall.b) {
            let t = nearest_parameter(beam.origin, wall.a, wall.b).clamp(t0, t1);
            offer(distance(&beam.origin, &lerp(wall.a, wall.b, t)), wall.class);
        }
    }
    for arc in arcs {
        let outward = unit(beam.origin - arc.centre);
        let foot = arc.centre + arc.radius * outward;
        let ends = [arc.at(0.0), arc.at(arc.sweep)];
        let foot = arc.spans(outward).then_some(foot);
        for p in foot.into_iter().chain(ends) {
            if let Some((d, _)) = beam.towards(p) {
                offer(d, arc.class);
            }
        }
        for side in [wedge.left, wedge.right, beam.axis] {
            for d in arc.intersections(beam.origin, side) {
                offer(if d > 0.0 { d } else { f64::NAN }, arc.class);
            }
        }
    }
    // a surface nearer than r_min still hides those behind it
    best.filter(|b| b.distance >= beam.r_min && b.distance <= beam.r_max)
}

/// The echoes that a rough wall may scatter back, from samples along its part in the beam.
pub(crate) fn scattered_by_wall(beam: &Beam, wall: &Wall) -> Vec<Echo> {
    let Some((t0, t1)) = beam.wedge().clip(wall.a, wall.b).filter(|_| wall.faces(beam.origin)) else {
        return Vec::new();
    };
    let along = unit(wall.b - wall.a);
    // the nearest point, then evenly along the wall
    let nearest = nearest_parameter(beam.origin, wall.a, wall.b).clamp(t0, t1);
    let even = (0..=SAMPLES).map(|k| t0 + (t1 - t0) * f64::from(k) / f64::from(SAMPLES));
    let echo = |t: f64| {
        let p = lerp(wall.a, wall.b, t);
        scattered(beam, p, along.perp(&unit(p - beam.origin)).abs(), wall.class)
    };
    std::iter::once(nearest).chain(even).filter_map(echo).collect()
}

/// The echoes that a rough arc may scatter back, from samples along it.
pub(crate) fn scattered_by_arc(beam: &Beam, arc: &Arc) -> Vec<Echo> {
    let outward = unit(beam.origin - arc.centre);
    let within = distance(&beam.origin, &arc.centre) <= arc.radius;
    if arc.is_circle() && within != arc.inside {
        return Vec::new();
    }
    let nearest = arc.centre + arc.radius * outward;
    let nearest = Some(nearest).filter(|_| arc.spans(outward));
    let even = (0..=4 * SAMPLES).map(|k| arc.at(arc.sweep * f64::from(k) / f64::from(4 * SAMPLES)));
    let echo = |p: Point| {
        let normal = unit(p - arc.centre);
        let cosine = normal.dot(&unit(beam.origin - p));
        // a circle answers on its free side only
        let faces = !arc.is_circle() || (cosine > 0.0) != arc.inside;
        faces.then(|| scattered(beam, p, cosine.abs(), arc.class)).flatten()
    };
    nearest.into_iter().chain(even).filter_map(echo).collect()
}

/// The echo of a rough point; `cosine` is that of the angle of incidence.
fn scattered(beam: &Beam, p: Point, cosine: f64, class: Option<u16>) -> Option<Echo> {
    let (distance, gain) = beam.towards(p)?;
    let amplitude = gain * gain * attenuation(distance) * SCATTER * cosine;
    Some(Echo { distance, amplitude, path: [p; 3], reflections: 1, closed: false, from_corner: false, class })
}
