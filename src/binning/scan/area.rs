//! A rectangle of cell centres, with its distances and bearings from a scan's pose.

use super::order::place;
use crate::geometry::layout::Beam;

/// A box of cell centres, µm from the centre of the chunk's first cell.
pub(super) struct Area {
    /// Lower left corner.
    pub low: [i32; 2],
    /// Upper right corner.
    pub high: [i32; 2],
}

impl Area {
    /// Squared distance from a point to the nearest point of the box, µm².
    pub fn square(&self, at: [i64; 2]) -> f64 {
        let away = |k: usize| (i64::from(self.low[k]) - at[k]).max(at[k] - i64::from(self.high[k])).max(0) as f64;
        away(0) * away(0) + away(1) * away(1)
    }

    /// The four corners.
    pub fn corners(&self) -> [[i32; 2]; 4] {
        let ([x0, y0], [x1, y1]) = (self.low, self.high);
        [[x0, y0], [x1, y0], [x0, y1], [x1, y1]]
    }

    /// The least and the largest place among the bounds of a scan's beams that a cell of the box may have.
    pub fn places(&self, pose: [i32; 2], beams: &[Beam]) -> [u32; 2] {
        let n = beams.len() as u32;
        if n == 1 {
            return [0, 0];
        }
        let low = [0, 1].map(|k| self.low[k].wrapping_sub(pose[k]));
        let high = [0, 1].map(|k| self.high[k].wrapping_sub(pose[k]));
        // The extremes are at the corners, unless the pose lies in the box or the bearings pass +x.
        let passes = low[1] <= 0 && high[1] >= 0 && high[0] >= 0;
        if passes {
            return [0, n];
        }
        let places = Area { low, high }.corners().map(|v| place(beams, v, 0, n));
        [places.into_iter().fold(n, u32::min), places.into_iter().fold(0, u32::max)]
    }
}
