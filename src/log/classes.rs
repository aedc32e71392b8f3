//! The names and colours of class labels (`--classes`, a TOML file).
//!
//! ```toml
//! [[class]]            # label 1, then 2, …
//! name = "north rooms"
//! colour = "#d55e00"
//!
//! [free]               # may be left out
//! name = "free"
//! colour = "#f4f6f8"
//! ```

use crate::grid::Palette;
use crate::{Error, Result};
use serde::Deserialize;
use std::path::Path;

/// The classes of a labelled log.
#[derive(Debug, Clone, PartialEq)]
pub struct Classes {
    /// Names of labels 1, 2, …, then of "free".
    pub names: Vec<String>,
    /// Their colours.
    pub palette: Palette,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    class: Vec<Row>,
    free: Option<Row>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    name: String,
    colour: Option<String>,
}

/// The classes of logs whose format has labels without names.
const ROOMS: &str = include_str!("../../classes/rooms.toml");
const FREE: [u8; 3] = [0xf4, 0xf6, 0xf8];

impl Classes {
    /// Reads a classes file.
    ///
    /// # Errors
    /// [`Error::Input`] with the line: unreadable, not TOML, an unknown key, a colour that is none, no class or too many.
    pub fn open(path: &Path) -> Result<Classes> {
        let text = std::fs::read_to_string(path).map_err(|e| Error::caused(path, format!("classes file: {e}"), e))?;
        Classes::parse(path, &text)
    }

    /// The six classes of the labelled Intel Research Lab.
    pub fn rooms() -> Result<Classes> {
        Classes::parse(Path::new("classes/rooms.toml"), ROOMS)
    }

    fn parse(path: &Path, text: &str) -> Result<Classes> {
        let file: File = toml::from_str(text).map_err(|e| Error::toml(path, text, &e))?;
        let free = file.free.unwrap_or(Row { name: "free".into(), colour: None });
        let count = file.class.len();
        let colour = |(k, row): (usize, &Row)| match &row.colour {
            None => Ok(if k == count { FREE } else { distinct(k, count) }),
            Some(text) => hex(text).ok_or_else(|| {
                let name = &row.name;
                Error::input(
                    path,
                    format!("class \"{name}\": \"{text}\" is no colour: write red, green and blue as #rrggbb"),
                )
            }),
        };
        let rows: Vec<Row> = file.class.into_iter().chain([free]).collect();
        let colours: Vec<[u8; 3]> = rows.iter().enumerate().map(colour).collect::<Result<_>>()?;
        let names: Vec<String> = rows.into_iter().map(|r| r.name).collect();
        Classes::of(names, &colours).ok_or_else(|| {
            Error::input(path, format!("has {count} [[class]] tables: 1 to {} are wanted", Palette::MOST))
        })
    }

    fn of(names: Vec<String>, colours: &[[u8; 3]]) -> Option<Classes> {
        Some(Classes { names, palette: Palette::of(colours)? })
    }

    /// Classes of these names in colours that are easy to distinguish; `None` for no names or too many.
    pub fn named(names: &[String]) -> Option<Classes> {
        let colours: Vec<[u8; 3]> = (0..names.len()).map(|k| distinct(k, names.len())).chain([FREE]).collect();
        Classes::of(names.iter().cloned().chain(["free".to_string()]).collect(), &colours)
    }

    /// The number of class labels, without "free".
    pub fn count(&self) -> usize {
        self.palette.classes()
    }
}

/// The `k`-th of `count` colours that are easy to distinguish.
fn distinct(k: usize, count: usize) -> [u8; 3] {
    let colour = match count {
        ..=10 => colorous::TABLEAU10[k.min(9)],
        _ => colorous::SINEBOW.eval_rational(k, count),
    };
    [colour.r, colour.g, colour.b]
}

fn hex(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#').filter(|d| d.bytes().all(|b| b.is_ascii_hexdigit()) && d.len() == 6)?;
    let byte = |k: usize| u8::from_str_radix(&digits[2 * k..2 * k + 2], 16).ok();
    Some([byte(0)?, byte(1)?, byte(2)?])
}
