//! The lists that the GPU makes of its own against those of the host.

use crate::common::{Scene, open};
use crate::scenes;
use echogrid::batch::{Batch, Binning, ChunkList};
use echogrid::kernels::gpu::{Gpu, Options};
use echogrid::layout::{ARC, Cone, Entry, WIDE};
use echogrid::snap::{Footprint, snap};
use std::collections::BTreeSet;

/// A scene's readings, snapped, but for those that reach far.
fn cones(scene: &Scene, footprint: Footprint) -> Vec<Cone> {
    let snap = |(reading, edges): &echogrid::mapper::Item| {
        let sensor = &scene.sensors[reading.record.sensor as usize];
        let heading = reading.record.pose.heading;
        let edges = edges.unwrap_or((heading + sensor.half_width, heading - sensor.half_width));
        snap(&scene.grid, sensor, reading, footprint, Some(edges)).map(|s| s.0)
    };
    scene.items.iter().filter_map(snap).filter(|c| c.flags & WIDE == 0).collect()
}

/// Holds the lists of a scene against the host's; how many entries, and how many on an arc.
fn check(gpu: &mut Gpu, scene: &Scene, footprint: Footprint, no_echo_arcs: bool) -> (usize, usize) {
    let size = [scene.grid.width, scene.grid.height];
    let binning = Binning { size, footprint, no_echo_arcs, only: None };
    let cones = cones(scene, footprint);
    let what = format!("{}, {footprint:?}", scene.name);
    let host = binning.bin(cones.clone());
    let near = binning.near(cones);
    let listed = gpu.list(size, &binning, &near).unwrap();
    let without_slots = |entries: &[Entry]| entries.iter().map(|e| e.cone).collect::<Vec<_>>();
    let filled: Vec<&ChunkList> = listed.iter().filter(|c| !c.entries.is_empty()).collect();
    assert_eq!(filled.len(), host.chunks.len(), "{what}");
    for (ours, theirs) in filled.iter().zip(&host.chunks) {
        assert_eq!((ours.place, &ours.tiles), (theirs.place, &theirs.tiles), "{what}");
        assert!(without_slots(&ours.entries) == without_slots(&theirs.entries), "{what}: other entries");
    }
    parts(&near, &filled, &host, &what);
    let entries = || filled.iter().flat_map(|c| &c.entries);
    (entries().count(), entries().filter(|e| e.cone & ARC != 0).count())
}

/// A reading's parts lie within its own, none twice, in the host's order.
fn parts(near: &Batch, listed: &[&ChunkList], host: &Batch, what: &str) {
    let by_reading = |chunks: &mut dyn Iterator<Item = &ChunkList>| {
        let mut parts: Vec<(usize, u32, [u32; 2], [u32; 2])> = Vec::new();
        for chunk in chunks {
            for tile in &chunk.tiles {
                for entry in &chunk.entries[tile.entries[0] as usize..tile.entries[1] as usize] {
                    if entry.cone & ARC != 0 {
                        parts.push((entry.index(), entry.slot, chunk.place, tile.corner));
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
        assert!((near.first_part[reading]..near.first_part[reading + 1]).contains(&slot), "{what}: reading {reading}");
    }
}

#[test]
fn lists_are_those_of_the_host() {
    let Some(mut gpu) = open(Options { lists: Some(true), ..Options::default() }) else { return };
    let (mut entries, mut arcs) = (0, 0);
    // The crowd is many segments; the others lie over several chunks, end within a tile, have lasers and missing echoes.
    for scene in [scenes::crowd(), scenes::ragged(), scenes::chunks(), scenes::edges(), scenes::fans()] {
        for footprint in [Footprint::Cone, Footprint::Wedge, Footprint::Axis] {
            for no_echo_arcs in [false, true] {
                let found = check(&mut gpu, &scene, footprint, no_echo_arcs);
                (entries, arcs) = (entries + found.0, arcs + found.1);
            }
        }
    }
    assert!(entries > 500_000 && arcs > 100_000, "{entries} entries, {arcs} on an arc");
}
