//! `echogrid view`: a web server for a page that shows a log step by step, or saved maps. A [`View`] answers the page's requests as plain
//! functions; the server around it decides who may ask. `web/README.md` documents the requests.

mod admission;
mod assets;
mod cache;
mod http_error;
mod legend;
pub mod log;
pub mod map;
pub mod protocol;
mod pyramid;
mod router;
mod server;
mod tile;

pub use legend::legend;
pub use pyramid::{LayerKey, Pyramid, PyramidLayer};
pub use server::{Limits, Options, Server, serve};
pub use tile::{EDGE, Tile, TileId, levels, pixels};

use crate::{Error, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::collections::BTreeMap;

/// A request of the page, after the server admitted it.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// POST, which changes something; else GET.
    pub post: bool,
    /// The path behind the token, without its first slash: `api/session`.
    pub path: &'a str,
    /// The query's keys and values, decoded.
    pub query: &'a BTreeMap<String, String>,
    /// The body; empty for GET.
    pub body: &'a [u8],
}

impl Request<'_> {
    /// Parses the body as JSON.
    ///
    /// # Errors
    /// [`Error::Usage`] that says what is wrong with it.
    pub fn json_body<T: DeserializeOwned>(&self) -> Result<T> {
        serde_json::from_slice(self.body)
            .map_err(|e| Error::Usage(format!("{}: the body is not what is wanted: {e}", self.path)))
    }

    /// A value of the query.
    ///
    /// # Errors
    /// [`Error::Usage`] where the key is missing.
    pub fn query_text(&self, key: &str) -> Result<&str> {
        let value = self.query.get(key).map(String::as_str);
        value.ok_or_else(|| Error::Usage(format!("{} wants {key}=", self.path)))
    }

    /// A whole number of the query, from 0.
    ///
    /// # Errors
    /// [`Error::Usage`] where the key is missing or its value is no such number.
    pub fn query_number(&self, key: &str) -> Result<usize> {
        let text = self.query_text(key)?;
        let number = text.parse::<u32>().map(|n| n as usize);
        number.map_err(|_| Error::Usage(format!("{key}={text} is no whole number from 0")))
    }
}

/// The response to a request.
#[derive(Debug, Clone, PartialEq)]
pub enum Response {
    /// JSON.
    Json(Value),
    /// Bytes, and their media type.
    Bytes(&'static str, Vec<u8>),
    /// Nothing to show (status 204).
    NoContent,
    /// No such path (status 404).
    NotFound,
}

impl Response {
    /// A response in JSON.
    ///
    /// # Errors
    /// [`Error::Resources`] where the value can't be represented in JSON.
    pub fn json(value: &impl Serialize) -> Result<Response> {
        let json = serde_json::to_value(value);
        json.map(Response::Json).map_err(|e| Error::Resources(format!("a response can't be written as JSON: {e}")))
    }
}

/// What the page shows: a log being stepped through, or saved maps. Called from several threads at once.
pub trait View: Send + Sync {
    /// Responds to a request.
    ///
    /// # Errors
    /// [`Error::Usage`] for a wrong request (status 400), [`Error::Input`] for a damaged file (422), others for the server's own
    /// failures (500).
    fn respond(&self, request: &Request) -> Result<Response>;
}
