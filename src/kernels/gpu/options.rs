//! How to open the GPU.

use crate::kernels::adapter::AdapterInfo;

/// A change to a kernel's source: every `from` becomes `to`. For tests that seed faults.
pub type Patch = (String, String);

/// How to open the GPU. Results depend on no option but `patches`.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Refuse a software adapter.
    pub hardware: bool,
    /// Changes to the kernels' sources, for tests that seed faults.
    pub patches: Vec<Patch>,
    /// Vectors of four cells that a thread owns, 1 to 16, rounded up to a power of two; `None`: what suits the adapter.
    pub vec4s_per_thread: Option<u32>,
    /// Whether kernels stage readings in workgroup memory and have code of their own for tiles that are interior throughout or without an
    /// arc; `None`: what suits the adapter.
    pub staged: Option<bool>,
    /// Whether the GPU bins cones into tiles itself; `None`: what suits the adapter. On a software adapter it is for tests: lists are not
    /// held to [`crate::kernels::Limits::max_loop_iterations`].
    pub bins_tiles: Option<bool>,
}

impl Options {
    /// Whether kernels stage readings on this adapter.
    pub(super) fn stages(&self, info: &AdapterInfo) -> bool {
        self.staged.unwrap_or(!info.software)
    }
}
