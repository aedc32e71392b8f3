//! Many at once: each is answered, and no more are worked on than may be.

use crate::web::{Puppet, Web, reply};
use echogrid::view::{Limits, Request, Response, View};
use serde_json::json;
use std::io::Write;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex};
use std::time::Duration;

/// Counts how many it is asked at once.
#[derive(Default)]
struct Counting {
    now: AtomicUsize,
    most: AtomicUsize,
    asked: AtomicUsize,
}

impl View for Counting {
    fn respond(&self, _: &Request) -> echogrid::Result<Response> {
        let now = self.now.fetch_add(1, Ordering::SeqCst) + 1;
        self.most.fetch_max(now, Ordering::SeqCst);
        self.asked.fetch_add(1, Ordering::SeqCst);
        std::thread::sleep(Duration::from_millis(2));
        self.now.fetch_sub(1, Ordering::SeqCst);
        Ok(Response::Json(json!("done")))
    }
}

#[test]
fn a_thousand_at_once_are_all_answered() {
    let view = Arc::new(Counting::default());
    let web = Web::of(view.clone(), Limits::default());
    let (at, request) = (web.at, web.fill("GET /TOKEN/api/x HTTP/1.1\r\nHost: HOST\r\n\r\n"));
    let client = |_| {
        let request = request.clone();
        let run = move || {
            let mut stream = std::net::TcpStream::connect(at).unwrap();
            stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
            stream.write_all(request.as_bytes()).unwrap();
            reply(&mut stream).map(|r| r.status)
        };
        std::thread::Builder::new().stack_size(256 << 10).spawn(run).unwrap()
    };
    let clients: Vec<_> = (0..1000).map(client).collect();
    let answered = clients.into_iter().filter(|_| true).map(|c| c.join().unwrap());
    assert_eq!(answered.filter(|status| *status == Some(200)).count(), 1000);
    assert_eq!(view.asked.load(Ordering::SeqCst), 1000);
    assert!(view.most.load(Ordering::SeqCst) <= 64, "{:?}", view.most);
}

/// Answers only once it is let go.
#[derive(Default)]
struct Gate {
    open: Mutex<bool>,
    opened: Condvar,
}

impl View for Gate {
    fn respond(&self, request: &Request) -> echogrid::Result<Response> {
        let mut open = self.open.lock().unwrap();
        while !*open && request.path == "api/wait" {
            open = self.opened.wait(open).unwrap();
        }
        Ok(Response::Json(json!("done")))
    }
}

#[test]
fn who_waits_too_long_is_told_so() {
    let view = Arc::new(Gate::default());
    let limits = Limits { worked_on: 1, wait: Duration::from_millis(200), ..Limits::default() };
    let web = Web::of(view.clone(), limits);
    let mut first = web.connect();
    first.write_all(web.fill("GET /TOKEN/api/wait HTTP/1.1\r\nHost: HOST\r\n\r\n").as_bytes()).unwrap();
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(web.get("api/other").status, 503);
    assert_eq!(web.get("view.js").status, 200, "the page itself doesn't wait");
    // its client goes: it keeps its turn until it is done
    drop(first);
    assert_eq!(web.get("api/other").status, 503);
    *view.open.lock().unwrap() = true;
    view.opened.notify_all();
    std::thread::sleep(Duration::from_millis(100));
    assert_eq!(web.get("api/other").status, 200);
}

#[test]
fn connections_are_bounded_and_the_next_one_gets_its_turn() {
    let limits = Limits { connections: 3, head: Duration::from_millis(400), ..Limits::default() };
    let web = Web::of(Arc::new(Puppet::default()), limits);
    let idle: Vec<_> = (0..20).map(|_| web.connect()).collect();
    web.lives();
    drop(idle);
    web.lives();
}
