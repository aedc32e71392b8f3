//! Writes a map chunk by chunk: whatever its size, a few chunks in memory. A finished chunk is written to every file and
//! then noted, so that a run that was killed goes on after the last one that was noted.

use super::names::{
    self, CANVAS, FEATURES, FEATURES_PICTURE, FOUND, LAYER_ARRAY, LAYER_PICTURE, OVERVIEW_CANVAS, PICTURE, PROGRESS,
    REPORT, RUN, STORE,
};
use super::raster::{Block, Raster};
use super::report::{self, Tally};
use super::{Report, RunInfo, figure, npy, png, ros, unwritable, zarr};
use crate::grid::{Data, GridSpec, Layer, Map};
use crate::grid::{EDGE, Place, part, places};
use crate::pipeline::out_of_core::{Chunk, ChunkSink};
use crate::{Error, Result};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The overview's coarsest level has no side longer than this.
const COARSEST: usize = 256;

/// What is to be written.
#[derive(Debug, Clone)]
pub struct Outline {
    /// The cells.
    pub grid: GridSpec,
    /// The method's name.
    pub method: String,
    /// The layers, without values.
    pub heads: Vec<Layer>,
    /// The combined layer, without values.
    pub combined: Layer,
    /// Whether each layer is written as `.npy` too.
    pub npy: bool,
}

/// A map being written into a folder.
pub struct MapWriter {
    place: PathBuf,
    outline: Outline,
    store: zarr::Store,
    pgm: Raster,
    arrays: Vec<Raster>,
    /// The combined layer's palette entries, reduced by 1, 2, 4, …: what is kept of each level.
    levels: Vec<Option<Raster>>,
    /// Which level is `map.png`.
    shown: usize,
    /// The layers' pictures under way.
    canvases: Vec<Raster>,
    done: BTreeMap<Place, Tally>,
    progress: File,
}

impl ChunkSink for MapWriter {
    fn done(&self) -> BTreeSet<Place> {
        self.done.keys().copied().collect()
    }

    fn write(&mut self, chunk: &Chunk) -> Result<()> {
        self.chunk(chunk.place, &chunk.finished.map, &chunk.finished.combined)
    }
}

impl MapWriter {
    /// Opens the files in `place`. With `resume` it goes on with what an earlier run of the same log, method and parameters
    /// left there; if there is none, it begins.
    ///
    /// # Errors
    /// [`Error::Resources`] if something can't be written; [`Error::Usage`] where the earlier run was another one.
    pub fn open(place: &Path, outline: Outline, info: &RunInfo, resume: bool) -> Result<MapWriter> {
        let mut identity = zarr::attributes(&outline.grid, &outline.method, &outline.heads, info);
        identity.insert("npy".into(), outline.npy.into());
        let run = RUN.at(place);
        let before = std::fs::read(&run).ok().and_then(|text| serde_json::from_slice::<Value>(&text).ok());
        let resume = resume && before.is_some();
        if let (true, Some(before)) = (resume, before) {
            same_run(place, &before, &Value::Object(identity.clone()))?;
        }
        let progress = PROGRESS.at(place);
        if !resume {
            // Before all other files: it says of which layers they are.
            File::create(&progress).map_err(|e| unwritable(&progress, e))?;
            std::fs::write(&run, Value::Object(identity).to_string()).map_err(|e| unwritable(&run, e))?;
        }
        let GridSpec { width, height, .. } = outline.grid;
        let coarser = |k: usize| width.max(height) >> k > COARSEST && 1 << k < EDGE;
        let levels = 1 + (0..).take_while(|k| coarser(*k)).count();
        let shown = png::factor(&outline.grid).trailing_zeros() as usize;
        let level = |k: usize| {
            // The finest level goes straight to the store, if it isn't the picture.
            if k == 0 && shown != 0 {
                return Ok(None);
            }
            canvas(place, &OVERVIEW_CANVAS.of(k), &outline.grid, 1 << k, resume).map(Some)
        };
        let canvases = outline.heads.iter().filter(|h| h.name != "map");
        let canvases = canvases.map(|h| canvas(place, &CANVAS.of(&h.name), &outline.grid, 1 << shown, resume));
        let array = |h: &Layer| npy::open(&place.join(LAYER_ARRAY.of(&h.name)), &outline.grid, &h.data, resume);
        let arrays = if outline.npy { &outline.heads[..] } else { &[] };
        let mut writer = MapWriter {
            store: zarr::Store::open(&place.join(STORE), &outline.grid, &outline.heads, &outline.combined, levels)?,
            pgm: ros::open(place, &outline.grid, resume)?,
            arrays: arrays.iter().map(array).collect::<Result<_>>()?,
            levels: (0..levels).map(level).collect::<Result<_>>()?,
            canvases: canvases.collect::<Result<_>>()?,
            done: BTreeMap::new(),
            progress: File::options()
                .read(true)
                .append(true)
                .create(true)
                .open(&progress)
                .map_err(|e| unwritable(&progress, e))?,
            place: place.into(),
            shown,
            outline,
        };
        if resume {
            writer.recall(&progress)?;
        }
        Ok(writer)
    }

    /// Reads which chunks are done. The last line may be torn.
    fn recall(&mut self, path: &Path) -> Result<()> {
        let text = std::fs::read_to_string(path).map_err(|e| unwritable(path, e))?;
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        self.progress.set_len(whole as u64).map_err(|e| unwritable(path, e))?;
        let lines = text[..whole].lines().map(serde_json::from_str::<(Place, Tally)>);
        self.done = lines.collect::<serde_json::Result<_>>().map_err(|e| unwritable(path, e))?;
        Ok(())
    }

    /// Writes a chunk's part of the map to every file, and notes it.
    pub fn chunk(&mut self, at: Place, map: &Map, combined: &Layer) -> Result<()> {
        self.store.chunk(at, map)?;
        let block = block(&map.grid, at, 1);
        for (raster, layer) in self.arrays.iter().zip(&map.layers) {
            raster.write(block, &npy::bytes(&layer.data))?;
        }
        if let Some(class) = map.layer("class") {
            let pixels: Vec<u8> = (0..class.data.len()).map(|k| ros::pixel(class.data.get(k))).collect();
            self.pgm.write(block, &pixels)?;
        }
        let mut shown = png::Shown::of(map, combined);
        for (level, raster) in self.levels.iter().enumerate() {
            if level > 0 {
                shown = shown.half();
            }
            let entries = shown.entries();
            if level == 0 {
                self.store.overview(0, at, &entries)?;
            }
            if let Some(raster) = raster {
                raster.write(self::block(&map.grid, at, 1 << level), &entries)?;
            }
        }
        let factor = 1 << self.shown;
        for (raster, layer) in self.canvases.iter().zip(map.layers.iter().filter(|l| l.name != "map")) {
            raster.write(self::block(&map.grid, at, factor), &png::Shown::of(map, layer).reduced(factor).entries())?;
        }
        let tally = Tally::of(map);
        let line = serde_json::to_string(&(at, &tally)).unwrap_or_default() + "\n";
        self.progress.write_all(line.as_bytes()).map_err(|e| unwritable(&PROGRESS.at(&self.place), e))?;
        self.done.insert(at, tally);
        Ok(())
    }

    /// Writes what remains: what no reading reached, the overview, the pictures, the attributes, the report.
    pub fn finish(mut self, info: &RunInfo) -> Result<Report> {
        let started = Instant::now();
        let outline = &self.outline;
        for at in places(&outline.grid).filter(|at| !self.done.contains_key(at)) {
            let grid = part(&outline.grid, at);
            let block = block(&grid, at, 1);
            self.pgm.fill(block, &[ros::pixel(0.0)])?;
            for (raster, head) in self.arrays.iter().zip(&outline.heads).filter(|(_, h)| h.fill != 0.0) {
                raster.fill(block, &npy::fill(head))?;
            }
        }
        self.pgm.close()?;
        self.arrays.drain(..).try_for_each(Raster::close)?;
        for (level, raster) in self.levels.iter().enumerate() {
            let Some(raster) = raster else { continue };
            if level > 0 {
                shards(raster, |at, entries| self.store.overview(level, at, entries))?;
            }
            if level == self.shown {
                save(raster, &PICTURE.at(&self.place), &outline.combined)?;
            }
        }
        let heads = outline.heads.iter().filter(|h| h.name != "map");
        for (raster, head) in self.canvases.iter().zip(heads) {
            save(raster, &self.place.join(LAYER_PICTURE.of(&head.name)), head)?;
        }
        figure::write(&self.place, outline, &info.classes)?;
        let unreached: BTreeMap<Place, Tally> = places(&outline.grid)
            .filter(|at| !self.done.contains_key(at))
            .map(|at| (at, Tally::unreached(&outline.heads, part(&outline.grid, at).cells())))
            .collect();
        let tallies = places(&outline.grid).filter_map(|at| self.done.get(&at).or(unreached.get(&at)));
        let mut report = Report::of(&outline.grid, &outline.method, &outline.heads, tallies, info);
        report.files = files(&self.place, outline, info);
        let mut attributes = zarr::attributes(&outline.grid, &outline.method, &outline.heads, info);
        attributes.insert("updates".into(), report.updates.into());
        self.store.close(attributes)?;
        report.seconds.push(("write".into(), started.elapsed().as_secs_f64()));
        report.peak_memory = report::peak_memory();
        report::write(&REPORT.at(&self.place), &report)?;
        // What a resumed run would need goes last, and what tells it that there is something to resume goes first.
        for name in [RUN, PROGRESS] {
            let path = name.at(&self.place);
            std::fs::remove_file(&path).map_err(|e| unwritable(&path, e))?;
        }
        self.levels.into_iter().flatten().chain(self.canvases).try_for_each(Raster::remove)?;
        Ok(report)
    }
}

/// The map's files but for those of [`write_working`](super::write_working): what is written, and what its features will be.
fn files(place: &Path, outline: &Outline, info: &RunInfo) -> Vec<String> {
    let layers: Vec<String> = outline.heads.iter().map(|h| h.name.clone()).collect();
    let mut later = vec![REPORT.at(place)];
    if info.features.is_some() {
        later.extend([FEATURES, FEATURES_PICTURE].map(|name| name.at(place)));
    }
    let there = |path: PathBuf| path.is_file() || later.contains(&path);
    names::of(&layers).into_iter().filter(|name| there(place.join(name))).collect()
}

/// Whether something lies in a partial folder with which `--resume` would go on: finished chunks, or what the rounds before
/// them found.
pub fn begun(partial: &Path) -> bool {
    let finished = std::fs::metadata(PROGRESS.at(partial)).is_ok_and(|file| file.len() > 0);
    RUN.at(partial).exists() && (finished || FOUND.at(partial).exists())
}

/// A chunk's part of a raster that is reduced by a factor.
fn block(part: &GridSpec, [row, column]: Place, factor: usize) -> Block {
    let [width, height] = png::reduced(part, factor);
    Block { column: column as usize * EDGE / factor, row: row as usize * EDGE / factor, width, height }
}

/// A picture's palette entries on disk, top row first.
fn canvas(place: &Path, name: &str, grid: &GridSpec, factor: usize, resume: bool) -> Result<Raster> {
    Raster::open(&place.join(name), &[], png::reduced(grid, factor), 1, false, resume)
}

/// Shows each shard of a level's entries.
fn shards(raster: &Raster, mut show: impl FnMut(Place, &[u8]) -> Result<()>) -> Result<()> {
    let [width, height] = raster.extent();
    for row in (0..height).step_by(EDGE) {
        for column in (0..width).step_by(EDGE) {
            let block = Block { column, row, width: EDGE.min(width - column), height: EDGE.min(height - row) };
            show([(row / EDGE) as u32, (column / EDGE) as u32], &raster.read(block)?)?;
        }
    }
    Ok(())
}

/// Saves a canvas as a PNG on the layer's scale.
fn save(raster: &Raster, path: &Path, head: &Layer) -> Result<()> {
    let [width, height] = raster.extent();
    let mut pixels = raster.read(Block { column: 0, row: 0, width, height })?;
    png::flip(&mut pixels, width);
    png::save(path, [width, height], head.scale, &pixels)
}

/// Refuses to go on with another run's chunks.
fn same_run(place: &Path, before: &Value, now: &Value) -> Result<()> {
    // what the user chose first: the rest follows from it
    let first = ["method", "parameters", "log_sha256"].map(String::from);
    let keys = now.as_object().into_iter().chain(before.as_object()).flat_map(|o| o.keys());
    let differs = |key: &&String| before.get(key.as_str()) != now.get(key.as_str());
    let Some(key) = first.iter().chain(keys).find(differs) else { return Ok(()) };
    let of = |v: &Value| v.get(key).map_or("nothing".into(), |v| v.to_string());
    let (mut was, mut is) = (of(before), of(now));
    let mut name = key.clone();
    if let (Some(a), Some(b)) = (before[key].as_object(), now[key].as_object())
        && let Some(inner) = a.keys().chain(b.keys()).find(|k| a.get(*k) != b.get(*k))
    {
        let of = |o: &serde_json::Map<String, Value>| o.get(inner).map_or("nothing".into(), |v| v.to_string());
        (was, is, name) = (of(a), of(b), inner.clone());
    }
    Err(Error::Usage(format!(
        "{} holds an unfinished map of another run: its {name} is {was}, now it is {is}; resume with the same, or remove it",
        place.display()
    )))
}

/// A layer without its values.
pub fn head(layer: &Layer) -> Layer {
    let data = match layer.data {
        Data::F32(_) => Data::F32(Vec::new()),
        Data::U32(_) => Data::U32(Vec::new()),
        Data::U8(_) => Data::U8(Vec::new()),
        Data::I8(_) => Data::I8(Vec::new()),
    };
    Layer { data, name: layer.name.clone(), ..*layer }
}

/// A chunk's part of a whole layer.
pub fn cut(grid: &GridSpec, layer: &Layer, at: Place) -> Layer {
    let part = part(grid, at);
    let (column, row) = (at[1] as usize * EDGE, at[0] as usize * EDGE);
    fn rows<T: Copy>(values: &[T], grid: &GridSpec, part: &GridSpec, column: usize, row: usize) -> Vec<T> {
        let line = |r: usize| &values[r * grid.width + column..][..part.width];
        (row..row + part.height).flat_map(|r| line(r).iter().copied()).collect()
    }
    let data = match &layer.data {
        Data::F32(v) => Data::F32(rows(v, grid, &part, column, row)),
        Data::U32(v) => Data::U32(rows(v, grid, &part, column, row)),
        Data::U8(v) => Data::U8(rows(v, grid, &part, column, row)),
        Data::I8(v) => Data::I8(rows(v, grid, &part, column, row)),
    };
    Layer { data, name: layer.name.clone(), ..*layer }
}
