//! A log being stepped through: one method or two side by side, locked together by their place in the log.

mod cell_query;
mod current_item;
mod lane;
mod session;
mod tiles;
mod views;
mod webgpu_batch;
mod webgpu_check;
mod working;

use super::protocol::{GoRequest, LaneSpec, LanesRequest, Stamp, Stamped, State, StepUnit};
use super::pyramid::Pyramid;
use super::{Request, Response, View, protocol};
use crate::pipeline::session::Session;
use crate::pipeline::step::{By, Stepper};
use crate::{Error, Result};
use lane::Lane;
use serde::Serialize;
use serde_json::json;
use std::path::PathBuf;
use std::sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};
use std::time::{Duration, Instant};

/// Turns a lane's specification into what a session is opened with.
pub type SessionRequester = dyn Fn(&LaneSpec) -> Result<crate::pipeline::session::Request> + Send + Sync;

/// How a log is shown.
pub struct Options {
    /// The log.
    pub path: PathBuf,
    /// Turns a lane's specification into a session request; its errors are shown to the user.
    pub request: Box<SessionRequester>,
    /// Threads of the kernels; 0: all.
    pub threads: usize,
    /// Memory that may be used, bytes; `None`: what the machine has free.
    pub memory: Option<u64>,
}

/// A log with one lane or two.
pub struct LogView {
    options: Options,
    lanes: RwLock<Lanes>,
    pyramid: Pyramid,
}

/// The lanes. Several pages may show them: a page compares version and generation with its own.
struct Lanes {
    all: Vec<Lane>,
    /// Increases whenever the position in the log changes.
    version: u64,
    /// Increases whenever the lanes are made anew.
    generation: u64,
}

/// Bytes of cached tiles, and of each lane's snapshots.
const TILE_CACHE: usize = 256 << 20;
const SNAPSHOTS: u64 = 256 << 20;

impl LogView {
    /// Opens a log with these lanes, one or two.
    ///
    /// # Errors
    /// The log's and the parameters'; [`Error::Resources`] where memory doesn't suffice.
    pub fn open(options: Options, lanes: &[LaneSpec]) -> Result<LogView> {
        let all = open_lanes(&options, lanes)?;
        Ok(LogView {
            options,
            lanes: RwLock::new(Lanes { all, version: 1, generation: 1 }),
            pyramid: Pyramid::new(TILE_CACHE),
        })
    }

    /// Calls `of` with the first lane's session, for example to warn of bad lines.
    pub fn with_session<T>(&self, of: impl FnOnce(&Session) -> T) -> T {
        of(self.read().all[0].stepper.session())
    }

    /// Moves to the requested position, and reports what changed.
    fn go(&self, request: &Request) -> Result<State> {
        let GoRequest { by, count, to, budget_ms, since } = request.json_body()?;
        let by = match (by, to) {
            (Some(StepUnit::Reading), None) => By::Items(count),
            (Some(StepUnit::Scan), None) => By::Scans(count),
            (None, Some(to)) => By::To(to),
            _ => return Err(Error::Usage("go by \"reading\" or \"scan\", so many, or to a position".into())),
        };
        let until = budget_ms.map(|ms| Instant::now() + Duration::from_millis(ms.min(60_000)));
        let mut more = || until.is_none_or(|until| Instant::now() < until);
        let mut lanes = self.write();
        let missed = since.is_some_and(|version| version != lanes.version);
        let target = lanes.all[0].stepper.target(by);
        let positions = |lanes: &Lanes| lanes.all.iter().map(|l| l.stepper.position()).collect::<Vec<_>>();
        let before = positions(&lanes);
        let changed = lanes.go(target, &mut more)?;
        lanes.version += u64::from(positions(&lanes) != before);
        for (k, tiles) in changed.into_iter().enumerate() {
            tiles::invalidate(&self.pyramid, k, &lanes.all, &tiles);
            lanes.all[k].record_changes(tiles);
        }
        let state = session::state(&lanes, target, missed);
        lanes.all.iter_mut().for_each(|lane| lane.changed.clear());
        Ok(state)
    }

    /// Replaces the lanes by others, at the same place of the log.
    fn replace_lanes(&self, request: &Request) -> Result<protocol::Session> {
        let LanesRequest { lanes: specs } = request.json_body()?;
        let mut made = Lanes { all: open_lanes(&self.options, &specs)?, version: 0, generation: 0 };
        // The old lanes remain usable meanwhile, and may move on.
        let place = self.read().all[0].next_place();
        made.go_to_place(place)?;
        let mut lanes = self.write();
        made.go_to_place(lanes.all[0].next_place())?;
        (made.version, made.generation) = (lanes.version + 1, lanes.generation + 1);
        *lanes = made;
        tiles::invalidate_all(&self.pyramid);
        session::session(&self.options, &lanes)
    }

    fn read(&self) -> RwLockReadGuard<'_, Lanes> {
        self.lanes.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn write(&self) -> RwLockWriteGuard<'_, Lanes> {
        self.lanes.write().unwrap_or_else(PoisonError::into_inner)
    }

    /// Responds to the requests of the browser's GPU.
    fn respond_gpu(&self, request: &Request) -> Result<Response> {
        match (request.post, request.path) {
            (false, "api/gpu/plan") => Response::json(&webgpu_batch::plan(self.read().requested(request)?)),
            (false, "api/gpu/wgsl") => webgpu_batch::wgsl(self.read().requested(request)?, request),
            (false, "api/gpu/batch") => webgpu_batch::batch(self.read().requested(request)?, request),
            (true, "api/gpu/share") => webgpu_check::share(self.read().requested(request)?, request),
            (true, "api/gpu/words") => {
                let mut lanes = self.write();
                let k = lanes.requested_number(request)?;
                let first = lanes.all[k].webgpu.is_none();
                let (check, changed) = webgpu_check::words(&mut lanes.all[k], request)?;
                if first {
                    tiles::invalidate_webgpu(&self.pyramid, k);
                }
                tiles::invalidate(&self.pyramid, k, &lanes.all, &changed);
                Response::json(&check)
            }
            (true, "api/gpu/reset") => {
                let mut lanes = self.write();
                let k = lanes.requested_number(request)?;
                lanes.all[k].reset_webgpu();
                tiles::invalidate_webgpu(&self.pyramid, k);
                Ok(Response::Json(json!({})))
            }
            _ => Ok(Response::NotFound),
        }
    }

    /// A response with the version and the generation that it refers to.
    fn stamped<T: Serialize>(&self, of: impl FnOnce(&Lanes) -> Result<T>) -> Result<Response> {
        let lanes = self.read();
        let stamp = Stamp { version: lanes.version, generation: lanes.generation };
        Response::json(&Stamped { answer: of(&lanes)?, stamp })
    }
}

impl View for LogView {
    fn respond(&self, request: &Request) -> Result<Response> {
        match (request.post, request.path) {
            (false, "api/session") => Response::json(&session::session(&self.options, &self.read())?),
            (false, "api/tile") => tiles::tile(&self.pyramid, &self.read().all, request),
            (false, "api/cell") => self.stamped(|lanes| cell_query::cell(&lanes.all, request)),
            (false, "api/working") => self.stamped(|lanes| working::working(lanes.requested(request)?)),
            (false, "api/history") => self.stamped(|lanes| cell_query::history(lanes.requested(request)?, request)),
            (true, "api/go") => Response::json(&self.go(request)?),
            (true, "api/lanes") => Response::json(&self.replace_lanes(request)?),
            (_, path) if path.starts_with("api/gpu/") => self.respond_gpu(request),
            _ => Ok(Response::NotFound),
        }
    }
}

impl Lanes {
    /// Moves to a place of the log.
    fn go_to_place(&mut self, place: lane::NextPlace) -> Result<()> {
        let to = self.all[0].position_at(place);
        self.go(to, &mut || true).map(|_| ())
    }

    /// The number of the lane that is requested.
    fn requested_number(&self, request: &Request) -> Result<usize> {
        let (k, count) = (request.query_number("lane")?, self.all.len());
        let unknown = || Error::Usage(format!("there is no lane {k}: there are {count}, from 0"));
        (k < count).then_some(k).ok_or_else(unknown)
    }

    /// The lane that is requested.
    fn requested(&self, request: &Request) -> Result<&Lane> {
        Ok(&self.all[self.requested_number(request)?])
    }

    /// Moves the first lane to a position, while `more` allows, and the others to the same place of the log. Returns the tiles that changed
    /// in each.
    fn go(&mut self, to: usize, more: &mut dyn FnMut() -> bool) -> Result<Vec<crate::pipeline::step::Tiles>> {
        let mut changed = vec![self.all[0].stepper.go(to, more)?];
        let Some((first, rest)) = self.all.split_first_mut() else { return Ok(changed) };
        for lane in rest {
            let to = match lane.has_items_of(first) {
                true => first.stepper.position(),
                false => lane.position_at(first.next_place()),
            };
            // Without a limit: the lanes must stay at one place of the log.
            changed.push(lane.stepper.go(to, &mut || true)?);
        }
        Ok(changed)
    }
}

/// Opens a session for each lane, on one grid.
fn open_lanes(options: &Options, specs: &[LaneSpec]) -> Result<Vec<Lane>> {
    if specs.is_empty() || specs.len() > 2 {
        return Err(Error::Usage(format!("one method or two side by side, not {}", specs.len())));
    }
    let open = |spec: &LaneSpec| Session::open(&options.path, &(options.request)(spec)?);
    let mut sessions = specs.iter().map(open).collect::<Result<Vec<_>>>()?;
    let grid = sessions.iter().map(|s| s.grid).reduce(|a, b| a.union(&b));
    let (mut lanes, count) = (Vec::new(), sessions.len() as u64);
    for (mut session, spec) in sessions.drain(..).zip(specs) {
        session.grid = grid.unwrap_or(session.grid);
        let share = options.memory.map(|m| m / count);
        let stepper = Stepper::open(session, options.threads, share, SNAPSHOTS)?;
        lanes.push(Lane::new(stepper, spec.clone()));
    }
    Ok(lanes)
}
