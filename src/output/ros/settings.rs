//! The settings of a `map.yaml`, with map_server's meanings. A value that isn't understood is refused with its line, its key and a right
//! value: a map that is read with another meaning than its maker's has walls where the floor is.

use super::yaml::{self, Document, Entry, Node, Value};
use crate::{Error, Result};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The largest settings file, bytes.
const LONGEST: u64 = 1 << 20;
/// The farthest origin of a map, metres.
const FARTHEST: f64 = 1e7;

const KEYS: [&str; 7] = ["image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode"];
const YES: [&str; 4] = ["true", "yes", "on", "y"];
const NO: [&str; 4] = ["false", "no", "off", "n"];

/// The interpretation of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    /// Occupied, free or unknown.
    Trinary,
    /// Occupied, free, or a percentage between; a pixel that isn't opaque is unknown.
    Scale,
    /// The pixel's value, of 255, is the percentage; above 100 it is unknown.
    Raw,
}

/// The settings of a map.yaml.
pub(super) struct MapSettings {
    /// The path of the picture as written: relative to the YAML file, or absolute.
    pub image: String,
    /// Edge of a pixel, metres.
    pub resolution: f64,
    /// x, y, metres, and yaw, radians, of the lower left pixel's lower left corner.
    pub origin: [f64; 3],
    /// The line of `origin`.
    pub origin_line: u64,
    /// White is occupied.
    pub negate: bool,
    pub mode: Mode,
    /// A pixel is occupied above this; by default 0.65.
    pub occupied: f64,
    /// A pixel is free below this; by default 0.196.
    pub free: f64,
    /// Notes for the user: keys that aren't read, settings without effect.
    pub notes: Vec<String>,
}

impl MapSettings {
    /// Reads and checks a file.
    pub fn open(path: &Path) -> Result<MapSettings> {
        let unreadable = |e: std::io::Error| Error::input(path, format!("can't be read: {e}; give a map.yaml"));
        let mut bytes = Vec::new();
        File::open(path).map_err(unreadable)?.take(LONGEST + 1).read_to_end(&mut bytes).map_err(unreadable)?;
        if bytes.len() as u64 > LONGEST {
            return Err(Error::input(path, "it is longer than 1 MiB: no map_server map.yaml"));
        }
        let text = String::from_utf8(bytes).map_err(|e| {
            let line = e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|b| **b == b'\n').count() as u64 + 1;
            Error::at(path, line, "is not UTF-8 text: save it as UTF-8")
        })?;
        MapSettings::of(path, &yaml::parse(path, &text)?)
    }

    fn of(path: &Path, document: &Document) -> Result<MapSettings> {
        let keys = SettingsReader { path, entries: &document.entries };
        let image = keys.image()?;
        let resolution =
            keys.number(keys.needed("resolution")?, "metres a pixel, such as 0.05", |v| (1e-6..=1e6).contains(&v))?;
        let origin = keys.needed("origin")?;
        let threshold = |key: &str, default: f64| match keys.find(key) {
            Some(entry) => keys.number(entry, "a share from 0 to 1, such as 0.65", |v| (0.0..=1.0).contains(&v)),
            None => Ok(default),
        };
        let (occupied, free) = (threshold("occupied_thresh", 0.65)?, threshold("free_thresh", 0.196)?);
        if free > occupied {
            let line = keys.find("free_thresh").or(keys.find("occupied_thresh")).map_or(0, |e| e.value.line);
            let what = format!(
                "free_thresh {free} is above occupied_thresh {occupied}: write the smaller one for free_thresh, such as \
                 0.196 and 0.65"
            );
            return Err(Error::at(path, line, what));
        }
        let (negate, mode) = (keys.negate()?, keys.mode()?);
        let mut notes = keys.unknown();
        if negate && mode == Mode::Raw {
            let line = keys.find("negate").map_or(0, |e| e.line);
            notes.push(format!("{}:{line}: negate changes nothing in mode raw, as in map_server", path.display()));
        }
        if let Some(line) = document.next {
            notes.push(format!("{}:{line}: only the first document of the file is read", path.display()));
        }
        Ok(MapSettings {
            image,
            resolution,
            origin: keys.origin(origin)?,
            origin_line: origin.value.line,
            negate,
            mode,
            occupied,
            free,
            notes,
        })
    }
}

/// The entries of a document, by key.
struct SettingsReader<'a> {
    path: &'a Path,
    entries: &'a [Entry],
}

impl<'a> SettingsReader<'a> {
    fn find(&self, key: &str) -> Option<&'a Entry> {
        self.entries.iter().find(|e| e.key == key)
    }

    fn needed(&self, key: &str) -> Result<&'a Entry> {
        let near = |e: &&Entry| nearest(&e.key) == Some(key) && !KEYS.contains(&e.key.as_str());
        self.find(key).ok_or_else(|| match self.entries.iter().find(near) {
            Some(e) => {
                Error::at(self.path, e.line, format!("it has no \"{key}\": write that in place of \"{}\"", e.key))
            }
            None => Error::input(self.path, format!("it has no \"{key}\": not a map_server map.yaml")),
        })
    }

    /// The error about a value: its text, and a right value.
    fn wrong(&self, key: &str, node: &Node, right: &str) -> Error {
        let found = match &node.value {
            Value::Text(text) if text.is_empty() => "has no value".into(),
            Value::Text(text) => format!("\"{text}\" isn't understood"),
            Value::List(items) => format!("is a list of {}", items.len()),
            Value::Table => "is a table of keys".into(),
        };
        Error::at(self.path, node.line, format!("{key}: {found}: write {right}"))
    }

    fn text(&self, entry: &'a Entry, right: &str) -> Result<&'a str> {
        match &entry.value.value {
            Value::Text(text) if !text.trim().is_empty() => Ok(text.trim()),
            _ => Err(self.wrong(&entry.key, &entry.value, right)),
        }
    }

    fn number(&self, entry: &Entry, right: &str, good: impl Fn(f64) -> bool) -> Result<f64> {
        let right = format!("a plain number, {right}");
        number(&entry.value).filter(|v| good(*v)).ok_or_else(|| self.wrong(&entry.key, &entry.value, &right))
    }

    fn image(&self) -> Result<String> {
        let entry = self.needed("image")?;
        let right = "the picture's file, such as map.pgm, relative to this file's folder or absolute";
        Ok(self.text(entry, right)?.to_string())
    }

    fn origin(&self, entry: &Entry) -> Result<[f64; 3]> {
        let right = "[x, y, yaw]: metres and radians as plain numbers, such as [-1.0, -2.0, 0.0]";
        let Value::List(items) = &entry.value.value else { return Err(self.wrong("origin", &entry.value, right)) };
        let mut values = Vec::new();
        for item in items {
            values.push(number(item).filter(|v| v.abs() <= FARTHEST).ok_or_else(|| self.wrong("origin", item, right))?);
        }
        values.try_into().map_err(|_| self.wrong("origin", &entry.value, right))
    }

    /// Reads `negate`: YAML's booleans in any case, and whole numbers, of which all but 0 are true.
    fn negate(&self) -> Result<bool> {
        let Some(entry) = self.find("negate") else { return Ok(false) };
        let right = "0, 1, or one of true, false, yes, no, on, off";
        let text = self.text(entry, right)?.to_lowercase();
        match text.parse::<i64>() {
            Ok(number) => Ok(number != 0),
            Err(_) if YES.contains(&text.as_str()) => Ok(true),
            Err(_) if NO.contains(&text.as_str()) => Ok(false),
            Err(_) => Err(self.wrong("negate", &entry.value, right)),
        }
    }

    fn mode(&self) -> Result<Mode> {
        let Some(entry) = self.find("mode") else { return Ok(Mode::Trinary) };
        let right = "trinary, scale or raw";
        match self.text(entry, right)?.to_lowercase().as_str() {
            "trinary" => Ok(Mode::Trinary),
            "scale" => Ok(Mode::Scale),
            "raw" => Ok(Mode::Raw),
            _ => Err(self.wrong("mode", &entry.value, right)),
        }
    }

    /// Notes on the keys that aren't read.
    fn unknown(&self) -> Vec<String> {
        let unknown = self.entries.iter().filter(|e| !KEYS.contains(&e.key.as_str()));
        let note = |e: &Entry| {
            let meant = nearest(&e.key)
                .map_or(format!("; the keys are {}", KEYS.join(", ")), |k| format!("; did you mean \"{k}\"?"));
            format!("{}:{}: the key \"{}\" isn't read{meant}", self.path.display(), e.line, e.key)
        };
        unknown.map(note).collect()
    }
}

/// The known key that is most like a key, if one is near.
fn nearest(key: &str) -> Option<&'static str> {
    let near = |known: &&str| strsim::jaro_winkler(&key.to_lowercase(), known);
    KEYS.into_iter().max_by(|a, b| near(a).total_cmp(&near(b))).filter(|k| near(k) > 0.85)
}

/// The finite number of a scalar; `None` for other values.
fn number(node: &Node) -> Option<f64> {
    match &node.value {
        Value::Text(text) => text.trim().parse().ok().filter(|v: &f64| v.is_finite()),
        _ => None,
    }
}
