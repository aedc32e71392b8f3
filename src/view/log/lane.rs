//! A lane: one method with its parameters, stepping through the log.

use crate::kernels::ChunkStates;
use crate::method::{self, Unit};
use crate::pipeline::step::{LogInputs, Stepper, Tiles, tile_at};
use crate::view::protocol::LaneSpec;

/// One method with its parameters, stepping through the log.
pub struct Lane {
    /// Its position and its map.
    pub stepper: Stepper,
    /// What the user requested.
    pub spec: LaneSpec,
    /// The cells that the page computed on the browser's GPU.
    pub webgpu: Option<ChunkStates>,
    /// Tiles that changed since the last state that the page got.
    pub changed: Tiles,
    /// Tiles that changed since the page last sent its cells; all tiles where it never did.
    pub unsent: Tiles,
}

/// The place in the log of the next item: scan and line; `None` at the log's end.
pub type NextPlace = Option<(u64, u64)>;

impl Lane {
    /// A lane at the log's beginning.
    pub fn new(stepper: Stepper, spec: LaneSpec) -> Lane {
        Lane { stepper, spec, webgpu: None, changed: Tiles::new(), unsent: Tiles::new() }
    }

    /// Records the tiles that changed.
    pub fn record_changes(&mut self, tiles: Tiles) {
        self.unsent.extend(&tiles);
        self.changed = tiles;
    }

    /// Discards the cells that the page computed.
    pub fn reset_webgpu(&mut self) {
        self.webgpu = None;
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

    /// The names of the method's layers.
    pub fn layer_names(&self) -> Vec<&'static str> {
        self.stepper.method().layers().iter().map(|l| l.name).collect()
    }

    /// The place in the log where its next item begins.
    pub fn next_place(&self) -> NextPlace {
        let (items, at) = (self.stepper.items(), self.stepper.position());
        match items {
            LogInputs::Scans(scans) => scans.all.get(at).and_then(|s| s.rays.first()).map(|r| (0, r.source.1)),
            _ => items.place(at),
        }
    }

    /// The position before the first item at a place of the log or after it. Lines decide: some scans are known to one lane only.
    pub fn position_at(&self, next: NextPlace) -> usize {
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

    /// Whether its items correspond to another lane's one by one.
    pub fn has_items_of(&self, other: &Lane) -> bool {
        let alike = |lane: &Lane| (lane.stepper.method().unit(), lane.stepper.items().len());
        alike(self) == alike(other) && self.stepper.method().unit() == Unit::Reading
    }
}
