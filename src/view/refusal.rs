//! Why a request isn't answered, as a response.

use axum::Json;
use axum::http::StatusCode;
use axum::http::header::{ALLOW, CONNECTION};
use axum::response::{IntoResponse, Response};
use serde_json::json;

/// A refusal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Refusal(StatusCode, &'static str);

/// The token isn't known.
pub(super) const TOKEN: Refusal =
    Refusal(StatusCode::FORBIDDEN, "Forbidden: open the whole address that echogrid view printed, token and all.\n");
/// A name that a stranger's domain may have.
pub(super) const NAME: Refusal =
    Refusal(StatusCode::FORBIDDEN, "Forbidden: open it by its IP address, or as localhost, not by another name.\n");
/// Another site's page.
pub(super) const STRANGER: Refusal = Refusal(
    StatusCode::FORBIDDEN,
    "Forbidden: another site asked for it. Paste the address into the browser's address bar.\n",
);
/// No such path.
pub(super) const UNKNOWN: Refusal = Refusal(StatusCode::NOT_FOUND, "there is nothing at this address");
/// A method that isn't for this path.
pub(super) const METHOD: Refusal = Refusal(StatusCode::METHOD_NOT_ALLOWED, "GET, HEAD and POST are answered");
/// A body that a form on another site could send.
pub(super) const FORM: Refusal = Refusal(StatusCode::UNSUPPORTED_MEDIA_TYPE, "send JSON or bytes, no form");
/// A body that is too large.
pub(super) const LARGE: Refusal = Refusal(StatusCode::PAYLOAD_TOO_LARGE, "the body is too large");
/// A body that doesn't come.
pub(super) const SLOW: Refusal = Refusal(StatusCode::REQUEST_TIMEOUT, "the body did not come in time");
/// A body that breaks off.
pub(super) const BROKEN: Refusal = Refusal(StatusCode::BAD_REQUEST, "the body can't be read");
/// A query that isn't percent-encoded UTF-8.
pub(super) const QUERY: Refusal = Refusal(StatusCode::BAD_REQUEST, "the query can't be read");
/// Too much to do.
pub(super) const BUSY: Refusal =
    Refusal(StatusCode::SERVICE_UNAVAILABLE, "too many requests are being worked on: ask again");

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        let Refusal(status, text) = self;
        match status {
            // who isn't let in learns nothing of what is asked and answered here
            StatusCode::FORBIDDEN => (status, text).into_response(),
            StatusCode::METHOD_NOT_ALLOWED => ([(ALLOW, "GET, HEAD, POST")], failed(status, text)).into_response(),
            // what is left of the body is not waited for
            StatusCode::PAYLOAD_TOO_LARGE | StatusCode::REQUEST_TIMEOUT => {
                ([(CONNECTION, "close")], failed(status, text)).into_response()
            }
            _ => failed(status, text),
        }
    }
}

/// A response that says what went wrong.
pub(super) fn failed(status: StatusCode, what: &str) -> Response {
    (status, Json(json!({ "error": what }))).into_response()
}
