//! `echogrid view`: what a page in the browser is told. A [`View`] answers its questions, as plain functions; the server around it
//! keeps everybody else out. `web/README.md` says what is asked and answered.

mod answer;
mod cache;
mod guard;
mod legend;
pub mod log;
pub mod map;
mod page;
mod pyramid;
mod refusal;
mod server;
mod tile;

pub use legend::legend;
pub use pyramid::{Key, Pyramid, Shown};
pub use server::{Limits, Options, Server, serve};
pub use tile::{EDGE, Place, Tile, levels, pixels};

use crate::{Error, Result};
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::collections::BTreeMap;

/// A question of the page.
#[derive(Debug, Clone, Copy)]
pub struct Ask<'a> {
    /// POST: it changes something; GET doesn't.
    pub post: bool,
    /// What follows the token, without the first slash: `api/session`.
    pub path: &'a str,
    /// The query's keys and values, decoded.
    pub query: &'a BTreeMap<String, String>,
    /// The body; empty for GET.
    pub body: &'a [u8],
}

impl Ask<'_> {
    /// The body as what is wanted.
    ///
    /// # Errors
    /// [`Error::Usage`] that says what is wrong with it.
    pub fn json<T: DeserializeOwned>(&self) -> Result<T> {
        serde_json::from_slice(self.body)
            .map_err(|e| Error::Usage(format!("{}: the body is not what is wanted: {e}", self.path)))
    }

    /// A value of the query.
    ///
    /// # Errors
    /// [`Error::Usage`] where it isn't there.
    pub fn text(&self, key: &str) -> Result<&str> {
        let value = self.query.get(key).map(String::as_str);
        value.ok_or_else(|| Error::Usage(format!("{} wants {key}=", self.path)))
    }

    /// A whole number of the query, from 0.
    ///
    /// # Errors
    /// [`Error::Usage`] where it isn't there, or is none.
    pub fn number(&self, key: &str) -> Result<usize> {
        let text = self.text(key)?;
        let number = text.parse::<u32>().map(|n| n as usize);
        number.map_err(|_| Error::Usage(format!("{key}={text} is no whole number from 0")))
    }
}

/// What it is told.
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    /// JSON.
    Json(Value),
    /// Bytes, and their media type.
    Bytes(&'static str, Vec<u8>),
    /// There is nothing to show (204).
    Nothing,
    /// There is no such path (404).
    Unknown,
}

/// What is looked at: a log being stepped through, or a saved map. Called from several threads at once.
pub trait View: Send + Sync {
    /// Answers a question.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] for what is wrong with the question (400); others for what went wrong here (500).
    fn answer(&self, ask: &Ask) -> Result<Answer>;
}
