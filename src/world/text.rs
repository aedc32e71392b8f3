//! Reads a world's TOML with the line of every key and value, so that an error can say where and what to do.

use crate::geometry::plane::Point;
use crate::sensor::{SensorValue as Value, angle, length};
use crate::support::similar::similar;
use crate::{Error, Result};
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A file's text, for its lines.
pub(crate) struct Text<'a> {
    pub path: &'a Path,
    pub text: &'a str,
    /// Where each line ends.
    ends: Vec<usize>,
}

/// Reads a number with its unit.
type Quantity = fn(&str) -> std::result::Result<f64, String>;

/// Anything read, with its place.
pub(crate) type At<T> = (T, Range<usize>);

impl<'a> Text<'a> {
    pub fn new(path: &'a Path, text: &'a str) -> Text<'a> {
        Text { path, text, ends: text.match_indices('\n').map(|(k, _)| k).collect() }
    }

    pub fn line(&self, at: &Range<usize>) -> u64 {
        self.ends.partition_point(|end| *end < at.start) as u64 + 1
    }

    pub fn fail(&self, at: &Range<usize>, what: impl Into<String>) -> Error {
        Error::at(self.path, self.line(at), what)
    }
}

/// One table of the file.
pub(crate) struct Part<'a> {
    pub text: &'a Text<'a>,
    /// As the file writes it, such as `[[wall]]`.
    pub name: &'static str,
    pub table: &'a DeTable<'a>,
    pub at: Range<usize>,
}

impl<'a> Part<'a> {
    /// Refuses keys that aren't known.
    pub fn check(&self, known: &[&str]) -> Result<()> {
        for key in self.table.keys() {
            let name: &str = key.get_ref();
            if !known.contains(&name) {
                let what = format!("{} has no key {name:?}{}", self.name, similar(name, known));
                return Err(self.text.fail(&key.span(), what));
            }
        }
        Ok(())
    }

    pub fn get(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.table.iter().find(|(k, _)| k.get_ref() == key).map(|(_, v)| v)
    }

    /// A key that must be there.
    pub fn need<T>(&self, key: &str, value: Option<T>, example: &str) -> Result<T> {
        value.ok_or_else(|| self.text.fail(&self.at, format!("{} has no {key}: add {key} = {example}", self.name)))
    }

    /// The place of a key's value, or of the table.
    pub fn place(&self, key: &str) -> Range<usize> {
        self.get(key).map_or(self.at.clone(), |v| v.span())
    }

    /// Metres.
    pub fn length(&self, key: &str) -> Result<Option<f64>> {
        self.get(key).map(|v| self.quantity(key, v, length)).transpose()
    }

    /// Radians.
    pub fn angle(&self, key: &str) -> Result<Option<f64>> {
        self.get(key).map(|v| self.quantity(key, v, angle)).transpose()
    }

    /// Metres, more than 0.
    pub fn positive(&self, key: &str) -> Result<Option<f64>> {
        match self.length(key)? {
            Some(v) if v <= 0.0 => {
                Err(self.text.fail(&self.place(key), format!("{key} = {v:?}: {key} takes more than 0")))
            }
            other => Ok(other),
        }
    }

    /// `true` or `false`.
    pub fn flag(&self, key: &str) -> Result<Option<bool>> {
        match self.get(key).map(|v| (v.get_ref(), v.span())) {
            None => Ok(None),
            Some((DeValue::Boolean(b), _)) => Ok(Some(*b)),
            Some((_, at)) => Err(self.text.fail(&at, format!("{key} takes true or false"))),
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

    /// A text.
    pub fn word(&self, key: &str) -> Result<Option<At<&'a str>>> {
        match self.get(key).map(|v| (v.get_ref(), v.span())) {
            None => Ok(None),
            Some((DeValue::String(text), at)) => Ok(Some((text.as_ref(), at))),
            Some((_, at)) => Err(self.text.fail(&at, format!("{key} takes a text in quotes"))),
        }
    }

    /// A list of texts.
    pub fn words(&self, key: &str) -> Result<Vec<String>> {
        let mut words = Vec::new();
        for value in self.list(key)?.unwrap_or_default() {
            match value.get_ref() {
                DeValue::String(text) => words.push(text.to_string()),
                _ => return Err(self.text.fail(&value.span(), format!("{key} takes a list of texts"))),
            }
        }
        Ok(words)
    }

    /// One of some names.
    pub fn choice<T: Copy>(&self, key: &str, known: &[(&str, T)], default: T) -> Result<T> {
        let Some((word, at)) = self.word(key)? else { return Ok(default) };
        let names: Vec<&str> = known.iter().map(|k| k.0).collect();
        known.iter().find(|k| k.0 == word).map(|k| k.1).ok_or_else(|| {
            self.text.fail(&at, format!("{key} = {word:?}: there is no such {key}{}", similar(word, &names)))
        })
    }

    fn list(&self, key: &str) -> Result<Option<Vec<&'a Spanned<DeValue<'a>>>>> {
        match self.get(key).map(|v| (v.get_ref(), v.span())) {
            None => Ok(None),
            Some((DeValue::Array(items), _)) => Ok(Some(items.iter().collect())),
            Some((_, at)) => Err(self.text.fail(&at, format!("{key} takes a list, in [ ]"))),
        }
    }

    /// One point, `[x, y]`.
    pub fn point(&self, key: &str) -> Result<Option<Point>> {
        self.get(key).map(|v| self.row(key, v, 2).map(|r| (r[0], r[1]))).transpose()
    }

    /// A list of rows of 2 numbers, or up to `most`; the third is an angle.
    pub fn rows(&self, key: &str, most: usize) -> Result<Option<Vec<At<Vec<f64>>>>> {
        let Some(items) = self.list(key)? else { return Ok(None) };
        items.into_iter().map(|v| Ok((self.row(key, v, most)?, v.span()))).collect::<Result<_>>().map(Some)
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
        let found = match value.get_ref() {
            DeValue::Integer(i) if i.radix() == 10 => read(i.as_str()),
            DeValue::Float(f) => read(f.as_str()),
            DeValue::String(s) => read(s),
            _ => read(""),
        };
        match found {
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

    /// A value as the sensors' tables take it.
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
