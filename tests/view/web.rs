//! A server in this process, a view that does as it is told, and a client that sends whatever bytes a test wants.

use echogrid::view::{Limits, Options, Request, Response, Server, View};
use echogrid::{Error, Result};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// A view whose answers are chosen by the path.
#[derive(Default)]
pub struct Puppet {
    /// Poisoned by `api/poison`, as a view's own lock may be.
    lock: Mutex<u64>,
}

impl View for Puppet {
    fn respond(&self, request: &Request) -> Result<Response> {
        let text = |what: &str| what.to_string();
        Ok(match request.path {
            "api/echo" => {
                Response::Json(json!({"post": request.post, "query": request.query, "bytes": request.body.len()}))
            }
            "api/gpu/words" => Response::Json(json!({"bytes": request.body.len()})),
            "api/bytes" => Response::Bytes("image/png", vec![1, 2, 3]),
            "api/nothing" => Response::NoContent,
            "api/usage" => return Err(Error::Usage(text("wrong parameter"))),
            "api/input" => return Err(Error::input("map.zarr", "damaged")),
            "api/resources" => return Err(Error::Resources(text("no memory"))),
            "api/adapter" => return Err(Error::NoAdapter(text("no adapter"))),
            "api/panic" => panic!("as told"),
            "api/poison" => {
                let _held = self.lock.lock();
                panic!("as told, with the lock held")
            }
            "api/slow" => {
                std::thread::sleep(Duration::from_millis(20));
                Response::Json(json!("slept"))
            }
            _ => Response::NotFound,
        })
    }
}

/// A server under test.
pub struct Web {
    /// It serves until it is dropped.
    _server: Server,
    pub at: SocketAddr,
    pub token: String,
}

/// A response, in parts.
#[derive(Debug, Clone)]
pub struct Reply {
    pub status: u16,
    pub headers: BTreeMap<String, String>,
    pub body: Vec<u8>,
}

impl Reply {
    #[track_caller]
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|e| panic!("{e}: {self:?}"))
    }

    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }
}

impl Web {
    pub fn new() -> Web {
        Web::of(Arc::new(Puppet::default()), Limits::default())
    }

    pub fn of(view: Arc<dyn View>, limits: Limits) -> Web {
        let server = Server::open(view, &Options { limits, ..Options::default() }).unwrap();
        let address = server.address();
        let (at, token) = parts(&address);
        Web { _server: server, at, token }
    }

    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.at).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        stream
    }

    /// Sends bytes, in which `TOKEN` and `HOST` stand for the real ones, and reads the answer.
    #[track_caller]
    pub fn raw(&self, text: &str) -> Reply {
        let mut stream = self.connect();
        stream.write_all(self.fill(text).as_bytes()).unwrap();
        reply(&mut stream).unwrap_or_else(|| panic!("no answer to {text:?}"))
    }

    pub fn fill(&self, text: &str) -> String {
        text.replace("TOKEN", &self.token).replace("HOST", &self.at.to_string())
    }

    #[track_caller]
    pub fn get(&self, path: &str) -> Reply {
        self.raw(&format!("GET /TOKEN/{path} HTTP/1.1\r\nHost: HOST\r\n\r\n"))
    }

    #[track_caller]
    pub fn post(&self, path: &str, body: &str) -> Reply {
        let length = body.len();
        let head = format!("POST /TOKEN/{path} HTTP/1.1\r\nHost: HOST\r\nContent-Length: {length}\r\n");
        self.raw(&format!("{head}Content-Type: application/json\r\n\r\n{body}"))
    }

    /// It lives: a good request is answered.
    #[track_caller]
    pub fn lives(&self) {
        let reply = self.get("api/echo?a=b");
        assert_eq!(reply.status, 200, "{reply:?}");
        assert_eq!(reply.json(), json!({"post": false, "query": {"a": "b"}, "bytes": 0}));
    }

    /// A request is refused with this status, with all headers, and the server lives.
    #[track_caller]
    pub fn refuses(&self, text: &str, status: u16) -> Reply {
        let reply = self.raw(text);
        assert_eq!(reply.status, status, "{text:?}: {reply:?}");
        guarded(&reply);
        self.lives();
        reply
    }
}

/// The headers that every response has; and none lets another site read it.
#[track_caller]
pub fn guarded(reply: &Reply) {
    let policy = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; \
                  connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
    for (name, value) in [
        ("content-security-policy", policy),
        ("x-content-type-options", "nosniff"),
        ("referrer-policy", "no-referrer"),
        ("cache-control", "no-store"),
        ("cross-origin-resource-policy", "same-origin"),
    ] {
        assert_eq!(reply.headers.get(name).map(String::as_str), Some(value), "{name}: {reply:?}");
    }
    assert!(!reply.headers.keys().any(|k| k.starts_with("access-control")), "{reply:?}");
}

/// Where an address points, and its token.
pub fn parts(address: &str) -> (SocketAddr, String) {
    let rest = address.strip_prefix("http://").unwrap().strip_suffix('/').unwrap();
    let (at, token) = rest.split_once('/').unwrap();
    assert!(token.len() == 32 && token.bytes().all(|b| b.is_ascii_hexdigit()), "{address}");
    (at.parse().unwrap(), token.into())
}

/// Reads one response; `None` where the connection ends first.
pub fn reply(stream: &mut TcpStream) -> Option<Reply> {
    let mut bytes = Vec::new();
    let mut byte = [0];
    while !bytes.ends_with(b"\r\n\r\n") {
        match stream.read(&mut byte) {
            Ok(1) => bytes.push(byte[0]),
            _ => return None,
        }
    }
    let head = String::from_utf8(bytes).unwrap();
    let mut lines = head.lines();
    let status = lines.next()?.split(' ').nth(1)?.parse().unwrap();
    let header = |line: &str| line.split_once(": ").map(|(k, v)| (k.to_lowercase(), v.to_string()));
    let headers: BTreeMap<String, String> = lines.filter_map(header).collect();
    let length = headers.get("content-length").map_or(0, |n| n.parse().unwrap());
    let mut body = vec![0; length];
    stream.read_exact(&mut body).ok()?;
    Some(Reply { status, headers, body })
}
