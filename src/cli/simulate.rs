//! `echogrid simulate`: a log of a world.

use super::say;
use crate::world::{RIGS, Rig, World, simulate};
use crate::{Error, Result};
use indicatif::ProgressBar;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `simulate`.
#[derive(Debug, clap::Args)]
pub struct Simulate {
    /// The world: a TOML file, such as worlds/room.toml
    world: PathBuf,
    /// The log to write (echogrid's JSON Lines), or - for standard output
    #[arg(short, long, value_name = "LOG")]
    output: PathBuf,
    /// The same seed gives the same log, on any number of threads
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// What the robot carries [default: the world's]
    #[arg(long, value_parser = clap::builder::PossibleValuesParser::new(RIGS))]
    rig: Option<String>,
    /// Scans [default: one at each stop of the path; more go round again]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    scans: Option<u64>,
    /// Events on an echo's way, 1 to 3 [default: the world's, else 3]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=3))]
    bounces: Option<u8>,
    /// No mirrors: every reading is the nearest distance in its cone
    #[arg(long)]
    no_specular: bool,
    /// Threads; 0: one a core
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

impl Simulate {
    /// Simulates, and says how it went.
    pub fn run(self) -> Result<u8> {
        let world = World::open(&self.world)?;
        let mut rig = match &self.rig {
            Some(name) => Rig::named(name)?,
            None => world.rig.clone(),
        };
        rig.physics.bounces = self.bounces.unwrap_or(rig.physics.bounces);
        rig.physics.specular &= !self.no_specular;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.threads).build();
        let pool = pool.map_err(|e| Error::Resources(format!("{} threads can't be started: {e}", self.threads)))?;
        let to_stdout = self.output == Path::new("-");
        let out: Box<dyn Write + Send> = if to_stdout {
            Box::new(std::io::stdout())
        } else {
            Box::new(File::create(&self.output).map_err(|e| {
                Error::Resources(format!("{} can't be written: {e}; give another path with -o", self.output.display()))
            })?)
        };
        let bar = if self.quiet {
            ProgressBar::hidden()
        } else {
            ProgressBar::new(self.scans.unwrap_or(world.stops.len() as u64))
        };
        let started = Instant::now();
        let (done, _) = pool.install(|| {
            simulate(&world, &rig, self.seed, self.scans, BufWriter::with_capacity(1 << 20, out), &|n| {
                bar.set_position(n)
            })
        })?;
        bar.finish_and_clear();
        let seconds = started.elapsed().as_secs_f64();
        if !self.quiet && !to_stdout {
            say!(
                "{}: {} readings ({}) in {} scans, {:.0} % without an echo; {:.0} readings/s",
                world.name,
                done.readings,
                rig.name,
                done.scans,
                100.0 * done.no_echo as f64 / done.readings as f64,
                done.readings as f64 / seconds
            );
            say!("Next: echogrid map {} -o DIR", self.output.display());
        }
        Ok(0)
    }
}
