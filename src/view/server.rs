//! The HTTP server of `echogrid view`. It listens on one address of this machine, by default one that only this machine reaches, and
//! serves clients that know its token.

use super::View;
use super::router::router;
use crate::{Error, Result};
use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::runtime::Runtime;
use tokio::sync::Semaphore;
use tokio_io_timeout::TimeoutStream;

/// Largest head of a request, bytes.
const HEAD: usize = 64 << 10;
/// The pause after a connection could not be accepted, for example for lack of file handles.
const PAUSE: Duration = Duration::from_millis(50);

/// Where to listen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// The address to listen on; 127.0.0.1 is reached from this machine only.
    pub bind: IpAddr,
    /// The port; 0: a free one.
    pub port: u16,
    /// Limits on clients.
    pub limits: Limits,
}

impl Default for Options {
    fn default() -> Options {
        Options { bind: Ipv4Addr::LOCALHOST.into(), port: 0, limits: Limits::default() }
    }
}

/// Limits on clients, so that none of them blocks the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Open connections; further ones wait to be accepted.
    pub connections: usize,
    /// Requests that the view works on at once; further ones wait.
    pub worked_on: usize,
    /// Time for a request's head, and for an idle connection.
    pub head: Duration,
    /// Time for a body, and for a client to accept more of a response.
    pub body: Duration,
    /// Time that a request may wait before the view works on it.
    pub wait: Duration,
}

impl Default for Limits {
    fn default() -> Limits {
        let [head, body, wait] = [10, 60, 60].map(Duration::from_secs);
        Limits { connections: 1024, worked_on: 64, head, body, wait }
    }
}

/// A server that listens until it is dropped.
#[derive(Debug)]
pub struct Server {
    at: SocketAddr,
    token: String,
    runtime: Option<Runtime>,
}

impl Server {
    /// Starts to listen, and to serve `view`.
    ///
    /// # Errors
    /// [`Error::Resources`] where it can't listen on the address.
    pub fn open(view: Arc<dyn View>, options: &Options) -> Result<Server> {
        let failed = |what: &str| Error::Resources(format!("the server can't be started: {what}"));
        let token = token().map_err(|e| failed(&e.to_string()))?;
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
        let runtime = runtime.map_err(|e| failed(&e.to_string()))?;
        let wanted = SocketAddr::new(options.bind, options.port);
        let listener = runtime.block_on(TcpListener::bind(wanted)).map_err(|e| {
            Error::Resources(format!("{wanted} can't be listened on: {e}; give another --port, or another --bind"))
        })?;
        let at = listener.local_addr().map_err(|e| failed(&e.to_string()))?;
        raise_file_limit();
        let limits = options.limits;
        runtime.spawn(listen(listener, router(view, &token, limits), limits));
        Ok(Server { at, token, runtime: Some(runtime) })
    }

    /// The page's URL with the token. For a server that listens on every address it names the loopback one.
    pub fn address(&self) -> String {
        let mut at = self.at;
        if at.ip().is_unspecified() {
            at.set_ip(Ipv4Addr::LOCALHOST.into());
        }
        format!("http://{at}/{}/", self.token)
    }

    /// The port.
    pub fn port(&self) -> u16 {
        self.at.port()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_background(); // requests in progress are not waited for
        }
    }
}

/// Serves a view until Ctrl-C. Calls `started` once it listens; an error of it ends the server.
///
/// # Errors
/// As [`Server::open`], and those of `started`.
pub fn serve(view: Arc<dyn View>, options: &Options, started: &dyn Fn(&Server) -> Result<()>) -> Result<()> {
    let server = Server::open(view, options)?;
    if let Some(runtime) = &server.runtime {
        let interrupted = runtime.spawn(tokio::signal::ctrl_c());
        started(&server)?;
        let heard = runtime.block_on(interrupted).map_err(|e| e.to_string());
        heard
            .and_then(|r| r.map_err(|e| e.to_string()))
            .map_err(|e| Error::Resources(format!("Ctrl-C can't be waited for: {e}")))?;
    }
    Ok(())
}

/// Accepts connections. Not by `axum::serve`: it bounds neither their number nor how long a head may take.
async fn listen(listener: TcpListener, router: Router, limits: Limits) {
    let places = Arc::new(Semaphore::new(limits.connections));
    loop {
        let Ok(place) = places.clone().acquire_owned().await else { return };
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(PAUSE).await;
            continue;
        };
        let _ = stream.set_nodelay(true);
        let mut stream = TimeoutStream::new(stream);
        stream.set_write_timeout(Some(limits.body));
        let service = TowerToHyperService::new(router.clone());
        let mut http = http1::Builder::new();
        http.timer(TokioTimer::new()).header_read_timeout(limits.head).max_buf_size(HEAD);
        let connection = http.serve_connection(TokioIo::new(Box::pin(stream)), service);
        tokio::spawn(async move {
            let _ = connection.await; // a client may disconnect at any time
            drop(place);
        });
    }
}

/// 128 random bits in hexadecimal.
fn token() -> std::result::Result<String, getrandom::Error> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes)?;
    Ok(bytes.iter().map(|b| format!("{b:02x}")).collect())
}

/// Raises the soft limit of file handles, often 1024, for connections and the files of maps.
fn raise_file_limit() {
    #[cfg(unix)]
    {
        use rustix::process::{Resource, getrlimit, setrlimit};
        const WANTED: u64 = 4096;
        let mut limit = getrlimit(Resource::Nofile);
        if limit.current.is_some_and(|n| n < WANTED) {
            limit.current = Some(limit.maximum.map_or(WANTED, |most| most.min(WANTED)));
            let _ = setrlimit(Resource::Nofile, limit);
        }
    }
}
