use crate::geom::{Aabb, Affine};
use bytemuck::{Pod, Zeroable};

/// The vertex cache of one part: where its vertices are in every key frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct CacheRow {
    /// Part row whose vertices it moves.
    pub part: u32,
    /// Bone that carries the part: the cache's positions are in the space that its `X` maps from.
    pub bone: u32,
    /// Key frames; at least one.
    pub key_count: u32,
    /// First segment row.
    pub segment_first: u32,
    /// Segment rows; at least one.
    pub segment_count: u32,
    /// Bounds how far a stored position is from the source's at any key, in the cache's space.
    pub position_error: f32,
    /// Zero.
    pub reserved: [u32; 2],
}

/// A range of key frames with its own tracks, vertex positions, clusters and trees. Neighbours share a key.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct SegmentRow {
    /// First key of the cache that it covers: the last one of the segment before, or 0.
    pub key_first: u32,
    /// Keys that it covers; at least two, or one where the cache has only one.
    pub key_count: u32,
    /// First track row.
    pub track_first: u32,
    /// Track rows.
    pub track_count: u32,
    /// First cluster row.
    pub cluster_first: u32,
    /// Cluster rows.
    pub cluster_count: u32,
    /// Key-vertex row of the part's first vertex; the others follow.
    pub key_vertex_first: u32,
    /// First row in the key-word section.
    pub word_first: u32,
    /// Words of each key; those of a key stand together, key after key.
    pub words_per_key: u32,
}

impl SegmentRow {
    /// Row in the key-word section of a key's first word; the key is counted from the segment's first.
    #[inline]
    #[must_use]
    pub fn first_word(&self, key: u32) -> usize {
        self.word_first as usize + key as usize * self.words_per_key as usize
    }

    /// A key's words, counted from the segment's first key, and all that follow.
    ///
    /// # Panics
    /// When the rows were never checked and the key's words lie outside of `words`.
    #[inline]
    #[must_use]
    pub fn key_words<'a>(&self, words: &'a [u32], key: u32) -> &'a [u32] {
        &words[self.first_word(key)..]
    }
}

/// The motion of a cluster of a vertex cache, and the lattice on which its vertices' positions are stored.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct TrackRow {
    /// First key row, one per key of the segment; `NONE` where local space is the cache's own space at every key.
    pub key_first: u32,
    /// Local position of the lattice's zero.
    pub origin: [f32; 3],
    /// Local length of a lattice step, above zero.
    pub step: f32,
    /// First [`KeyBoxRow`](super::KeyBoxRow) of the cluster that it moves; zero without keys.
    pub box_first: u32,
    /// Keys from one that has boxes to the next; zero where none has any, and without keys.
    pub box_interval: u32,
    /// Zero.
    pub reserved: u32,
}

/// A track in one key frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct KeyRow {
    /// The cache's space from local space: four columns of three, as [`Affine`].
    pub map: [f32; 12],
    /// Around the vertices of the track's cluster in this key, in the cache's space.
    pub bounds: Aabb,
    /// [`KeyRow::CUT`] or zero.
    pub flags: u32,
    /// Zero.
    pub reserved: u32,
}

impl KeyRow {
    /// Flag: between this key and the next the cluster's tree holds nothing.
    pub const CUT: u32 = 1;

    /// The map, as columns.
    #[must_use]
    pub fn map(&self) -> Affine {
        Affine {
            columns: bytemuck::cast(self.map),
        }
    }

    /// True where the tree may not be used between this key and the next.
    #[must_use]
    pub fn is_cut(&self) -> bool {
        self.flags & Self::CUT != 0
    }
}

/// A vertex of a cache in one segment: its track, and where its positions are among the words of each key.
///
/// Its record of a key has one unsigned number per axis, x in the lowest bits, of as many bits as `widths` says. A lattice
/// coordinate is `base` plus that number. Where `raw` is one a record is instead 96 bits, those of three `f32`.
///
/// The records of a key, those of all vertices, follow each other without gaps, low bits first: whoever is between two keys
/// reads the words of these two, and neighbours in the mesh read the same ones.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct KeyVertexRow {
    /// Least lattice coordinate per axis.
    pub base: [i32; 3],
    /// Track row in whose lattice the positions are.
    pub track: u32,
    /// First bit of its record in the words of a key.
    pub bit_first: u32,
    /// Bits per axis, each at most [`KeyVertexRow::MAX_WIDTH`].
    pub widths: [u8; 3],
    /// 0: lattice coordinates. 1: `f32` bits.
    pub raw: u8,
}

impl KeyVertexRow {
    /// Most bits per axis.
    pub const MAX_WIDTH: u8 = 21;
    /// Lattice coordinates are at most this in magnitude, so that each is an `f32`.
    pub const MAX_COORDINATE: i32 = 1 << 24;
    /// Zero words that close the key-word section: a record is read as four words wherever it begins, and one without
    /// bits may begin where they do.
    pub const CLOSING_WORDS: usize = 4;

    /// Bits of one key's record.
    #[inline]
    #[must_use]
    pub fn record_bits(&self) -> u32 {
        if self.raw != 0 {
            96
        } else {
            self.widths.iter().map(|width| u32::from(*width)).sum()
        }
    }

    /// Contains the stored numbers of all keys: every number that the widths have room for, or just the raw positions.
    /// `keys` are the words of each, as of [`KeyVertexRow::stored`].
    ///
    /// # Panics
    /// When the rows were never checked and the row breaks their rules.
    #[must_use]
    pub fn bounds<'a>(&self, keys: impl Iterator<Item = &'a [u32]>) -> Aabb {
        if self.raw == 0 {
            let ranges = [0, 1, 2].map(|k| self.lattice_range(k));
            return Aabb {
                min: ranges.map(|[least, _]| least as f32),
                max: ranges.map(|[_, greatest]| greatest as f32),
            };
        }
        Aabb::around(keys.map(|key| self.stored(key)))
    }

    /// The least and the greatest lattice coordinate that a record may hold on an axis. Widths are in range.
    pub(crate) fn lattice_range(&self, axis: usize) -> [i64; 2] {
        let least = i64::from(self.base[axis]);
        [least, least + (1 << self.widths[axis]) - 1]
    }

    /// The stored numbers of one key: lattice coordinates, or positions where `raw` is one. What the track's map, with its
    /// lattice, makes positions of.
    ///
    /// `key_words` are the key's, and those behind them: [`SegmentRow::key_words`].
    ///
    /// # Panics
    /// When the rows were never checked and the record lies outside of `key_words`.
    // No closures: they would not be compiled for the instructions that the function around them is.
    #[inline(always)]
    #[must_use]
    pub fn stored(&self, key_words: &[u32]) -> [f32; 3] {
        let first = self.word();
        let words = &key_words[first..first + 4];
        let low = u64::from(words[0]) | u64::from(words[1]) << 32;
        let high = u64::from(words[2]) | u64::from(words[3]) << 32;
        let record = (u128::from(low) | u128::from(high) << 64) >> (self.bit_first % 32);
        if self.raw != 0 {
            let word = |k: u32| f32::from_bits((record >> (32 * k)) as u32);
            return [word(0), word(1), word(2)];
        }
        let mut record = record as u64;
        let mut out = [0.0; 3];
        for k in 0..3 {
            let number = record & ((1 << self.widths[k]) - 1);
            record >>= self.widths[k];
            out[k] = (self.base[k] + number as i32) as f32;
        }
        out
    }

    /// The first word of a key's that holds bits of its record.
    #[inline(always)]
    #[must_use]
    pub fn word(&self) -> usize {
        self.bit_first as usize / 32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROW: KeyVertexRow = KeyVertexRow {
        base: [-5, 0, 9],
        track: 0,
        bit_first: 0,
        widths: [0; 3],
        raw: 0,
    };

    /// Words of one key from what its bits are, closed.
    fn words(bits: &[u64]) -> Vec<u32> {
        let word = |bits: &[u64]| bits.iter().rev().fold(0, |sum, bit| sum << 1 | *bit as u32);
        let mut out: Vec<u32> = bits.chunks(32).map(word).collect();
        out.extend([0; KeyVertexRow::CLOSING_WORDS]);
        out
    }

    fn bits_of(number: u64, width: u32) -> impl Iterator<Item = u64> {
        (0..width).map(move |bit| number >> bit & 1)
    }

    #[test]
    fn records_are_read_back_wherever_they_begin() {
        for widths in [[0u8, 0, 0], [1, 0, 3], [7, 11, 13], [21, 21, 21], [21, 21, 20]] {
            let value = |at: u64, k: usize| ((at + 1) * 2_654_435_761 * (k as u64 + 1)) & ((1 << widths[k]) - 1);
            let (mut rows, mut bits) = (Vec::new(), vec![1]);
            for at in 0..40 {
                let row = KeyVertexRow {
                    bit_first: bits.len() as u32,
                    widths,
                    ..ROW
                };
                (0..3).for_each(|k| bits.extend(bits_of(value(at, k), widths[k].into())));
                assert_eq!(row.bit_first + row.record_bits(), bits.len() as u32);
                rows.push(row);
            }
            let words = words(&bits);
            for (at, row) in (0..).zip(&rows) {
                let expected = std::array::from_fn(|k| (row.base[k] + value(at, k) as i32) as f32);
                assert_eq!(row.stored(&words), expected, "{widths:?} record {at}");
            }
        }
    }

    #[test]
    fn raw_records_are_the_bits_of_three_floats_wherever_they_begin() {
        let points = [[1.5f32, -0.0, 1e-40], [f32::MAX, 3.0, -7.25]];
        for before in 0..40 {
            let mut bits = vec![1; before];
            let coordinates = points.as_flattened().iter();
            coordinates.for_each(|x| bits.extend(bits_of(x.to_bits().into(), 32)));
            for (at, point) in points.into_iter().enumerate() {
                let row = KeyVertexRow {
                    base: [0; 3],
                    bit_first: (before + 96 * at) as u32,
                    raw: 1,
                    ..ROW
                };
                assert_eq!(row.stored(&words(&bits)).map(f32::to_bits), point.map(f32::to_bits));
                assert_eq!(row.record_bits(), 96);
            }
        }
    }

    #[test]
    fn keys_follow_each_other_from_the_segments_first_word_on() {
        let segment = SegmentRow {
            word_first: 2,
            words_per_key: 3,
            ..SegmentRow::zeroed()
        };
        let words: Vec<u32> = (0..12).collect();
        assert_eq!(segment.key_words(&words, 0), &words[2..]);
        assert_eq!(segment.key_words(&words, 2), &words[8..]);
    }

    #[test]
    fn bounds_contain_every_stored_number() {
        let lattice = KeyVertexRow {
            widths: [3, 0, 4],
            ..ROW
        };
        let expected = Aabb {
            min: [-5.0, 0.0, 9.0],
            max: [2.0, 0.0, 24.0],
        };
        assert_eq!(lattice.bounds([].into_iter()), expected);
        let raw = KeyVertexRow {
            base: [0; 3],
            bit_first: 32,
            raw: 1,
            ..ROW
        };
        let keys = [[f32::MAX, 1.0, -2.0, 0.0, 9.0], [f32::MAX, -3.0, 4.0, 0.5, 9.0]];
        let keys = keys.map(|key| key.map(f32::to_bits));
        let expected = Aabb {
            min: [-3.0, -2.0, 0.0],
            max: [1.0, 4.0, 0.5],
        };
        assert_eq!(raw.bounds(keys.iter().map(|key| &key[..])), expected);
    }
}
