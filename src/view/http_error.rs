//! The HTTP errors of the server, with their texts.

use axum::Json;
use axum::http::StatusCode;
use axum::http::header::{ALLOW, CONNECTION};
use axum::response::{IntoResponse, Response};
use serde_json::json;

/// A status of 400 or more, and its text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct HttpError(StatusCode, &'static str);

/// The token is wrong.
pub(super) const WRONG_TOKEN: HttpError =
    HttpError(StatusCode::FORBIDDEN, "Forbidden: open the whole address that echogrid view printed, token and all.\n");
/// A host name that another site's domain may have.
pub(super) const WRONG_HOST: HttpError =
    HttpError(StatusCode::FORBIDDEN, "Forbidden: open it by its IP address, or as localhost, not by another name.\n");
/// A request from another site's page.
pub(super) const CROSS_SITE: HttpError = HttpError(
    StatusCode::FORBIDDEN,
    "Forbidden: another site asked for it. Paste the address into the browser's address bar.\n",
);
/// No such path.
pub(super) const NOT_FOUND: HttpError = HttpError(StatusCode::NOT_FOUND, "there is nothing at this address");
/// A method that the path does not take.
pub(super) const METHOD_NOT_ALLOWED: HttpError =
    HttpError(StatusCode::METHOD_NOT_ALLOWED, "GET, HEAD and POST are answered");
/// A media type that a form on another site could send.
pub(super) const WRONG_MEDIA_TYPE: HttpError =
    HttpError(StatusCode::UNSUPPORTED_MEDIA_TYPE, "send JSON or bytes, no form");
/// A body that is too large.
pub(super) const TOO_LARGE: HttpError = HttpError(StatusCode::PAYLOAD_TOO_LARGE, "the body is too large");
/// A body that does not arrive in time.
pub(super) const TIMED_OUT: HttpError = HttpError(StatusCode::REQUEST_TIMEOUT, "the body did not come in time");
/// A body that ends early.
pub(super) const TRUNCATED: HttpError = HttpError(StatusCode::BAD_REQUEST, "the body can't be read");
/// A query that isn't percent-encoded UTF-8.
pub(super) const WRONG_QUERY: HttpError = HttpError(StatusCode::BAD_REQUEST, "the query can't be read");
/// Too many requests are being worked on.
pub(super) const BUSY: HttpError =
    HttpError(StatusCode::SERVICE_UNAVAILABLE, "too many requests are being worked on: ask again");

impl IntoResponse for HttpError {
    fn into_response(self) -> Response {
        let HttpError(status, text) = self;
        match status {
            // Clients that are not admitted learn nothing of the protocol.
            StatusCode::FORBIDDEN => (status, text).into_response(),
            StatusCode::METHOD_NOT_ALLOWED => {
                ([(ALLOW, "GET, HEAD, POST")], error_response(status, text)).into_response()
            }
            // The rest of the body is not read.
            StatusCode::PAYLOAD_TOO_LARGE | StatusCode::REQUEST_TIMEOUT => {
                ([(CONNECTION, "close")], error_response(status, text)).into_response()
            }
            _ => error_response(status, text),
        }
    }
}

/// A response with a JSON error.
pub(super) fn error_response(status: StatusCode, what: &str) -> Response {
    (status, Json(json!({ "error": what }))).into_response()
}
