//! `echogrid plan`.

use super::common::{LogArguments, bar, count, done, parameters, warn_of_bad_lines, warn_of_jump};
use super::say;
use crate::Result;
use crate::kernels::dry::Dry;
use crate::memory::{self, show};
use crate::method::{self, Step};
use crate::output::tidy;

/// Arguments of `plan`.
#[derive(Debug, clap::Args)]
pub struct Plan {
    #[command(flatten)]
    log: LogArguments,
    /// Print the plan as JSON
    #[arg(long)]
    json: bool,
}

impl Plan {
    /// Reads and bins the log, and says what it came to.
    pub fn run(self) -> Result<u8> {
        let session = self.log.session()?;
        warn_of_bad_lines(&session);
        warn_of_jump(&self.log, &session);
        let mut dry = Dry::default();
        let method = session.method.as_ref();
        let mut mapper = crate::mapper::Mapper::new(session.grid, session.sensors(), method, &mut dry, self.log.batch);
        let bar = bar(session.survey.counts.used, "plan", self.json);
        mapper.sweep(0, session.items()?.inspect(|_| bar.inc(1)))?;
        drop(bar);
        let work = mapper.work;
        let (grid, counts) = (&session.grid, &session.survey.counts);
        let need = session.memory(self.log.batch);
        let fit = session.check_memory(need, None);
        let steps: Vec<Vec<String>> =
            method.sweeps().iter().map(|sweep| sweep.iter().map(|s| step_name(s).to_string()).collect()).collect();
        let busiest = dry.chunks.iter().max_by_key(|(_, load)| load.entries);
        if self.json {
            let chunks: Vec<_> = dry.chunks.iter().map(|(at, load)| serde_json::json!({"row": at[0], "column": at[1], "entries": load.entries, "tiles": load.tiles})).collect();
            let plan = serde_json::json!({
                "method": method::name(method),
                "format": session.log.header().format,
                "parameters": parameters(&session).into_iter().collect::<std::collections::BTreeMap<_, _>>(),
                "readings": counts,
                "scans": session.survey.scans,
                "bad_lines": session.survey.bad_lines.count,
                "cells": {"x0": tidy(grid.x0()), "y0": tidy(grid.y0()), "resolution": grid.resolution, "width": grid.width, "height": grid.height},
                "chunks": chunks,
                "batches": work.batches,
                "entries": work.entries,
                "sweeps": steps,
                "memory": need,
                "fits": fit.is_ok(),
                "available": memory::available(),
            });
            say!("{}", serde_json::to_string_pretty(&plan).unwrap_or_default());
            return Ok(done(&session));
        }
        say!("log       {}, {}", session.log.header().format, count(session.sensors().len() as u64, "sensor"));
        say!(
            "readings  {} used of {} in {}, {}, {}",
            counts.used,
            counts.read,
            count(session.survey.scans, "scan"),
            count(session.survey.bad_lines.count, "bad line"),
            count(session.survey.ignored, "other line")
        );
        say!(
            "grid      {} × {} cells of {} m from ({:.2}, {:.2}) to ({:.2}, {:.2}) m",
            grid.width,
            grid.height,
            grid.resolution,
            grid.x0(),
            grid.y0(),
            grid.x0() + grid.width as f64 * grid.resolution,
            grid.y0() + grid.height as f64 * grid.resolution
        );
        say!(
            "chunks    {} reached; {} pairs of reading and tile in {} batches",
            dry.chunks.len(),
            work.entries,
            work.batches
        );
        if let Some((at, load)) = busiest {
            say!(
                "          the busiest, column {} row {}, has {} pairs in {} tiles",
                at[1],
                at[0],
                load.entries,
                load.tiles
            );
        }
        for (k, sweep) in steps.iter().enumerate() {
            say!("sweep {}   {}", k + 1, sweep.join(", then "));
        }
        let free = memory::available().map(|f| format!(", of {} free", show(f))).unwrap_or_default();
        say!("memory    about {}{free}", show(need));
        if let Err(e) = fit {
            say!("does not fit: {e}");
        }
        for (key, value) in parameters(&session) {
            say!("  {key} = {value}");
        }
        Ok(done(&session))
    }
}

fn step_name(step: &Step) -> &'static str {
    match step {
        Step::Pass(method::Pass::Weigh, _) => "weigh",
        Step::Pass(method::Pass::Count, _) => "count",
        Step::Pass(method::Pass::Fuse, _) => "fuse",
        Step::Sum => "sum",
        Step::Share => "share",
        Step::Hand => "hand over",
        Step::Tally => "tally",
    }
}
