//! Writes a map chunk by chunk, so that only a few chunks are in memory however large it is. A finished chunk is written to every file
//! and then noted in the progress file; a resumed run goes on after the last noted chunk.

mod canvas;
mod resume;

pub use resume::begun;

use super::names::{
    self, CANVAS, FEATURES, FEATURES_PICTURE, LAYER_ARRAY, LAYER_PICTURE, OVERVIEW_CANVAS, PICTURE, PROGRESS, REPORT,
    RUN, STORE,
};
use super::raster::Raster;
use super::report::{self, ChunkStatistics};
use super::{MapSchema, Report, RunInfo, figure, npy, png, ros, unwritable, zarr};
use crate::Result;
use crate::grid::{ChunkId, EDGE, GridSpec, Layer, Map, chunks, part};
use crate::pipeline::out_of_core::{ChunkSink, FinishedChunk};
use canvas::{block, open_canvas, save_png, shards};
use resume::same_run;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The longest side of the overview's coarsest level, pixels.
const COARSEST: usize = 256;

/// A map that is being written to a folder.
pub struct MapWriter {
    folder: PathBuf,
    schema: MapSchema,
    store: zarr::Store,
    pgm: Raster,
    arrays: Vec<Raster>,
    /// The combined layer's palette entries, reduced by 1, 2, 4, …; `None`: the level is not kept on disk.
    levels: Vec<Option<Raster>>,
    /// The level that becomes `map.png`.
    shown: usize,
    /// The layers' pictures while they are written.
    canvases: Vec<Raster>,
    done: BTreeMap<ChunkId, ChunkStatistics>,
    progress: File,
}

impl ChunkSink for MapWriter {
    fn done(&self) -> BTreeSet<ChunkId> {
        self.done.keys().copied().collect()
    }

    fn write(&mut self, chunk: &FinishedChunk) -> Result<()> {
        self.chunk(chunk.place, &chunk.finished.map, &chunk.finished.combined)
    }
}

impl MapWriter {
    /// Opens the files in `folder`. With `resume` it goes on with the files of an earlier run of the same log, method and parameters; if
    /// there are none, it begins.
    ///
    /// # Errors
    /// [`crate::Error::Resources`] if something can't be written; [`crate::Error::Usage`] where the earlier run was another one.
    pub fn open(folder: &Path, schema: MapSchema, info: &RunInfo, resume: bool) -> Result<MapWriter> {
        let mut identity = zarr::attributes(&schema, info);
        identity.insert("npy".into(), schema.npy.into());
        let run = RUN.at(folder);
        let before = std::fs::read(&run).ok().and_then(|text| serde_json::from_slice::<Value>(&text).ok());
        let resume = resume && before.is_some();
        if let (true, Some(before)) = (resume, before) {
            same_run(folder, &before, &Value::Object(identity.clone()))?;
        }
        let progress = PROGRESS.at(folder);
        if !resume {
            // Before all other files, as it names the layers that they are of.
            File::create(&progress).map_err(|e| unwritable(&progress, e))?;
            std::fs::write(&run, Value::Object(identity).to_string()).map_err(|e| unwritable(&run, e))?;
        }
        let GridSpec { width, height, .. } = schema.grid;
        let coarser = |k: usize| width.max(height) >> k > COARSEST && 1 << k < EDGE;
        let levels = 1 + (0..).take_while(|k| coarser(*k)).count();
        let shown = png::factor(&schema.grid).trailing_zeros() as usize;
        let level = |k: usize| {
            // The finest level is written to the store alone, unless it is the picture.
            if k == 0 && shown != 0 {
                return Ok(None);
            }
            open_canvas(&folder.join(OVERVIEW_CANVAS.of(k)), &schema.grid, 1 << k, resume).map(Some)
        };
        let canvases = schema.layers.iter().filter(|l| l.name != "map");
        let canvases =
            canvases.map(|l| open_canvas(&folder.join(CANVAS.of(&l.name)), &schema.grid, 1 << shown, resume));
        let array = |l: &Layer| npy::open(&folder.join(LAYER_ARRAY.of(&l.name)), &schema.grid, &l.data, resume);
        let arrays = if schema.npy { &schema.layers[..] } else { &[] };
        let mut writer = MapWriter {
            store: zarr::Store::open(&folder.join(STORE), &schema, levels)?,
            pgm: ros::open(folder, &schema.grid, resume)?,
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
            folder: folder.into(),
            shown,
            schema,
        };
        if resume {
            writer.read_progress(&progress)?;
        }
        Ok(writer)
    }

    /// Reads the chunks that an earlier run has written. The last line of the file may be torn.
    fn read_progress(&mut self, path: &Path) -> Result<()> {
        let text = std::fs::read_to_string(path).map_err(|e| unwritable(path, e))?;
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        self.progress.set_len(whole as u64).map_err(|e| unwritable(path, e))?;
        let lines = text[..whole].lines().map(serde_json::from_str::<(ChunkId, ChunkStatistics)>);
        self.done = lines.collect::<serde_json::Result<_>>().map_err(|e| unwritable(path, e))?;
        Ok(())
    }

    /// Writes a chunk's part of the map to every file, and notes it in the progress file.
    ///
    /// # Errors
    /// [`Error::Resources`](crate::Error::Resources) if a file can't be written.
    pub fn chunk(&mut self, at: ChunkId, map: &Map, combined: &Layer) -> Result<()> {
        self.store.chunk(at, map)?;
        let block = block(&map.grid, at, 1);
        for (raster, layer) in self.arrays.iter().zip(&map.layers) {
            raster.write(block, &npy::bytes(&layer.data))?;
        }
        if let Some(class) = map.layer("class") {
            let pixels: Vec<u8> = (0..class.data.len()).map(|k| ros::pixel(class.data.get(k))).collect();
            self.pgm.write(block, &pixels)?;
        }
        let mut values = png::PictureValues::of(map, combined);
        for (level, raster) in self.levels.iter().enumerate() {
            if level > 0 {
                values = values.half();
            }
            let entries = values.entries();
            if level == 0 {
                self.store.overview(0, at, &entries)?;
            }
            if let Some(raster) = raster {
                raster.write(self::block(&map.grid, at, 1 << level), &entries)?;
            }
        }
        let factor = 1 << self.shown;
        for (raster, layer) in self.canvases.iter().zip(map.layers.iter().filter(|l| l.name != "map")) {
            raster.write(
                self::block(&map.grid, at, factor),
                &png::PictureValues::of(map, layer).reduced(factor).entries(),
            )?;
        }
        let (statistics, progress) = (ChunkStatistics::of(map), PROGRESS.at(&self.folder));
        let line = serde_json::to_string(&(at, &statistics)).map_err(|e| unwritable(&progress, e))? + "\n";
        self.progress.write_all(line.as_bytes()).map_err(|e| unwritable(&progress, e))?;
        self.done.insert(at, statistics);
        Ok(())
    }

    /// Writes the rest: the chunks that no reading reached, the overview, the pictures, the attributes, the report.
    ///
    /// # Errors
    /// [`Error::Resources`](crate::Error::Resources) if a file can't be written.
    pub fn finish(mut self, info: &RunInfo) -> Result<Report> {
        let started = Instant::now();
        let schema = &self.schema;
        for at in chunks(&schema.grid).filter(|at| !self.done.contains_key(at)) {
            let grid = part(&schema.grid, at);
            let block = block(&grid, at, 1);
            self.pgm.fill(block, &[ros::pixel(0.0)])?;
            for (raster, layer) in self.arrays.iter().zip(&schema.layers).filter(|(_, l)| l.fill != 0.0) {
                raster.fill(block, &npy::fill(layer))?;
            }
        }
        self.pgm.close()?;
        self.arrays.drain(..).try_for_each(Raster::close)?;
        for (level, raster) in self.levels.iter().enumerate() {
            // The finest level is in the store already, where it isn't the picture.
            let Some(raster) = raster else { continue };
            if level > 0 {
                shards(raster, |at, entries| self.store.overview(level, at, entries))?;
            }
            if level == self.shown {
                save_png(raster, &PICTURE.at(&self.folder), &schema.combined)?;
            }
        }
        let layers = schema.layers.iter().filter(|l| l.name != "map");
        for (raster, layer) in self.canvases.iter().zip(layers) {
            save_png(raster, &self.folder.join(LAYER_PICTURE.of(&layer.name)), layer)?;
        }
        figure::write(&self.folder, schema, &info.classes)?;
        let unreached: BTreeMap<ChunkId, ChunkStatistics> = chunks(&schema.grid)
            .filter(|at| !self.done.contains_key(at))
            .map(|at| (at, ChunkStatistics::unreached(&schema.layers, part(&schema.grid, at).cells())))
            .collect();
        let chunks = chunks(&schema.grid).filter_map(|at| self.done.get(&at).or(unreached.get(&at)));
        let mut report = Report::of(schema, chunks, info);
        report.files = files(&self.folder, schema, info);
        let mut attributes = zarr::attributes(schema, info);
        attributes.insert("updates".into(), report.updates.into());
        self.store.close(attributes)?;
        report.seconds.push(("write".into(), started.elapsed().as_secs_f64()));
        report.peak_memory = report::peak_memory();
        report::write(&REPORT.at(&self.folder), &report)?;
        // RUN tells a resumed run that there is something to resume, so it is removed first.
        for name in [RUN, PROGRESS] {
            let path = name.at(&self.folder);
            std::fs::remove_file(&path).map_err(|e| unwritable(&path, e))?;
        }
        self.levels.into_iter().flatten().chain(self.canvases).try_for_each(Raster::remove)?;
        Ok(report)
    }
}

/// The names of the map's files that are written, and of those that [`write_features`](super::write_features) will write.
fn files(folder: &Path, schema: &MapSchema, info: &RunInfo) -> Vec<String> {
    let layers: Vec<String> = schema.layers.iter().map(|l| l.name.clone()).collect();
    let mut later = vec![REPORT.at(folder)];
    if info.features.is_some() {
        later.extend([FEATURES, FEATURES_PICTURE].map(|name| name.at(folder)));
    }
    let there = |path: PathBuf| path.is_file() || later.contains(&path);
    names::of(&layers).into_iter().filter(|name| there(folder.join(name))).collect()
}
