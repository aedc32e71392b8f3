//! A lane: a method stepping through the log.

use crate::kernels::Chunks;
use crate::method::{self, Unit};
use crate::pipeline::step::{Items, Stepper, Tiles, tile_at};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A method, and the parameters that are set of it and of the sensors.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wanted {
    /// The method's name.
    pub method: String,
    /// Keys and values, as in `--set`.
    #[serde(default)]
    pub set: BTreeMap<String, String>,
}

/// A method stepping through the log.
pub struct Lane {
    /// Where it is, and its map.
    pub stepper: Stepper,
    /// What was asked for.
    pub wanted: Wanted,
    /// The cells that a page computed on its own GPU.
    pub page: Option<Chunks>,
    /// Tiles that changed since the page was last told.
    pub changed: Tiles,
    /// Tiles that changed since the page last sent its own cells; all that there are where it never did.
    pub unsent: Tiles,
}

/// The place in a log of what comes next: scan and line; `None`: nothing does.
pub type Next = Option<(u64, u64)>;

impl Lane {
    /// At the start.
    pub fn new(stepper: Stepper, wanted: Wanted) -> Lane {
        Lane { stepper, wanted, page: None, changed: Tiles::new(), unsent: Tiles::new() }
    }

    /// Notes what changed.
    pub fn note(&mut self, tiles: Tiles) {
        self.unsent.extend(&tiles);
        self.changed = tiles;
    }

    /// Forgets what a page computed.
    pub fn reset(&mut self) {
        self.page = None;
        let words = method::tile_words(self.stepper.method());
        for (place, state) in self.stepper.chunks() {
            let tiles = (0u32..).zip(state.chunks_exact(words)).filter(|(_, tile)| tile.iter().any(|w| *w != 0));
            self.unsent.extend(tiles.map(|(slot, _)| tile_at(*place, slot)));
        }
    }

    /// The method's name.
    pub fn name(&self) -> &'static str {
        method::name(self.stepper.method())
    }

    /// Where in the log its next item begins.
    pub fn next_place(&self) -> Next {
        let (items, at) = (self.stepper.items(), self.stepper.position());
        match items {
            Items::Scans(scans) => scans.all.get(at).and_then(|s| s.rays.first()).map(|r| (0, r.source.1)),
            _ => items.place(at),
        }
    }

    /// The position before what stands at a place of the log or after it. Lines count: some scans are known to one lane only.
    pub fn position_at(&self, next: Next) -> usize {
        let Some((_, line)) = next else { return self.stepper.items().len() };
        let items = self.stepper.items();
        // Lines ascend.
        let (mut low, mut high) = (0, items.len());
        while low < high {
            let middle = (low + high) / 2;
            match items.place(middle).is_some_and(|p| p.1 < line) {
                true => low = middle + 1,
                false => high = middle,
            }
        }
        low
    }

    /// Whether its items are those of another lane, one by one.
    pub fn steps_as(&self, other: &Lane) -> bool {
        let alike = |lane: &Lane| (lane.stepper.method().unit(), lane.stepper.items().len());
        alike(self) == alike(other) && self.stepper.method().unit() == Unit::Reading
    }
}
