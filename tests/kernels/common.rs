//! Running a scene on a backend, holding the result against the oracle, and what a failure leaves behind.

#[path = "../data/mod.rs"]
mod data;

pub use data::data;
use echogrid::binning::batch::BATCH;
use echogrid::binning::scan::{Scan, Scans};
use echogrid::binning::update;
use echogrid::evaluate::compare::{self, compare, write_pictures};
use echogrid::feature::Update;
use echogrid::grid::{Data, GridSpec, Layer, Map, Palette, Scale};
use echogrid::kernels::Backend;
use echogrid::kernels::cpu::Cpu;
use echogrid::kernels::gpu::{Gpu, Options};
use echogrid::kernels::shader::Kernel;
use echogrid::log::reading::{Counts, Reading};
use echogrid::method::settings::{Csm, Settings};
use echogrid::method::{self, Method, Step, Unit};
use echogrid::oracle::{self, OracleMap};
use echogrid::pipeline::batching::BatchStatistics;
use echogrid::pipeline::finished::{CellVisits, FinishedMap};
use echogrid::pipeline::layers;
use echogrid::pipeline::mapper::Mapper;
use echogrid::pipeline::readings::ReadingInput;
use echogrid::pipeline::scans::{ChunkedScans, Spill};
use echogrid::pipeline::updates::Updater;
use echogrid::sensor::Sensor;
use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, OnceLock};

/// Readings of some sensors, and the grid to map them on.
#[derive(Clone)]
pub struct Scene {
    pub name: String,
    pub grid: GridSpec,
    pub sensors: Vec<Sensor>,
    pub items: Vec<ReadingInput>,
    /// What features made of the items, one of each; none: updates of which no feature is known.
    pub updates: Vec<Update>,
}

/// What a backend made of a scene.
pub struct Run {
    pub map: Map,
    pub visits: CellVisits,
    pub counts: Counts,
    pub statistics: BatchStatistics,
}

impl Scene {
    pub fn readings(&self) -> Vec<Reading> {
        self.items.iter().map(|(r, _)| *r).collect()
    }

    /// The items as scans, for a model with so many class labels.
    pub fn scans(&self, csm: &Csm) -> Vec<Scan> {
        let records = self.items.iter().map(|(r, _)| Ok(r.record));
        let labels = if csm.semantic { csm.labels() } else { 0 };
        Scans::new(records, &self.sensors, labels, u64::MAX, Path::new("scene")).collect::<Result<_, _>>().unwrap()
    }

    /// Only its first items.
    pub fn truncate(&mut self, count: usize) {
        self.items.truncate(count);
        self.updates.truncate(count);
    }

    /// The updates of its items.
    pub fn updates(&self) -> Vec<Update> {
        match self.updates.is_empty() {
            true => (0..).zip(&self.items).map(|(k, item)| update::plain(k, item.0)).collect(),
            false => self.updates.clone(),
        }
    }

    fn update(&self, method: &dyn Method, backend: &mut dyn Backend, batch: usize) -> Run {
        let updates = self.updates().into_iter().map(Ok);
        let mut updater = Updater::new(&self.grid, &self.sensors, method, backend, batch);
        updater.apply(updates, &|_| {}).unwrap();
        let (counts, statistics) = (updater.counts, updater.statistics);
        let FinishedMap { map, visits, .. } = layers::from_chunks(&self.grid, method, &backend.finish(method).unwrap());
        Run { map, visits, counts, statistics }
    }

    fn count(&self, csm: Csm, method: &dyn Method, backend: &mut dyn Backend, batch: usize) -> Run {
        let (scans, selection) = (self.scans(&csm), csm.selection(self.grid.resolution));
        // So little memory that beams are spilled with small batches.
        let memory = if batch < 100 { 0 } else { u64::MAX };
        let scans = scans.into_iter().map(Ok);
        let spill = Spill { folder: std::env::temp_dir(), memory };
        let scans = ChunkedScans::read(&self.grid, selection, scans, &spill, &|_| {}).unwrap();
        let statistics = scans.apply(method, backend, batch, &|_| {}).unwrap();
        let FinishedMap { map, visits, .. } = layers::from_chunks(&self.grid, method, &backend.finish(method).unwrap());
        Run { map, visits, counts: Counts::default(), statistics }
    }

    pub fn run(&self, method: &dyn Method, backend: &mut dyn Backend, batch: usize) -> Run {
        if let Settings::Csm(csm) = method.settings() {
            return self.count(csm, method, backend, batch);
        }
        if method.unit() == Unit::Update {
            return self.update(method, backend, batch);
        }
        let mut mapper = Mapper::new(self.grid, &self.sensors, method, backend, batch).unwrap();
        // Wedges are for the laser truth alone.
        let item = |(reading, edges): &ReadingInput| (*reading, edges.filter(|_| method.settings() == Settings::Truth));
        for sweep in 0..method.sweeps().len() {
            mapper.sweep(sweep, self.items.iter().map(|i| Ok(item(i)))).unwrap();
        }
        let (counts, statistics) = (mapper.counts, mapper.statistics);
        let FinishedMap { map, visits, .. } = mapper.finish().unwrap();
        Run { map, visits, counts, statistics }
    }

    pub fn cpu(&self, settings: Settings) -> Run {
        self.run(method::make(settings).as_ref(), &mut Cpu::new(0).unwrap(), BATCH)
    }

    /// `None` where there is no adapter, or the method can't run on one.
    pub fn gpu(&self, settings: Settings) -> Option<Run> {
        let method = method::make(settings);
        if method.cpu_only().is_some() {
            return None;
        }
        gpu().map(|mut gpu| self.run(method.as_ref(), &mut *gpu, BATCH))
    }

    pub fn oracle(&self, settings: Settings) -> OracleMap {
        if let Settings::Csm(csm) = settings {
            return oracle::map_scans(&self.grid, &self.scans(&csm), &csm);
        }
        if let Settings::Features(_) = settings {
            return oracle::map_updates(&self.grid, &self.sensors, self.updates().into_iter().map(Ok), &settings)
                .unwrap();
        }
        let wedges: Option<Vec<(f64, f64)>> = self.items.iter().map(|(_, edges)| *edges).collect();
        let wedges = wedges.filter(|_| settings == Settings::Truth);
        oracle::map(&self.grid, &self.sensors, &self.readings(), &settings, wedges.as_deref()).unwrap()
    }
}

/// Every method with every choice that changes what a kernel does.
pub fn every_settings() -> Vec<(&'static str, Settings)> {
    let with = |method: &str, keys: &[(&str, &str)]| {
        let mut settings = Settings::of(method).unwrap();
        for (key, value) in keys {
            assert!(settings.set(key, value).unwrap(), "{method} has no {key}");
        }
        settings
    };
    vec![
        ("certainty", with("certainty", &[])),
        ("certainty-batch", with("certainty", &[("order", "batch")])),
        ("dempster-shafer", with("dempster-shafer", &[])),
        ("dempster-shafer-rho", with("dempster-shafer", &[("rho", "0.3")])),
        ("dempster-shafer-murphy", with("dempster-shafer", &[("model", "murphy")])),
        ("bayes", with("bayes", &[])),
        ("bayes-no-floors", with("bayes", &[("region_one_floor", "0"), ("region_two_floor", "0")])),
        ("bayes-constant", with("bayes", &[("model", "constant")])),
        ("himm", with("himm", &[])),
        ("himm-gro", with("himm", &[("gro", "true")])),
        ("truth", Settings::Truth),
        ("features", with("features", &[])),
    ]
    .into_iter()
    .chain(scan_settings())
    .collect()
}

/// The counting sensor models with every choice that changes what a kernel does.
pub fn scan_settings() -> Vec<(&'static str, Settings)> {
    let with = |method: &str, keys: &[(&str, &str)]| {
        let mut settings = Settings::of(method).unwrap();
        for (key, value) in keys {
            assert!(settings.set(key, value).unwrap(), "{method} has no {key}");
        }
        settings
    };
    let mut many = with("csm-semantic-continuous", &[("neighbours", "5")]);
    if let Settings::Csm(csm) = &mut many {
        let colours: Vec<[u8; 3]> = (0..=32).map(|k| [k; 3]).collect();
        csm.palette = Palette::of(&colours).unwrap();
    }
    let wide = [("neighbours", "all"), ("w_beam", "40deg"), ("w_obstacle", "0.3")];
    let nearest = [("neighbours", "1"), ("w_beam", "170deg"), ("z_max", "2")];
    let broad = [("neighbours", "all"), ("l", "1"), ("sigma0", "2")];
    vec![
        ("csm-discrete", with("csm-discrete", &[("w_beam", "10deg")])),
        ("csm-discrete-all", with("csm-discrete", &wide)),
        ("csm-discrete-1", with("csm-discrete", &nearest)),
        ("csm-continuous", with("csm-continuous", &[])),
        ("csm-continuous-all", with("csm-continuous", &broad)),
        ("csm-continuous-64", with("csm-continuous", &[("neighbours", "64"), ("z_max", "2")])),
        ("csm-continuous-sample", with("csm-continuous", &[("free", "sample"), ("step", "0.07")])),
        ("csm-continuous-clamp", with("csm-continuous", &[("free", "clamp"), ("l", "0.5")])),
        ("csm-semantic-discrete", with("csm-semantic-discrete", &[("w_beam", "30deg")])),
        ("csm-semantic-continuous", with("csm-semantic-continuous", &[])),
        ("csm-semantic-continuous-32", many),
    ]
}

/// Those for scenes without wedges.
pub fn cone_settings() -> Vec<(&'static str, Settings)> {
    every_settings()
        .into_iter()
        .filter(|(_, s)| !matches!(s, Settings::Truth | Settings::Csm(_) | Settings::Features(_)))
        .collect()
}

pub fn settings(name: &str) -> Settings {
    every_settings().into_iter().find(|(n, _)| *n == name).unwrap_or_else(|| panic!("no settings {name}")).1
}

/// The kernels that a method's sweeps use.
pub fn kernels_of(method: &dyn Method) -> BTreeSet<Kernel> {
    let kernel = |step: &Step| match step {
        Step::Pass(pass, _) => Some(Kernel::from(*pass)),
        Step::Sum => Some(Kernel::Sum),
        Step::NormalizeByCount | Step::ReadBack | Step::AccumulateCounts => None,
    };
    method.sweeps().iter().copied().flatten().filter_map(kernel).collect()
}

/// Straight to the stream: the harness would swallow a print of a test that passes.
pub fn say(text: &str) {
    let _ = std::io::stderr().write_all(format!("{text}\n").as_bytes());
}

fn gpu_required() -> bool {
    std::env::var_os("ECHOGRID_REQUIRE_GPU").is_some_and(|v| v == "1")
}

/// The adapter, shared by all tests; `None`, loudly, where there is none.
pub fn gpu() -> Option<MutexGuard<'static, Gpu>> {
    static GPU: OnceLock<Option<Mutex<Gpu>>> = OnceLock::new();
    let shared = GPU.get_or_init(|| open(Options::default()).map(Mutex::new));
    // A test that failed while it held the adapter left it with chunks of cells: none may reach the next test.
    shared.as_ref().map(|gpu| match gpu.lock() {
        Ok(gpu) => gpu,
        Err(poisoned) => {
            let mut gpu = poisoned.into_inner();
            let _ = gpu.finish(method::make(Settings::Truth).as_ref());
            gpu
        }
    })
}

/// An adapter of its own, its kernels' sources changed.
pub fn patched_gpu(patches: &[(&str, &str)]) -> Option<Gpu> {
    let patches = patches.iter().map(|(from, to)| (from.to_string(), to.to_string())).collect();
    // A thread's cells by themselves, so that a fault stands in the source once.
    open(Options { patches, vec4s_per_thread: Some(1), ..Options::default() })
}

/// An adapter; `None`, loudly, where there is none.
pub fn open(options: Options) -> Option<Gpu> {
    match Gpu::new(&options) {
        Ok(gpu) => Some(gpu),
        Err(e) if gpu_required() => panic!("ECHOGRID_REQUIRE_GPU=1, but {e}"),
        Err(e) => {
            say(&format!("SKIPPED: the gpu half of the kernel tests: {e}"));
            None
        }
    }
}

/// A cell by its place: column, row, world coordinates.
pub fn place(grid: &GridSpec, k: usize) -> String {
    let (column, row) = (k % grid.width, k / grid.width);
    let (x, y) = grid.centre(column, row);
    format!("cell {column},{row} at ({x:.3}, {y:.3}) m")
}

/// What differs between a backend's result and the oracle's: nothing, or one line a quantity, with its worst cell.
pub fn against_oracle(run: &Run, oracle: &OracleMap) -> Vec<String> {
    let mut wrong = Vec::new();
    let grid = &oracle.grid;
    for (what, mine, theirs) in
        [("interior", &run.visits.interior, &oracle.interior), ("arc", &run.visits.arc, &oracle.arc)]
    {
        let differ: Vec<usize> = (0..grid.cells()).filter(|&k| mine[k] != theirs[k]).collect();
        if let Some(&k) = differ.iter().max_by_key(|&&k| mine[k].abs_diff(theirs[k])) {
            let (n, at) = (differ.len(), place(grid, k));
            wrong.push(format!("{what} updates: {n} cells differ; worst {at}: {} for {}", mine[k], theirs[k]));
        }
    }
    let differ = run.visits.marks.iter().zip(&oracle.marks).filter(|(a, b)| a != b).count();
    if differ > 0 || run.visits.marks.len() != oracle.marks.len() {
        wrong.push(format!("marks: {differ} cells differ"));
    }
    let tallies = [
        ("updates", run.map.updates, oracle.updates),
        ("readings outside", run.counts.outside, oracle.outside),
        ("empty arcs", run.counts.empty_arc, oracle.empty_arc),
        ("wide readings", run.counts.wide, oracle.wide),
    ];
    wrong.extend(tallies.iter().filter(|(_, a, b)| a != b).map(|(what, a, b)| format!("{what}: {a} for {b}")));
    let names: Vec<&str> = run.map.layers.iter().map(|l| l.name.as_str()).collect();
    let wanted: Vec<&str> = oracle.layers.iter().map(|l| l.name).chain(["touched", "class"]).collect();
    if names != wanted {
        wrong.push(format!("layers {names:?} for {wanted:?}"));
        return wrong;
    }
    for (layer, reference) in run.map.layers.iter().zip(&oracle.layers) {
        // How far beyond its bound; NaN is beyond any.
        let beyond = |k: usize| {
            let over = (layer.data.get(k) - reference.values[k]).abs() - reference.bound[k];
            if over <= 0.0 { 0.0 } else { over.max(f64::MIN_POSITIVE) }
        };
        let differ: Vec<usize> = (0..grid.cells()).filter(|&k| beyond(k) > 0.0).collect();
        if let Some(&k) = differ.iter().max_by(|&&a, &&b| beyond(a).total_cmp(&beyond(b))) {
            let (n, at, value) = (differ.len(), place(grid, k), layer.data.get(k));
            let (want, bound) = (reference.values[k], reference.bound[k]);
            wrong.push(format!("{}: {n} cells off; worst {at}: {value} for {want} +- {bound:e}", layer.name));
        }
    }
    let class = &run.map.layer("class").unwrap().data;
    let touched = &run.map.layer("touched").unwrap().data;
    let differs = |k: &usize| class.get(*k) != f64::from(oracle.class[*k]) && !oracle.ambiguous[*k];
    if let Some(k) = (0..grid.cells()).find(differs) {
        let (n, at) = ((0..grid.cells()).filter(differs).count(), place(grid, k));
        wrong.push(format!("class: {n} cells differ; first {at}: {} for {}", class.get(k), oracle.class[k]));
    }
    if let Some(k) = (0..grid.cells()).find(|&k| (touched.get(k) != 0.0) != oracle.is_touched(k)) {
        wrong.push(format!("touched differs; first {}", place(grid, k)));
    }
    wrong
}

/// The oracle's map as a map, to be pictured.
fn as_map(oracle: &OracleMap, like: &Map) -> Map {
    let layers = like.layers.iter().map(|layer| {
        let data = match oracle.layer(&layer.name) {
            Some(l) => Data::F32(l.values.iter().map(|v| *v as f32).collect()),
            None if layer.name == "class" => Data::I8(oracle.class.clone()),
            None => Data::U8((0..oracle.grid.cells()).map(|k| u8::from(oracle.is_touched(k))).collect()),
        };
        Layer { data, ..layer.clone() }
    });
    Map { layers: layers.collect(), ..like.clone() }
}

/// A map of how often each cell was updated.
fn counted(visits: &[u32], like: &Map) -> Map {
    let data = Data::U32(visits.to_vec());
    let scale = Scale::Grey { low: 0.0, high: f64::from(visits.iter().copied().max().unwrap_or(1).max(1)) };
    let layer = Layer { name: "updates".into(), about: "updates", data, fill: 0.0, scale };
    Map { layers: vec![layer], ..like.clone() }
}

/// Writes pictures of both sides into `target/failures/NAME`; returns the folder.
fn pictures(name: &str, a: &Map, b: &Map) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("failures").join(name);
    let found = compare(a, b, &compare::Options::default()).unwrap();
    write_pictures(a, b, &found, &folder).unwrap();
    folder
}

/// Fails, with pictures, unless the result is the oracle's.
pub fn assert_oracle(name: &str, run: &Run, oracle: &OracleMap) {
    let wrong = against_oracle(run, oracle);
    if wrong.is_empty() {
        return;
    }
    let folder = pictures(name, &run.map, &as_map(oracle, &run.map));
    for (what, mine, theirs) in
        [("interior", &run.visits.interior, &oracle.interior), ("arc", &run.visits.arc, &oracle.arc)]
    {
        pictures(&format!("{name}/{what}"), &counted(mine, &run.map), &counted(theirs, &run.map));
    }
    panic!("{name} differs from the oracle:\n  {}\n  pictures in {}", wrong.join("\n  "), folder.display());
}

/// Fails, with pictures, unless two results are equal to the bit.
pub fn assert_same(name: &str, a: &Run, b: &Run) {
    let found = compare(&a.map, &b.map, &compare::Options::default()).unwrap();
    if !found.equal {
        let folder = pictures(name, &a.map, &b.map);
        let worst: Vec<String> = found
            .layers
            .iter()
            .filter(|l| l.differ > 0)
            .map(|l| format!("{}: {} cells, largest {:e}, worst {:?}", l.name, l.differ, l.largest, l.worst))
            .collect();
        panic!("{name}: not the same bytes:\n  {}\n  pictures in {}", worst.join("\n  "), folder.display());
    }
    assert!(a.visits == b.visits, "{name}: updates differ from cell to cell");
    assert_eq!((a.map.updates, a.counts), (b.map.updates, b.counts), "{name}");
}
