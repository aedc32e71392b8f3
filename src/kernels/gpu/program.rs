//! The kernels that a dispatch can run, by name.

use crate::kernels::bindings::{Binding, LIST_TILES, SORT_INTO_BLOCKS};
use crate::kernels::shader::Kernel;

/// A kernel that a dispatch runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Program {
    /// A kernel of the batch's method.
    Method(Kernel),
    /// A kernel that bins cones into tiles.
    Binner(BinnerKernel),
}

/// A kernel of the binner, in the order in which they run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BinnerKernel {
    /// Which cones' boxes meet which block of tiles.
    SortIntoBlocks,
    /// The length of each tile's list.
    Measure,
    /// Where each tile's list begins.
    Place,
    /// The entries of the lists.
    List,
}

impl BinnerKernel {
    /// All, in order.
    pub const ALL: [BinnerKernel; 4] =
        [BinnerKernel::SortIntoBlocks, BinnerKernel::Measure, BinnerKernel::Place, BinnerKernel::List];

    /// The entry point's name.
    pub fn name(self) -> &'static str {
        match self {
            BinnerKernel::SortIntoBlocks => "sort_into_blocks",
            BinnerKernel::Measure => "measure",
            BinnerKernel::Place => "place",
            BinnerKernel::List => "list",
        }
    }

    /// What it binds.
    pub fn bindings(self) -> &'static [Binding] {
        match self {
            BinnerKernel::SortIntoBlocks => SORT_INTO_BLOCKS,
            BinnerKernel::Measure | BinnerKernel::Place | BinnerKernel::List => LIST_TILES,
        }
    }
}
