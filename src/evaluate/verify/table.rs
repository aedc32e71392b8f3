//! A verification as text.

use super::report::{BackendCheck, CellDifference, LayerCheck, Verification};
use crate::support::wrap::wrap;
use std::fmt;

impl fmt::Display for CellDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let CellDifference { column, row, x, y, oracle, value, difference, bound, .. } = self;
        write!(f, "cell ({column}, {row}) at ({x:.3}, {y:.3}) m: oracle {oracle:.9}, here {value:.9}, ")?;
        write!(f, "difference {difference:.3e}, bound {bound:.3e}")?;
        let last: Vec<String> = self
            .last_readings
            .iter()
            .map(|r| format!("line {} sensor {} ({:.2} m)", r.line, r.sensor, r.range))
            .collect();
        if !last.is_empty() {
            write!(f, "; last readings: {}", last.join(", "))?;
        }
        Ok(())
    }
}

impl Verification {
    /// Whether a backend and the oracle differ.
    pub fn differs(&self) -> bool {
        self.backends.iter().any(|b| !b.passed)
    }

    /// The result in a line.
    fn verdict(&self) -> String {
        let ran: Vec<&str> = self.backends.iter().map(|b| b.backend.as_str()).collect();
        match (self.differs(), self.skipped.is_empty()) {
            (true, _) => "NOT EQUAL".into(),
            (false, true) => "equal".into(),
            (false, false) => {
                format!("NOT VERIFIED: only oracle and {} were compared, and are equal", ran.join(" and "))
            }
        }
    }
}

impl fmt::Display for Verification {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        let (method, readings, updates) = (&self.method, self.readings, self.updates);
        writeln!(f, "{method}: {readings} readings, {width} × {height} cells, {updates} cell updates")?;
        writeln!(f, "oracle  f64, one reading at a time ({:.2} s)", self.oracle_seconds)?;
        for backend in &self.backends {
            write_backend(f, backend)?;
        }
        if let Some(same) = self.same_bytes {
            writeln!(f, "cpu and gpu: {}", if same { "the same bytes in every layer" } else { "not the same bytes" })?;
        }
        for why in &self.absent {
            writeln!(f, "{}", wrap(why, 2))?;
        }
        for why in &self.skipped {
            writeln!(f, "{}", wrap(&format!("SKIPPED {why}"), 2))?;
        }
        write!(f, "{}", self.verdict())
    }
}

fn write_backend(f: &mut fmt::Formatter<'_>, b: &BackendCheck) -> fmt::Result {
    let ran = format!("{:<7} {} ({:.2} s)", b.backend, b.adapter, b.seconds);
    writeln!(f, "{}", wrap(&ran, 8))?;
    writeln!(f, "  cells that other readings reach  {}", b.membership)?;
    if let Some(cell) = &b.membership_cell {
        writeln!(f, "{}", wrap(&format!("    the first: {cell}"), 6))?;
    }
    if b.counts > 0 {
        writeln!(f, "  readings counted otherwise  {}", b.counts)?;
    }
    for layer in &b.layers {
        write_layer(f, layer)?;
    }
    let boundary = match b.class {
        0 => String::new(),
        _ => format!(", {} of them on a decision boundary", b.class - b.class_wrong),
    };
    writeln!(f, "  cells whose class differs  {}{boundary}", b.class)
}

fn write_layer(f: &mut fmt::Formatter<'_>, l: &LayerCheck) -> fmt::Result {
    let beyond = if l.beyond > 0 { format!("  {} CELLS BEYOND THEIR BOUND", l.beyond) } else { String::new() };
    writeln!(f, "  {:<10} largest difference {:.3e}, bound there {:.3e}{beyond}", l.layer, l.largest, l.bound)?;
    let mut write_cell = |what: &str, cell: &Option<CellDifference>| match cell {
        Some(cell) => writeln!(f, "{}", wrap(&format!("    {what}: {cell}"), 6)),
        None => Ok(()),
    };
    if l.largest_cell.is_some() && l.largest_cell == l.worst {
        return write_cell("largest, nearest to its bound", &l.worst);
    }
    write_cell("largest", &l.largest_cell)?;
    write_cell("nearest to its bound", &l.worst)
}
