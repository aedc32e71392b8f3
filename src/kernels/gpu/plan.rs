//! The plan of a batch: which buffers, and which labelled passes over them, in order.

use super::buffers::{ChunkBuffers, InputBuffers, make_chunks};
use super::program::Program;
use super::recording::{BufferId, Command, Dispatch, Download, Recording};
use super::work::{Capacity, Work};
use crate::geometry::layout::{CHUNK, Frame};
use crate::kernels::bindings::bindings;
use crate::kernels::shader::Kernel;
use crate::kernels::{KernelError, normalize_by_count};
use crate::method::Step;

/// Threads of a workgroup of *sum*; each has one reading.
const SUM_THREADS: u32 = 64;

/// Lists the passes of a batch: bin its cones into tiles where the host has not, then each step over every chunk.
///
/// # Errors
/// [`KernelError`] where a step has no kernel, or a kernel lacks a buffer.
pub fn plan<'a>(work: &Work<'a>, capacity: Capacity) -> Result<Recording<'a>, KernelError> {
    let mut recording = Recording::default();
    for list in &work.batch.chunks {
        let bytes = work.tile_bytes() * (CHUNK * CHUNK) as u64;
        recording.command(Command::MakeResident { chunk: list.place, bytes });
    }
    let input = InputBuffers::new(&mut recording, work, capacity);
    let chunks = make_chunks(&mut recording, work, &input, capacity)?;
    let buffer = |name| input.get(name).ok_or(KernelError::MissingBuffer { pass: "host", binding: name });
    for step in work.steps {
        match *step {
            Step::Pass(pass, mode) => {
                let frame = recording.upload_owned(&[Frame { mode, ..work.frame }]);
                for chunk in &chunks {
                    let dispatch = over_tiles(work, pass.into(), (frame, &input, chunk))?;
                    recording.pass(Kernel::from(pass).name(), dispatch);
                }
            }
            Step::Sum => {
                // Without readings there is nothing to sum.
                if !work.batch.cones().is_empty() {
                    recording.pass(Kernel::Sum.name(), over_readings(work, &input)?);
                }
            }
            Step::NormalizeByCount => {
                let (method, cones) = (work.method, work.batch.cones());
                let compute = Box::new(move |counts: Vec<u32>| normalize_by_count(method, counts.into_iter(), cones));
                recording.command(Command::HostPass { input: buffer("parts")?, output: buffer("shares")?, compute });
            }
            Step::AccumulateCounts => recording.command(Command::Download(buffer("parts")?, Download::Counts)),
            Step::ReadBack => recording.command(Command::Download(buffer("shares")?, Download::Shares)),
        }
    }
    Ok(recording)
}

/// A kernel over the listed tiles of a chunk, a workgroup each.
fn over_tiles(
    work: &Work,
    kernel: Kernel,
    (frame, input, chunk): (BufferId, &InputBuffers, &ChunkBuffers),
) -> Result<Dispatch, KernelError> {
    let buffer = |name| match name {
        "frame" => Some(frame),
        name => chunk.get(name).or_else(|| input.get(name)),
    };
    dispatch(work, kernel, buffer, chunk.workgroups)
}

/// *sum*, a thread a reading.
fn over_readings(work: &Work, input: &InputBuffers) -> Result<Dispatch, KernelError> {
    let readings = work.batch.cones().len() as u32;
    dispatch(work, Kernel::Sum, |name| input.get(name), readings.div_ceil(SUM_THREADS))
}

/// A kernel with the buffers that it binds, by their names.
fn dispatch(
    work: &Work,
    kernel: Kernel,
    buffer: impl Fn(&'static str) -> Option<BufferId>,
    workgroups: u32,
) -> Result<Dispatch, KernelError> {
    let missing = |binding| KernelError::MissingBuffer { pass: kernel.name(), binding };
    let bound = bindings(work.method.unit(), kernel)?
        .iter()
        .map(|b| Ok((b.number, buffer(b.name).ok_or(missing(b.name))?)))
        .collect::<Result<_, KernelError>>()?;
    Ok(Dispatch { program: Program::Method(kernel), bindings: bound, workgroups: [workgroups, 1] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::binning::batch::{Batch, ChunkList, ConeInput, Input};
    use crate::geometry::layout::{Cone, Tile};
    use crate::method::{self, settings::Settings};
    use bytemuck::Zeroable;

    /// One reading in one tile of one chunk.
    fn batch() -> Batch {
        let tile = Tile { entries: [0, 1], ..Tile::zeroed() };
        let chunks = vec![ChunkList { tiles: vec![tile], entries: vec![Zeroable::zeroed()], ..ChunkList::default() }];
        Batch { chunks, input: Input::Cones(ConeInput { cones: vec![Cone::zeroed()], first_part: vec![0, 1] }) }
    }

    fn labels(method: &str, steps: Option<&[Step]>) -> Result<Vec<&'static str>, KernelError> {
        let Some(settings) = Settings::of(method) else { return Ok(Vec::new()) };
        let (method, batch) = (method::make(settings), batch());
        let steps = steps.unwrap_or(method.sweeps()[0]);
        let work = Work { method: method.as_ref(), frame: Frame::zeroed(), batch: &batch, steps, shares: &[[0; 4]] };
        let capacity = Capacity { part_bytes: 4, tiles_per_binding: CHUNK * CHUNK };
        let recording = plan(&work, capacity)?;
        let label = |command: &Command| match command {
            Command::MakeResident { .. } => "make resident",
            Command::Pass(pass) => pass.label,
            Command::Release(_) => "release",
            Command::HostPass { .. } => "host",
            Command::Download(..) => "download",
        };
        Ok(recording.commands.iter().map(label).collect())
    }

    #[test]
    fn passes_stand_in_the_order_of_the_steps() {
        let found = |method| labels(method, None);
        assert_eq!(found("certainty"), Ok(vec!["make resident", "weigh", "sum", "fuse"]));
        assert_eq!(found("dempster-shafer"), Ok(vec!["make resident", "count", "host", "fuse"]));
        assert_eq!(found("bayes"), Ok(vec!["make resident", "fuse"]));
        let carried = [Step::Pass(method::Pass::Weigh, 0), Step::Sum, Step::ReadBack];
        assert_eq!(labels("certainty", Some(&carried)), Ok(vec!["make resident", "weigh", "sum", "download"]));
    }

    #[test]
    fn a_step_without_its_buffer_is_an_error() {
        let missing = Err(KernelError::MissingBuffer { pass: "host", binding: "parts" });
        assert_eq!(labels("bayes", Some(&[Step::AccumulateCounts])), missing);
        assert_eq!(labels("bayes", Some(&[Step::NormalizeByCount])), missing);
    }
}
