//! Faults seeded into the WGSL: the comparison must reject each one. A test that can't fail proves nothing.

use crate::common::{Scene, against_oracle, gpu, kernels_of, open, patched_gpu, settings};
use crate::scenes;
use echogrid::binning::batch::BATCH;
use echogrid::evaluate::compare::{self, compare};
use echogrid::evaluate::verify;
use echogrid::kernels::gpu::Options;
use echogrid::kernels::shader::source;
use echogrid::log::reading::{Outcome, Record};
use echogrid::log::{self, Writer};
use echogrid::method;
use echogrid::pipeline::session::{Request, Session};
use std::collections::BTreeMap;

/// A change of the source, the methods that must notice, and where.
struct Fault {
    what: &'static str,
    from: &'static str,
    to: &'static str,
    methods: &'static [&'static str],
    scene: fn() -> Scene,
}

const CONES: &[&str] = &["certainty", "dempster-shafer", "dempster-shafer-murphy", "bayes", "bayes-constant"];
const ALL: &[&str] = &["certainty", "certainty-batch", "dempster-shafer", "bayes", "himm"];

fn few() -> Scene {
    let mut scene = scenes::ragged();
    scene.truncate(400);
    scene
}

const SCANS: &[&str] = &["csm-discrete-all", "csm-continuous", "csm-semantic-continuous"];
const UPDATES: &[&str] = &["features"];

/// The loop over a stage's entries, and one that leaves out the last of a tile's.
const LAST: &str = "for (var k = first; k < end; k++) {\n            let entry";
const BUT_LAST: &str =
    "for (var k = first; k + select(0u, 1u, end == tile.entries.y) < end; k++) {\n            let entry";
const NEAREST: &[&str] = &["csm-discrete", "csm-continuous", "csm-semantic-continuous"];

const FAULTS: &[Fault] = &[
    Fault {
        what: "the arc ends a fiftieth early",
        from: "(d2 <= vec4<i32>(outer))",
        to: "(d2 <= vec4<i32>(outer - outer / 50))",
        methods: CONES,
        scene: few,
    },
    Fault {
        what: "the arc begins at R",
        from: "let inner = cone.reach.x * cone.reach.x;",
        to: "let middle = (cone.reach.x + cone.reach.y) / 2; let inner = middle * middle;",
        methods: CONES,
        scene: few,
    },
    Fault {
        what: "the arc's profile is a tenth narrower",
        from: "let e = (d - profile.z) * profile.w;",
        to: "let e = (d - profile.z) * profile.w * 1.1;",
        methods: &["certainty", "certainty-batch"],
        scene: few,
    },
    Fault {
        what: "hit and miss are swapped",
        from: "fuse_cells(cone, row, share, cells);",
        to: "var swapped = row; swapped.interior = row.arc; swapped.arc = row.interior; \
             fuse_cells(cone, swapped, share, cells);",
        methods: ALL,
        scene: few,
    },
    Fault {
        what: "hit and miss are counted swapped",
        from: "* THREADS] += one * counts_0[0];\n    state[at + 0 * THREADS + 64u] += one * counts_0[1];",
        to: "* THREADS] += one * counts_0[1];\n    state[at + 0 * THREADS + 64u] += one * counts_0[0];",
        methods: &["certainty", "bayes", "himm"],
        scene: few,
    },
    Fault {
        what: "hits and passes are swapped",
        from: "* THREADS] += one * counts_0[0];\n    state[at + 0 * THREADS + 64u] += one * counts_0[1];",
        to: "* THREADS] += one * counts_0[1];\n    state[at + 0 * THREADS + 64u] += one * counts_0[0];",
        methods: &["truth"],
        scene: scenes::fans,
    },
    Fault { what: "the last reading of a tile is dropped", from: LAST, to: BUT_LAST, methods: ALL, scene: few },
    Fault {
        what: "the last reading of a tile is dropped",
        from: LAST,
        to: BUT_LAST,
        methods: &["truth"],
        scene: scenes::fans,
    },
    Fault {
        what: "readings come in reverse order",
        from: "let cone = cone_at(k, first);\n            let share",
        to: "let cone = cones[entries[tile.entries.y - 1u - (k - tile.entries.x)].cone >> ENTRY_SHIFT];\n            let share",
        methods: &["certainty", "himm"],
        scene: few,
    },
    Fault {
        what: "near certainty the product goes on",
        from: "min(rest, product) < vec4<f32>(NEARLY)",
        to: "rest < vec4<f32>(0.0)",
        methods: &["certainty", "certainty-batch"],
        scene: scenes::parked,
    },
    Fault {
        what: "near certainty the bracket is not rounded",
        from: "round(e * units * per_place) * place",
        to: "e * units",
        methods: &["certainty", "certainty-batch"],
        scene: scenes::parked,
    },
    Fault {
        what: "the sums are of evidence that was not cancelled",
        from: "let part = weigh_cells(cone, row, cells);",
        to: "var fresh = *cells; fresh.open = vec4<f32>(1.0); let part = weigh_cells(cone, row, &fresh); \
             let kept = weigh_cells(cone, row, cells);",
        methods: &["certainty", "certainty-batch"],
        scene: few,
    },
    Fault {
        what: "the sums are cancelled by the emptiness before the batch",
        from: "let part = weigh_cells(cone, row, cells);",
        to: "var old = *cells; let part = weigh_cells(cone, row, &old);",
        methods: &["certainty"],
        scene: few,
    },
    Fault {
        what: "the sum leaves out its last part",
        from: "k < first_part[reading + 1u]; k++",
        to: "k + 1u < first_part[reading + 1u]; k++",
        methods: &["certainty", "certainty-batch"],
        scene: few,
    },
    Fault {
        what: "a row of the evidence is left out",
        from: "for (var at = k * 64u; at",
        to: "for (var at = k * 64u + 4u; at",
        methods: &["certainty", "certainty-batch"],
        scene: few,
    },
    Fault {
        what: "neighbouring tiles are swapped",
        from: "let at = tile.slot * PLANES * 64u + lane;",
        to: "let at = (tile.slot ^ 1u) * PLANES * 64u + lane;",
        methods: ALL,
        scene: few,
    },
    Fault {
        what: "the count is one too many",
        from: "atomicAdd(&parts[cone.index], cells);",
        to: "atomicAdd(&parts[cone.index], cells + 1u);",
        methods: &["dempster-shafer"],
        scene: few,
    },
    Fault {
        what: "cells beyond the grid are counted",
        from: "< vec4<i32>(columns);",
        to: "< vec4<i32>(columns + 4);",
        methods: &["certainty", "dempster-shafer"],
        scene: few,
    },
    Fault {
        what: "a missing echo has an arc",
        from: "if (cone.flags & NO_ECHO) != 0u {\n        row.arc = vec4<bool>(false);",
        to: "if (cone.flags & NO_ECHO) != 0u {\n        row.interior = row.interior;",
        methods: &["certainty", "bayes"],
        scene: few,
    },
    Fault {
        what: "the laser's band is missing",
        from: "return wedge | band;",
        to: "return wedge;",
        methods: CONES,
        scene: few,
    },
    Fault {
        what: "the laser's band is a unit narrower",
        from: "(abs(across) <= vec4<i32>(CELL / 2 * DIRECTION))",
        to: "(abs(across) <= vec4<i32>((CELL / 2 - 1) * DIRECTION))",
        methods: CONES,
        scene: few,
    },
    Fault {
        what: "a laser's edge cells are left out",
        from: "(abs(across) <= vec4<i32>(CELL / 2 * DIRECTION))",
        to: "(abs(across) < vec4<i32>(CELL / 2 * DIRECTION))",
        methods: CONES,
        scene: scenes::edges,
    },
    Fault {
        what: "both edges of a wedge belong to its beam",
        from: "-i32((cone.flags & HALF_OPEN) != 0u)",
        to: "0",
        methods: &["truth"],
        scene: scenes::fans,
    },
    Fault {
        what: "both edges of a far wedge belong to its beam",
        from: "wide_from(-i32((cone.flags & HALF_OPEN) != 0u))",
        to: "wide_from(1)",
        methods: &["truth"],
        scene: scenes::wide_fans,
    },
    Fault {
        what: "far arcs end a unit early",
        from: "let outer = wide_mul(cone.reach.y, cone.reach.y);",
        to: "let outer = wide_mul(cone.reach.y - 1, cone.reach.y - 1);",
        methods: CONES,
        scene: scenes::wide,
    },
    Fault {
        what: "far arcs leave out the cells exactly at their end",
        from: "!wide_less(outer, d2);",
        to: "wide_less(d2, outer);",
        methods: CONES,
        scene: scenes::wide,
    },
    Fault {
        what: "a carry is lost",
        from: "a.y + b.y + select(0u, 1u, low < a.x)",
        to: "a.y + b.y",
        methods: &["certainty", "dempster-shafer", "bayes", "himm"],
        scene: scenes::wide,
    },
    Fault {
        what: "far readings go the near way",
        from: "if (cone.flags & WIDE) != 0u",
        to: "if (cone.flags & WIDE) == 77u",
        // Not himm: near the axis its differences of products are small, and come out right modulo 2³².
        methods: CONES,
        scene: scenes::wide,
    },
    Fault {
        what: "both borders of the axis belong to it",
        from: "(side < edge)",
        to: "(side <= edge)",
        methods: &["himm"],
        scene: scenes::edges,
    },
    Fault {
        what: "on the diagonal the other axis leads",
        from: "let steep = abs(cone.axis.y) > abs(cone.axis.x);",
        to: "let steep = abs(cone.axis.y) >= abs(cone.axis.x);",
        methods: &["himm"],
        scene: scenes::edges,
    },
    Fault {
        what: "a hit adds two",
        from: "const HIT: u32 = 196608u;",
        to: "const HIT: u32 = 131072u;",
        methods: &["himm"],
        scene: few,
    },
    Fault {
        what: "the floors are swapped",
        from: "let least = select(vec4<f32>(given.w), vec4<f32>(given.z), arc);",
        to: "let least = select(vec4<f32>(0.9 * given.z), vec4<f32>(given.w), arc);",
        methods: &["bayes"],
        scene: few,
    },
    Fault {
        what: "the sums of logarithms lose their carry",
        from: "select(zero, addend_high, on) + select(zero, vec4<u32>(1u), low < (*sum)[0])",
        to: "select(zero, addend_high, on)",
        methods: &["dempster-shafer", "dempster-shafer-murphy"],
        scene: few,
    },
    Fault {
        what: "the off-axis angle of a broad beam is a thousandth large",
        from: "return low + (w2 * w2) * high;",
        to: "return (low + (w2 * w2) * high) * 1.001;",
        methods: &["certainty", "dempster-shafer-murphy", "bayes"],
        scene: few,
    },
    Fault {
        what: "the off-axis angle of a narrow beam is a thousandth large",
        from: "return t * cone.shape.y * angle(t * t);",
        to: "return t * cone.shape.y * angle(t * t) * 1.001;",
        methods: &["certainty", "dempster-shafer-murphy", "bayes"],
        scene: few,
    },
    Fault {
        what: "broad beams go the narrow way",
        from: "(cone.flags & BROAD) != 0u",
        to: "(cone.flags & BROAD) == 77u",
        methods: &["certainty", "dempster-shafer-murphy", "bayes"],
        scene: few,
    },
    Fault {
        what: "exponents are cut off, and nobody counts them",
        from: "(*cells).scale + (occupied >> places) - (empty >> places)",
        to: "(*cells).scale",
        methods: &["bayes"],
        scene: few,
    },
    Fault {
        what: "products are left to vanish",
        from: "fn renormalize(cells: ptr<function, CellStates>) {\n    let occupied",
        to: "fn renormalize(cells: ptr<function, CellStates>) {\n    if true {\n        return;\n    }\n    let occupied",
        methods: &["bayes"],
        scene: scenes::parked,
    },
    Fault {
        what: "the logarithm's polynomial is cut short",
        from: " + (w * w) * (0.29925594 * w + 0.399748)",
        to: "",
        methods: &["dempster-shafer-murphy"],
        scene: few,
    },
    Fault {
        what: "one more of equally near poses",
        from: "ties += select(0u, 1u, all(held[j] == last));",
        to: "ties += select(0u, 2u, all(held[j] == last));",
        methods: NEAREST,
        scene: scenes::scans,
    },
    Fault {
        what: "no equally near pose",
        from: "let tied = all(square == last.square) && ties > 0u;",
        to: "let tied = false;",
        methods: NEAREST,
        scene: scenes::scans,
    },
    Fault {
        what: "the nearest but one",
        from: "let last = held[HELD - 1u];",
        to: "let last = held[max(HELD, 2u) - 2u];",
        methods: &["csm-discrete", "csm-continuous", "csm-semantic-continuous-32"],
        scene: scenes::scans,
    },
    Fault {
        what: "a pose on the cell",
        from: " && any(square != vec2<u32>(0u))",
        to: "",
        methods: &["csm-continuous", "csm-continuous-clamp"],
        scene: scenes::scans,
    },
    Fault {
        what: "no z_max",
        from: "wide_less(square, farthest)",
        to: "true",
        methods: &["csm-continuous-64"],
        scene: scenes::scans,
    },
    Fault {
        what: "the later of equally near beams",
        from: "(beams[beam].id & YIELD) != 0u",
        to: "(beams[beam].id & YIELD) == 0u",
        methods: &["csm-continuous", "csm-discrete-1"],
        scene: scenes::scans,
    },
    Fault {
        what: "quarters in another order",
        from: "select(3u, 2u, v.x < 0)",
        to: "select(2u, 3u, v.x < 0)",
        methods: SCANS,
        scene: scenes::scans,
    },
    Fault {
        what: "the search ends a beam early",
        from: "low = middle + 1u;",
        to: "low = min(middle + 1u, most - 1u);",
        methods: SCANS,
        scene: scenes::scans,
    },
    Fault {
        what: "past the last beam is not the first",
        from: "select(found, 0u, found == scan.count)",
        to: "min(found, scan.count - 1u)",
        methods: SCANS,
        scene: scenes::scans,
    },
    Fault {
        what: "what nothing came back from",
        from: "if (beam.id & IDLE) != 0u {",
        to: "if false {",
        methods: SCANS,
        scene: scenes::scans,
    },
    Fault {
        what: "a thinner obstacle",
        from: "let half = frame.limits.y;",
        to: "let half = frame.limits.y - frame.limits.y / 40;",
        methods: &["csm-discrete", "csm-discrete-all", "csm-semantic-discrete"],
        scene: scenes::scans,
    },
    Fault {
        what: "a gate that is open to the left",
        from: "wide_negative(right) || wide_negative(left)",
        to: "wide_negative(right)",
        methods: &["csm-discrete", "csm-discrete-all", "csm-semantic-discrete"],
        scene: scenes::scans,
    },
    Fault {
        what: "all hits of one class",
        from: "(*cell).alpha[label - 1u] += 1u;",
        to: "(*cell).alpha[0] += 1u;",
        methods: &["csm-semantic-discrete"],
        scene: scenes::scans,
    },
    Fault {
        what: "a coefficient in the sixth digit",
        from: "13.387694",
        to: "13.38775",
        methods: &["csm-continuous", "csm-continuous-all", "csm-semantic-continuous-32"],
        scene: scenes::scans,
    },
    Fault {
        what: "no unlabelled hit is left out",
        from: "if label > 0u && max(abs(e.x), abs(e.y)) < l {",
        to: "if max(abs(e.x), abs(e.y)) < l {",
        methods: &["csm-semantic-continuous"],
        scene: scenes::scans,
    },
    Fault {
        what: "free beyond the hit",
        from: "!wide_less(wide_mul(beam.range, UNIT), along)",
        to: "true",
        methods: &["csm-continuous", "csm-continuous-all"],
        scene: scenes::scans,
    },
    Fault {
        what: "free behind the sensor",
        from: "FREE_RULE == 0u && wide_negative(along)",
        to: "false",
        methods: &["csm-continuous", "csm-semantic-continuous"],
        scene: scenes::scans,
    },
    Fault {
        what: "clamped at the hit",
        from: "max(beam.range - l, 0)",
        to: "beam.range",
        methods: &["csm-continuous-clamp"],
        scene: scenes::scans,
    },
    Fault {
        what: "every other sample",
        from: "k += 1;",
        to: "k += 2;",
        methods: &["csm-continuous-sample"],
        scene: scenes::scans,
    },
    Fault {
        what: "touched from a little farther",
        from: "wide_mul(frame.limits.y, frame.limits.y)",
        to: "wide_mul(frame.limits.y + 2000, frame.limits.y)",
        methods: &["csm-continuous", "csm-continuous-sample", "csm-semantic-continuous"],
        scene: scenes::scans,
    },
    Fault {
        what: "a fan without its right ray",
        from: "(left >= zero)",
        to: "(left > zero)",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "a fan without its left ray",
        from: "select(-1, 0, k + 1u == fan.y)",
        to: "-1",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "rays between triangles belong to both",
        from: "select(-1, 0, k + 1u == fan.y)",
        to: "0",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "a fan without its far side",
        from: "(right - left + area >= zero)",
        to: "(right - left + area > zero)",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "triangles without an area",
        from: "vec4<bool>(area > 0)",
        to: "vec4<bool>(area >= 0)",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "a fan's last triangle is left out",
        from: "k < fan.y; k++",
        to: "k + 1u < fan.y; k++",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "a tile that a fan meets lies in it",
        from: "(slot & (FULL << k)) != 0u",
        to: "(slot & (FAN << k)) != 0u",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "a line is a unit thinner",
        from: "CELL / 2 * (abs(d.x) + abs(d.y))",
        to: "CELL / 2 * (abs(d.x) + abs(d.y)) - max(abs(d.x), abs(d.y))",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "a line ends before its end",
        from: "(along <= vec4<i32>(",
        to: "(along < vec4<i32>(",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "a point is a unit smaller",
        from: "const SPOT: i32 = 24;",
        to: "const SPOT: i32 = 23;",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "the last line is left out",
        from: "k < ends.y; k += 2u",
        to: "k + 2u < ends.y; k += 2u",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "either part occupies the first's lines",
        from: "part(1u, update.lines[1], update.fans[1], slot, v)",
        to: "part(1u, update.lines[0], update.fans[1], slot, v)",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "what is free is not occupied",
        from: "select(select(none, vec4<u32>(FREED << (2u * k)), freed), vec4<u32>(OCCUPIED << (2u * k)), occupied)",
        to: "select(select(none, vec4<u32>(OCCUPIED << (2u * k)), occupied), vec4<u32>(FREED << (2u * k)), freed)",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "what is freed has no limit",
        from: "(update.flags & FREE_LIMIT) != 0u",
        to: "false",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "what is occupied is limited as what is freed",
        from: "fan(update.fans[3], 3u, slot, v)",
        to: "fan(update.fans[2], 2u, slot, v)",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "the parts' weights are swapped",
        from: "lean(vec4<f32>(weights.x), code, 0u)",
        to: "lean(vec4<f32>(weights.y), code, 0u)",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "the routine part has no weight",
        from: "lean((p - 0.5) * weights.z, code, 2u)",
        to: "lean(p - 0.5, code, 2u)",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "freed as if occupied",
        from: "select(none, none - weight, freed)",
        to: "select(none, weight, freed)",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "updates are marked as the next",
        from: "mark(update.number, contributions_0.code)",
        to: "mark(update.number + 1u, contributions_0.code)",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "freed and occupied are counted alike",
        from: "select(none, one, member_0 & !on_arc_0)",
        to: "select(none, one, member_0)",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "a tile's last update is dropped",
        from: "k < tile.entries.y; k++",
        to: "k + 1u < tile.entries.y; k++",
        methods: UPDATES,
        scene: scenes::updates,
    },
    Fault {
        what: "neighbouring tiles are swapped",
        from: "let at = tile.slot * PLANES * 64u + lane;",
        to: "let at = (tile.slot ^ 1u) * PLANES * 64u + lane;",
        methods: UPDATES,
        scene: scenes::updates,
    },
];

#[test]
fn every_seeded_fault_is_rejected() {
    if gpu().is_none() {
        return;
    }
    let mut scenes: BTreeMap<String, Scene> = BTreeMap::new();
    let mut oracles = BTreeMap::new();
    let mut unseen = Vec::new();
    for fault in FAULTS {
        let scene = (fault.scene)();
        let key = |name: &str| (scene.name.clone(), scene.items.len(), name.to_string());
        let mut patched = patched_gpu(&[(fault.from, fault.to)]).unwrap();
        for name in fault.methods {
            let settings = settings(name);
            let method = method::make(settings);
            // A fault that changes no kernel of the method would test nothing.
            let kernels = kernels_of(method.as_ref());
            let sources =
                kernels.iter().flat_map(|k| [false, true].map(|wide| source(method.as_ref(), *k, wide, 1).unwrap()));
            assert!(
                sources.into_iter().any(|s| s.contains(fault.from)),
                "\"{}\": its text is not in {name}'s kernels",
                fault.what
            );
            // Without the fault all is well, so it is the fault that is seen.
            let (oracle, sound) = oracles.entry(key(name)).or_insert_with(|| {
                let (oracle, sound) = (scene.oracle(settings), scene.gpu(settings).unwrap());
                let wrong = against_oracle(&sound, &oracle);
                assert!(wrong.is_empty(), "{} {name} without a fault: {wrong:?}", scene.name);
                (oracle, sound)
            });
            let run = scene.run(method.as_ref(), &mut patched, BATCH);
            let same = compare(&run.map, &sound.map, &compare::Options::default()).unwrap().equal;
            if against_oracle(&run, oracle).is_empty() {
                unseen.push(format!("{} in {name} on {} (bytes changed: {})", fault.what, scene.name, !same));
            }
        }
        scenes.entry(scene.name.clone()).or_insert(scene);
    }
    assert!(unseen.is_empty(), "{} faults go unseen:\n  {}", unseen.len(), unseen.join("\n  "));
    println!("{} faults seen on {} scenes", FAULTS.len(), scenes.len());
}

/// The comparison of two backends, without the oracle, sees a fault as well.
#[test]
fn cpu_against_gpu_sees_a_fault() {
    let scene = few();
    let Some(mut patched) = patched_gpu(&[(LAST, BUT_LAST)]) else { return };
    for name in ALL {
        let settings = settings(name);
        let run = scene.run(method::make(settings).as_ref(), &mut patched, BATCH);
        let cpu = scene.cpu(settings);
        let found = compare(&run.map, &cpu.map, &compare::Options::default()).unwrap();
        assert!(!found.equal, "{name}");
        let differing = found.layers.iter().find(|l| l.differ > 0).unwrap();
        let worst = differing.worst.unwrap();
        assert!(worst.column < scene.grid.width && worst.row < scene.grid.height);
        assert!(run.visits != cpu.visits, "{name}");
    }
}

/// A failure leaves pictures of both sides, and names the worst cell.
#[test]
fn a_failure_says_where_and_leaves_pictures() {
    let (scene, settings) = (few(), settings("bayes"));
    let oracle = scene.oracle(settings);
    let mut run = scene.cpu(settings);
    let k = (0..scene.grid.cells()).find(|&k| oracle.arc[k] > 0).unwrap();
    if let echogrid::grid::Data::F32(odds) = &mut run.map.layers[0].data {
        odds[k] += 1.0;
    }
    let caught = std::panic::catch_unwind(|| crate::common::assert_oracle("a failure on purpose", &run, &oracle));
    let message = *caught.unwrap_err().downcast::<String>().unwrap();
    let at = format!("cell {},{}", k % scene.grid.width, k / scene.grid.width);
    assert!(message.contains(&at) && message.contains("log_odds: 1 cells"), "{message}");
    let folder = message.rsplit_once("pictures in ").unwrap().1;
    for side in ["a", "b", "difference"] {
        let picture = std::path::Path::new(folder).join(format!("log_odds.{side}.png"));
        assert!(picture.is_file(), "{}", picture.display());
    }
    std::fs::remove_dir_all(folder).unwrap();
}

/// `echogrid verify` itself: passes as it is, and fails with a fault in the kernels.
#[test]
fn verify_rejects_faults() {
    let mut scene = few();
    scene.sensors.iter_mut().enumerate().for_each(|(k, s)| s.id = k.to_string());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.jsonl");
    let mut writer = Writer::new(Vec::new(), &scene.sensors, &[]).unwrap();
    for (k, (reading, _)) in scene.items.iter().enumerate() {
        let missing = reading.outcome == Outcome::NoEcho;
        let range = if missing { f64::INFINITY } else { reading.range };
        writer.write(&Record { range, scan: k as u64, ..reading.record }).unwrap();
    }
    std::fs::write(&path, writer.finish().unwrap()).unwrap();
    for (what, from, to) in [
        ("nothing", "", ""),
        ("a dropped reading", LAST, BUT_LAST),
        ("an arc cut short", "(d2 <= vec4<i32>(outer))", "(d2 <= vec4<i32>(outer - outer / 50))"),
        ("a wrong product", "to_one(cells.clear)", "to_one(cells.clear * 0.999)"),
    ] {
        let patches: &[(&str, &str)] = if from.is_empty() { &[] } else { &[(from, to)] };
        let Some(mut gpu) = patched_gpu(patches) else { return };
        let request = Request {
            log: log::Options::default(),
            settings: settings("certainty"),
            resolution: 0.1,
            bounds: Some([0.0, 0.0, 3.7, 5.3]),
            until: None,
            strict: true,
        };
        let session = Session::open(&path, &request).unwrap();
        let oracle = session.oracle().unwrap();
        let mapped = session.map(&mut gpu, BATCH, &|_| {}).unwrap();
        let wrong = u64::from(
            (mapped.counts.outside, mapped.counts.empty_arc, mapped.counts.wide)
                != (oracle.outside, oracle.empty_arc, oracle.wide),
        );
        let adapter = gpu.adapter_info().to_string();
        let finished = &mapped.finished;
        let run = verify::BackendRun { name: "gpu", adapter, finished, wrong_counts: wrong, seconds: 0.0 };
        let check = verify::check_backend(&session, &oracle, run).unwrap();
        assert_eq!(check.passed, from.is_empty(), "{what}: {check:?}");
        if !check.passed {
            let named =
                check.membership_cell.is_some() || check.layers.iter().any(|l| l.beyond > 0 && l.worst.is_some());
            assert!(named, "{what}: no cell is named: {check:?}");
        }
    }
}

/// What only hardware runs is held against the oracle as well: faults in stages, and in tiles told apart.
#[test]
fn faults_of_hardware_kernels_are_seen() {
    let faults = [
        (
            "a stage's readings are shifted",
            "staged_cones[k - first] = cone;",
            "staged_cones[(k - first) ^ 1u] = cone;",
            ALL,
        ),
        (
            "a stage's entries are shifted",
            "staged_entries[k - first] = entry;",
            "staged_entries[(k - first) ^ 1u] = entry;",
            &["certainty"],
        ),
        (
            "a stage's shares are shifted",
            "staged_shares[k - first] = shares",
            "staged_shares[(k - first) ^ 1u] = shares",
            &["dempster-shafer"],
        ),
        (
            "a stage ends early",
            "k < end; k += THREADS) {\n            let entry = entries[k];",
            "k + 1u < end; k += THREADS) {\n            let entry = entries[k];",
            ALL,
        ),
        (
            "a row of the evidence is left out",
            "let columns = groups_of(at) + groups_of(at + 4u)",
            "let columns = groups_of(at + 4u)",
            &["certainty", "certainty-batch"],
        ),
        (
            "a stage's evidence is another's",
            "parts[entry.slot] = part_of_tile((k - first) * STRIDE);",
            "parts[entry.slot] = part_of_tile(((k - first) ^ 1u) * STRIDE);",
            &["certainty"],
        ),
        ("a tile inside is left out", "row.interior = vec4<bool>(true);", "row.interior = vec4<bool>(false);", CONES),
        (
            "a tile inside is measured from elsewhere",
            "row.d2 = vec4<f32>(x * x + v.y * v.y);\n    row.across = vec4<f32>(abs(cross_4(",
            "row.d2 = vec4<f32>(x * x);\n    row.across = vec4<f32>(abs(cross_4(",
            &["certainty", "bayes"],
        ),
        (
            "a tile off the arc is left out",
            "row.interior = between_edges(cone, x, v.y, across, along) &",
            "row.interior = vec4<bool>(false) &",
            CONES,
        ),
    ];
    let scene = scenes::large();
    let mut unseen = Vec::new();
    for (what, from, to, methods) in faults {
        let patches = vec![(from.to_string(), to.to_string())];
        let options = Options {
            staged: Some(true),
            bins_tiles: Some(true),
            vec4s_per_thread: Some(1),
            patches,
            ..Options::default()
        };
        let Some(mut patched) = open(options) else { return };
        for name in methods {
            let settings = settings(name);
            let method = method::make(settings);
            let sources =
                kernels_of(method.as_ref()).into_iter().map(|k| source(method.as_ref(), k, false, 1).unwrap());
            assert!(sources.into_iter().any(|s| s.contains(from)), "{what}: its text is not in {name}'s kernels");
            let run = scene.run(method.as_ref(), &mut patched, BATCH);
            if against_oracle(&run, &scene.oracle(settings)).is_empty() {
                unseen.push(format!("{what} in {name}"));
            }
        }
    }
    assert!(unseen.is_empty(), "unseen: {unseen:?}");
}
