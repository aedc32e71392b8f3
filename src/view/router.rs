//! HTTP requests to responses: the page's files, and the view, which works on threads of its own.

use super::admission::{admission, body_limit, is_large, split_token};
use super::http_error::{
    BUSY, HttpError, METHOD_NOT_ALLOWED, NOT_FOUND, TIMED_OUT, TOO_LARGE, TRUNCATED, WRONG_QUERY, error_response,
};
use super::{Limits, Request, Response, View, assets};
use crate::Error;
use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, FromRequest, Query, State};
use axum::http::{Method, StatusCode, Uri, header::CONTENT_TYPE};
use axum::response::{IntoResponse, Redirect};
use axum::routing::get;
use axum::{Json, Router, middleware};
use std::collections::BTreeMap;
use std::sync::Arc;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::timeout;

type HttpRequest = axum::extract::Request;
type HttpResponse = axum::response::Response;

/// Large bodies held in memory at once.
const LARGE_BODIES: usize = 2;
/// Bytes that are still read of a body that is too large, so that the client gets the response before the connection closes.
const EXCESS: usize = 128 << 10;

/// What all requests share.
struct AppState {
    view: Arc<dyn View>,
    /// A permit for each request that the view works on.
    workers: Arc<Semaphore>,
    /// A permit for each large body.
    large_bodies: Arc<Semaphore>,
    limits: Limits,
}

/// The routes of a view, behind a token.
pub(super) fn router(view: Arc<dyn View>, token: &str, limits: Limits) -> Router {
    let [workers, large_bodies] = [limits.worked_on, LARGE_BODIES].map(|n| Arc::new(Semaphore::new(n)));
    let files = assets::FILES.into_iter().fold(Router::new(), |router, (name, kind, bytes)| {
        router.route(&format!("/{{token}}/{name}"), get(move || async move { ([(CONTENT_TYPE, kind)], bytes) }))
    });
    files
        .route("/{token}", get(|uri: Uri| async move { Redirect::permanent(&format!("{}/", uri.path())) }))
        .route("/{token}/api/{*path}", get(call_view).post(call_view))
        .fallback(|| async { NOT_FOUND })
        .method_not_allowed_fallback(|| async { METHOD_NOT_ALLOWED })
        .layer(middleware::from_fn_with_state(token.into(), admission))
        .with_state(Arc::new(AppState { view, workers, large_bodies, limits }))
}

impl AppState {
    /// A permit, if one becomes free in time.
    async fn permit(&self, of: &Arc<Semaphore>) -> Result<OwnedSemaphorePermit, HttpError> {
        timeout(self.limits.wait, of.clone().acquire_owned()).await.ok().and_then(Result::ok).ok_or(BUSY)
    }
}

/// Reads a request and calls the view with it.
async fn call_view(State(state): State<Arc<AppState>>, request: HttpRequest) -> Result<HttpResponse, HttpError> {
    let post = request.method() == Method::POST;
    let query = decode_query(request.uri()).ok_or(WRONG_QUERY)?;
    let path = split_token(request.uri().path()).1.to_string();
    let body_permit = if post && is_large(&path) { Some(state.permit(&state.large_bodies).await?) } else { None };
    let body = match post {
        true => timeout(state.limits.body, read_body(request, body_limit(&path))).await.map_err(|_| TIMED_OUT)??,
        false => Bytes::new(),
    };
    let worker_permit = state.permit(&state.workers).await?;
    // A client that goes away does not stop the work, which keeps its permit until it is done.
    let work = tokio::task::spawn_blocking(move || {
        let response = state.view.respond(&Request { post, path: &path, query: &query, body: &body });
        drop((worker_permit, body_permit));
        http_response(response)
    });
    Ok(work.await.unwrap_or_else(|_| {
        let what = "this went wrong inside echogrid: please report it, with what the terminal says";
        error_response(StatusCode::INTERNAL_SERVER_ERROR, what)
    }))
}

/// A query's keys and values; `None` where an escape is malformed or the bytes are no UTF-8. The decoder itself accepts the one
/// and replaces the other.
fn decode_query(uri: &Uri) -> Option<BTreeMap<String, String>> {
    let is_escape = |text: &str| text.get(..2).is_some_and(|t| t.bytes().all(|b| b.is_ascii_hexdigit()));
    let escapes = uri.query().unwrap_or_default().split('%').skip(1).all(is_escape);
    let Query(query) = Query::<BTreeMap<String, String>>::try_from_uri(uri).ok()?;
    let replaced = query.iter().flat_map(|(k, v)| [k, v]).any(|t| t.contains(char::REPLACEMENT_CHARACTER));
    (escapes && !replaced).then_some(query)
}

/// Reads a body of at most `limit` bytes.
async fn read_body(mut request: HttpRequest, limit: usize) -> Result<Bytes, HttpError> {
    DefaultBodyLimit::max(limit + EXCESS).apply(&mut request);
    match Bytes::from_request(request, &()).await {
        Ok(body) if body.len() <= limit => Ok(body),
        Err(rejection) if rejection.status() != StatusCode::PAYLOAD_TOO_LARGE => Err(TRUNCATED),
        _ => Err(TOO_LARGE),
    }
}

/// The view's response or error as HTTP.
fn http_response(response: crate::Result<Response>) -> HttpResponse {
    match response {
        Ok(Response::Json(value)) => Json(value).into_response(),
        Ok(Response::Bytes(kind, bytes)) => ([(CONTENT_TYPE, kind)], bytes).into_response(),
        Ok(Response::NoContent) => StatusCode::NO_CONTENT.into_response(),
        Ok(Response::NotFound) => NOT_FOUND.into_response(),
        Err(error) => {
            let status = match error {
                Error::Usage(_) => StatusCode::BAD_REQUEST,
                Error::Input { .. } => StatusCode::UNPROCESSABLE_ENTITY,
                Error::NoAdapter(_) | Error::Resources(_) | Error::Kernel(_) => StatusCode::INTERNAL_SERVER_ERROR,
            };
            error_response(status, &error.to_string())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::decode_query;

    #[test]
    fn queries() {
        let decode = |text: &str| decode_query(&format!("/?{text}").parse().expect("it is an address"));
        let query = decode("a=1&view=log+odds&b=%C3%a4%26&c&").expect("it is well formed");
        let pairs: Vec<(&str, &str)> = query.iter().map(|(k, v)| (k.as_str(), v.as_str())).collect();
        assert_eq!(pairs, [("a", "1"), ("b", "ä&"), ("c", ""), ("view", "log odds")]);
        assert_eq!(["a=%", "a=%2", "a=%zz", "a=%ff"].map(decode), [None, None, None, None]);
    }
}
