//! What can go wrong inside a backend, apart from a missing adapter. All but the last are defects of the program.

use crate::grid::ChunkId;
use crate::method::driver::WrongInput;

const DEFECT: &str = "this is a defect of echogrid: please report it";

/// A pass that can't run.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum KernelError {
    /// A method was given a batch of another kind than it takes.
    #[error(transparent)]
    WrongInput(#[from] WrongInput),
    /// No WGSL is known for a pass.
    #[error("there is no kernel \"{kernel}\" for {input}: {DEFECT}")]
    NoKernel {
        /// The pass.
        kernel: &'static str,
        /// What the method takes.
        input: &'static str,
    },
    /// A pass binds a buffer that the plan does not make.
    #[error("the pass \"{pass}\" lacks its buffer \"{binding}\": {DEFECT}")]
    MissingBuffer {
        /// The pass.
        pass: &'static str,
        /// The buffer's name in the WGSL.
        binding: &'static str,
    },
    /// A pass comes before its pipeline is made.
    #[error("the pass \"{pass}\" has no pipeline: {DEFECT}")]
    NoPipeline {
        /// The pass.
        pass: &'static str,
    },
    /// A pass over a chunk whose cells are not on the backend.
    #[error("the cells of chunk column {}, row {} are not resident: {DEFECT}", chunk.column, chunk.row)]
    NotResident {
        /// The chunk.
        chunk: ChunkId,
    },
    /// A dispatch of more workgroups than the adapter takes along one axis.
    #[error(
        "the pass \"{pass}\" needs {workgroups} workgroups, the adapter takes {limit}: give a smaller --batch, or --backend cpu"
    )]
    DispatchTooLarge {
        /// The pass.
        pass: &'static str,
        /// Workgroups along the longest axis.
        workgroups: u32,
        /// The adapter's limit.
        limit: u32,
    },
}

impl From<KernelError> for crate::Error {
    fn from(error: KernelError) -> Self {
        crate::Error::Kernel(Box::new(error))
    }
}
