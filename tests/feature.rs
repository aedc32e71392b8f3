//! The feature stage's rules, each on geometry whose answer can be worked out by hand.

#![allow(clippy::unwrap_used, reason = "clippy.toml allows it in test functions; here are their helpers too")]

#[path = "feature/associate.rs"]
mod associate;
#[path = "feature/common.rs"]
mod common;
#[path = "feature/corner.rs"]
mod corner;
#[path = "feature/decide.rs"]
mod decide;
#[path = "feature/draw.rs"]
mod draw;
#[path = "feature/limit.rs"]
mod limit;
#[path = "feature/line.rs"]
mod line;
#[path = "feature/spatial.rs"]
mod spatial;
#[path = "feature/phantom.rs"]
mod phantom;
#[path = "feature/ping.rs"]
mod ping;
#[path = "feature/rcd.rs"]
mod rcd;
#[path = "feature/ring.rs"]
mod ring;
#[path = "feature/stage.rs"]
mod stage;
#[path = "feature/vote.rs"]
mod vote;
#[path = "feature/wall.rs"]
mod wall;
