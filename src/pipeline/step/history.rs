//! The history of a cell: the items that touched it, and how each changed it.
//!
//! The state of a cell depends on the readings that touch it and on the share of each, which the stepper keeps. So the kernel is run again
//! over the cell's own tile, one reading at a time.

use super::apply::{binning, cone, snap_update};
use super::cells::words_at;
use super::explain::update_probability;
use super::{Cell, LogInputs, Stepper};
use crate::binning::batch::Batch;
use crate::binning::snap::region;
use crate::binning::update::Bins;
use crate::geometry::layout::{COUNT, Frame, TILE, TILE_CELLS};
use crate::grid::{ChunkId, EDGE};
use crate::method::driver::{Job, TileTask};
use crate::method::{self, Pass, Step};
use crate::oracle;
use crate::pipeline::batching::frame;
use crate::pipeline::readings::ReadingInput;
use crate::{Error, Result};
use rayon::prelude::*;

/// The effect of an item on the cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// The number of the item, from 0.
    pub item: usize,
    /// Whether the cell is on the item's arc; else it is in the interior.
    pub arc: bool,
    /// The cell before the item; `None` for a scan, as scans have no order.
    pub before: Option<Cell>,
    /// The cell after the item; `None` for a scan.
    pub after: Option<Cell>,
    /// The item's own evidence of the cell ([`oracle::CellTrace::own`]); for an update its P(occupied); `None` for a scan.
    pub own: Option<f64>,
    /// For a scan the beam that the cell takes, and what each α gained.
    pub given: Option<oracle::BeamContribution>,
}

/// A cell's history up to the position.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct History {
    /// The number of items that touched the cell.
    pub total: usize,
    /// The last of them, latest first.
    pub events: Vec<Event>,
}

impl Stepper {
    /// The history of a cell: the last `count` items that touched it.
    ///
    /// # Errors
    /// The kernels'.
    pub fn history(&self, column: usize, row: usize, count: usize) -> Result<History> {
        let mut events = match self.items() {
            LogInputs::Scans(scans) => {
                let all = &scans.all[..self.position()];
                let given = oracle::beam_contributions(self.grid(), all, &scans.csm, (column, row));
                let event = |given: oracle::BeamContribution| Event {
                    item: given.beam.0,
                    arc: given.counted[1],
                    before: None,
                    after: None,
                    own: None,
                    given: Some(given),
                };
                given.into_iter().map(event).collect()
            }
            LogInputs::Updates(..) => self.of_updates(column, row)?,
            LogInputs::Readings(all) | LogInputs::SweptReadings(all) => {
                self.of_readings(&all[..self.position()], column, row)?
            }
        };
        let total = events.len();
        events.reverse();
        events.truncate(count);
        for event in &mut events {
            event.own = self.own(event, column, row)?;
        }
        Ok(History { total, events })
    }

    /// An item's own evidence of the cell.
    fn own(&self, event: &Event, column: usize, row: usize) -> Result<Option<f64>> {
        if let (LogInputs::Updates(..), Some(before), Some(after)) = (self.items(), &event.before, &event.after) {
            return Ok(Some(update_probability(self, before, after)));
        }
        // A scan has no reading of its own; its evidence is in `given`.
        let Some((reading, wedge)) = self.items().reading(event.item) else { return Ok(None) };
        let settings = self.method().settings();
        let setup = oracle::Setup { grid: self.grid(), sensors: self.sensors(), settings: &settings };
        let trace = oracle::trace_alone(&setup, &reading, wedge, &|_| 0.0)?;
        let cell = trace.cells.iter().find(|c| (c.update.column, c.update.row) == (column, row));
        Ok(cell.map(|c| c.own))
    }

    fn of_readings(&self, items: &[ReadingInput], column: usize, row: usize) -> Result<Vec<Event>> {
        let (session, footprint) = (self.session(), self.method().footprint());
        let touches = |(k, item): (usize, &ReadingInput)| {
            let cone = cone(session, item)?;
            let (interior, arc) = region(&cone, footprint, column as i64, row as i64);
            (interior || arc).then_some((k, arc, cone))
        };
        let touching: Vec<_> = items.par_iter().enumerate().filter_map(touches).collect();
        // Without rounds chunk by chunk a cell depends on its neighbours: its own tile is not enough.
        if self.method().rounds().is_none() {
            return self.replayed(touching.into_iter().map(|t| t.0), column, row);
        }
        let mut run = TileReplay::new(self, column, row);
        // In two sweeps interiors come first, then arcs.
        let sweeps = self.method().sweeps();
        for (sweep, steps) in sweeps.iter().enumerate() {
            let mut binning = binning(session, steps);
            binning.only = Some(ChunkId { row: (row / EDGE) as u32, column: (column / EDGE) as u32 });
            for (k, _, cone) in touching.iter().filter(|t| sweeps.len() == 1 || t.1 == (sweep > 0)) {
                let share = self.shares.get(*k).copied().unwrap_or_default();
                run.apply(*k, &binning.bin(vec![*cone]), steps, share)?;
            }
        }
        Ok(run.events)
    }

    fn of_updates(&self, column: usize, row: usize) -> Result<Vec<Event>> {
        let grid = self.grid();
        let (x, y) = grid.centre(column, row);
        let mut run = TileReplay::new(self, column, row);
        let bins = Bins { size: [grid.width, grid.height] };
        for k in 0..self.position() {
            let Some(update) = self.items().update(k) else {
                return Err(Error::Usage(format!("item {k} is no update")));
            };
            let pose = update.reading.record.pose;
            // No update reaches farther than 512 cells.
            if (pose.x - x).hypot(pose.y - y) > 514.0 * grid.resolution {
                continue;
            }
            let Some(snapped) = snap_update(self.session(), update)? else { continue };
            run.apply(k, &bins.bin(&[snapped]).batch, self.method().sweeps()[0], [0; 4])?;
        }
        Ok(run.events)
    }

    /// Replays the whole log, for a method whose cells depend on their neighbours.
    fn replayed(&self, touching: impl Iterator<Item = usize>, column: usize, row: usize) -> Result<Vec<Event>> {
        let mut again = crate::kernels::cpu::Cpu::new(0)?;
        let planes = method::planes(self.method());
        let (mut at, mut events) = (0, Vec::new());
        for k in touching {
            let mut words = Vec::new();
            for to in [k, k + 1] {
                super::apply::items(self.session(), self.items(), at..to, &mut again, &mut Default::default())?;
                at = to;
                let found = super::cell_of(again.chunks(), planes, column, row);
                words.push(found.unwrap_or_else(|| vec![0; planes]));
            }
            events.extend(event(self, k, &words[0], &words[1]));
        }
        Ok(events)
    }
}

/// The effect of an item on a cell with these words before and after; `None`: they are equal.
fn event(stepper: &Stepper, item: usize, before: &[u32], after: &[u32]) -> Option<Event> {
    let cell = |words| Some(Cell::of(stepper.method(), Some(words)));
    let arc = before[1] != after[1];
    (before != after).then(|| Event { item, arc, before: cell(before), after: cell(after), own: None, given: None })
}

/// A replay of the kernel over one tile.
struct TileReplay<'a> {
    stepper: &'a Stepper,
    frame: Frame,
    /// The tile's lower left cell.
    corner: [u32; 2],
    /// The index of the cell in the tile.
    at: usize,
    state: Vec<u32>,
    /// The effects on the cell so far.
    events: Vec<Event>,
}

impl TileReplay<'_> {
    fn new(stepper: &Stepper, column: usize, row: usize) -> TileReplay<'_> {
        TileReplay {
            stepper,
            frame: frame(stepper.grid(), stepper.method()),
            corner: [column, row].map(|v| (v / TILE * TILE) as u32),
            at: row % TILE * TILE + column % TILE,
            state: vec![0; method::planes(stepper.method()) * TILE_CELLS],
            events: Vec::new(),
        }
    }

    /// Applies a batch of one item to the tile, and notes its effect on the cell.
    fn apply(&mut self, item: usize, batch: &Batch, steps: &[Step], share: [u32; 4]) -> Result<()> {
        let lists = batch.chunks.iter().flat_map(|list| list.tiles.iter().map(move |tile| (list, tile)));
        // An item whose box reaches the tile may still have no cell there.
        let Some((list, tile)) = lists.into_iter().find(|(_, tile)| tile.corner == self.corner) else { return Ok(()) };
        let entries = &list.entries[tile.entries[0] as usize..tile.entries[1] as usize];
        let planes = method::planes(self.stepper.method());
        let before = words_at(&self.state, planes, self.at);
        for step in steps {
            // The other steps only prepare shares, which are known.
            let Step::Pass(Pass::Fuse, mode) = *step else { continue };
            let frame = Frame { mode: mode | COUNT, ..self.frame };
            let shares = &[share];
            let job = Job::new(TileTask { frame: &frame, tile, entries }, &batch.input, &[], shares);
            self.stepper.method().run(Pass::Fuse, &job, &mut self.state)?;
        }
        self.events.extend(event(self.stepper, item, &before, &words_at(&self.state, planes, self.at)));
        Ok(())
    }
}
