//! The lists that the GPU makes, read back: for tests, which compare them with those of `batch`.

use super::Gpu;
use super::program::{BinnerKernel, Program};
use super::recording::{BufferId, Command, Download, Recording};
use super::tile_binner;
use crate::Result;
use crate::binning::batch::{Batch, Binning, ChunkList};
use crate::geometry::layout::{Entry, Tile};

impl Gpu {
    /// The lists of a batch's chunks, binned on the GPU.
    ///
    /// # Errors
    /// What the device reports.
    pub fn list(&mut self, size: [usize; 2], binning: &Binning, batch: &Batch) -> Result<Vec<ChunkList>> {
        batch.chunks.iter().map(|list| self.list_chunk(size, binning, batch, list)).collect()
    }

    fn list_chunk(
        &mut self,
        size: [usize; 2],
        binning: &Binning,
        batch: &Batch,
        list: &ChunkList,
    ) -> Result<ChunkList> {
        let params = tile_binner::params(size.map(|s| s as u32), list, binning.footprint, binning.no_echo_arcs);
        let mut recording = Recording::default();
        let cones: BufferId = recording.upload(batch.cones());
        let binned = tile_binner::record(&mut recording, cones, list, params)?;
        recording.command(Command::Download(binned.tiles, Download::Tiles));
        recording.command(Command::Download(binned.entries, Download::Entries));
        let binner = self.pipelines.binner(&self.device)?;
        let programs = BinnerKernel::ALL.map(|k| (Program::Binner(k), binner.pipeline(k).clone()));
        let mut chunk = list.clone();
        for (download, words) in self.execute(recording, &programs)?.downloads {
            match download {
                Download::Tiles => chunk.tiles = bytemuck::pod_collect_to_vec::<u32, Tile>(&words),
                Download::Entries => chunk.entries = bytemuck::pod_collect_to_vec::<u32, Entry>(&words),
                Download::Counts | Download::Shares => {}
            }
        }
        chunk.entries.truncate(chunk.tiles.last().map_or(0, |t| t.entries[1] as usize));
        chunk.tiles.retain(|t| t.entries[0] < t.entries[1]);
        Ok(chunk)
    }
}
