//! A log, a method and a grid, checked before the long run; the readings to map, as often as a method sweeps over them.

mod parameters;

use crate::binning::scan::{Scan, Scans};
use crate::binning::snap::Edges;
use crate::binning::update;
use crate::binning::wedge;
use crate::feature::{self, StageResult, Update};
use crate::grid::{GridSpec, Palette};
use crate::kernels::Backend;
use crate::log::classes::Classes;
use crate::log::reading::{Counts, Reading, Record, classify};
use crate::log::{self, Log, Problem};
use crate::method::settings::{Bayes, Csm, Likelihood, Settings};
use crate::method::{self, Method};
use crate::oracle::{self, OracleMap};
use crate::pipeline::finished::Finished;
use crate::pipeline::layers;
use crate::pipeline::mapper::{self, Item, Mapper, Work};
use crate::pipeline::memory;
use crate::pipeline::out_of_core::Scanned;
use crate::pipeline::survey::{Look, Spread, Survey, survey};
use crate::pipeline::updates;
use crate::sensor::{Kind, Overrides, Sensor};
use crate::{Error, Result};
use std::collections::VecDeque;

/// What to map, and how.
#[derive(Debug, Clone)]
pub struct Request {
    /// How to read the log.
    pub log: log::Options,
    /// The method and its parameters.
    pub settings: Settings,
    /// Edge of a cell, metres.
    pub resolution: f64,
    /// x0, y0, x1, y1 in metres; `None`: around all that the readings reach.
    pub bounds: Option<[f64; 4]>,
    /// Only the first so many used readings.
    pub until: Option<u64>,
    /// A bad line is an error.
    pub strict: bool,
}

/// An open log, surveyed, with its grid.
pub struct Session {
    /// The log.
    pub log: Log,
    sensors: Vec<Sensor>,
    /// The method.
    pub method: Box<dyn Method>,
    /// The grid.
    pub grid: GridSpec,
    /// What a first pass over the log found.
    pub survey: Survey,
    /// The class labels, where the method tells them apart.
    pub classes: Option<Classes>,
    until: u64,
    bounded: bool,
}

/// A map and what came with it.
#[derive(Debug, Clone)]
pub struct Mapped {
    /// The map.
    pub finished: Finished,
    /// What became of the log's records.
    pub counts: Counts,
    /// What the batches came to.
    pub work: Work,
    /// What the stage found, for a method that takes updates.
    pub found: Option<StageResult>,
}

impl Session {
    /// Opens a log and looks through it once.
    ///
    /// # Errors
    /// The log's and the parameters' errors; [`Error::Input`] for a log without a usable reading, and for the first bad
    /// line where the request is strict.
    pub fn open(path: &std::path::Path, request: &Request) -> Result<Session> {
        let mut options = request.log.clone();
        if request.settings == Settings::Truth {
            if options.kind == Some(Kind::Sonar) {
                return Err(Error::Usage(
                    "method truth takes the nearest beam of each laser scan: leave out `sensor sonar`".into(),
                ));
            }
            options.kind = Some(Kind::Laser);
        }
        if let Settings::Features(_) = request.settings {
            if options.kind == Some(Kind::Laser) {
                return Err(Error::Usage(
                    "method features tells what a sonar's readings came from: leave out `sensor laser`".into(),
                ));
            }
            options.kind = Some(Kind::Sonar);
        }
        let log = Log::open(path, &options).map_err(|e| lasers_only(path, request, e))?;
        let mut sensors = log.header().sensors.clone();
        if request.settings == Settings::Truth {
            sensors.iter_mut().for_each(|s| limit(s, &options.overrides));
        }
        if let Settings::Features(_) = request.settings {
            update::check(&sensors, request.resolution)?;
        }
        // Given bounds are checked before the log is read through.
        let given = request.bounds.map(|b| GridSpec::from_bounds(b, request.resolution)).transpose()?;
        let until = request.until.unwrap_or(u64::MAX);
        let look = Look {
            resolution: request.resolution,
            until,
            r_max_set: options.overrides.r_max.is_some(),
            spread: spread(&request.settings),
        };
        let survey = survey(&log, &sensors, &look)?;
        if let (true, Some(first)) = (request.strict, survey.bad_lines.first.first()) {
            let more = match survey.bad_lines.count - 1 {
                0 => String::new(),
                more => format!(", the first of {} bad lines", more + 1),
            };
            return Err(Error::input(path, format!("{first}{more}; mend it, or leave out `strict`")));
        }
        if survey.counts.used == 0 {
            return Err(Error::input(path, nothing_to_map(&survey)));
        }
        let grid = match given {
            Some(grid) => grid,
            None => GridSpec::around(survey.covered, request.resolution).map_err(|e| survey.explain(e, path))?,
        };
        let (mut settings, mut classes) = (request.settings, None);
        if let Settings::Bayes(bayes) = &mut settings {
            bayes.model = Some(likelihood(bayes, &sensors));
        }
        if let Settings::Csm(csm) = &mut settings {
            classes = prepare(csm, request, &log, &survey)?;
            let far = [grid.x0(), grid.y0()].into_iter().find(|v| v.abs() > FARTHEST);
            if let Some(far) = far {
                let what = format!(
                    "`bounds` begin at {far} m: the counting sensor models map up to {FARTHEST:e} m from the origin"
                );
                return Err(Error::Usage(what));
            }
        }
        let method = method::make(settings);
        Ok(Session { log, sensors, method, grid, survey, classes, until, bounded: given.is_some() })
    }

    /// Whether the grid's bounds were given.
    pub fn bounded(&self) -> bool {
        self.bounded
    }

    /// The log's sensors, with the method's limits.
    pub fn sensors(&self) -> &[Sensor] {
        &self.sensors
    }

    /// What a user should know of how the log was read, in whole sentences.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = self.log.notes();
        notes.extend(self.survey.notes.iter().cloned());
        notes
    }

    /// What mapping takes at most, bytes, `batch` readings at a time.
    pub fn memory(&self, batch: usize) -> u64 {
        let batch = batch.min(usize::try_from(self.survey.counts.used).unwrap_or(usize::MAX));
        let stage = match self.method.settings() {
            // Missing echoes are held, too.
            Settings::Features(_) => feature::memory(self.survey.counts.read),
            _ => 0,
        };
        memory::needed(&self.grid, self.method.as_ref(), batch) + stage
    }

    /// Fails where a run needs more than the cap, or than the machine has; names the pose that made the grid so large.
    pub fn check_memory(&self, needed: u64, cap: Option<u64>) -> Result<()> {
        let checked = self.grid.check_memory(needed, cap, "give smaller `bounds` or a coarser `resolution`");
        checked.map_err(|e| self.explain(e))
    }

    /// An error about a grid that is too large, with the pose that made it so, if it follows the poses.
    pub fn explain(&self, error: Error) -> Error {
        if self.bounded { error } else { self.survey.explain(error, self.log.path()) }
    }

    /// The scans to map, in log order, for a method that takes them.
    pub fn scans(&self) -> Result<impl Iterator<Item = Result<Scan>> + '_> {
        self.scans_first(u64::MAX)
    }

    /// The same up to the `count`-th used reading.
    fn scans_first(&self, count: u64) -> Result<impl Iterator<Item = Result<Scan>> + '_> {
        let labels = self.classes.as_ref().map_or(0, Classes::count);
        Ok(Scans::new(self.records()?, self.sensors(), labels, self.until.min(count), self.log.path()))
    }

    /// The updates of the first `count` used readings, in order, and what was found, for a method that takes them: all at once.
    ///
    /// # Errors
    /// The log's.
    pub fn updates(&self, count: usize) -> Result<(Vec<Update>, StageResult)> {
        self.associate(count, |updates| updates.collect::<Result<Vec<_>>>())
    }

    /// Associates the first `count` used readings with features while `apply` takes the updates that come of it.
    fn associate<T>(
        &self,
        count: usize,
        apply: impl FnOnce(&mut dyn Iterator<Item = Result<Update>>) -> Result<T>,
    ) -> Result<(T, StageResult)> {
        let Settings::Features(features) = self.method.settings() else {
            return Err(Error::Usage(format!("{} takes no features", method::name(self.method.as_ref()))));
        };
        let most = self.until.min(count as u64);
        feature::run(|| self.records(), self.sensors(), (features.rules, self.grid.resolution, most), apply)
    }

    /// The log's records, in order, bad lines left out.
    fn records(&self) -> Result<impl Iterator<Item = Result<Record>> + '_> {
        Ok(self.log.records()?.filter_map(|record| match record {
            Ok(record) => Some(Ok(record)),
            Err(Problem::Fatal(e)) => Some(Err(e)),
            Err(Problem::Line(_)) => None,
        }))
    }

    /// The readings to map, in log order, bad lines and unused records left out.
    pub fn items(&self) -> Result<impl Iterator<Item = Result<Item>> + '_> {
        Ok(Items {
            records: self.log.records()?,
            sensors: self.sensors(),
            wedges: self.method.settings() == Settings::Truth,
            scan: Vec::new(),
            ready: VecDeque::new(),
        }
        .take(usize::try_from(self.until).unwrap_or(usize::MAX)))
    }

    /// Every reading at once, and their wedges: what the oracle takes.
    pub fn all(&self) -> Result<(Vec<Reading>, Option<Vec<Edges>>)> {
        let items: Vec<Item> = self.items()?.collect::<Result<_>>()?;
        let readings = items.iter().map(|i| i.0).collect();
        Ok((readings, items.iter().map(|i| i.1).collect()))
    }

    /// Maps the log on a backend, `batch` readings at a time; `progress` hears of each reading.
    pub fn map(&self, backend: &mut dyn Backend, batch: usize, progress: &dyn Fn(u64)) -> Result<Mapped> {
        self.map_first(usize::MAX, backend, batch, progress)
    }

    /// Maps its first `count` used readings.
    pub fn map_first(
        &self,
        count: usize,
        backend: &mut dyn Backend,
        batch: usize,
        progress: &dyn Fn(u64),
    ) -> Result<Mapped> {
        if let Settings::Csm(csm) = self.method.settings() {
            let here = (std::env::temp_dir(), u64::MAX);
            let scans = self.scans_first(count as u64)?;
            let scanned =
                Scanned::read(&self.grid, csm.selection(self.grid.resolution), scans, (&here.0, here.1), &|_| {})?;
            let work = scanned.apply(self.method.as_ref(), backend, batch, progress)?;
            let finished = mapper::finish(&self.grid, self.method.as_ref(), backend, false)?;
            return Ok(Mapped { finished, counts: self.survey.counts, work, found: None });
        }
        if let Settings::Features(_) = self.method.settings() {
            let (grid, sensors, method) = (&self.grid, self.sensors(), self.method.as_ref());
            let apply = |updates: &mut dyn Iterator<Item = Result<Update>>| {
                updates::apply(grid, sensors, method, backend, batch.min(feature::WINDOW), updates, progress)
            };
            let ((reached, work), found) = self.associate(count, apply)?;
            let finished = mapper::finish(grid, method, backend, false)?;
            let Counts { outside, empty_arc, wide, .. } = reached;
            let counts = Counts { outside, empty_arc, wide, ..self.survey.counts };
            return Ok(Mapped { finished, counts, work, found: Some(found) });
        }
        let mut mapper = Mapper::new(self.grid, self.sensors(), self.method.as_ref(), backend, batch)?;
        for sweep in 0..self.method.sweeps().len() {
            mapper.sweep(sweep, self.items()?.take(count).inspect(|_| progress(1)))?;
        }
        let (reached, work) = (mapper.counts, mapper.work);
        let finished = mapper.finish()?;
        let Counts { outside, empty_arc, wide, .. } = reached;
        let counts = Counts { outside, empty_arc, wide, ..self.survey.counts };
        Ok(Mapped { finished, counts, work, found: None })
    }

    /// Maps the log by the f64 oracle, one reading, scan, or update, at a time.
    pub fn oracle(&self) -> Result<OracleMap> {
        if let Settings::Csm(csm) = self.method.settings() {
            let scans: Vec<Scan> = self.scans()?.collect::<Result<_>>()?;
            return Ok(oracle::map_scans(&self.grid, &scans, &csm));
        }
        if let Settings::Features(_) = self.method.settings() {
            return Ok(self.oracle_of_updates()?.0);
        }
        let (readings, wedges) = self.all()?;
        oracle::map(&self.grid, self.sensors(), &readings, &self.method.settings(), wedges.as_deref())
    }

    /// The oracle's map of a method that takes updates, and what was found.
    fn oracle_of_updates(&self) -> Result<(OracleMap, StageResult)> {
        let map = |updates: &mut dyn Iterator<Item = Result<Update>>| {
            oracle::map_updates(&self.grid, self.sensors(), updates, &self.method.settings())
        };
        self.associate(usize::MAX, map)
    }

    /// The oracle's map as every other backend gives it.
    pub fn oracle_map(&self) -> Result<Mapped> {
        let (map, found) = match self.method.settings() {
            Settings::Features(_) => self.oracle_of_updates().map(|(map, found)| (map, Some(found)))?,
            _ => (self.oracle()?, None),
        };
        let counts = Counts { outside: map.outside, empty_arc: map.empty_arc, wide: map.wide, ..self.survey.counts };
        Ok(Mapped { finished: layers::from_oracle(&map, self.method.as_ref()), counts, work: Work::default(), found })
    }
}

/// The error of a log that has no sonar for method features, which nobody asked to leave its lasers out.
fn lasers_only(path: &std::path::Path, request: &Request, error: Error) -> Error {
    let laser = log::Options { kind: Some(Kind::Laser), ..request.log.clone() };
    let sonar_wanted = matches!(request.settings, Settings::Features(_)) && request.log.kind.is_none();
    match sonar_wanted && Log::open(path, &laser).is_ok() {
        true => Error::input(
            path,
            "it holds laser readings alone, and method features finds walls in a sonar's: map it with `method bayes`",
        ),
        false => error,
    }
}

/// How far around a beam a method updates cells.
fn spread(settings: &Settings) -> Spread {
    match settings {
        Settings::Csm(csm) if csm.continuous => Spread { beside: csm.l, half_width: 0.0 },
        Settings::Csm(csm) => Spread { beside: csm.w_obstacle.unwrap_or(0.0) / 2.0, half_width: csm.w_beam / 2.0 },
        _ => Spread::default(),
    }
}

/// The likelihoods that fit the sensors, unless the user chose: a sonar's profile thins out towards its range and its edge, which would
/// cost a laser a part of its walls.
fn likelihood(bayes: &Bayes, sensors: &[Sensor]) -> Likelihood {
    let lasers = sensors.iter().all(|s| s.kind == Kind::Laser);
    bayes.model.unwrap_or(if lasers { Likelihood::Constant } else { Likelihood::Murphy })
}

/// Gives a counting sensor model what it needs of the log: its class labels, the size of its cells.
fn prepare(csm: &mut Csm, request: &Request, log: &Log, survey: &Survey) -> Result<Option<Classes>> {
    let (path, resolution) = (log.path(), request.resolution);
    if resolution > LARGEST_CELL {
        let what = format!("the counting sensor models take cells of at most {LARGEST_CELL} m, not {resolution} m");
        return Err(Error::Usage(what));
    }
    if !csm.continuous && csm.w_obstacle.is_none() {
        csm.w_obstacle = Some(2.0 * resolution);
    }
    if !csm.semantic {
        return Ok(None);
    }
    let names = &log.header().classes;
    let classes = match &request.log.classes {
        Some(file) => Some(Classes::open(file)?),
        None => Classes::named(names)
            .map(|named| Classes::rooms().ok().filter(|r| r.names[..r.count()] == **names).unwrap_or(named)),
    };
    let plain = "map it with csm-discrete or csm-continuous, which need none";
    match (classes, survey.labelled) {
        (_, 0) => Err(Error::input(path, format!("none of its {} hits carries a class label: {plain}", survey.hits))),
        (None, n) if names.is_empty() => Err(Error::input(
            path,
            format!(
                "{n} hits carry class labels, but nothing says what they are: name the classes with `classes`, or {plain}"
            ),
        )),
        (None, _) => Err(Error::input(path, format!("{} classes, more than {}: {plain}", names.len(), Palette::MOST))),
        (Some(classes), _) => {
            csm.palette = classes.palette;
            Ok(Some(classes))
        }
    }
}

/// A grid's lower left corner, metres from the origin, at most.
const FARTHEST: f64 = 2e6;

/// Edge of a cell, metres, at most: a chunk's µm must fit 32 bits.
const LARGEST_CELL: f64 = 2.0;

/// The laser truth trusts 5 cm to 20 m, and no more than the sensor does; what the user sets stays.
fn limit(sensor: &mut Sensor, set: &Overrides) {
    if set.r_min.is_none() {
        sensor.r_min = sensor.r_min.max(0.05);
    }
    if set.r_max.is_none() {
        sensor.r_max = sensor.r_max.min(20.0);
    }
    if set.hit_range.is_none() {
        sensor.hit_range = sensor.hit_range.min(sensor.r_max);
    }
}

/// What to say of a log none of whose readings can be mapped.
fn nothing_to_map(survey: &Survey) -> String {
    let Survey { counts, bad_lines: bad, ignored, .. } = survey;
    let r = counts.rejected;
    let reasons = [
        (counts.no_echo, "without echo (no_echo_range is 0)"),
        (r.below_r_min, "nearer than r_min"),
        (r.beyond_hit_range, "beyond hit_range"),
        (r.negative, "negative"),
        (r.not_a_number, "not a number"),
    ];
    let reasons: Vec<String> = reasons.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
    let mut text = match counts.read {
        0 if *ignored > 0 => format!("holds no reading, but {ignored} lines (or scans) without one"),
        0 => "holds no reading".into(),
        read => format!(
            "none of its {read} readings can be mapped: {}; check `sensor` and the sensors' ranges (`r_min=…`, \
             hit_range=…, no_echo_range=…)",
            reasons.join(", ")
        ),
    };
    for note in &survey.notes {
        text += &format!("; {note}");
    }
    if let Some(first) = bad.first.first() {
        text += &format!("; {} bad lines, the first: {first}", bad.count);
    }
    text
}

/// Records judged, and where they are wanted given their wedges, a scan at a time.
struct Items<'a> {
    records: log::Records,
    sensors: &'a [Sensor],
    wedges: bool,
    scan: Vec<Record>,
    ready: VecDeque<Item>,
}

impl Items<'_> {
    /// Readies the scan that is complete.
    fn release(&mut self) {
        let edges = wedge::edges(&self.scan, self.sensors);
        for (record, edges) in self.scan.drain(..).zip(edges) {
            if let Ok(reading) = classify(record, &self.sensors[record.sensor as usize]) {
                self.ready.push_back((reading, Some(edges)));
            }
        }
    }
}

impl Iterator for Items<'_> {
    type Item = Result<Item>;

    fn next(&mut self) -> Option<Result<Item>> {
        loop {
            if let Some(item) = self.ready.pop_front() {
                return Some(Ok(item));
            }
            match self.records.next() {
                None if self.scan.is_empty() => return None,
                None => self.release(),
                Some(Err(Problem::Fatal(e))) => return Some(Err(e)),
                Some(Err(Problem::Line(_))) => {}
                Some(Ok(record)) if self.wedges => {
                    if self.scan.last().is_some_and(|last| last.scan != record.scan) {
                        self.release();
                    }
                    self.scan.push(record);
                }
                Some(Ok(record)) => {
                    if let Ok(reading) = classify(record, &self.sensors[record.sensor as usize]) {
                        return Some(Ok((reading, None)));
                    }
                }
            }
        }
    }
}
