//! A log being stepped through: one method or two side by side, locked together by their place in the log.

mod current;
mod describe;
mod gpu;
mod lane;
mod shown;
mod told;

pub use lane::Wanted;

use super::pyramid::Pyramid;
use super::{Answer, Ask, View};
use crate::pipeline::session::{Request, Session};
use crate::pipeline::step::{By, Stepper};
use crate::{Error, Result};
use lane::Lane;
use serde::Deserialize;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};
use std::time::{Duration, Instant};

/// What a lane is asked to be, made into what a session takes.
pub type Ready = dyn Fn(&Wanted) -> Result<Request> + Send + Sync;

/// How a log is looked at.
pub struct Options {
    /// The log.
    pub path: PathBuf,
    /// From a method and what is set of it to a request; its errors are shown to the user.
    pub ready: Box<Ready>,
    /// Threads of the kernels; 0: all.
    pub threads: usize,
    /// Memory that may be used, bytes; `None`: what the machine has free.
    pub memory: Option<u64>,
}

/// A log, and one lane or two.
pub struct LogView {
    options: Options,
    lanes: RwLock<Lanes>,
    pyramid: Pyramid,
}

/// The lanes, how often their place in the log changed, and how often they were made anew: a page tells by these whether what it
/// shows is still there, for another may be open.
struct Lanes {
    all: Vec<Lane>,
    version: u64,
    generation: u64,
}

/// Bytes of tiles that are kept, and of each lane's snapshots.
const TILES: usize = 256 << 20;
const SNAPSHOTS: u64 = 256 << 20;
/// Events of a cell's history that are told, unless asked for another number, and at most.
const EVENTS: usize = 100;
const MOST_EVENTS: usize = 10_000;

impl LogView {
    /// Opens a log for these lanes, one or two.
    ///
    /// # Errors
    /// The log's and the parameters'; [`Error::Resources`] where memory doesn't suffice.
    pub fn open(options: Options, lanes: &[Wanted]) -> Result<LogView> {
        let all = make(&options, lanes)?;
        Ok(LogView {
            options,
            lanes: RwLock::new(Lanes { all, version: 1, generation: 1 }),
            pyramid: Pyramid::new(TILES),
        })
    }

    /// What `of` makes of the first lane's session, such as a warning of its bad lines.
    pub fn about<T>(&self, of: impl FnOnce(&Session) -> T) -> T {
        of(self.read().all[0].stepper.session())
    }

    /// Goes where the page asks, and says what changed.
    fn go(&self, ask: &Ask) -> Result<Value> {
        let Go { by, count, to, budget_ms, since } = ask.json()?;
        let by = match (by.as_deref(), to) {
            (Some("reading"), None) => By::Items(count),
            (Some("scan"), None) => By::Scans(count),
            (None, Some(to)) => By::To(to),
            _ => return Err(Error::Usage("go by \"reading\" or \"scan\", so many, or to a position".into())),
        };
        let until = budget_ms.map(|ms| Instant::now() + Duration::from_millis(ms.min(60_000)));
        let mut more = || until.is_none_or(|until| Instant::now() < until);
        let mut lanes = self.write();
        let missed = since.is_some_and(|version| version != lanes.version);
        let to = lanes.all[0].stepper.target(by);
        let places = |lanes: &Lanes| lanes.all.iter().map(|l| l.stepper.position()).collect::<Vec<_>>();
        let before = places(&lanes);
        let changed = lanes.go(to, &mut more)?;
        lanes.version += u64::from(places(&lanes) != before);
        for (k, tiles) in changed.into_iter().enumerate() {
            shown::forget(&self.pyramid, k, &lanes.all, &tiles);
            lanes.all[k].note(tiles);
        }
        let told = describe::state(&lanes, to, missed);
        lanes.all.iter_mut().for_each(|lane| lane.changed.clear());
        Ok(told)
    }

    /// Other methods or parameters, at the same place of the log.
    fn remake(&self, ask: &Ask) -> Result<Value> {
        let Remake { lanes: wanted } = ask.json()?;
        let mut made = Lanes { all: make(&self.options, &wanted)?, version: 0, generation: 0 };
        // What is there can be looked at meanwhile, so that it may go on, too.
        let place = self.read().all[0].next_place();
        made.follow(place)?;
        let mut lanes = self.write();
        made.follow(lanes.all[0].next_place())?;
        (made.version, made.generation) = (lanes.version + 1, lanes.generation + 1);
        *lanes = made;
        shown::forget_all(&self.pyramid);
        Ok(describe::session(&self.options, &lanes))
    }

    fn read(&self) -> RwLockReadGuard<'_, Lanes> {
        self.lanes.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn write(&self) -> RwLockWriteGuard<'_, Lanes> {
        self.lanes.write().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is told of the lane that is asked for.
    fn lane<T>(&self, ask: &Ask, of: impl FnOnce(&Lane) -> Result<T>) -> Result<T> {
        of(self.read().find(ask.number("lane")?)?)
    }

    /// The same with the version and the generation that it is of.
    fn dated(&self, of: impl FnOnce(&Lanes) -> Result<Value>) -> Result<Answer> {
        let lanes = self.read();
        let mut told = of(&lanes)?;
        told["version"] = json!(lanes.version);
        told["generation"] = json!(lanes.generation);
        Ok(Answer::Json(told))
    }
}

impl View for LogView {
    fn answer(&self, ask: &Ask) -> Result<Answer> {
        let json = |value: Value| Ok(Answer::Json(value));
        match (ask.post, ask.path) {
            (false, "api/session") => json(describe::session(&self.options, &self.read())),
            (false, "api/tile") => shown::tile(&self.pyramid, &self.read().all, ask),
            (false, "api/cell") => self.dated(|lanes| told::cell(&lanes.all, ask)),
            (false, "api/working") => self.dated(|lanes| told::working(lanes.find(ask.number("lane")?)?)),
            (false, "api/history") => self.dated(|lanes| told::history(lanes.find(ask.number("lane")?)?, ask)),
            (true, "api/go") => json(self.go(ask)?),
            (true, "api/lanes") => json(self.remake(ask)?),
            (false, "api/gpu/plan") => json(self.lane(ask, |lane| Ok(gpu::plan(lane)))?),
            (false, "api/gpu/wgsl") => self.lane(ask, |lane| gpu::wgsl(lane, ask)),
            (false, "api/gpu/batch") => self.lane(ask, |lane| gpu::batch(lane, ask)),
            (true, "api/gpu/share") => self.lane(ask, |lane| gpu::share(lane, ask)),
            (true, "api/gpu/words" | "api/gpu/reset") => {
                let mut lanes = self.write();
                let k = ask.number("lane")?;
                lanes.find(k)?;
                if ask.path == "api/gpu/reset" {
                    lanes.all[k].reset();
                    shown::forget_page(&self.pyramid, k);
                    return json(json!({}));
                }
                let (first, (told, tiles)) = (lanes.all[k].page.is_none(), gpu::words(&mut lanes.all[k], ask)?);
                if first {
                    shown::forget_page(&self.pyramid, k);
                }
                shown::forget(&self.pyramid, k, &lanes.all, &tiles);
                json(told)
            }
            _ => Ok(Answer::Unknown),
        }
    }
}

impl Lanes {
    /// Goes to a place of the log.
    fn follow(&mut self, place: lane::Next) -> Result<()> {
        let to = self.all[0].position_at(place);
        self.go(to, &mut || true).map(|_| ())
    }

    fn find(&self, k: usize) -> Result<&Lane> {
        let count = self.all.len();
        self.all.get(k).ok_or_else(|| Error::Usage(format!("there is no lane {k}: there are {count}, from 0")))
    }

    /// Brings the first lane to a position, while there is time, and the others to the same place of the log; what changed in each.
    fn go(&mut self, to: usize, more: &mut dyn FnMut() -> bool) -> Result<Vec<crate::pipeline::step::Tiles>> {
        let mut changed = vec![self.all[0].stepper.go(to, more)?];
        let Some((first, rest)) = self.all.split_first_mut() else { return Ok(changed) };
        for lane in rest {
            let to = match lane.steps_as(first) {
                true => first.stepper.position(),
                false => lane.position_at(first.next_place()),
            };
            // It is as quick, or else it would fall behind.
            changed.push(lane.stepper.go(to, &mut || true)?);
        }
        Ok(changed)
    }
}

/// Opens a session for each lane, on one grid.
fn make(options: &Options, wanted: &[Wanted]) -> Result<Vec<Lane>> {
    if wanted.is_empty() || wanted.len() > 2 {
        return Err(Error::Usage(format!("one method or two side by side, not {}", wanted.len())));
    }
    let open = |wanted: &Wanted| Session::open(&options.path, &(options.ready)(wanted)?);
    let mut sessions = wanted.iter().map(open).collect::<Result<Vec<_>>>()?;
    let grid = sessions.iter().map(|s| s.grid).reduce(|a, b| a.union(&b));
    let (mut lanes, count) = (Vec::new(), sessions.len() as u64);
    for (mut session, wanted) in sessions.drain(..).zip(wanted) {
        session.grid = grid.unwrap_or(session.grid);
        let share = options.memory.map(|m| m / count);
        let stepper = Stepper::open(session, options.threads, share, SNAPSHOTS)?;
        lanes.push(Lane::new(stepper, wanted.clone()));
    }
    Ok(lanes)
}

/// What `api/go` takes.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Go {
    by: Option<String>,
    #[serde(default = "one")]
    count: i64,
    to: Option<usize>,
    budget_ms: Option<u64>,
    since: Option<u64>,
}

fn one() -> i64 {
    1
}

/// What `api/lanes` takes.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Remake {
    lanes: Vec<Wanted>,
}

/// Numbers that are not finite are null.
fn number(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { Value::Null }
}

/// The same of f32, with the digits that it has.
fn short(value: f32) -> Value {
    if value.is_finite() { json!(value) } else { Value::Null }
}
