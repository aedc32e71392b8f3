//! The lists that the GPU makes of its own against those of the host.

use crate::common::{Scene, open};
use crate::scenes;
use echogrid::binning::batch::{Batch, Binning, ChunkList};
use echogrid::binning::snap::{Footprint, snap};
use echogrid::geometry::layout::{ARC, Cone, Entry, WIDE};
use echogrid::kernels::gpu::{Gpu, Options, tile_binner};
use std::collections::BTreeSet;

/// A scene's readings, snapped, but for those that reach far.
fn cones(scene: &Scene, footprint: Footprint) -> Vec<Cone> {
    let snap = |(reading, edges): &echogrid::pipeline::readings::ReadingInput| {
        let sensor = &scene.sensors[reading.record.sensor as usize];
        let heading = reading.record.pose.heading;
        let edges = edges.unwrap_or((heading + sensor.half_width, heading - sensor.half_width));
        snap(&scene.grid, sensor, reading, footprint, Some(edges)).map(|s| s.0)
    };
    scene.items.iter().filter_map(snap).filter(|c| c.flags & WIDE == 0).collect()
}

/// A scene's lists by the host and by the GPU.
struct Listed {
    what: String,
    near: Batch,
    host: Batch,
    listed: Vec<ChunkList>,
}

impl Listed {
    fn of(gpu: &mut Gpu, scene: &Scene, footprint: Footprint, no_echo_arcs: bool) -> Listed {
        let size = [scene.grid.width, scene.grid.height];
        let binning = Binning { size, footprint, no_echo_arcs, only: None };
        let cones = cones(scene, footprint);
        let near = binning.bound_cones(&cones, |c| Some(*c)).unwrap();
        let listed = gpu.list(size, &binning, &near).unwrap();
        Listed { what: format!("{}, {footprint:?}", scene.name), near, host: binning.bin(cones), listed }
    }

    /// Holds them against each other; how many entries there are, and how many on an arc.
    fn check(&self) -> (usize, usize) {
        let Listed { what, near, host, listed } = self;
        let without_slots = |entries: &[Entry]| entries.iter().map(|e| e.cone).collect::<Vec<_>>();
        let filled: Vec<&ChunkList> = listed.iter().filter(|c| !c.entries.is_empty()).collect();
        assert_eq!(filled.len(), host.chunks.len(), "{what}");
        for (ours, theirs) in filled.iter().zip(&host.chunks) {
            assert!((ours.place, &ours.tiles) == (theirs.place, &theirs.tiles), "{what}: other tiles");
            assert!(without_slots(&ours.entries) == without_slots(&theirs.entries), "{what}: other entries");
        }
        parts(near, &filled, host, what);
        let entries = || filled.iter().flat_map(|c| &c.entries);
        (entries().count(), entries().filter(|e| e.cone & ARC != 0).count())
    }
}

/// A reading's parts lie within its own, none twice, in the host's order.
fn parts(near: &Batch, listed: &[&ChunkList], host: &Batch, what: &str) {
    let by_reading = |chunks: &mut dyn Iterator<Item = &ChunkList>| {
        let mut parts: Vec<(usize, u32, [u32; 2], [u32; 2])> = Vec::new();
        for chunk in chunks {
            for tile in &chunk.tiles {
                for entry in &chunk.entries[tile.entries[0] as usize..tile.entries[1] as usize] {
                    if entry.cone & ARC != 0 {
                        parts.push((entry.index(), entry.slot, [chunk.place.column, chunk.place.row], tile.corner));
                    }
                }
            }
        }
        parts.sort_unstable();
        parts
    };
    let ours = by_reading(&mut listed.iter().copied());
    let theirs = by_reading(&mut host.chunks.iter());
    let places = |parts: &[(usize, u32, [u32; 2], [u32; 2])]| parts.iter().map(|p| (p.0, p.2, p.3)).collect::<Vec<_>>();
    assert!(places(&ours) == places(&theirs), "{what}: parts in another order");
    let slots: BTreeSet<u32> = ours.iter().map(|p| p.1).collect();
    assert_eq!(slots.len(), ours.len(), "{what}: two tiles share a part");
    for (reading, slot, ..) in ours {
        assert!(
            (near.first_part()[reading]..near.first_part()[reading + 1]).contains(&slot),
            "{what}: reading {reading}"
        );
    }
}

#[test]
fn lists_are_those_of_the_host() {
    let Some(mut gpu) = open(Options { bins_tiles: Some(true), ..Options::default() }) else { return };
    let (mut entries, mut arcs) = (0, 0);
    // The crowd is many segments; the others lie over several chunks, end within a tile, have lasers and missing echoes.
    for scene in [scenes::crowd(), scenes::ragged(), scenes::chunks(), scenes::large(), scenes::edges(), scenes::fans()]
    {
        for footprint in [Footprint::Cone, Footprint::Wedge, Footprint::Axis] {
            for no_echo_arcs in [false, true] {
                let found = Listed::of(&mut gpu, &scene, footprint, no_echo_arcs).check();
                (entries, arcs) = (entries + found.0, arcs + found.1);
            }
        }
    }
    assert!(entries > 500_000 && arcs > 100_000, "{entries} entries, {arcs} on an arc");
}

/// A fault in what lists tiles is seen: by the lists themselves.
#[test]
fn faults_in_lists_are_seen() {
    let faults = [
        (
            "a corner of the tile is forgotten",
            "let left = cross_over(cone.left, low, high);",
            "let left = cross_over(cone.left, low, low);",
        ),
        (
            "the arc begins late",
            "let arc = far2 >= u32(cone.reach.x * cone.reach.x);",
            "let arc = far2 > u32(cone.reach.y * cone.reach.y);",
        ),
        ("a tile across an edge is inside", "let inside = left.y < 0", "let inside = left.x < 0"),
        ("a tile beyond the grid is inside", "if any(corner + TILE > params.size)", "if any(corner > params.size)"),
        ("missing echoes have an arc", "if (cone.flags & NO_ECHO) != 0u && (params.flags & ARCS) == 0u", "if false"),
        ("a box ends a tile early", "any(at >= box.high)", "any(at + 1u >= box.high)"),
        ("order is lost", "entries[to + place.x]", "entries[to + place.y - 1u - place.x]"),
        ("a turn is forgotten", "        to += place.y;", "        to += select(place.y, 0u, turn == 2u);"),
        ("a segment is forgotten", "segment < params.segments", "segment + 1u < max(params.segments, 2u)"),
        ("a block's neighbour", "at.y / BLOCK * BLOCKS + at.x / BLOCK", "(at.y + 1u) / BLOCK * BLOCKS + at.x / BLOCK"),
        (
            "parts are shared",
            "box.part + inside.y * (box.high.x - box.low.x)",
            "box.part + inside.y * (box.high.x - box.low.x - 1u)",
        ),
        ("a thread's bit is lost", "1u << (lane % 32u)", "1u << (lane % 31u)"),
    ];
    let mut unseen = Vec::new();
    for (what, from, to) in faults {
        assert!(tile_binner::sources().iter().any(|s| s.contains(from)), "{what}: its text is not in the kernels");
        let patches = vec![(from.to_string(), to.to_string())];
        let Some(mut gpu) = open(Options { bins_tiles: Some(true), patches, ..Options::default() }) else { return };
        let scenes = [scenes::crowd(), scenes::ragged(), scenes::chunks(), scenes::large()];
        let seen = scenes.iter().any(|scene| {
            let listed = Listed::of(&mut gpu, scene, Footprint::Cone, false);
            std::panic::catch_unwind(|| listed.check()).is_err()
        });
        if !seen {
            unseen.push(what);
        }
    }
    assert!(unseen.is_empty(), "unseen: {unseen:?}");
}
