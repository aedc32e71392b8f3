//! `echogrid simulate`: a log of a world.

use super::progress::bar;
use super::suggested_values::SuggestedValues;
use super::values::{parse_threads, use_threads};
use super::{interrupt, print_line, print_note};
use crate::world::{Rig, SHIPPED, Shipped, Simulation, World, simulate};
use crate::{Error, Result};
use clap::ValueHint;
use std::fs::File;
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;
use tempfile::NamedTempFile;

/// Arguments of `simulate`.
#[derive(Debug, clap::Args)]
pub struct SimulateArguments {
    /// The world: a built-in one, such as room, or a TOML file
    #[arg(required_unless_present = "list", value_hint = ValueHint::FilePath)]
    world: Option<PathBuf>,
    /// The log to write (echogrid's JSON Lines), or - for standard output
    #[arg(short, long, value_name = "LOG", required_unless_present = "list", value_hint = ValueHint::FilePath)]
    output: Option<PathBuf>,
    /// List the built-in worlds
    #[arg(long, exclusive = true)]
    list: bool,
    /// The same seed gives the same log, on any number of threads
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// What the robot carries: dense, ring8, ringN (1 to 360 sonars) or laser [default: the world's]
    #[arg(long, value_parser = SuggestedValues(rigs), hide_possible_values = true)]
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
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = parse_threads)]
    threads: usize,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

impl SimulateArguments {
    /// Simulates, and prints a summary.
    pub fn run(self) -> Result<u8> {
        // without --list both are required
        let (Some(name), Some(output)) = (&self.world, &self.output) else {
            SHIPPED.iter().for_each(|s| print_line!("{:<10}{}", s.name, s.about()));
            return Ok(0);
        };
        Shipped::beside_file(name).iter().for_each(|what| print_note!("{what}"));
        let world = World::find(name)?;
        let mut rig = match &self.rig {
            Some(name) => Rig::named(name)?,
            None => world.rig.clone(),
        };
        rig.physics.bounces = self.bounces.unwrap_or(rig.physics.bounces);
        rig.physics.specular &= !self.no_specular;
        use_threads(self.threads)?;
        let to_stdout = output == Path::new("-");
        let out = Destination::open(output)?;
        let bar = bar(self.scans.unwrap_or(world.trajectory.len() as u64), "simulating", self.quiet);
        let started = Instant::now();
        let out = BufWriter::with_capacity(1 << 20, out);
        let (done, out) =
            simulate(&Simulation { world: &world, rig: &rig, seed: self.seed, scans: self.scans }, out, &|n| {
                bar.set_position(n)
            })?;
        drop(bar);
        out.into_inner().map_err(|e| unwritable(output, e))?.finish(output)?;
        let seconds = started.elapsed().as_secs_f64();
        if !self.quiet && !to_stdout {
            print_line!(
                "{}: {} readings ({}) in {} scans, {:.0} % without an echo; {:.0} readings/s",
                world.name,
                done.readings,
                rig.name,
                done.scans,
                100.0 * done.no_echo as f64 / done.readings as f64,
                done.readings as f64 / seconds
            );
            print_line!("Next: echogrid map {} -o DIR", output.display());
        }
        Ok(0)
    }
}

/// The rigs that shell completion suggests.
fn rigs() -> Vec<String> {
    ["dense", "ring8", "ring24", "laser"].map(String::from).into()
}

/// The destination of a log. A file is written under a temporary name beside its place, and renamed when it is complete.
enum Destination {
    Stream(Box<dyn Write + Send>),
    File(NamedTempFile),
}

impl Destination {
    fn open(path: &Path) -> Result<Destination> {
        if path == Path::new("-") {
            return Ok(Destination::Stream(Box::new(io::stdout())));
        }
        if path.exists() && !path.is_file() && !path.is_dir() {
            // a pipe or a device
            return Ok(Destination::Stream(Box::new(File::create(path).map_err(|e| unwritable(path, e))?)));
        }
        if path.is_dir() {
            return Err(Error::Resources(format!("{} is a folder: give a file with -o", path.display())));
        }
        if !replaceable(path).map_err(|e| unwritable(path, e))? {
            let what = "it is no log of echogrid's, so it is left as it is";
            return Err(Error::Resources(format!(
                "{} can't be the log: {what}; give another file with -o",
                path.display()
            )));
        }
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let name = path.file_name().unwrap_or_default();
        let file = tempfile::Builder::new().prefix(name).suffix(".partial").make_in(folder, |p| File::create_new(p));
        let file = file.map_err(|e| unwritable(path, e))?;
        interrupt::register_temporary(file.path());
        Ok(Destination::File(file))
    }

    fn finish(self, path: &Path) -> Result<()> {
        match self {
            Destination::Stream(_) => Ok(()),
            Destination::File(file) => file.persist(path).map(drop).map_err(|e| unwritable(path, e.error)),
        }
    }
}

impl Write for Destination {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Destination::Stream(out) => match out.write(bytes) {
                // A closed pipe: the reader has all it wants.
                Err(e) if e.kind() == io::ErrorKind::BrokenPipe => std::process::exit(0),
                other => other,
            },
            Destination::File(out) => out.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Destination::Stream(out) => out.flush(),
            Destination::File(out) => out.flush(),
        }
    }
}

/// Whether a log may replace the file at a path: there is none, or it is empty, or it begins as echogrid's own logs do.
fn replaceable(path: &Path) -> io::Result<bool> {
    const BEGIN: &[u8] = b"{\"echogrid_log\"";
    let mut begin = Vec::new();
    match File::open(path) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(true),
        file => file?.take(BEGIN.len() as u64).read_to_end(&mut begin)?,
    };
    Ok(begin.is_empty() || begin == BEGIN)
}

fn unwritable(path: &Path, cause: impl std::fmt::Display) -> Error {
    Error::Resources(format!("{} can't be written: {cause}; give another path with -o", path.display()))
}
