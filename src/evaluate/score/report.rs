//! The files of a score: error plots, histograms, and one HTML page that contains them all.

use super::chart::histogram;
use super::picture::Window;
use super::table::{labels, rows};
use super::{Check, Score, picture};
use crate::{Error, Result};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::path::{Path, PathBuf};

const STYLE: &str = "\
body{font:15px/1.45 sans-serif;margin:2em auto;max-width:1200px;padding:0 1em;color:#222}\
table{border-collapse:collapse}td,th{padding:.2em .8em;text-align:right;border-bottom:1px solid #ddd}\
td:first-child,th:first-child{text-align:left}td.best{font-weight:bold;background:#e8f3e8}\
figure{margin:0;flex:1 1 330px}figure img{width:100%;image-rendering:pixelated;border:1px solid #bbb}\
figcaption{color:#555}.row{display:flex;flex-wrap:wrap;gap:1em;align-items:flex-start}svg{max-width:100%;height:auto}\
.key span{display:inline-block;padding:.1em .6em;border:1px solid #999}.bad{color:#a00}";

/// Writes `score.html`, and the error plot and the histogram of each map, into a folder that is created if need be. Returns the path of
/// the HTML file.
///
/// # Errors
/// [`Error::Resources`] where a file can't be written.
pub fn write_report(folder: &Path, truth: &str, scores: &[Score], checks: &[Check]) -> Result<PathBuf> {
    let unwritable = |path: &Path, e: std::io::Error| {
        Error::Resources(format!("{} can't be written: {e}; give another folder with -o", path.display()))
    };
    std::fs::create_dir_all(folder).map_err(|e| unwritable(folder, e))?;
    let save = |name: String, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).map_err(|e| unwritable(&path, e)).map(|()| path)
    };
    let labels = labels(scores);
    let sections = sections(scores, &labels)?;
    for (section, file) in sections.iter().zip(file_names(&labels)) {
        save(format!("{file}.errors.png"), &section.errors)?;
        save(format!("{file}.levels.svg"), section.chart.as_bytes())?;
    }
    save("score.html".into(), page(truth, scores, checks, &sections).into_string().as_bytes())
}

/// What the page shows of one map: its pictures as PNG, its histogram as SVG.
struct Section<'a> {
    label: &'a str,
    method: &'a str,
    truth: Vec<u8>,
    map: Vec<u8>,
    errors: Vec<u8>,
    chart: String,
}

fn sections<'a>(scores: &'a [Score], labels: &'a [String]) -> Result<Vec<Section<'a>>> {
    let failed = |e: std::io::Error| Error::Resources(format!("a picture can't be drawn: {e}"));
    let anchored = scores.windows(2).all(|s| s[0].cells.grid.anchor == s[1].cells.grid.anchor);
    let common = anchored.then(|| Window::around(scores.iter().map(|s| &s.cells)));
    let section = |(score, label): (&'a Score, &'a String)| {
        let cells = &score.cells;
        let window = common.unwrap_or_else(|| Window::around([cells].into_iter()));
        Ok(Section {
            label,
            method: &score.method,
            truth: picture::classes(cells, &window, &cells.actual).map_err(failed)?,
            map: picture::classes(cells, &window, &cells.obtained).map_err(failed)?,
            errors: picture::errors(cells, &window).map_err(failed)?,
            chart: histogram(label, &score.numbers.levels),
        })
    };
    scores.iter().zip(labels).map(section).collect()
}

fn page(truth: &str, scores: &[Score], checks: &[Check], sections: &[Section]) -> Markup {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                title { "echogrid score" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { "Maps scored against " (truth) }
                (conditions(checks))
                (table(scores, sections))
                (level_key())
                p {
                    "White is right, darker is more dangerous. 1: occupied beside a true wall. 2, 3, 4: left unknown. \
                     5, 6: occupied where nothing is. "
                    b {
                        "7: empty where nothing is known; 8, 9: a wall shown empty, 9 with nothing occupied beside it."
                    }
                    " Bluish grey is not compared. In the pictures of the truth and of the map white is empty, black \
                     occupied, bluish grey unknown. docs/scores.md says what each number means."
                }
                @for section in sections {
                    h2 { (section.label) " (" (section.method) ")" }
                    div class="row" {
                        (figure("truth", section.label, &section.truth))
                        (figure("map", section.label, &section.map))
                        (figure("errors", section.label, &section.errors))
                    }
                    (PreEscaped(&section.chart))
                }
            }
        }
    }
}

/// A picture inside the page.
fn figure(what: &str, label: &str, png: &[u8]) -> Markup {
    html! {
        figure {
            img alt={ (what) " of " (label) } src={ "data:image/png;base64," (BASE64_STANDARD.encode(png)) };
            figcaption { (what) }
        }
    }
}

/// The conditions of `--require`, and whether they hold.
fn conditions(checks: &[Check]) -> Markup {
    html! {
        @if !checks.is_empty() {
            ul {
                @for check in checks {
                    li class=(if check.held { "good" } else { "bad" }) {
                        (check.require) (if check.held { " holds for " } else { " does not hold for " }) (check.path) ": "
                        (check.value.map_or("no value".into(), |v| format!("{v:.4}")))
                    }
                }
            }
        }
    }
}

fn table(scores: &[Score], sections: &[Section]) -> Markup {
    html! {
        table {
            tr {
                th {}
                @for section in sections { th { (section.label) } }
            }
            @for row in rows(scores) {
                tr {
                    td { (row.name) }
                    @for (value, best) in row.values.iter().zip(&row.best) {
                        td class=[best.then_some("best")] { (value) }
                    }
                }
            }
        }
    }
}

/// The colours of the error levels.
fn level_key() -> Markup {
    html! {
        p class="key" {
            "Error level: "
            @for level in 0..10 {
                span style=(format!(
                    "background:{};color:{}",
                    picture::colour(level),
                    if level > 5 { "#fff" } else { "#000" }
                )) { (level) }
            }
        }
    }
}

/// Labels as file names, no two the same.
fn file_names(labels: &[String]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for label in labels {
        let plain = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' };
        let name: String = label.chars().map(plain).collect();
        let name = name.trim_matches(['_', '.']);
        let name = if name.is_empty() { "map" } else { name };
        let taken = |n: &String| names.iter().any(|m| m.eq_ignore_ascii_case(n));
        let numbered = (2..).map(|k| format!("{name}-{k}"));
        let free = std::iter::once(name.to_string()).chain(numbered).find(|n| !taken(n));
        names.extend(free);
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_escaped_and_pictures_are_embedded() {
        let figure = figure("map", "a<b>&\"c\"", b"\xfb\xff\xfe").into_string();
        assert!(figure.contains("alt=\"map of a&lt;b&gt;&amp;&quot;c&quot;\""), "{figure}");
        assert!(figure.contains("src=\"data:image/png;base64,+//+\""), "{figure}");
    }

    #[test]
    fn file_names_are_plain_and_differ() {
        let labels = ["a/b", "a:b", "../..", ""].map(String::from);
        assert_eq!(file_names(&labels), ["a_b", "a_b-2", "map", "map-2"]);
    }
}
