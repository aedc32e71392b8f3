//! The library's error, with its cause. A message names the file, the line, the value and the remedy; options and parameters stand in backticks, as
//! in "give a coarser `resolution`", and the command writes them as its flags.

use std::path::PathBuf;

/// Every error of the library.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A parameter, a method or an option is wrong.
    #[error("{0}")]
    Usage(String),
    /// A log, a sensor file or a map can't be read.
    #[error("{}{}: {what}", path.display(), line.map(|l| format!(":{l}")).unwrap_or_default())]
    Input {
        /// The file or folder that is at fault.
        path: PathBuf,
        /// Its line, counted from 1, where there is one.
        line: Option<u64>,
        /// What is wrong and what to do about it.
        what: String,
        /// The error that caused it, where there is one.
        #[source]
        cause: Option<Box<Cause>>,
    },
    /// A GPU was asked for and none is there, or it can't do the work.
    #[error("{0}")]
    NoAdapter(String),
    /// Memory or disk doesn't suffice, or the output can't be written.
    #[error("{0}")]
    Resources(String),
    /// A backend can't run a pass.
    #[error(transparent)]
    Kernel(Box<dyn std::error::Error + Send + Sync>),
}

/// The cause of an [`Error::Input`], its `source()`.
#[derive(Debug, thiserror::Error)]
pub enum Cause {
    /// A file can't be read.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// A text is not the expected TOML.
    #[error(transparent)]
    Toml(#[from] toml::de::Error),
    /// A text is not the expected JSON.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// Bytes are not UTF-8.
    #[error(transparent)]
    Utf8(#[from] std::str::Utf8Error),
}

impl Error {
    /// An [`Error::Input`] about a whole file.
    pub fn input(path: impl Into<PathBuf>, what: impl Into<String>) -> Self {
        Error::Input { path: path.into(), line: None, what: what.into(), cause: None }
    }

    /// An [`Error::Input`] about one line, counted from 1.
    pub fn at(path: impl Into<PathBuf>, line: u64, what: impl Into<String>) -> Self {
        Error::Input { path: path.into(), line: Some(line), what: what.into(), cause: None }
    }

    /// An [`Error::Input`] about a whole file, with the error that caused it.
    pub fn caused(path: impl Into<PathBuf>, what: impl Into<String>, cause: impl Into<Cause>) -> Self {
        Error::Input { path: path.into(), line: None, what: what.into(), cause: Some(Box::new(cause.into())) }
    }

    /// An [`Error::Input`] about a text that is not the expected TOML, with its line.
    pub(crate) fn toml(path: impl Into<PathBuf>, text: &str, error: &toml::de::Error) -> Self {
        let line = |at: usize| text.bytes().take(at).filter(|b| *b == b'\n').count() as u64 + 1;
        let line = error.span().map(|span| line(span.start));
        Error::Input {
            path: path.into(),
            line,
            what: error.message().to_string(),
            cause: Some(Box::new(error.clone().into())),
        }
    }

    /// Appends to the message, after a semicolon.
    pub fn and(self, more: &str) -> Self {
        match self {
            Error::Usage(what) => Error::Usage(format!("{what}; {more}")),
            Error::Input { path, line, what, cause } => {
                Error::Input { path, line, what: format!("{what}; {more}"), cause }
            }
            Error::NoAdapter(what) => Error::NoAdapter(format!("{what}; {more}")),
            Error::Resources(what) => Error::Resources(format!("{what}; {more}")),
            Error::Kernel(what) => Error::NoAdapter(format!("{what}; {more}")),
        }
    }

    /// The kind of this error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Error::Usage(_) => ErrorKind::Usage,
            Error::Input { .. } => ErrorKind::Input,
            Error::NoAdapter(_) | Error::Kernel(_) => ErrorKind::NoAdapter,
            Error::Resources(_) => ErrorKind::Resources,
        }
    }
}

/// The kind of an [`Error`], without its message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorKind {
    /// [`Error::Usage`].
    Usage,
    /// [`Error::Input`].
    Input,
    /// [`Error::NoAdapter`].
    NoAdapter,
    /// [`Error::Resources`].
    Resources,
}

/// The library's result.
pub type Result<T> = std::result::Result<T, Error>;
