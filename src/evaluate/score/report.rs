//! What a score leaves to look at: error plots, histograms, and one HTML file that holds them all.

use super::chart::histogram;
use super::picture::Window;
use super::table::{labels, rows};
use super::{Check, Score, picture};
use crate::output::svg::{base64, escape};
use crate::{Error, Result};
use std::path::{Path, PathBuf};

const HEAD: &str = "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>echogrid score</title><style>\
body{font:15px/1.45 sans-serif;margin:2em auto;max-width:1200px;padding:0 1em;color:#222}\
table{border-collapse:collapse}td,th{padding:.2em .8em;text-align:right;border-bottom:1px solid #ddd}\
td:first-child,th:first-child{text-align:left}td.best{font-weight:bold;background:#e8f3e8}\
figure{margin:0;flex:1 1 330px}figure img{width:100%;image-rendering:pixelated;border:1px solid #bbb}\
figcaption{color:#555}.row{display:flex;flex-wrap:wrap;gap:1em;align-items:flex-start}svg{max-width:100%;height:auto}\
.key span{display:inline-block;padding:.1em .6em;border:1px solid #999}.bad{color:#a00}</style></head><body>\n";

const NOTES: &str = "<p>White is right, darker is more dangerous. 1: occupied beside a true wall. 2, 3, 4: left unknown. \
5, 6: occupied where nothing is. <b>7: empty where nothing is known; 8, 9: a wall shown empty, 9 with nothing occupied \
beside it.</b> Bluish grey is not compared. In the pictures of the truth and of the map white is empty, black occupied, bluish \
grey unknown. docs/scores.md says what each number means.</p>\n";

/// Writes `score.html` with everything in it, and for each map its error plot and its histogram, into a folder that is
/// made if need be. Returns the path of the HTML file.
pub fn write_report(folder: &Path, truth: &str, scores: &[Score], checks: &[Check]) -> Result<PathBuf> {
    let unwritable = |path: &Path, e: std::io::Error| {
        Error::Resources(format!("{} can't be written: {e}; give another folder with -o", path.display()))
    };
    std::fs::create_dir_all(folder).map_err(|e| unwritable(folder, e))?;
    let save = |name: String, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).map_err(|e| unwritable(&path, e)).map(|()| path)
    };
    let drawn = |e: std::io::Error| Error::Resources(format!("a picture can't be drawn: {e}"));
    let labels = labels(scores);
    let mut html = format!("{HEAD}<h1>Maps scored against {}</h1>\n", escape(truth));
    html += &conditions(checks);
    html += &html_table(scores, &labels);
    html += "<p class=\"key\">Error level: ";
    for level in 0..10 {
        let text = if level > 5 { "#fff" } else { "#000" };
        html += &format!("<span style=\"background:{};color:{text}\">{level}</span>", picture::colour(level));
    }
    html += "</p>\n";
    html += NOTES;
    let anchored = scores.windows(2).all(|s| s[0].cells.grid.anchor == s[1].cells.grid.anchor);
    let window = anchored.then(|| Window::around(scores.iter().map(|s| &s.cells)));
    for ((score, label), file) in scores.iter().zip(&labels).zip(file_names(&labels)) {
        let cells = &score.cells;
        let window = window.unwrap_or_else(|| Window::around([cells].into_iter()));
        let errors = picture::errors(cells, &window).map_err(drawn)?;
        let chart = histogram(label, &score.numbers.levels);
        save(format!("{file}.errors.png"), &errors)?;
        save(format!("{file}.levels.svg"), chart.as_bytes())?;
        html += &format!("<h2>{} ({})</h2>\n<div class=\"row\">", escape(label), escape(&score.method));
        let pictures = [
            ("truth", picture::classes(cells, &window, &cells.actual).map_err(drawn)?),
            ("map", picture::classes(cells, &window, &cells.obtained).map_err(drawn)?),
            ("errors", errors),
        ];
        for (what, png) in pictures {
            html += &format!(
                "<figure><img alt=\"{what} of {0}\" src=\"data:image/png;base64,{1}\"><figcaption>{what}</figcaption>\
                 </figure>",
                escape(label),
                base64(&png)
            );
        }
        html += &format!("</div>\n{chart}");
    }
    save("score.html".into(), (html + "</body></html>\n").as_bytes())
}

fn conditions(checks: &[Check]) -> String {
    let line = |c: &Check| {
        let (class, verdict) = if c.held { ("good", "holds") } else { ("bad", "does not hold") };
        let value = c.value.map_or("no value".into(), |v| format!("{v:.4}"));
        let (require, path) = (escape(&c.require), escape(&c.path));
        format!("<li class=\"{class}\">{require} {verdict} for {path}: {value}</li>\n")
    };
    let items: String = checks.iter().map(line).collect();
    if items.is_empty() { items } else { format!("<ul>{items}</ul>\n") }
}

fn html_table(scores: &[Score], labels: &[String]) -> String {
    let head: String = labels.iter().map(|l| format!("<th>{}</th>", escape(l))).collect();
    let mut html = format!("<table><tr><th></th>{head}</tr>\n");
    for row in rows(scores) {
        html += &format!("<tr><td>{}</td>", escape(&row.name));
        for (value, best) in row.values.iter().zip(&row.best) {
            html += &format!("<td{}>{value}</td>", if *best { " class=\"best\"" } else { "" });
        }
        html += "</tr>\n";
    }
    html + "</table>\n"
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
    fn file_names_are_plain_and_differ() {
        let labels = ["a/b", "a:b", "../..", ""].map(String::from);
        assert_eq!(file_names(&labels), ["a_b", "a_b-2", "map", "map-2"]);
    }
}
