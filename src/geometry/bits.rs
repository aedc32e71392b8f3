//! An iterator over the set bits of a 16-bit word, which stand for a row's cells or a tile's rows.

use super::layout::TILE;

/// The positions of the set bits of a 16-bit word, in ascending order.
pub(crate) struct Bits(pub(crate) u32);

impl Iterator for Bits {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let place = self.0.trailing_zeros() as usize & (TILE - 1);
        let some = self.0 != 0;
        self.0 &= self.0.wrapping_sub(1);
        some.then_some(place)
    }
}
