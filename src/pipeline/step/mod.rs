//! Stepping through a log, forwards and backwards: the map after any of its inputs, and what the last input changed.
//!
//! A [`Stepper`] is a state machine over a log and a method: the cells depend on the log, the method and the position alone, not on the
//! steps taken. It applies inputs with the CPU's kernels, with all chunks resident; at the end of the log its cells are those that `map`
//! writes. An *item* is one input of the method ([`crate::method::Unit`]): a reading, a scan, or an update of the feature stage, which
//! knows all features of the log as in `map`.
//!
//! A step back restores a snapshot and applies the items after it. A method of several sweeps (`order=batch` of the certainty grid, the
//! order of 1985) is computed from nothing at each position, as `map --until` does.

mod apply;
mod cells;
mod explain;
mod go;
mod history;
mod inputs;
mod packed;
mod snapshots;
mod stepped_scans;

pub(crate) use cells::tile_at;
pub use cells::{Cell, Tiles, Touched, cell_of, tile_of};
pub use explain::{CellStory, Explained, explain};
pub use go::By;
pub use history::{Event, History};
pub use inputs::LogInputs;
pub use packed::{Packed, steps};

use crate::Result;
use crate::grid::GridSpec;
use crate::kernels::ChunkStates;
use crate::kernels::cpu::Cpu;
use crate::method::{self, Method};
use crate::pipeline::finished::FinishedMap;
use crate::pipeline::layers;
use crate::pipeline::memory;
use crate::pipeline::session::Session;
use crate::sensor::Sensor;
use snapshots::Snapshots;

/// A position in a log, and the map of the items before it.
pub struct Stepper {
    session: Session,
    items: LogInputs,
    /// The first item of each scan.
    starts: Vec<usize>,
    cpu: Cpu,
    /// The shares of the applied items ([`crate::kernels::Shares`]).
    shares: Vec<[u32; 4]>,
    snapshots: Snapshots,
    position: usize,
    /// The cells that the item before the position changed.
    touched: Vec<Touched>,
}

impl Stepper {
    /// Opens a stepper at the start of a session's log. All items are held in memory. `threads`: 0 for all of the processor's;
    /// `snapshots`: the most memory that snapshots take, bytes.
    ///
    /// # Errors
    /// The log's; [`crate::Error::Resources`] where the whole map needs more than `cap`, or than is free.
    pub fn open(session: Session, threads: usize, cap: Option<u64>, snapshots: u64) -> Result<Stepper> {
        let state = memory::resident(&session.grid, session.method.as_ref(), apply::WINDOW);
        session.check_memory(state + LogInputs::memory(&session) + snapshots, cap)?;
        let items = LogInputs::read(&session)?;
        let snapshots = Snapshots::new(items.len(), snapshots);
        let (starts, cpu) = (items.starts(), Cpu::new(threads)?);
        Ok(Stepper { session, items, starts, cpu, shares: Vec::new(), snapshots, position: 0, touched: Vec::new() })
    }

    /// The log and the method.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// The method.
    pub fn method(&self) -> &dyn Method {
        self.session.method.as_ref()
    }

    /// The grid.
    pub fn grid(&self) -> &GridSpec {
        &self.session.grid
    }

    /// The log's sensors, with the method's limits.
    pub fn sensors(&self) -> &[Sensor] {
        self.session.sensors()
    }

    /// The items of the log, in order.
    pub fn items(&self) -> &LogInputs {
        &self.items
    }

    /// The number of scans that begin before a position. Scans without a used reading don't count.
    pub fn scans(&self, position: usize) -> usize {
        self.starts.partition_point(|start| *start < position)
    }

    /// The number of items that are applied.
    pub fn position(&self) -> usize {
        self.position
    }

    /// The cells, as the kernels hold them.
    pub fn chunks(&self) -> &ChunkStates {
        self.cpu.chunks()
    }

    /// The cells that the item before the position changed, row by row in each tile, with their words before and after.
    pub fn touched(&self) -> &[Touched] {
        &self.touched
    }

    /// The words of a cell; `None`: no item has reached it.
    pub fn words(&self, column: usize, row: usize) -> Option<Vec<u32>> {
        cell_of(self.chunks(), method::planes(self.method()), column, row)
    }

    /// The map so far, as `map` would give it.
    pub fn finished(&self) -> FinishedMap {
        layers::from_chunks(self.grid(), self.method(), self.chunks())
    }
}
