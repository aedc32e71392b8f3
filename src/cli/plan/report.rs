//! A plan as text and as JSON.

use super::estimate::TimeEstimate;
use crate::cli::print_line;
use crate::cli::text::{count, format_value, print_item};
use crate::grid::{self, ChunkId};
use crate::method;
use crate::output::tidy;
use crate::pipeline::session::Session;
use crate::support::memory::{self, format_size};
use crate::support::wrap::wrap;
use serde_json::json;

/// A plan, as it is printed.
#[derive(Default)]
pub(super) struct PlanReport {
    /// The passes of each round.
    pub rounds: Vec<String>,
    /// The chunks that have readings, with how many.
    pub chunks: Vec<(ChunkId, u64)>,
    /// Sum of the readings of all chunks.
    pub binned: u64,
    /// Bytes of a GPU's memory that the run needs; 0: unknown.
    pub card: u64,
    /// The time, where it was measured.
    pub estimate: Option<TimeEstimate>,
    /// Readings at a time.
    pub batch: usize,
    /// Bytes that the run needs at once.
    pub memory: u64,
    /// Bytes of the outputs that aren't compressed.
    pub disk: u64,
    /// Bytes of bins that went to disk.
    pub spilled: u64,
    /// Why the run would fail.
    pub why_not: Option<String>,
}

impl PlanReport {
    /// Prints the plan as JSON.
    pub fn print_json(&self, session: &Session) {
        let cells = &session.grid;
        let chunk = |(ChunkId { row, column }, readings): &(ChunkId, u64)| json!({"row": row, "column": column, "readings": readings});
        let plan = json!({
            "method": method::name(session.method.as_ref()),
            "format": session.log.header().format,
            "parameters": session.parameters().into_iter().collect::<std::collections::BTreeMap<_, _>>(),
            "readings": session.survey.counts,
            "scans": session.survey.scans,
            "bad_lines": session.survey.bad_lines.count,
            "cells": {"x0": tidy(cells.x0()), "y0": tidy(cells.y0()), "resolution": cells.resolution, "width": cells.width, "height": cells.height},
            "chunks": self.chunks.iter().map(chunk).collect::<Vec<_>>(),
            "binned": self.binned,
            "spilled": self.spilled,
            "batch": self.batch,
            "rounds": self.rounds,
            "memory": self.memory,
            "card": self.card,
            "disk": self.disk,
            "fits": self.why_not.is_none(),
            "why_not": self.why_not,
            "available": memory::available(),
            "expected": self.estimate.iter().collect::<Vec<_>>(),
        });
        print_line!("{}", serde_json::to_string_pretty(&plan).unwrap_or_default());
    }

    /// Prints the plan as text.
    pub fn print(&self, session: &Session) {
        let (cells, counts) = (&session.grid, &session.survey.counts);
        let sensors = count(session.sensors().len() as u64, "sensor");
        print_item("log", &format!("{}, {sensors}", session.log.header().format));
        print_item(
            "readings",
            &format!(
                "{} used of {} in {}, {}, {}",
                counts.used,
                counts.read,
                count(session.survey.scans, "scan"),
                count(session.survey.bad_lines.count, "bad line"),
                count(session.survey.ignored, "other line")
            ),
        );
        let end = |start: f64, count: usize| start + count as f64 * cells.resolution;
        print_item(
            "grid",
            &format!(
                "{} × {} cells of {} m from ({:.2}, {:.2}) to ({:.2}, {:.2}) m",
                cells.width,
                cells.height,
                cells.resolution,
                cells.x0(),
                cells.y0(),
                end(cells.x0(), cells.width),
                end(cells.y0(), cells.height)
            ),
        );
        if let Some((ChunkId { row, column }, most)) = self.chunks.iter().max_by_key(|p| p.1) {
            print_item(
                "chunks",
                &format!(
                    "{} of {} squares of {} × {} cells have readings; the fullest, column {column} row {row}, has {most}",
                    self.chunks.len(),
                    grid::chunks(cells).count(),
                    grid::EDGE,
                    grid::EDGE,
                ),
            );
            let disk = if self.spilled > 0 {
                format!("; {} of them on disk", format_size(self.spilled))
            } else {
                String::new()
            };
            print_item(
                "",
                &format!(
                    "{} if a reading counts in each square that it reaches, {} at a time{disk}",
                    count(self.binned, "reading"),
                    self.batch
                ),
            );
        }
        for (k, steps) in self.rounds.iter().enumerate() {
            print_item(&format!("round {}", k + 1), steps);
        }
        let free = memory::available().map(|f| format!(", of {} free", format_size(f))).unwrap_or_default();
        print_item("memory", &format!("about {}{free}", format_size(self.memory)));
        if self.card > 0 {
            print_item("card", &format!("about {} of a GPU's memory, where one maps", format_size(self.card)));
        }
        if self.disk > 0 {
            print_item("disk", &format!("{} and the compressed layers", format_size(self.disk)));
        }
        if let Some(e) = &self.estimate {
            let (rate, chunk) = (e.readings_per_second / 1e3, e.chunk_seconds);
            let chunk = if chunk > 0.0 { format!(", {chunk:.3} s to write a chunk") } else { String::new() };
            let why = if e.why.is_empty() { String::new() } else { format!(", because {}", e.why) };
            let about = format!("about {:.1} s: {rate:.1} k readings/s{chunk} ({}{why})", e.seconds, e.adapter);
            print_item(e.backend, &about);
        }
        if let Some(e) = &self.why_not {
            print_line!("{}", wrap(&format!("does not fit: {e}"), 10));
        }
        for (key, value) in session.parameters() {
            print_line!("{}", wrap(&format!("  {key} = {}", format_value(&key, &value)), 10));
        }
    }
}
