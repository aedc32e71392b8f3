//! Stepping through a log: the map after any of its readings, what the last one did, and back again.
//!
//! A [`Stepper`] is a pure state machine over a log and a method: the same log, method and position give the same cells, by whichever
//! steps it got there. It applies readings with the kernels of `map`, on the CPU, all chunks resident; what it ends with are the bytes
//! that `map` writes. What it steps over is what the method takes one at a time ([`crate::method::Unit`]): a reading, a whole scan for a counting sensor
//! model, for the feature-based grid an update, with all features of the log known as in `map`.
//!
//! Going back restores a snapshot and applies the readings from there. In the 1985 order of the certainty grid (`order=batch`) every reading
//! changes what the others say: there the state is made anew for each position, that of `map --until`.

mod apply;
mod cells;
mod go;
mod history;
mod items;
mod packed;
mod scans;
mod snapshots;
mod working;

pub(crate) use cells::tile_at;
pub use cells::{Cell, Tiles, Touched, cell_of, tile_of};
pub use go::By;
pub use history::{Event, History};
pub use items::Items;
pub use packed::{Packed, steps};
pub use working::{CellStory, Explained, explain};

use crate::Result;
use crate::grid::GridSpec;
use crate::kernels::ChunkStates;
use crate::kernels::cpu::Cpu;
use crate::method::{self, Method};
use crate::pipeline::finished::Finished;
use crate::pipeline::layers;
use crate::pipeline::memory;
use crate::pipeline::session::Session;
use crate::sensor::Sensor;
use snapshots::Snapshots;

/// A place in a log, and the map of what lies before it.
pub struct Stepper {
    session: Session,
    items: Items,
    /// Where scans begin.
    starts: Vec<usize>,
    cpu: Cpu,
    /// What each item's steps found for it so far ([`crate::kernels::Shares`]), from the first on.
    shares: Vec<[u32; 4]>,
    snapshots: Snapshots,
    position: usize,
    /// What the item before the position did.
    touched: Vec<Touched>,
}

impl Stepper {
    /// At the start of a session's log, whose readings are held in memory; `threads`: 0 for all. Snapshots take `snapshots` bytes at most.
    ///
    /// # Errors
    /// The log's; [`crate::Error::Resources`] where `cap`, or what the machine has free, doesn't suffice for the whole map.
    pub fn open(session: Session, threads: usize, cap: Option<u64>, snapshots: u64) -> Result<Stepper> {
        let state = memory::needed(&session.grid, session.method.as_ref(), apply::WINDOW);
        session.check_memory(state + Items::memory(&session) + snapshots, cap)?;
        let items = Items::read(&session)?;
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

    /// What it steps over, in log order.
    pub fn items(&self) -> &Items {
        &self.items
    }

    /// How many scans have begun before a position; those of which no reading is used don't count.
    pub fn scans(&self, position: usize) -> usize {
        self.starts.partition_point(|start| *start < position)
    }

    /// How many items were applied.
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

    /// A cell's words; `None`: nothing has reached it.
    pub fn words(&self, column: usize, row: usize) -> Option<Vec<u32>> {
        cell_of(self.chunks(), method::planes(self.method()), column, row)
    }

    /// The map so far, as `map` would give it.
    pub fn finished(&self) -> Finished {
        layers::from_chunks(self.grid(), self.method(), self.chunks())
    }
}
