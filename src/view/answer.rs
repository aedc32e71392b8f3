//! A request to a response: the guard, the page's files, and the view, which is asked on a thread of its own.

use super::guard::{self, BROKEN, BUSY, LARGE, QUERY, Refusal, SLOW};
use super::{Answer, Ask, Limits, View, page};
use crate::Error;
use http_body_util::{BodyExt, Full};
use hyper::body::{Body, Bytes, Incoming};
use hyper::header::{ALLOW, CONNECTION, CONTENT_TYPE, HeaderName, HeaderValue, LOCATION};
use hyper::{Method, Request, Response, StatusCode};
use serde_json::json;
use std::collections::BTreeMap;
use std::sync::Arc;
use tokio::sync::Semaphore;
use tokio::time::timeout;

/// Large bodies held at once.
const LARGE_ONES: usize = 2;
/// Of a body that is too large so much is still taken, so that the client hears why before the connection is closed.
const SPILLED: usize = 1 << 20;

type Reply = Response<Full<Bytes>>;

/// What all connections share.
pub(super) struct Desk {
    view: Arc<dyn View>,
    token: String,
    turns: Arc<Semaphore>,
    large: Arc<Semaphore>,
    limits: Limits,
}

impl Desk {
    /// For a view, behind a token.
    pub fn new(view: Arc<dyn View>, token: String, limits: Limits) -> Desk {
        let (turns, large) = (Arc::new(Semaphore::new(limits.worked_on)), Arc::new(Semaphore::new(LARGE_ONES)));
        Desk { view, token, turns, large, limits }
    }

    /// Answers a request, whatever it is.
    pub async fn answer(&self, request: Request<Incoming>) -> Reply {
        let (head, body) = request.into_parts();
        let mut reply = match guard::admit(&head, &self.token) {
            Ok(None) => {
                let mut reply = plain(StatusCode::PERMANENT_REDIRECT, String::new());
                set(&mut reply, LOCATION, &format!("/{}/", self.token));
                reply
            }
            Ok(Some(path)) => match path.starts_with("api/") {
                true => self.ask(&head.method, path, head.uri.query(), body).await.unwrap_or_else(refuse),
                false => file(&path),
            },
            Err(refusal) => refuse(refusal),
        };
        for (name, value) in page::HEADERS {
            reply.headers_mut().insert(HeaderName::from_static(name), HeaderValue::from_static(value));
        }
        reply
    }

    async fn ask(&self, method: &Method, path: String, query: Option<&str>, body: Incoming) -> Result<Reply, Refusal> {
        let post = method == Method::POST;
        let query = decode(query.unwrap_or_default()).ok_or(QUERY)?;
        let limit = guard::limit(&path);
        if body.size_hint().lower() > limit {
            return Err(LARGE);
        }
        let turn = |of: &Arc<Semaphore>| timeout(self.limits.wait, of.clone().acquire_owned());
        let room = match post && guard::is_large(&path) {
            true => Some(turn(&self.large).await.ok().and_then(Result::ok).ok_or(BUSY)?),
            false => None,
        };
        let body = match post {
            true => timeout(self.limits.body, read(body, limit as usize)).await.map_err(|_| SLOW)??,
            false => Vec::new(),
        };
        let turn = turn(&self.turns).await.ok().and_then(Result::ok).ok_or(BUSY)?;
        let view = self.view.clone();
        // Whoever asked may go away; what is under way keeps its turn until it is done.
        let work = tokio::task::spawn_blocking(move || {
            let reply = reply(&*view, &Ask { post, path: &path, query: &query, body: &body });
            drop((turn, room));
            reply
        });
        Ok(work.await.unwrap_or_else(|_| {
            let what = "this went wrong inside echogrid: please report it, with what the terminal says";
            failed(StatusCode::INTERNAL_SERVER_ERROR, what)
        }))
    }
}

/// Reads a body of at most so many bytes.
async fn read(mut body: Incoming, limit: usize) -> Result<Vec<u8>, Refusal> {
    let (mut bytes, mut spilled) = (Vec::new(), 0);
    while let Some(frame) = body.frame().await {
        let Ok(data) = frame.map_err(|_| BROKEN)?.into_data() else { continue };
        if spilled > 0 || bytes.len() + data.len() > limit {
            spilled += data.len();
            bytes = Vec::new();
            if spilled > SPILLED {
                break;
            }
        } else {
            bytes.extend_from_slice(&data);
        }
    }
    if spilled > 0 { Err(LARGE) } else { Ok(bytes) }
}

/// Asks the view.
fn reply(view: &dyn View, ask: &Ask) -> Reply {
    match view.answer(ask) {
        Ok(Answer::Json(value)) => typed(StatusCode::OK, "application/json", value.to_string().into()),
        Ok(Answer::Bytes(kind, bytes)) => typed(StatusCode::OK, kind, bytes.into()),
        Ok(Answer::Nothing) => {
            let mut reply = Reply::default();
            *reply.status_mut() = StatusCode::NO_CONTENT;
            reply
        }
        Ok(Answer::Unknown) => failed(StatusCode::NOT_FOUND, "there is nothing at this address"),
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

fn file(path: &str) -> Reply {
    match page::file(path) {
        Some((kind, bytes)) => typed(StatusCode::OK, kind, Bytes::from_static(bytes)),
        None => failed(StatusCode::NOT_FOUND, "there is nothing at this address"),
    }
}

/// A refusal. What it leaves unread is not waited for.
fn refuse(refusal: Refusal) -> Reply {
    let mut reply = match refusal.status {
        // who isn't let in learns nothing of what is asked and answered here
        StatusCode::FORBIDDEN => plain(refusal.status, refusal.text.into()),
        status => failed(status, refusal.text),
    };
    match refusal.status {
        StatusCode::METHOD_NOT_ALLOWED => set(&mut reply, ALLOW, "GET, HEAD, POST"),
        StatusCode::PAYLOAD_TOO_LARGE | StatusCode::REQUEST_TIMEOUT => set(&mut reply, CONNECTION, "close"),
        _ => {}
    }
    reply
}

fn failed(status: StatusCode, what: &str) -> Reply {
    typed(status, "application/json", json!({ "error": what }).to_string().into())
}

fn plain(status: StatusCode, text: String) -> Reply {
    typed(status, "text/plain; charset=utf-8", text.into())
}

fn typed(status: StatusCode, kind: &'static str, bytes: Bytes) -> Reply {
    let mut reply = Response::new(Full::new(bytes));
    *reply.status_mut() = status;
    reply.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static(kind));
    reply
}

fn set(reply: &mut Reply, name: HeaderName, value: &str) {
    if let Ok(value) = HeaderValue::from_str(value) {
        reply.headers_mut().insert(name, value);
    }
}

/// A query's keys and values; `None` where an escape is none, or the bytes are no UTF-8.
fn decode(query: &str) -> Option<BTreeMap<String, String>> {
    let text = |part: &str| -> Option<String> {
        let mut bytes = Vec::with_capacity(part.len());
        let mut rest = part.bytes();
        while let Some(byte) = rest.next() {
            let mut digit = || char::from(rest.next()?).to_digit(16);
            bytes.push(match byte {
                b'+' => b' ',
                b'%' => (digit()? * 16 + digit()?) as u8,
                other => other,
            });
        }
        String::from_utf8(bytes).ok()
    };
    let pairs = query.split('&').filter(|pair| !pair.is_empty());
    pairs.map(|pair| pair.split_once('=').unwrap_or((pair, ""))).map(|(k, v)| text(k).zip(text(v))).collect()
}

#[cfg(test)]
mod tests {
    use super::decode;

    #[test]
    fn queries() {
        let query = decode("a=1&view=log+odds&b=%C3%a4%26&c&").expect("it is well formed");
        let pairs: Vec<(&str, &str)> = query.iter().map(|(k, v)| (k.as_str(), v.as_str())).collect();
        assert_eq!(pairs, [("a", "1"), ("b", "ä&"), ("c", ""), ("view", "log odds")]);
        assert_eq!(["a=%", "a=%2", "a=%zz", "a=%ff"].map(decode), [None, None, None, None]);
    }
}
