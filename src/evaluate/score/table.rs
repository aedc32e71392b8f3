//! Scores side by side as a text table, with the best of each row marked.

use super::{Numbers, Score};

/// Which values of a row are better.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Better {
    Higher,
    Lower,
    Neither,
}

/// A row: its name, the maps' values as text, and which of them are best.
pub(super) struct Row {
    pub name: String,
    pub values: Vec<String>,
    pub best: Vec<bool>,
}

/// A table with a column for each map and `*` at the best of each row.
pub fn table(scores: &[Score]) -> String {
    let mut lines = vec![(String::new(), labels(scores))];
    for row in rows(scores) {
        let mark = |(value, best): (String, bool)| format!("{value}{}", if best { " *" } else { "  " });
        lines.push((row.name, row.values.into_iter().zip(row.best).map(mark).collect()));
    }
    lines[0].1.iter_mut().for_each(|label| *label += "  ");
    let length = |text: &str| text.chars().count();
    let first = lines.iter().map(|l| length(&l.0)).max().unwrap_or(0);
    let widths: Vec<usize> =
        (0..scores.len()).map(|k| lines.iter().map(|l| length(&l.1[k])).max().unwrap_or(0)).collect();
    let line = |(name, values): &(String, Vec<String>)| {
        let mut text = format!("{name:first$}");
        for (value, width) in values.iter().zip(&widths) {
            text += &format!("  {value:>width$}");
        }
        text.trim_end().to_string()
    };
    lines.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// The maps' labels: the folder's name, or the whole path where two maps have the same name.
pub(super) fn labels(scores: &[Score]) -> Vec<String> {
    let short = |path: &str| {
        let path = path.trim_end_matches(['/', '\\']);
        let name = path.rsplit(['/', '\\']).next().unwrap_or(path);
        if name.is_empty() || name == "." || name == ".." { path.to_string() } else { name.to_string() }
    };
    let names: Vec<String> = scores.iter().map(|s| short(&s.path)).collect();
    let alone = |name: &String| names.iter().filter(|n| *n == name).count() == 1;
    names.iter().zip(scores).map(|(name, s)| if alone(name) { name.clone() } else { s.path.clone() }).collect()
}

/// A number of the table: its name, which values are better, how to get and how to print it.
type RowSpec = (&'static str, Better, fn(&Numbers) -> Option<f64>, fn(f64) -> String);

fn count(v: f64) -> String {
    format!("{v:.0}")
}

fn fraction(v: f64) -> String {
    format!("{v:.3}")
}

fn percent(v: f64) -> String {
    format!("{:.1} %", 100.0 * v)
}

fn of_cells(part: u64, n: &Numbers) -> Option<f64> {
    (n.cells > 0).then(|| part as f64 / n.cells as f64)
}

const ROWS: &[RowSpec] = {
    use Better::{Higher, Lower, Neither};
    &[
        ("cells compared", Neither, |n| Some(n.cells as f64), count),
        ("known in both", Neither, |n| Some(n.known as f64), count),
        ("left unknown", Lower, |n| n.unknown, percent),
        ("accuracy", Higher, |n| n.accuracy, fraction),
        ("danger", Lower, |n| n.danger, fraction),
        ("danger, of all walls", Lower, |n| n.freed, fraction),
        ("walls shown free", Lower, |n| Some(n.o_to_e as f64), count),
        ("walls found", Higher, |n| Some(n.occupied_found as f64), count),
        ("recall, tolerant", Higher, |n| n.recall_tolerant, fraction),
        ("precision, tolerant", Higher, |n| n.precision_tolerant, fraction),
        ("F1, tolerant", Higher, |n| n.f1_tolerant, fraction),
        ("IoU, tolerant", Higher, |n| n.iou_tolerant, fraction),
        ("recall", Higher, |n| n.recall, fraction),
        ("precision", Higher, |n| n.precision, fraction),
        ("F1", Higher, |n| n.f1, fraction),
        ("IoU", Higher, |n| n.iou, fraction),
        ("Z1 accurate", Higher, |n| of_cells(n.zones.z1, n), percent),
        ("Z2 safe", Higher, |n| of_cells(n.zones.z2, n), percent),
        ("Z3 overhead", Lower, |n| of_cells(n.zones.z3, n), percent),
        ("Z4 less accurate", Lower, |n| of_cells(n.zones.z4, n), percent),
        ("Z5 danger", Lower, |n| of_cells(n.zones.z5, n), percent),
        ("Z5 cells", Lower, |n| Some(n.zones.z5 as f64), count),
        ("Brier", Lower, |n| n.quality.brier, fraction),
        ("log loss", Lower, |n| n.quality.log_loss, fraction),
        ("AUC", Higher, |n| n.quality.auc, fraction),
        ("calibration error", Lower, |n| n.quality.ece, fraction),
    ]
};

/// The rows that are repeated for the world's box and half a metre around it.
const NEAR: &[&str] = &["cells compared", "accuracy", "Z1 accurate", "Z2 safe", "Z5 danger", "Z5 cells"];

/// Every row.
pub(super) fn rows(scores: &[Score]) -> Vec<Row> {
    let all: Vec<Option<&Numbers>> = scores.iter().map(|s| Some(&s.numbers)).collect();
    let near: Vec<Option<&Numbers>> = scores.iter().map(|s| s.near.as_ref()).collect();
    let mut rows: Vec<Row> = ROWS.iter().map(|c| row(c.0.into(), c, &all)).collect();
    if near.iter().any(Option::is_some) {
        let again = ROWS.iter().filter(|c| NEAR.contains(&c.0));
        rows.extend(again.map(|c| row(format!("near: {}", c.0), c, &near)));
    }
    rows
}

fn row(name: String, &(_, better, get, print): &RowSpec, numbers: &[Option<&Numbers>]) -> Row {
    let values: Vec<Option<f64>> = numbers.iter().map(|n| n.and_then(get)).collect();
    let text: Vec<String> = values.iter().map(|v| v.map_or("-".into(), print)).collect();
    let found = values.iter().flatten().copied();
    let best = match better {
        Better::Higher => found.reduce(f64::max),
        Better::Lower => found.reduce(f64::min),
        Better::Neither => None,
    };
    // Values that print alike are equal. A row of equal values has no best.
    let best = best.filter(|_| numbers.len() > 1).map(print);
    let is_best: Vec<bool> = text.iter().map(|t| Some(t) == best.as_ref()).collect();
    let all = is_best.iter().all(|b| *b);
    Row { name, best: is_best.into_iter().map(|b| b && !all).collect(), values: text }
}
