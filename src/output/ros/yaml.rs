//! Reads the keys of a YAML document with their values and lines, from a parser's events. That is enough for a flat settings file in any of
//! YAML's styles. Values stay texts here.

use crate::{Error, Result};
use saphyr_parser::{Event, Parser, ScalarStyle, ScanError, StrInput};
use std::path::Path;

/// The deepest nesting of lists.
const DEEPEST: usize = 8;

/// A key of the document.
pub(super) struct Entry {
    pub key: String,
    /// Its line, counted from 1.
    pub line: u64,
    pub value: Node,
}

/// A value and the line where it stands.
pub(super) struct Node {
    pub line: u64,
    pub value: Value,
}

pub(super) enum Value {
    /// A scalar's text, without quotes; empty for null.
    Text(String),
    List(Vec<Node>),
    /// Keys and values, which are skipped.
    Table,
}

/// A file's first document.
pub(super) struct Document {
    /// In the order of the file, each key once.
    pub entries: Vec<Entry>,
    /// The line where another document starts.
    pub next: Option<u64>,
}

struct YamlReader<'a> {
    path: &'a Path,
    parser: Parser<'a, StrInput<'a>>,
}

/// Reads a text's first document, which has to be keys and values.
pub(super) fn parse(path: &Path, text: &str) -> Result<Document> {
    let mut reader = YamlReader { path, parser: Parser::new_from_str(text) };
    let mut entries: Vec<Entry> = Vec::new();
    let none = || Error::input(path, "it has no key: give a map_server map.yaml, with image, resolution and origin");
    loop {
        match reader.next()? {
            (Event::MappingStart(..), _) => break,
            (Event::StreamStart | Event::DocumentStart(_), _) => {}
            (Event::StreamEnd | Event::DocumentEnd, _) => return Err(none()),
            (Event::Scalar(text, ..), _) if text.is_empty() => return Err(none()),
            (_, line) => {
                return Err(Error::at(
                    path,
                    line,
                    "it is no map_server map.yaml: write keys and values, such as resolution: 0.05",
                ));
            }
        }
    }
    loop {
        let (event, line) = reader.next()?;
        if event == Event::MappingEnd {
            break;
        }
        let Value::Text(key) = reader.node(event, line, 0)?.value else {
            return Err(Error::at(path, line, "a key is no plain word: write keys such as resolution: 0.05"));
        };
        if let Some(first) = entries.iter().find(|e| e.key == key) {
            let what = format!("{key} stands twice, first in line {}: leave one of them out", first.line);
            return Err(Error::at(path, line, what));
        }
        let (event, at) = reader.next()?;
        let mut value = reader.node(event, at, 0)?;
        if matches!(&value.value, Value::Text(text) if text.is_empty()) {
            value.line = line;
        }
        entries.push(Entry { key, line, value });
    }
    let next = loop {
        match reader.next()? {
            (Event::StreamEnd, _) => break None,
            (Event::DocumentStart(_), line) => break Some(line),
            _ => {}
        }
    };
    Ok(Document { entries, next })
}

impl<'a> YamlReader<'a> {
    /// The next event and its line.
    fn next(&mut self) -> Result<(Event<'a>, u64)> {
        let wrong = |e: ScanError| Error::at(self.path, e.marker().line() as u64, format!("not YAML: {}", e.info()));
        match self.parser.next_event() {
            Some(event) => event.map(|(event, span)| (event, span.start.line() as u64)).map_err(wrong),
            None => Ok((Event::StreamEnd, 0)),
        }
    }

    /// Reads the value that an event begins.
    fn node(&mut self, event: Event<'a>, line: u64, depth: usize) -> Result<Node> {
        let path = self.path;
        let refused = |what: &str| Err(Error::at(path, line, what));
        let value = match event {
            Event::Scalar(text, style, ..) => {
                let null = style == ScalarStyle::Plain && ["~", "null", "Null", "NULL"].contains(&&*text);
                Value::Text(if null { String::new() } else { text.into_owned() })
            }
            Event::SequenceStart(..) if depth == DEEPEST => return refused("lists within lists: write [x, y, yaw]"),
            Event::SequenceStart(..) => {
                let mut items = Vec::new();
                loop {
                    match self.next()? {
                        (Event::SequenceEnd, _) => break Value::List(items),
                        (event, line) => items.push(self.node(event, line, depth + 1)?),
                    }
                }
            }
            Event::MappingStart(..) => {
                let mut open = 1;
                while open > 0 {
                    match self.next()?.0 {
                        Event::MappingStart(..) => open += 1,
                        Event::MappingEnd => open -= 1,
                        _ => {}
                    }
                }
                Value::Table
            }
            Event::Alias(_) => return refused("an alias (*name) isn't read: write the value itself"),
            _ => return refused("a value is missing"),
        };
        Ok(Node { line, value })
    }
}
