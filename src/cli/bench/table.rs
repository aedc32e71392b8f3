//! The table of `echogrid bench`.

use crate::bench::throughput::Measurement;
use crate::bench::workload::Workload;
use crate::cli::print_line;
use crate::kernels::peak::Peaks;
use crate::support::wrap::wrap;

/// The most characters of a workload's name; the second where the runs are compared with earlier ones.
const MAX_NAME: [usize; 2] = [30, 22];
/// Widths of the columns after the name.
const WIDTHS: [usize; 8] = [10, 11, 8, 8, 7, 12, 12, 8];

/// The legend of the columns.
const LEGEND: &str = "
M updates: millions of cell updates; one is one reading applied to one cell.
whole: the median of the runs, from readings in memory to cells in memory; binning: what of it is
spent on finding which tiles the readings reach, before the kernels.
per update: bytes that an update moves if nothing is cached.
of the limit: how much of what the processor can do at most, above, is reached in what is used most:
floating-point operations (flop), integer ones (int) or memory traffic (bytes); whole: by the whole
run; in kernels: by the kernels alone, by the processor's own clock.";

/// How a table is printed.
#[derive(Clone, Copy)]
pub(super) struct Style {
    /// As Markdown.
    pub markdown: bool,
    /// Not at all.
    pub silent: bool,
    /// With the factor to an earlier run.
    pub compared: bool,
}

/// The table of results, printed row by row.
pub(super) struct Table {
    /// Characters of the column of workloads.
    width: usize,
    style: Style,
    /// The method whose rows are being printed.
    method: String,
}

impl Table {
    /// A table for results of these workloads.
    pub fn new<'a>(workloads: impl Iterator<Item = &'a Workload>, style: Style) -> Table {
        let widest = workloads.map(|w| w.name.chars().count()).max().unwrap_or(0);
        let width = widest.clamp(15, MAX_NAME[usize::from(style.compared)]);
        Table { width, style, method: String::new() }
    }

    /// Prints a backend's title, its peaks, and the heads of the columns.
    pub fn begin(&mut self, title: &str, ceilings: Option<Peaks>) {
        if self.style.silent {
            return;
        }
        let most = ceilings.map(|c| {
            let giga = |v: f64| v / 1e9;
            format!(
                "at most {:.1} GFLOP/s (fused), {:.1} G integer operations/s, {:.1} GB/s copied",
                giga(c.flop),
                giga(c.int),
                giga(c.bytes)
            )
        });
        let gap = if self.style.markdown { "\n" } else { "" };
        print_line!("{gap}{}{gap}", wrap(title, 2));
        most.iter().for_each(|m| print_line!("{m}{gap}"));
        self.method.clear();
        if self.style.markdown {
            let mut heads = vec![
                "method",
                "workload",
                "M updates/s",
                "k readings/s",
                "ms",
                "binning",
                "B/update",
                "of ceiling",
                "in kernels",
                "passes, ms",
            ];
            heads.extend(self.style.compared.then_some("before"));
            print_line!("| {} |", heads.join(" | "));
            print_line!("|{}", "---|".repeat(heads.len()));
            return;
        }
        for (first, heads) in [
            ("", ["M updates", "k readings", "whole", "binning", "per", "of the", "limit", "times"]),
            ("workload", ["a second", "a second", "ms", "ms", "update", "whole", "in kernels", "before"]),
        ] {
            self.line(first, &heads.map(String::from)[..WIDTHS.len() - usize::from(!self.style.compared)]);
        }
    }

    /// Prints a result; `before`: the updates a second of an earlier run, where one is compared.
    pub fn row(&mut self, m: &Measurement, before: Option<Option<f64>>) {
        if self.style.silent {
            return;
        }
        let mut cells = vec![
            format!("{:.1}", m.updates_per_second / 1e6),
            format!("{:.1}", m.readings_per_second / 1e3),
            format!("{:.1}", m.median * 1e3),
            format!("{:.1}", m.binning * 1e3),
            format!("{:.1}", m.bytes),
            share(m.ceiling),
            share(m.kernels),
        ];
        let before = before.map(|b| b.map_or("-".into(), |old| format!("{:.2} x", m.updates_per_second / old)));
        if self.style.markdown {
            cells.push(passes(m, " "));
            cells.extend(before);
            print_line!("| {} | {} | {} |", m.method, m.workload, cells.join(" | "));
            return;
        }
        cells.extend(before);
        if self.method != m.method {
            print_line!("{}", m.method);
            self.method = m.method.clone();
        }
        self.line(&m.workload, &cells);
        if m.passes.len() > 1 {
            print_line!("    of which kernels, ms: {}", passes(m, ", "));
        }
    }

    /// Prints a row of cells.
    fn line(&self, workload: &str, cells: &[String]) {
        let cells: String = cells.iter().zip(WIDTHS).map(|(text, width)| format!("{text:>width$}")).collect();
        print_line!("  {:<1$}{cells}", short(workload, self.width), self.width);
    }

    /// Prints the legend of the columns.
    pub fn end(&self) {
        if !self.style.silent && !self.style.markdown {
            print_line!("{LEGEND}");
        }
    }
}

/// A share of a peak, in percent.
fn share(share: Option<(f64, &str)>) -> String {
    share.map_or("-".into(), |(share, of)| format!("{:.0} % {of}", 100.0 * share))
}

/// The time of each kind of pass, ms.
fn passes(m: &Measurement, joint: &str) -> String {
    let each: Vec<String> = m.passes.iter().map(|(name, s)| format!("{name} {:.2}", s * 1e3)).collect();
    if each.is_empty() { "-".into() } else { each.join(joint) }
}

/// A name, cut to the width of its column.
fn short(name: &str, most: usize) -> String {
    if name.chars().count() <= most {
        return name.into();
    }
    let end = name.char_indices().nth(most - 1).map_or(name.len(), |(at, _)| at);
    format!("{}…", &name[..end])
}
