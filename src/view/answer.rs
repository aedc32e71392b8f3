//! A request to a response: the page's files, and the view, which is asked on a thread of its own.

use super::guard::{guard, is_large, limit, parts};
use super::refusal::{BROKEN, BUSY, LARGE, METHOD, QUERY, Refusal, SLOW, UNKNOWN, failed};
use super::{Answer, Ask, Limits, View, page};
use crate::Error;
use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, FromRequest, Query, Request, State};
use axum::http::{Method, StatusCode, Uri, header::CONTENT_TYPE};
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::get;
use axum::{Json, Router, middleware};
use std::collections::BTreeMap;
use std::sync::Arc;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::timeout;

/// Large bodies held at once.
const LARGE_ONES: usize = 2;
/// Of a body that is too large so much is still taken, so that the client hears why before the connection is closed.
const SPILLED: usize = 128 << 10;

/// What all requests share.
struct Desk {
    view: Arc<dyn View>,
    turns: Arc<Semaphore>,
    large: Arc<Semaphore>,
    limits: Limits,
}

/// All that is answered from a view, behind a token.
pub(super) fn router(view: Arc<dyn View>, token: &str, limits: Limits) -> Router {
    let [turns, large] = [limits.worked_on, LARGE_ONES].map(|n| Arc::new(Semaphore::new(n)));
    let files = page::FILES.into_iter().fold(Router::new(), |router, (name, kind, bytes)| {
        router.route(&format!("/{{token}}/{name}"), get(move || async move { ([(CONTENT_TYPE, kind)], bytes) }))
    });
    files
        .route("/{token}", get(|uri: Uri| async move { Redirect::permanent(&format!("{}/", uri.path())) }))
        .route("/{token}/api/{*path}", get(ask).post(ask))
        .fallback(|| async { UNKNOWN })
        .method_not_allowed_fallback(|| async { METHOD })
        .layer(middleware::from_fn_with_state(token.into(), guard))
        .with_state(Arc::new(Desk { view, turns, large, limits }))
}

impl Desk {
    /// A turn, if it comes in time.
    async fn turn(&self, of: &Arc<Semaphore>) -> Result<OwnedSemaphorePermit, Refusal> {
        timeout(self.limits.wait, of.clone().acquire_owned()).await.ok().and_then(Result::ok).ok_or(BUSY)
    }
}

/// Asks the view.
async fn ask(State(desk): State<Arc<Desk>>, request: Request) -> Result<Response, Refusal> {
    let post = request.method() == Method::POST;
    let query = query(request.uri()).ok_or(QUERY)?;
    let path = parts(request.uri().path()).1.to_string();
    let room = if post && is_large(&path) { Some(desk.turn(&desk.large).await?) } else { None };
    let body = match post {
        true => timeout(desk.limits.body, read(request, limit(&path))).await.map_err(|_| SLOW)??,
        false => Bytes::new(),
    };
    let turn = desk.turn(&desk.turns).await?;
    // Whoever asked may go away; what is under way keeps its turn until it is done.
    let work = tokio::task::spawn_blocking(move || {
        let reply = reply(desk.view.answer(&Ask { post, path: &path, query: &query, body: &body }));
        drop((turn, room));
        reply
    });
    Ok(work.await.unwrap_or_else(|_| {
        let what = "this went wrong inside echogrid: please report it, with what the terminal says";
        failed(StatusCode::INTERNAL_SERVER_ERROR, what)
    }))
}

/// A query's keys and values; `None` where an escape is none, or the bytes are no UTF-8: the decoder itself lets the one
/// stand and replaces the other.
fn query(uri: &Uri) -> Option<BTreeMap<String, String>> {
    let is_escape = |text: &str| text.get(..2).is_some_and(|t| t.bytes().all(|b| b.is_ascii_hexdigit()));
    let escapes = uri.query().unwrap_or_default().split('%').skip(1).all(is_escape);
    let Query(query) = Query::<BTreeMap<String, String>>::try_from_uri(uri).ok()?;
    let replaced = query.iter().flat_map(|(k, v)| [k, v]).any(|t| t.contains(char::REPLACEMENT_CHARACTER));
    (escapes && !replaced).then_some(query)
}

/// Reads a body of at most so many bytes.
async fn read(mut request: Request, limit: usize) -> Result<Bytes, Refusal> {
    DefaultBodyLimit::max(limit + SPILLED).apply(&mut request);
    match Bytes::from_request(request, &()).await {
        Ok(body) if body.len() <= limit => Ok(body),
        Err(rejection) if rejection.status() != StatusCode::PAYLOAD_TOO_LARGE => Err(BROKEN),
        _ => Err(LARGE),
    }
}

/// The view's answer as a response.
fn reply(answer: crate::Result<Answer>) -> Response {
    match answer {
        Ok(Answer::Json(value)) => Json(value).into_response(),
        Ok(Answer::Bytes(kind, bytes)) => ([(CONTENT_TYPE, kind)], bytes).into_response(),
        Ok(Answer::Nothing) => StatusCode::NO_CONTENT.into_response(),
        Ok(Answer::Unknown) => UNKNOWN.into_response(),
        Err(error) => {
            let status = match error {
                Error::Usage(_) => StatusCode::BAD_REQUEST,
                Error::Input { .. } => StatusCode::UNPROCESSABLE_ENTITY,
                Error::NoAdapter(_) | Error::Resources(_) => StatusCode::INTERNAL_SERVER_ERROR,
            };
            failed(status, &error.to_string())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::query;

    #[test]
    fn queries() {
        let decode = |text: &str| query(&format!("/?{text}").parse().expect("it is an address"));
        let query = decode("a=1&view=log+odds&b=%C3%a4%26&c&").expect("it is well formed");
        let pairs: Vec<(&str, &str)> = query.iter().map(|(k, v)| (k.as_str(), v.as_str())).collect();
        assert_eq!(pairs, [("a", "1"), ("b", "ä&"), ("c", ""), ("view", "log odds")]);
        assert_eq!(["a=%", "a=%2", "a=%zz", "a=%ff"].map(decode), [None, None, None, None]);
    }
}
