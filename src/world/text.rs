//! Reads the tables of a world's TOML file. Every key and value has its span, so that an error can name its line.

use crate::geometry::plane::Point;
use crate::sensor::{SensorValue as Value, angle, length};
use crate::support::suggest::similar;
use crate::{Error, Result};
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Bytes of the file, from and to.
pub(crate) type Span = Range<usize>;

/// The text of a file, for the lines of its spans.
pub(crate) struct SourceText<'a> {
    pub path: &'a Path,
    pub text: &'a str,
    /// Where each line ends.
    ends: Vec<usize>,
}

/// Parses a number with its unit.
type Quantity = fn(&str) -> std::result::Result<f64, String>;

impl<'a> SourceText<'a> {
    pub fn new(path: &'a Path, text: &'a str) -> SourceText<'a> {
        SourceText { path, text, ends: text.match_indices('\n').map(|(k, _)| k).collect() }
    }

    /// The line of a span, from 1.
    pub fn line(&self, span: &Span) -> u64 {
        self.ends.partition_point(|end| *end < span.start) as u64 + 1
    }

    /// An error at a span.
    pub fn fail(&self, span: &Span, what: impl Into<String>) -> Error {
        Error::at(self.path, self.line(span), what)
    }
}

/// One table of the file.
pub(crate) struct Table<'a> {
    pub text: &'a SourceText<'a>,
    /// As it is written, such as `[[wall]]`.
    pub name: &'static str,
    pub entries: &'a DeTable<'a>,
    pub span: Span,
}

impl<'a> Table<'a> {
    /// Refuses unknown keys.
    pub fn check(&self, known: &[&str]) -> Result<()> {
        for key in self.entries.keys() {
            let name: &str = key.get_ref();
            if !known.contains(&name) {
                let what = format!("{} has no key {name:?}{}", self.name, similar(name, known));
                return Err(self.text.fail(&key.span(), what));
            }
        }
        Ok(())
    }

    /// The value of a key.
    pub fn get(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.entries.iter().find(|(k, _)| k.get_ref() == key).map(|(_, v)| v)
    }

    /// The tables of a key: `[name]`, or every `[[name]]`.
    pub fn tables(&self, key: &str, name: &'static str) -> Result<Vec<Table<'a>>> {
        let Some(value) = self.get(key) else { return Ok(Vec::new()) };
        let wrong = |span: Span| self.text.fail(&span, format!("{key} is a table: write {name}"));
        let table = |v: &'a Spanned<DeValue<'a>>| match v.get_ref() {
            DeValue::Table(entries) => Ok(Table { text: self.text, name, entries, span: v.span() }),
            _ => Err(wrong(v.span())),
        };
        match value.get_ref() {
            DeValue::Array(items) if name.starts_with("[[") => items.iter().map(table).collect(),
            DeValue::Table(_) if !name.starts_with("[[") => Ok(vec![table(value)?]),
            _ => Err(wrong(value.span())),
        }
    }

    /// The value of a required key; the error shows an example.
    pub fn need<T>(&self, key: &str, value: Option<T>, example: &str) -> Result<T> {
        value.ok_or_else(|| self.text.fail(&self.span, format!("{} has no {key}: add {key} = {example}", self.name)))
    }

    /// An error at the value of a key, or at the table if it has no such key.
    pub fn fail(&self, key: &str, what: impl Into<String>) -> Error {
        self.text.fail(&self.get(key).map_or(self.span.clone(), |v| v.span()), what)
    }

    /// A length, metres.
    pub fn length(&self, key: &str) -> Result<Option<f64>> {
        self.get(key).map(|v| self.quantity(key, v, length)).transpose()
    }

    /// An angle, radians.
    pub fn angle(&self, key: &str) -> Result<Option<f64>> {
        self.get(key).map(|v| self.quantity(key, v, angle)).transpose()
    }

    /// A length greater than 0, metres.
    pub fn positive(&self, key: &str) -> Result<Option<f64>> {
        match self.length(key)? {
            Some(v) if v <= 0.0 => Err(self.fail(key, format!("{key} = {v:?}: {key} takes more than 0"))),
            other => Ok(other),
        }
    }

    /// `true` or `false`.
    pub fn flag(&self, key: &str) -> Result<Option<bool>> {
        match self.get(key).map(Spanned::get_ref) {
            None => Ok(None),
            Some(DeValue::Boolean(b)) => Ok(Some(*b)),
            Some(_) => Err(self.fail(key, format!("{key} takes true or false"))),
        }
    }

    /// A whole number from 0.
    pub fn count(&self, key: &str) -> Result<Option<u64>> {
        let Some(value) = self.get(key) else { return Ok(None) };
        match value.get_ref() {
            DeValue::Integer(i) if i.radix() == 10 => i.as_str().parse().ok(),
            _ => None,
        }
        .map(Some)
        .ok_or_else(|| self.text.fail(&value.span(), format!("{key} takes a whole number from 0")))
    }

    /// A string.
    pub fn string(&self, key: &str) -> Result<Option<Spanned<&'a str>>> {
        match self.get(key).map(|v| (v.get_ref(), v.span())) {
            None => Ok(None),
            Some((DeValue::String(text), span)) => Ok(Some(Spanned::new(span, text.as_ref()))),
            Some((_, span)) => Err(self.text.fail(&span, format!("{key} takes a text in quotes"))),
        }
    }

    /// A list of strings; empty where there is no such key.
    pub fn strings(&self, key: &str) -> Result<Vec<String>> {
        let mut strings = Vec::new();
        for value in self.list(key)?.unwrap_or_default() {
            match value.get_ref() {
                DeValue::String(text) => strings.push(text.to_string()),
                _ => return Err(self.text.fail(&value.span(), format!("{key} takes a list of texts"))),
            }
        }
        Ok(strings)
    }

    /// One of the known names.
    pub fn choice<T: Copy>(&self, key: &str, known: &[(&str, T)], default: T) -> Result<T> {
        let Some(word) = self.string(key)? else { return Ok(default) };
        let (span, word) = (word.span(), word.into_inner());
        let names: Vec<&str> = known.iter().map(|k| k.0).collect();
        known.iter().find(|k| k.0 == word).map(|k| k.1).ok_or_else(|| {
            self.text.fail(&span, format!("{key} = {word:?}: there is no such {key}{}", similar(word, &names)))
        })
    }

    fn list(&self, key: &str) -> Result<Option<Vec<&'a Spanned<DeValue<'a>>>>> {
        match self.get(key).map(|v| (v.get_ref(), v.span())) {
            None => Ok(None),
            Some((DeValue::Array(items), _)) => Ok(Some(items.iter().collect())),
            Some((_, span)) => Err(self.text.fail(&span, format!("{key} takes a list, in [ ]"))),
        }
    }

    /// A point, `[x, y]`.
    pub fn point(&self, key: &str) -> Result<Option<Point>> {
        self.get(key).map(|v| self.row(key, v, 2).map(|r| Point::new(r[0], r[1]))).transpose()
    }

    /// A list of rows of 2 numbers, or up to `most`; the third is an angle.
    pub fn rows(&self, key: &str, most: usize) -> Result<Option<Vec<Spanned<Vec<f64>>>>> {
        let Some(items) = self.list(key)? else { return Ok(None) };
        let row = |v: &Spanned<DeValue<'_>>| Ok(Spanned::new(v.span(), self.row(key, v, most)?));
        items.into_iter().map(row).collect::<Result<_>>().map(Some)
    }

    fn row(&self, key: &str, value: &Spanned<DeValue<'_>>, most: usize) -> Result<Vec<f64>> {
        let form = if most == 2 { "[x, y]" } else { "[x, y] or [x, y, heading]" };
        let wrong = |n: usize| {
            self.text.fail(
                &value.span(),
                format!("{key}: {n} numbers where {form} must stand; write metres, like [1.5, 2.0]"),
            )
        };
        let DeValue::Array(items) = value.get_ref() else { return Err(wrong(1)) };
        if items.len() < 2 || items.len() > most {
            return Err(wrong(items.len()));
        }
        let read = |(k, v)| self.quantity(key, v, if k < 2 { length as Quantity } else { angle });
        items.iter().enumerate().map(read).collect()
    }

    fn quantity(&self, key: &str, value: &Spanned<DeValue<'_>>, read: Quantity) -> Result<f64> {
        let parsed = match value.get_ref() {
            DeValue::Integer(i) if i.radix() == 10 => read(i.as_str()),
            DeValue::Float(f) => read(f.as_str()),
            DeValue::String(s) => read(s),
            _ => read(""),
        };
        match parsed {
            Ok(v) if v.abs() <= 1e6 => Ok(v),
            Ok(v) => {
                Err(self.text.fail(&value.span(), format!("{key}: {v:?} is farther than 1e6: give a smaller number")))
            }
            Err(what) => {
                let shown = self.text.text.get(value.span()).unwrap_or("this");
                Err(self.text.fail(&value.span(), format!("{key}: {shown} is not a finite number: {key} {what}")))
            }
        }
    }

    /// A value for a sensor's description.
    pub fn value(&self, key: &str) -> Result<Option<Value>> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let number = |text: &str| text.parse().map(Value::Number).ok();
        let found = match value.get_ref() {
            DeValue::Integer(i) if i.radix() == 10 => number(i.as_str()),
            DeValue::Float(f) => number(f.as_str()),
            DeValue::String(s) => Some(Value::Text(s.to_string())),
            _ => None,
        };
        found.map(Some).ok_or_else(|| self.text.fail(&value.span(), format!("{key} takes a number or a text")))
    }
}
