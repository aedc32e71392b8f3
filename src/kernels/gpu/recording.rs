//! A list of what the GPU is to do, apart from doing it: buffers, and the passes that use them, in order. `plan` writes it, `engine`
//! executes it.

use super::program::Program;
use crate::grid::ChunkId;
use bytemuck::Pod;
use std::borrow::Cow;

/// A buffer of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BufferId(usize);

impl BufferId {
    /// Its index in [`Recording::buffers`].
    pub fn index(self) -> usize {
        self.0
    }
}

/// What a buffer holds before the first pass that uses it.
pub enum Contents<'a> {
    /// A copy of the host's bytes.
    Upload(Cow<'a, [u8]>),
    /// Zeros.
    Zeros,
    /// Anything: a kernel writes the buffer before one reads it.
    Undefined,
    /// Cells of the resident chunk in this row and column, from this byte on.
    Resident {
        /// Row, column.
        chunk: ChunkId,
        /// Bytes before the first cell.
        offset: u64,
    },
}

/// A buffer: how long it is and what it holds.
pub struct Buffer<'a> {
    /// Bytes.
    pub bytes: u64,
    /// What it holds first.
    pub contents: Contents<'a>,
}

/// A kernel over some workgroups.
pub struct Dispatch {
    /// The kernel.
    pub program: Program,
    /// The buffer of each binding, by its number.
    pub bindings: Vec<(u32, BufferId)>,
    /// Workgroups along x and y.
    pub workgroups: [u32; 2],
}

/// Dispatches that are labelled and timed together.
pub struct Pass {
    /// Its kind, under which its time is added up.
    pub label: &'static str,
    /// The dispatches, in order.
    pub dispatches: Vec<Dispatch>,
}

/// What is copied to the host.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Download {
    /// The readings' counts of arc cells.
    Counts,
    /// The readings' shares.
    Shares,
    /// The tiles that the GPU listed.
    Tiles,
    /// Their entries.
    Entries,
}

/// One thing to do.
pub enum Command<'a> {
    /// Makes sure that a chunk, by row and column, has its cells on the device; new ones are zeros.
    MakeResident {
        /// Row, column.
        chunk: ChunkId,
        /// Bytes of all of its cells.
        bytes: u64,
    },
    /// Runs a pass.
    Pass(Pass),
    /// Gives a buffer free for the passes that follow.
    Release(BufferId),
    /// Computes a buffer on the host from another.
    HostPass {
        /// Read.
        input: BufferId,
        /// Written.
        output: BufferId,
        /// The output from the words of the input.
        compute: Box<dyn Fn(Vec<u32>) -> Vec<[u32; 4]> + 'a>,
    },
    /// Copies a buffer to the host.
    Download(BufferId, Download),
}

/// Buffers, and what is done with them, in order.
#[derive(Default)]
pub struct Recording<'a> {
    /// The buffers; each is made when a command first uses it.
    pub buffers: Vec<Buffer<'a>>,
    /// The commands.
    pub commands: Vec<Command<'a>>,
}

impl<'a> Recording<'a> {
    /// A buffer of so many bytes.
    pub fn buffer(&mut self, bytes: u64, contents: Contents<'a>) -> BufferId {
        self.buffers.push(Buffer { bytes, contents });
        BufferId(self.buffers.len() - 1)
    }

    /// A copy of the host's elements; of none, room for one.
    pub fn upload<T: Pod>(&mut self, elements: &'a [T]) -> BufferId {
        let bytes = size_of_val(elements).max(size_of::<T>()) as u64;
        self.buffer(bytes, Contents::Upload(Cow::Borrowed(bytemuck::cast_slice(elements))))
    }

    /// A copy of elements that the host does not keep.
    pub fn upload_owned<T: Pod>(&mut self, elements: &[T]) -> BufferId {
        let bytes: Vec<u8> = bytemuck::cast_slice(elements).to_vec();
        self.buffer(bytes.len() as u64, Contents::Upload(Cow::Owned(bytes)))
    }

    /// Runs a pass of one dispatch.
    pub fn pass(&mut self, label: &'static str, dispatch: Dispatch) {
        self.passes(label, vec![dispatch]);
    }

    /// Runs dispatches as one pass.
    pub fn passes(&mut self, label: &'static str, dispatches: Vec<Dispatch>) {
        self.commands.push(Command::Pass(Pass { label, dispatches }));
    }

    /// Adds another command.
    pub fn command(&mut self, command: Command<'a>) {
        self.commands.push(command);
    }

    /// The kernels that it runs.
    pub fn programs(&self) -> impl Iterator<Item = Program> {
        let dispatches = |command: &'_ Command<'a>| match command {
            Command::Pass(pass) => pass.dispatches.iter().map(|d| d.program).collect(),
            _ => Vec::new(),
        };
        self.commands.iter().flat_map(dispatches)
    }
}
