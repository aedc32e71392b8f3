//! `echogrid truth`: a world's true map, as a map's folder like any other.

use super::values::{check_bounds, parse_length, parse_number};
use super::{interrupt, print_line, print_note};
use crate::Result;
use crate::evaluate::score::{extended_box, sensor_range};
use crate::grid::GridSpec;
use crate::output::{self, Folder, LogInfo, RunInfo};
use crate::pipeline::layers::of_classes;
use crate::world::{Shipped, World, true_map};
use clap::ValueHint;
use std::path::PathBuf;

/// Bytes of memory a cell: two layers, their pictures, the cells of the surfaces.
const BYTES_PER_CELL: u64 = 16;

/// Arguments of `truth`.
#[derive(Debug, clap::Args)]
pub struct TruthArguments {
    /// The world: a built-in one (`echogrid simulate --list`), such as room, or a TOML file
    #[arg(value_hint = ValueHint::FilePath)]
    world: PathBuf,
    /// Folder of the map; an echogrid map there is replaced when the new one is complete
    #[arg(short, long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    output: PathBuf,
    /// Edge of a cell: metres, or with mm, cm, m
    #[arg(short, long, value_name = "LENGTH", default_value = "0.05", value_parser = parse_length, allow_hyphen_values = true)]
    resolution: f64,
    /// Bounds in metres [default: the world's box and the range around it]
    #[arg(short, long, value_name = "X0,Y0,X1,Y1", value_delimiter = ',', num_args = 1, value_parser = parse_number, allow_hyphen_values = true)]
    bounds: Option<Vec<f64>>,
    /// How far is seen, metres [default: the farthest range of the world's sonars]
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    r_max: Option<f64>,
    /// Print nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

impl TruthArguments {
    /// Draws the true map.
    pub fn run(self) -> Result<u8> {
        let bounds = check_bounds(self.bounds.as_deref(), self.resolution)?;
        Shipped::beside_file(&self.world).iter().for_each(|what| print_note!("{what}"));
        let world = World::find(&self.world)?;
        let r_max = sensor_range(&world, self.r_max)?;
        let grid = match bounds {
            Some(bounds) => GridSpec::from_bounds(bounds, self.resolution)?,
            None => GridSpec::around(extended_box(world.bounds(), r_max), self.resolution)?,
        };
        grid.check_memory(
            grid.cells() as u64 * BYTES_PER_CELL,
            None,
            "give smaller --bounds or a coarser --resolution",
        )?;
        let created = interrupt::missing_parents(&self.output);
        let folder = Folder::prepare(&self.output)?;
        interrupt::register_output(folder.path(), created, false);
        let class = true_map(&world, &world.scans(), &grid, r_max);
        let info = RunInfo {
            parameters: output::parameters([("resolution", grid.resolution.to_string()), ("r_max", r_max.to_string())]),
            log: LogInfo { path: self.world.display().to_string(), sha256: world.sha256.clone(), ..LogInfo::default() },
            backend: "cpu".into(),
            ..RunInfo::default()
        };
        let map = of_classes(grid, "world", class);
        let Some(combined) = map.layer("class").cloned() else { return Ok(0) };
        let guard = interrupt::defer_signals();
        let report = output::write_map(&folder, &map, &combined, &info, false)?;
        let place = folder.finish()?;
        interrupt::mark_finished(&place, guard);
        if !self.quiet {
            let c = &report.cells;
            print_line!(
                "{}, seen from {} places up to {r_max} m: {} × {} cells of {} m; {} occupied, {} empty, {} unknown",
                world.name,
                world.trajectory.len(),
                c.width,
                c.height,
                c.resolution,
                c.occupied,
                c.empty,
                c.unknown
            );
            print_line!("{}", place.join("map.png").display());
        }
        Ok(0)
    }
}
