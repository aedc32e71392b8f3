//! `echogrid view`.

use super::log_arguments::LogArguments;
use super::suggested_values::{SuggestedValues, methods};
use super::values::use_threads;
use super::warnings::{print_log_notes, warn_of_bad_lines, warn_of_unused_parameters};
use super::{print_line, print_note, stdout};
use crate::output::seems_map;
use crate::support::memory;
use crate::view::log::{self, LogView};
use crate::view::map::{Companions, MapView};
use crate::view::protocol::LaneSpec;
use crate::view::{Options, Server, View, serve};
use crate::{Error, Result};
use clap::ValueHint;
use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;
use std::sync::Arc;

/// Arguments of `view`.
#[derive(Debug, clap::Args)]
#[command(
    mut_arg("log", |a| a.value_name("PATH").help(
        "A map's folder, or a log: a file, a sonar_ring_8 folder, or - for standard input")),
    after_help = AFTER,
)]
pub struct ViewArguments {
    #[command(flatten)]
    log: LogArguments,
    /// Of a log: a second method beside the first, and their difference
    #[arg(long, value_name = "METHOD", value_parser = SuggestedValues(methods), hide_possible_values = true)]
    beside: Option<String>,
    /// Of a map: another map beside it, of cells of the same size, and their difference
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    with: Option<PathBuf>,
    /// Of a map: what is true, a world (built in, or its .toml) or a map, to see the map's errors and its score
    #[arg(long, value_name = "WORLD|MAP", value_hint = ValueHint::AnyPath)]
    truth: Option<PathBuf>,
    /// Address to listen on; any but this one lets other machines in, unencrypted
    #[arg(long, value_name = "ADDR", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    bind: IpAddr,
    /// Port to listen on [default: one that is free]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Memory that may be used, such as 4GiB [default: what the machine has free]
    #[arg(long, value_name = "SIZE", value_parser = memory::parse_size)]
    memory: Option<u64>,
}

const AFTER: &str =
    "It prints the page's address, whose middle part is a secret made anew each time, and serves until Ctrl-C. \
Nothing is sent elsewhere, and no browser is opened.

A map is opened whatever its size: only what is looked at is read. Options of a log's mapping and --beside are for logs, --with and \
--truth for maps.

On another machine: ssh -L PORT:127.0.0.1:PORT HOST there, then the same address in a browser there.";

impl ViewArguments {
    /// Serves the page until Ctrl-C.
    pub fn run(self) -> Result<u8> {
        let view = self.open()?;
        let options = Options { bind: self.bind, port: self.port, ..Options::default() };
        serve(view, &options, &|server| self.announce(server))?;
        Ok(0)
    }

    fn open(&self) -> Result<Arc<dyn View>> {
        let path = &self.log.log;
        if seems_map(path) {
            let beside = self.beside.as_ref().map(|_| "--beside");
            if let Some(option) = self.log.changed().or(beside) {
                return Err(Error::Usage(format!(
                    "{option} is for logs: {} is a map, made already; `echogrid map` makes one anew",
                    path.display()
                )));
            }
            use_threads(self.log.threads)?;
            let beside = Companions { with: self.with.as_deref(), truth: self.truth.as_deref(), memory: self.memory };
            let view = MapView::open(path, &beside)?;
            view.notes().iter().for_each(|what| print_note!("{what}"));
            return Ok(Arc::new(view));
        }
        if self.with.is_some() || self.truth.is_some() {
            let option = if self.with.is_some() { "--with" } else { "--truth" };
            return Err(Error::Usage(format!(
                "{option} is for maps: {} is none, a folder with report.json and map.zarr",
                path.display()
            )));
        }
        self.open_log()
    }

    /// A log to step through.
    fn open_log(&self) -> Result<Arc<dyn View>> {
        let arguments = &self.log;
        if arguments.log.as_os_str() == "-" {
            let what =
                "a log is read anew for each method and parameter: write standard input to a file, and give that";
            return Err(Error::Usage(what.into()));
        }
        arguments.request()?;
        let own = LaneSpec { method: arguments.method.clone(), set: arguments.pairs()?.into_iter().collect() };
        let mut lanes = vec![own];
        if let Some(method) = &self.beside {
            lanes.push(LaneSpec { method: method.clone(), set: Default::default() });
        }
        let again = LogArguments { set: Vec::new(), ..arguments.clone() };
        let request = move |lane: &LaneSpec| {
            let set: Vec<(String, String)> = lane.set.clone().into_iter().collect();
            again.request_of(&lane.method, &set)
        };
        let options = log::Options {
            path: arguments.log.clone(),
            request: Box::new(request),
            threads: arguments.threads,
            memory: self.memory,
        };
        let view = LogView::open(options, &lanes).map_err(|error| match error {
            Error::Input { .. } if arguments.log.is_dir() => {
                error.and("a saved map is a folder with report.json and map.zarr")
            }
            error => error,
        })?;
        view.with_session(|session| {
            warn_of_bad_lines(session, "mend them; --strict refuses such a log");
            warn_of_unused_parameters(arguments, session);
            print_log_notes(session);
        });
        Ok(Arc::new(view))
    }

    fn announce(&self, server: &Server) -> Result<()> {
        print_line!("{}", server.address());
        // Fails here where the address can't be printed.
        stdout::finish()?;
        let port = server.port();
        if self.bind.is_loopback() {
            print_note!("from another machine: ssh -L {port}:127.0.0.1:{port} HOST, then open the same address there");
        } else {
            print_note!("it listens on {}: whoever has the address can look, and nothing is encrypted", self.bind);
        }
        print_note!("Ctrl-C ends it");
        Ok(())
    }
}
