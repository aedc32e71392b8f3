//! The trait of a method's CPU half: the state of a row of 16 cells, and its update by a reading.

use crate::geometry::layout::{Cone, Frame, TILE};
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16};

/// One word of every cell of a tile, row by row.
pub type Plane = [[u32; TILE]; TILE];

/// The 16 cells of a row relative to a reading: their regions, distances and angles.
#[derive(Debug, Clone, Copy)]
pub struct Reached<S: Simd> {
    /// Cells in the interior, which the reading frees.
    pub interior: mask32x16<S>,
    /// Cells on the reading's arc.
    pub arc: mask32x16<S>,
    /// Distance from the sensor, metres.
    pub distance: f32x16<S>,
    /// Off-axis angle over β; 0 for a laser.
    pub turn: f32x16<S>,
}

/// The CPU half of a method: the state of a row of cells, and its update by a reading.
pub trait Kernel: Copy + Sync {
    /// A row of cells in registers.
    type CellStates<S: Simd>: Copy;

    /// Whether a reading updates only the cells on its axis.
    const AXIS: bool = false;

    /// Reads a row of a tile from its planes, without those of the two counts.
    fn load<S: Simd>(simd: S, planes: &[Plane], row: usize) -> Self::CellStates<S>;

    /// Writes a row of a tile to its planes, without those of the two counts.
    fn store<S: Simd>(cells: Self::CellStates<S>, planes: &mut [Plane], row: usize);

    /// Whether the method uses distances and angles.
    fn polar(&self) -> bool {
        false
    }

    /// Applies a reading to a row.
    fn fuse_cells<S: Simd>(
        &self,
        frame: &Frame,
        cone: &Cone,
        row: &Reached<S>,
        share: &[u32; 4],
        cells: &mut Self::CellStates<S>,
    );

    /// Brings cells to their canonical form. It is called at least once in 16 updates; in between, a value may have several forms.
    #[inline(always)]
    fn renormalize<S: Simd>(&self, _: &mut Self::CellStates<S>) {}

    /// The evidence of a reading on its arc, not yet normalised. It also applies the part of the update on which the evidence depends.
    fn weigh_cells<S: Simd>(&self, _: &Frame, _: &Cone, row: &Reached<S>, _: &mut Self::CellStates<S>) -> f32x16<S> {
        f32x16::splat(row.distance.token(), 0.0)
    }
}
