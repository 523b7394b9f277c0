use crate::section::SECTION_ALIGN;
use bytemuck::{Pod, Zeroable};
use std::collections::TryReserveError;

#[repr(C, align(64))]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Block([u8; SECTION_ALIGN]);

/// Owned bytes that begin on a 64-byte boundary, as [`read`](crate::read) needs them.
#[derive(Clone, Default)]
pub struct AlignedBytes {
    blocks: Vec<Block>,
    len: usize,
}

impl AlignedBytes {
    /// `len` zero bytes, to be filled by [`AlignedBytes::as_mut_slice`].
    #[must_use]
    pub fn zeroed(len: usize) -> Self {
        Self {
            blocks: vec![Block::zeroed(); len.div_ceil(SECTION_ALIGN)],
            len,
        }
    }

    /// As [`AlignedBytes::zeroed`], for a length that a stranger chose.
    ///
    /// # Errors
    /// When there is not that much memory.
    pub fn try_zeroed(len: usize) -> Result<Self, TryReserveError> {
        let mut blocks = Vec::new();
        let count = len.div_ceil(SECTION_ALIGN);
        blocks.try_reserve_exact(count)?;
        blocks.resize(count, Block::zeroed());
        Ok(Self { blocks, len })
    }

    /// A copy of `bytes`.
    #[must_use]
    pub fn copy_of(bytes: &[u8]) -> Self {
        let mut out = Self::zeroed(bytes.len());
        out.as_mut_slice().copy_from_slice(bytes);
        out
    }

    /// The bytes.
    #[must_use]
    pub fn as_slice(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.blocks)[..self.len]
    }

    /// The bytes, to be changed.
    #[must_use]
    pub fn as_mut_slice(&mut self) -> &mut [u8] {
        &mut bytemuck::cast_slice_mut(&mut self.blocks)[..self.len]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_is_equal_and_aligned_at_any_length() {
        for len in [0, 1, 63, 64, 65, 1000] {
            let bytes: Vec<u8> = (0..len).map(|i| i as u8).collect();
            let copy = AlignedBytes::copy_of(&bytes);
            assert_eq!(copy.as_slice(), bytes);
            assert_eq!(copy.as_slice().as_ptr().addr() % SECTION_ALIGN, 0);
        }
    }
}
