//! The same bytes whatever the batch, the number of threads and the run.

use crate::common::{Scene, assert_same, every_settings, gpu, open, settings};
use crate::scenes;
use echogrid::binning::batch::BATCH;
use echogrid::kernels::cpu::Cpu;
use echogrid::kernels::gpu::Options;
use echogrid::kernels::{Backend, Limits};
use echogrid::method::settings::Settings;
use echogrid::method::{self, Unit};

/// The real log, or without it a made-up one; for the truth a fan.
fn log(settings: Settings) -> Scene {
    match settings {
        Settings::Truth => return scenes::fans(),
        Settings::Csm(_) => return scenes::scans(),
        Settings::Features(_) => return scenes::updates(),
        _ => {}
    }
    scenes::real("sonar_ring_8/test1", 0.1, false).unwrap_or_else(scenes::ragged)
}

fn first(mut scene: Scene, readings: usize) -> Scene {
    scene.truncate(readings);
    scene
}

#[test]
fn batches_on_the_cpu() {
    for (name, settings) in every_settings() {
        let (method, scene) = (method::make(settings), log(settings));
        let whole = scene.cpu(settings);
        for batch in [7, 1000] {
            let run = scene.run(method.as_ref(), &mut Cpu::new(0).unwrap(), batch);
            assert_same(&format!("{name}, batches of {batch}, cpu"), &run, &whole);
            if method.unit() == Unit::Scan {
                assert!(batch > 7 || run.statistics.batches > whole.statistics.batches, "{name}, batches of {batch}");
                continue;
            }
            assert_eq!(run.statistics.batches, (scene.items.len().div_ceil(batch) * method.sweeps().len()) as u64);
        }
        let one = scene.run(method.as_ref(), &mut Cpu::new(0).unwrap(), 1);
        assert_same(&format!("{name}, batches of 1, cpu"), &one, &whole);
    }
}

#[test]
fn batches_on_the_gpu() {
    for (name, settings) in every_settings() {
        let (method, whole) = (method::make(settings), log(settings));
        let Some(at_once) = whole.gpu(settings) else { continue };
        let Some(mut gpu) = gpu() else { return };
        let run = whole.run(method.as_ref(), &mut *gpu, 1000);
        assert_same(&format!("{name}, batches of 1000, gpu"), &run, &at_once);
        let few = first(whole, 210);
        let at_once = few.run(method.as_ref(), &mut *gpu, BATCH);
        for batch in [1, 7] {
            let run = few.run(method.as_ref(), &mut *gpu, batch);
            assert_same(&format!("{name}, batches of {batch}, gpu"), &run, &at_once);
        }
    }
}

/// However many cells a thread owns: what suits a software adapter, and what a hardware one.
#[test]
fn shapes_on_the_gpu() {
    for count in [1, 2, 3, 8] {
        let Some(mut gpu) = open(Options { vec4s_per_thread: Some(count), ..Options::default() }) else { return };
        for (name, settings) in every_settings() {
            let (method, scene) = (method::make(settings), first(log(settings), 700));
            if method.cpu_only().is_none() {
                let run = scene.run(method.as_ref(), &mut gpu, BATCH);
                let Some(usual) = scene.gpu(settings) else { return };
                assert_same(&format!("{name}, {count} count a thread"), &run, &usual);
            }
        }
    }
}

/// What a hardware adapter gets: readings staged in workgroup memory, tiles told apart, lists made on the GPU; and each by itself.
#[test]
fn as_on_hardware() {
    for (staged, lists, count) in [(true, true, 1), (true, false, 2), (false, true, 4)] {
        let options = Options {
            vec4s_per_thread: Some(count),
            staged: Some(staged),
            bins_tiles: Some(lists),
            ..Options::default()
        };
        let Some(mut gpu) = open(options) else { return };
        for (name, settings) in every_settings() {
            let (method, scene) = (method::make(settings), first(log(settings), 900));
            if method.cpu_only().is_some() {
                continue;
            }
            let Some(usual) = scene.gpu(settings) else { return };
            for batch in [BATCH, 70] {
                let run = scene.run(method.as_ref(), &mut gpu, batch);
                assert_same(&format!("{name}, staged {staged}, lists {lists}, batches of {batch}"), &run, &usual);
            }
            // Whole tiles inside; and readings too far for lists on the GPU, which the host bins.
            let others =
                if method.unit() == Unit::Reading { vec![scenes::large(), scenes::wide()] } else { Vec::new() };
            for other in others {
                let what = format!("{name} on {}, staged {staged}, lists {lists}", other.name);
                assert_same(&what, &other.run(method.as_ref(), &mut gpu, BATCH), &other.cpu(settings));
            }
        }
    }
}

/// Timing the passes names each kind, changes nothing, and ends when it is asked for.
#[test]
fn timed_passes() {
    fn check(backend: &mut dyn Backend, clock: bool) {
        for (name, kinds) in [("certainty", ["fuse", "sum", "weigh"].as_slice()), ("bayes", &["fuse"])] {
            let settings = settings(name);
            let (method, scene) = (method::make(settings), first(log(settings), 900));
            let untimed = scene.run(method.as_ref(), backend, 300);
            assert!(backend.pass_times().is_empty());
            backend.time_passes();
            let timed = scene.run(method.as_ref(), backend, 300);
            assert_same(&format!("{name}, timed"), &timed, &untimed);
            let times = backend.pass_times();
            // A card may have no clock.
            if times.is_empty() && !clock {
                return;
            }
            assert_eq!(times.iter().map(|t| t.0).collect::<Vec<_>>(), kinds, "{}", backend.name());
            assert!(times.iter().all(|t| t.1 > 0.0 && t.1 < 60.0), "{times:?}");
        }
    }
    check(&mut Cpu::new(0).unwrap(), true);
    if let Some(mut gpu) = gpu() {
        let clock = gpu.adapter_info().software;
        check(&mut *gpu, clock);
    }
}

/// The larger scenes, by the four methods: 20,000 overlapping cones, and both real logs in 5 cm cells.
#[test]
fn large_scenes() {
    let real = |name: &str| scenes::real(name, 0.05, false);
    let scenes = [Some(scenes::crowd()), real("sonar_ring_8/test1"), real("sonar_ring_8/test2")];
    for scene in scenes.into_iter().flatten() {
        for name in ["certainty", "dempster-shafer", "bayes", "himm"] {
            let settings = settings(name);
            let method = method::make(settings);
            let whole = scene.run(method.as_ref(), &mut Cpu::new(2).unwrap(), BATCH);
            for batch in [7, 1000] {
                let run = scene.run(method.as_ref(), &mut Cpu::new(2).unwrap(), batch);
                assert_same(&format!("{name} on {}, batches of {batch}, cpu", scene.name), &run, &whole);
            }
            let one = scene.run(method.as_ref(), &mut Cpu::new(1).unwrap(), 5000);
            assert_same(&format!("{name} on {}, 1 thread", scene.name), &one, &whole);
            // In this order: an adapter is shared by one test at a time.
            let Some(at_once) = scene.gpu(settings) else { continue };
            let Some(mut gpu) = gpu() else { return };
            let run = scene.run(method.as_ref(), &mut *gpu, 1000);
            assert_same(&format!("{name} on {}, batches of 1000, gpu", scene.name), &run, &at_once);
        }
    }
}

#[test]
fn threads() {
    for (name, settings) in every_settings() {
        let (method, scene) = (method::make(settings), log(settings));
        let [one, two, five] = [1, 2, 5].map(|n| scene.run(method.as_ref(), &mut Cpu::new(n).unwrap(), 500));
        assert_same(&format!("{name}, 1 and 2 threads"), &one, &two);
        assert_same(&format!("{name}, 1 and 5 threads"), &one, &five);
    }
}

#[test]
fn runs() {
    for (name, settings) in every_settings() {
        let scene = log(settings);
        assert_same(&format!("{name}, twice, cpu"), &scene.cpu(settings), &scene.cpu(settings));
        if let (Some(a), Some(b)) = (scene.gpu(settings), scene.gpu(settings)) {
            assert_same(&format!("{name}, twice, gpu"), &a, &b);
        }
    }
}

#[test]
fn an_entry_limit_that_splits_batches_changes_nothing() {
    /// A cpu that takes few entries at a time.
    struct Small(Cpu, usize);
    impl Backend for Small {
        fn name(&self) -> &'static str {
            "small"
        }
        fn adapter(&self) -> String {
            String::new()
        }
        fn limits(&self) -> Limits {
            Limits { entries: self.1, ..self.0.limits() }
        }
        fn apply(
            &mut self,
            method: &dyn method::Method,
            frame: echogrid::geometry::layout::Frame,
            batch: &echogrid::binning::batch::Batch,
            steps: &[method::Step],
            shares: &mut echogrid::kernels::Shares,
        ) -> echogrid::Result<()> {
            assert!(batch.chunks.iter().all(|c| c.entries.len() <= self.1));
            self.0.apply(method, frame, batch, steps, shares)
        }
        fn take(&mut self, place: echogrid::grid::ChunkId) -> echogrid::Result<Option<Vec<u32>>> {
            self.0.take(place)
        }
        fn finish(&mut self, method: &dyn method::Method) -> echogrid::Result<echogrid::kernels::ChunkStates> {
            self.0.finish(method)
        }
    }
    for (name, settings) in every_settings() {
        let (method, scene) = (
            method::make(settings),
            first(log(settings), if method::make(settings).unit() == Unit::Scan { 3000 } else { 800 }),
        );
        let mut small = Small(Cpu::new(0).unwrap(), 400);
        let run = scene.run(method.as_ref(), &mut small, BATCH);
        // One pose a cell is few.
        assert!(run.statistics.batches > 1 || name == "csm-discrete-1", "{name}");
        assert_same(&format!("{name}, split by the entry limit"), &run, &scene.cpu(settings));
    }
}

/// Mesa's software adapter ends loops without a word once all of a thread's have gone round 65535 times.
#[test]
fn more_readings_over_one_tile_than_a_software_adapter_goes_round_its_loops() {
    let Some(mut gpu) = gpu() else { return };
    let few = scenes::updates();
    for (name, copies) in [("bayes", 70_000), ("features", 3_000)] {
        let (settings, mut scene) = (Settings::of(name).unwrap(), few.clone());
        if name == "bayes" {
            scene.updates.clear();
            scene.items = few.items.iter().cycle().take(1).cycle().take(copies).cloned().collect();
        } else {
            let near: Vec<_> = (0..few.items.len()).cycle().take(copies).collect();
            scene.items = near.iter().map(|k| few.items[*k]).collect();
            scene.updates = near.iter().map(|k| few.updates[*k].clone()).collect();
        }
        let method = method::make(settings);
        let on_cpu = scene.run(method.as_ref(), &mut Cpu::new(0).unwrap(), copies);
        let on_gpu = scene.run(method.as_ref(), &mut *gpu, copies);
        assert_eq!(on_gpu.visits, on_cpu.visits, "{name}");
    }
}
