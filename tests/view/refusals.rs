//! Whoever isn't the page is turned away, and the server goes on.

use crate::web::{Web, guarded, reply};
use echogrid::view::Limits;
use serde_json::json;
use std::io::Write;
use std::time::{Duration, Instant};

#[test]
fn good_requests() {
    let web = Web::new();
    for (path, kind) in [("", "text/html"), ("view.js", "text/javascript"), ("view.css", "text/css")] {
        let reply = web.get(path);
        assert_eq!(reply.status, 200, "{path}");
        assert!(reply.headers["content-type"].starts_with(kind) && !reply.body.is_empty(), "{reply:?}");
        guarded(&reply);
    }
    web.lives();
    assert_eq!(web.post("api/echo", "{}").json(), json!({"post": true, "query": {}, "bytes": 2}));
    let bytes = web.get("api/bytes");
    assert_eq!((bytes.headers["content-type"].as_str(), bytes.body), ("image/png", vec![1, 2, 3]));
    assert_eq!(web.get("api/nothing").status, 204);
    // the address without its last slash leads to it
    let bare = web.raw("GET /TOKEN HTTP/1.1\r\nHost: HOST\r\n\r\n");
    assert_eq!((bare.status, bare.headers["location"].clone()), (308, format!("/{}/", web.token)));
    // two requests on one connection, and one of which only the head is wanted
    let mut stream = web.connect();
    for _ in 0..2 {
        stream.write_all(web.fill("GET /TOKEN/api/echo HTTP/1.1\r\nHost: HOST\r\n\r\n").as_bytes()).unwrap();
        assert_eq!(reply(&mut stream).unwrap().status, 200);
    }
    let mut stream = web.connect();
    let head = "HEAD /TOKEN/api/echo HTTP/1.1\r\nHost: HOST\r\nConnection: close\r\n\r\n";
    stream.write_all(web.fill(head).as_bytes()).unwrap();
    let mut text = String::new();
    std::io::Read::read_to_string(&mut stream, &mut text).unwrap();
    assert!(text.starts_with("HTTP/1.1 200") && text.ends_with("\r\n\r\n"), "{text}");
}

#[test]
fn errors_of_the_view() {
    let web = Web::new();
    for (path, status, error) in [
        ("api/usage", 400, "wrong parameter"),
        ("api/input", 422, "map.zarr: damaged"),
        ("api/resources", 500, "no memory"),
        ("api/adapter", 500, "no adapter"),
        ("api/unknown", 404, "there is nothing at this address"),
        ("nothing", 404, "there is nothing at this address"),
    ] {
        let reply = web.get(path);
        assert_eq!((reply.status, reply.json()), (status, json!({"error": error})), "{path}");
        guarded(&reply);
    }
    for path in ["api/panic", "api/poison", "api/poison", "api/panic"] {
        let reply = web.get(path);
        assert_eq!(reply.status, 500, "{path}");
        assert!(reply.json()["error"].as_str().unwrap().contains("report it"), "{reply:?}");
        web.lives();
    }
}

#[test]
fn a_wrong_token() {
    let web = Web::new();
    let other = format!("{}{}", &web.token[..31], if web.token.ends_with('0') { '1' } else { '0' });
    for path in ["/", "", "/api/session", "/view.js", "/favicon.ico", &format!("/{other}/"), "//TOKEN/", "/../TOKEN/"] {
        let path = if path.is_empty() { "*" } else { path };
        let method = if path == "*" { "OPTIONS" } else { "GET" };
        let reply = web.refuses(&format!("{method} {path} HTTP/1.1\r\nHost: HOST\r\n\r\n"), 403);
        assert!(reply.text().starts_with("Forbidden: open the whole address"), "{reply:?}");
        assert!(!reply.text().contains(&web.token));
    }
    web.refuses("GET /TOKEN0/ HTTP/1.1\r\nHost: HOST\r\n\r\n", 403);
    web.refuses(&format!("GET /{}/ HTTP/1.1\r\nHost: HOST\r\n\r\n", &web.token[1..]), 403);
    web.refuses("POST /wrong/api/echo HTTP/1.1\r\nHost: HOST\r\nContent-Length: 0\r\n\r\n", 403);
}

#[test]
fn strangers() {
    let web = Web::new();
    let port = web.at.port();
    // a name that a stranger's domain server could make point here
    for host in ["example.org", "localhost.example.org", "127.0.0.1.example.org", "evil@127.0.0.1", "[::1", ""] {
        let named = if host.is_empty() { String::new() } else { format!("{host}:{port}") };
        web.refuses(&format!("GET /TOKEN/api/echo HTTP/1.1\r\nHost: {named}\r\n\r\n"), 403);
    }
    web.refuses("GET /TOKEN/api/echo HTTP/1.1\r\nHost: HOST\r\nHost: example.org\r\n\r\n", 403);
    web.refuses("GET /TOKEN/api/echo HTTP/1.0\r\n\r\n", 403);
    web.refuses("GET http://example.org/TOKEN/api/echo HTTP/1.1\r\nHost: HOST\r\n\r\n", 403);
    for host in ["localhost", "localhost:9", "127.0.0.1:9", "[::1]:9", "192.168.1.2"] {
        let reply = web.raw(&format!("GET /TOKEN/api/echo HTTP/1.1\r\nHost: {host}\r\n\r\n"));
        assert_eq!(reply.status, 200, "{host}: a tunnel has its own port");
    }
    // another site's page
    for more in [
        "Origin: http://example.org",
        "Origin: null",
        "Origin: https://HOST",
        "Origin: http://HOST.example.org",
        "Origin: http://HOST\r\nOrigin: http://example.org",
        "Sec-Fetch-Site: cross-site",
        "Sec-Fetch-Site: same-site",
        "Origin: http://HOST\r\nSec-Fetch-Site: cross-site",
    ] {
        for method in ["GET", "POST"] {
            let text =
                format!("{method} /TOKEN/api/echo HTTP/1.1\r\nHost: HOST\r\n{more}\r\nContent-Length: 0\r\n\r\n");
            web.refuses(&text, 403);
        }
    }
    for more in ["Origin: http://HOST", "Sec-Fetch-Site: same-origin", "Sec-Fetch-Site: none"] {
        let reply = web.raw(&format!("GET /TOKEN/api/echo HTTP/1.1\r\nHost: HOST\r\n{more}\r\n\r\n"));
        assert_eq!(reply.status, 200, "{more}");
    }
}

#[test]
fn paths_that_climb() {
    let web = Web::new();
    for path in [
        "../",
        "..",
        "../../etc/passwd",
        "api/../view.js",
        "api//echo",
        "/view.js",
        "//etc/passwd",
        "./view.js",
        "%2e%2e/",
        "%2E%2E%2Fetc%2fpasswd",
        "api/echo%00",
        "view.js%00.css",
        "api/.",
        ".git/config",
        "api\\echo",
        "api/",
        "a;b",
        "view.js/",
        "index.html",
        "api/echo%20",
    ] {
        web.refuses(&format!("GET /TOKEN/{path} HTTP/1.1\r\nHost: HOST\r\n\r\n"), 404);
    }
    // a byte that no request line may have
    let reply = web.raw("GET /TOKEN/api\0/echo HTTP/1.1\r\nHost: HOST\r\n\r\n");
    assert!([400, 404].contains(&reply.status), "{reply:?}");
    web.lives();
    for query in ["a=%", "a=%zz", "a=%ff"] {
        web.refuses(&format!("GET /TOKEN/api/echo?{query} HTTP/1.1\r\nHost: HOST\r\n\r\n"), 400);
    }
}

#[test]
fn methods_and_forms() {
    let web = Web::new();
    for method in ["PUT", "DELETE", "OPTIONS", "PATCH", "TRACE", "BREW"] {
        let reply = web.refuses(&format!("{method} /TOKEN/api/echo HTTP/1.1\r\nHost: HOST\r\n\r\n"), 405);
        assert_eq!(reply.headers["allow"], "GET, HEAD, POST");
    }
    let connect = web.raw("CONNECT HOST HTTP/1.1\r\nHost: HOST\r\n\r\n");
    assert_eq!(connect.status, 403);
    web.refuses("POST /TOKEN/view.js HTTP/1.1\r\nHost: HOST\r\nContent-Length: 0\r\n\r\n", 405);
    for kind in [
        "text/plain",
        "TEXT/PLAIN;charset=utf-8",
        "multipart/form-data; boundary=x",
        "application/x-www-form-urlencoded",
    ] {
        let head = "POST /TOKEN/api/echo HTTP/1.1\r\nHost: HOST\r\nContent-Length: 2\r\nContent-Type: ";
        web.refuses(&format!("{head}{kind}\r\n\r\n{{}}"), 415);
    }
}

#[test]
fn bodies_that_are_too_large() {
    let web = Web::new();
    // refused by what the head says: not a byte of it is sent
    for length in ["1073741824", "65537", "9223372036854775807"] {
        let text = format!("POST /TOKEN/api/echo HTTP/1.1\r\nHost: HOST\r\nContent-Length: {length}\r\n\r\n");
        web.refuses(&text, 413);
        web.refuses(&text.replace("POST", "GET"), 413);
    }
    let words = "POST /TOKEN/api/gpu/words HTTP/1.1\r\nHost: HOST\r\nContent-Length: 67108865\r\n\r\n";
    web.refuses(words, 413);
    assert_eq!(web.post("api/echo", &"x".repeat(65536)).json()["bytes"], 65536);
    assert_eq!(web.post("api/gpu/words", &"x".repeat(1 << 20)).json()["bytes"], 1 << 20);
    // in chunks, of unknown length: cut at the limit
    let chunk = format!("{:x}\r\n{}\r\n", 30_000, "x".repeat(30_000));
    let chunks = |n: usize| {
        let head = "POST /TOKEN/api/echo HTTP/1.1\r\nHost: HOST\r\nTransfer-Encoding: chunked\r\n\r\n";
        format!("{head}{}0\r\n\r\n", chunk.repeat(n))
    };
    assert_eq!(web.raw(&chunks(2)).json()["bytes"], 60_000);
    web.refuses(&chunks(3), 413);
    // without end: it is not waited for
    let mut stream = web.connect();
    stream.write_all(web.fill(&chunks(1).replace("\r\n0\r\n\r\n", "\r\n")).as_bytes()).unwrap();
    while stream.write_all(chunk.as_bytes()).is_ok() {}
    web.lives();
    // lengths that aren't
    for length in ["x", "-1", "18446744073709551614", "99999999999999999999999"] {
        let reply =
            web.raw(&format!("POST /TOKEN/api/echo HTTP/1.1\r\nHost: HOST\r\nContent-Length: {length}\r\n\r\n"));
        assert!([400, 431].contains(&reply.status), "{length}: {reply:?}");
        web.lives();
    }
    // a head without end
    let mut stream = web.connect();
    stream.write_all(web.fill("GET /TOKEN/api/echo HTTP/1.1\r\nHost: HOST\r\n").as_bytes()).unwrap();
    while stream.write_all(b"X: 0123456789012345678901234567890123456789\r\n").is_ok() {}
    web.lives();
}

#[test]
fn clients_that_dawdle() {
    let short = Duration::from_millis(300);
    let limits = Limits { head: short, body: short, ..Limits::default() };
    let web = Web::of(std::sync::Arc::new(crate::web::Puppet::default()), limits);
    let started = Instant::now();
    // half a head
    let mut stream = web.connect();
    stream.write_all(b"GET / HTTP/1.1\r\nHo").unwrap();
    assert!(reply(&mut stream).is_none());
    // nothing at all
    assert!(reply(&mut web.connect()).is_none());
    // half a body
    let mut stream = web.connect();
    let half = "POST /TOKEN/api/echo HTTP/1.1\r\nHost: HOST\r\nContent-Length: 10\r\n\r\n{";
    stream.write_all(web.fill(half).as_bytes()).unwrap();
    assert_eq!(reply(&mut stream).unwrap().status, 408);
    assert!(started.elapsed() < Duration::from_secs(20));
    web.lives();
    // gone in the middle of it
    for _ in 0..50 {
        web.connect().write_all(web.fill(half).as_bytes()).unwrap();
    }
    web.lives();
    let [head, body, wait] = [10, 60, 60].map(Duration::from_secs);
    assert_eq!(Limits::default(), Limits { connections: 1024, worked_on: 64, head, body, wait });
}

#[test]
fn answers_that_nobody_reads() {
    let limits = Limits { connections: 1, body: Duration::from_millis(300), ..Limits::default() };
    let web = Web::of(std::sync::Arc::new(crate::web::Puppet::default()), limits);
    let mut stream = web.connect();
    let request = web.fill("GET /TOKEN/view.js HTTP/1.1\r\nHost: HOST\r\n\r\n");
    stream.write_all(request.repeat(1000).as_bytes()).unwrap();
    web.lives(); // its place was given to the next one
    drop(stream);
}
