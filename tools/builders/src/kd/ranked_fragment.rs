use std::ops::Range;

/// A fragment as ranks, in one word.
///
/// ```text
/// [23..0]  ranks where it begins, eight bits per axis      [31..24] its place among the fragments that were ranked
/// [55..32] ranks where it ends                             [63..56] zero
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ranked(pub u64);

impl Ranked {
    /// The fragment at a place below 128, its ranks still zero.
    pub(super) fn at(place: u64) -> Self {
        Self(place << 24)
    }

    #[inline(always)]
    pub(super) fn min(self, axis: usize) -> u8 {
        (self.0 >> (8 * axis)) as u8
    }

    #[inline(always)]
    pub(super) fn max(self, axis: usize) -> u8 {
        (self.0 >> (8 * axis + 32)) as u8
    }

    /// Its place among the fragments that were ranked.
    pub(super) fn place(self) -> usize {
        (self.0 >> 24) as usize & 0xff
    }
}

/// The fragments of all open nodes as ranks: a stack of ranges, that of the node in work on top.
#[derive(Debug, Default)]
pub(super) struct RankedStack {
    pub list: Vec<Ranked>,
    spare: Vec<Ranked>,
}

impl RankedStack {
    /// Parts the topmost range at `rank`; the right child's is on top of the left one's. As
    /// [`sift`](super::fragment::sift) does it. What is cut ends at the first and begins at the last of the ranks at the same
    /// position.
    #[inline(always)]
    pub(super) fn part(
        &mut self,
        range: Range<usize>,
        axis: usize,
        rank: u8,
        [first, last]: [u8; 2],
    ) -> [Range<usize>; 2] {
        let begin = range.start;
        self.spare.resize(self.spare.len().max(range.len()), Ranked::default());
        let list = &mut self.list[range];
        let spare = &mut self.spare[..list.len()];
        let (low, high) = (8 * axis as u32, 8 * axis as u32 + 32);
        let (first, last) = (u64::from(first), u64::from(last));
        let (mut left, mut right) = (0, 0);
        // Words are written whole: a byte written into one could not be forwarded to the read of the word.
        for next in 0..list.len() {
            let Ranked(word) = list[next];
            let (min, max) = ((word >> low) as u8, (word >> high) as u8);
            let (below, above) = (min < rank, max > rank);
            let lower = word & !(0xff << high) | first << high;
            list[left] = Ranked(if above { lower } else { word });
            left += usize::from(below);
            let upper = word & !(0xff << low) | last << low;
            spare[right] = Ranked(if below { upper } else { word });
            right += usize::from(above);
        }
        let (middle, end) = (begin + left, begin + left + right);
        if self.list.len() < end {
            self.list.resize(end, Ranked::default());
        }
        self.list[middle..end].copy_from_slice(&self.spare[..right]);
        [begin..middle, middle..end]
    }
}
