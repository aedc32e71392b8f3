//! `echogrid demo`: the main job on whatever the machine has.

use super::common::BackendArgument;
use super::map::{Ran, save};
use super::say;
use crate::grid::{Class, GridSpec, Layer};
use crate::kernels::choose;
use crate::log::{self, Writer};
use crate::mapper::BATCH;
use crate::method::{REGISTRY, settings::Settings};
use crate::output::Folder;
use crate::session::{Request, Session};
use crate::world::room;
use crate::{Error, Result};
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The demo's seed and cells.
const SEED: u64 = 1;
const RESOLUTION: f64 = 0.05;
/// The demo's bounds: the room and half a metre around.
const BOUNDS: [f64; 4] = [-0.5, -0.5, 5.5, 4.5];

/// Arguments of `demo`.
#[derive(Debug, clap::Args)]
pub struct Demo {
    /// Folder for the log and the maps
    #[arg(short, long, value_name = "DIR", default_value = "echogrid-demo")]
    output: PathBuf,
    /// What computes
    #[arg(long, default_value = "auto")]
    backend: BackendArgument,
}

impl Demo {
    /// Drives, maps, and prints a table.
    pub fn run(self) -> Result<u8> {
        let started = Instant::now();
        let unwritable = |e: std::io::Error| {
            Error::Resources(format!("{} can't be written: {e}; give another folder with -o", self.output.display()))
        };
        std::fs::create_dir_all(&self.output).map_err(unwritable)?;
        let log = self.output.join("room.jsonl");
        let (sensors, records) = room::records(SEED)?;
        let file = File::create(&log).map_err(unwritable)?;
        let mut writer = Writer::new(BufWriter::new(file), &sensors, &[])?;
        for record in &records {
            writer.write(record)?;
        }
        writer.finish()?;
        let scans = records.last().map_or(0, |r| r.scan + 1);
        say!("A ring of eight sonars, driven round a room of 5 × 4 m: {} readings in {scans} scans.", records.len());
        say!("");
        say!("method            backend      ms  M updates  occupied  empty  walls found  walls freed");
        let mut why = String::new();
        for entry in REGISTRY.iter().filter(|e| e.name != "truth") {
            let Some(settings) = Settings::of(entry.name) else { continue };
            why = self.map(&log, entry.name, settings)?;
        }
        say!("");
        if !why.is_empty() {
            say!("Computed on the {why}.");
        }
        say!(
            "A wall is found if a cell beside it is occupied, freed if its own cell is empty. In {:.1} s.",
            started.elapsed().as_secs_f64()
        );
        say!(
            "Look at {}; then map a log of your own: echogrid map LOG -o DIR",
            self.output.join("bayes").join("map.png").display()
        );
        Ok(0)
    }

    /// Maps by one method, prints its line, and says on what.
    fn map(&self, log: &Path, name: &str, settings: Settings) -> Result<String> {
        let request = Request {
            log: log::Options::default(),
            settings,
            resolution: RESOLUTION,
            bounds: Some(BOUNDS),
            until: None,
            strict: true,
        };
        let folder = Folder::prepare(&self.output.join(name))?;
        let session = Session::open(log, &request)?;
        let started = Instant::now();
        let (mapped, ran) = match self.backend.choice() {
            None => (session.oracle_map()?, Ran { backend: "oracle", ..Ran::default() }),
            Some(choice) => {
                let mut chosen = choose(choice, session.method.as_ref(), 0)?;
                (session.map(chosen.backend.as_mut(), BATCH, &|_| {})?, Ran::of(&chosen))
            }
        };
        let seconds = started.elapsed().as_secs_f64();
        let report = save(&folder, &session, &mapped, &ran, vec![("map".into(), seconds)], false)?;
        folder.finish()?;
        let class = mapped.finished.map.layer("class");
        let [found, freed] = class.map_or([0.0; 2], |class| walls(&session.grid, class));
        say!(
            "{name:<18}{:<8}{:>7.1}{:>11.2}{:>10}{:>7}{found:>11.0} %{freed:>11.0} %",
            ran.backend,
            1e3 * seconds,
            report.updates as f64 / 1e6,
            report.cells.occupied,
            report.cells.empty
        );
        let adapter = ran.adapter.map(|a| format!(" ({a})")).unwrap_or_default();
        let why = if ran.why.is_empty() { String::new() } else { format!(", because {}", ran.why) };
        Ok(format!("{}{adapter}{why}", ran.backend))
    }
}

/// Of the true walls' cells, in percent: those with an occupied cell within one, and those that are empty.
fn walls(grid: &GridSpec, class: &Layer) -> [f64; 2] {
    let truth = room::truth(grid);
    let at = |x: usize, y: usize| class.data.get(y * grid.width + x);
    let (mut all, mut found, mut freed) = (0u32, 0u32, 0u32);
    for y in 0..grid.height {
        for x in 0..grid.width {
            if truth[y * grid.width + x] != Class::Occupied as i8 {
                continue;
            }
            let near = |v: usize, end: usize| v.saturating_sub(1)..(v + 2).min(end);
            all += 1;
            found += u32::from(near(y, grid.height).any(|j| near(x, grid.width).any(|i| at(i, j) > 0.0)));
            freed += u32::from(at(x, y) < 0.0);
        }
    }
    [found, freed].map(|n| 100.0 * f64::from(n) / f64::from(all.max(1)))
}
