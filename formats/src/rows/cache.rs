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
    /// Zero.
    pub reserved: u32,
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

/// A vertex of a cache in one segment: its track, and where its positions are in the key-word section.
///
/// Its record of a key has one unsigned number per axis, x in the lowest bits, of as many bits as `widths` says; records
/// follow each other without gaps from the first bit of word `word_first`, low bits first. A lattice coordinate is
/// `base` plus that number. Where `raw` is one a record is instead three words, the bits of three `f32`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct KeyVertexRow {
    /// Least lattice coordinate per axis.
    pub base: [i32; 3],
    /// Track row in whose lattice the positions are.
    pub track: u32,
    /// First row in the key-word section.
    pub word_first: u32,
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
    /// Zero words that close the key-word section: a record is read as three words wherever it begins, and one without
    /// bits may begin where they do.
    pub const CLOSING_WORDS: usize = 3;

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

    /// Words that hold the records of `key_count` keys.
    #[must_use]
    pub fn word_count(&self, key_count: u32) -> u64 {
        (u64::from(self.record_bits()) * u64::from(key_count)).div_ceil(32)
    }

    /// Contains the stored numbers of all keys: every number that the widths have room for, or just the raw positions.
    ///
    /// # Panics
    /// When the rows were never checked and the row breaks their rules.
    #[must_use]
    pub fn bounds(&self, words: &[u32], key_count: u32) -> Aabb {
        if self.raw == 0 {
            let ranges = [0, 1, 2].map(|k| self.lattice_range(k));
            return Aabb {
                min: ranges.map(|[least, _]| least as f32),
                max: ranges.map(|[_, greatest]| greatest as f32),
            };
        }
        let first = self.word_first as usize;
        let (points, _) = words[first..first + self.word_count(key_count) as usize].as_chunks::<3>();
        Aabb::around(points.iter().map(|point| point.map(f32::from_bits)))
    }

    /// The least and the greatest lattice coordinate that a record may hold on an axis. Widths are in range.
    pub(crate) fn lattice_range(&self, axis: usize) -> [i64; 2] {
        let least = i64::from(self.base[axis]);
        [least, least + (1 << self.widths[axis]) - 1]
    }

    /// The stored numbers of one key, counted from the segment's first: lattice coordinates, or positions where `raw`
    /// is one. What the track's map, with its lattice, makes positions of.
    ///
    /// # Panics
    /// When the rows were never checked and the record lies outside of `words`.
    #[inline(always)]
    #[must_use]
    pub fn stored(&self, words: &[u32], key: u32) -> [f32; 3] {
        let bit = u64::from(key) * u64::from(self.record_bits());
        let first = self.word_first as usize + (bit / 32) as usize;
        let words: [u32; 3] = [words[first], words[first + 1], words[first + 2]];
        if self.raw != 0 {
            return words.map(f32::from_bits);
        }
        let record = (u128::from(words[0]) | u128::from(words[1]) << 32 | u128::from(words[2]) << 64) >> (bit % 32);
        let mut record = record as u64;
        std::array::from_fn(|k| {
            let number = record & ((1 << self.widths[k]) - 1);
            record >>= self.widths[k];
            (self.base[k] + number as i32) as f32
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_are_read_back_wherever_they_begin() {
        for widths in [[0u8, 0, 0], [1, 0, 3], [7, 11, 13], [21, 21, 21], [21, 21, 20]] {
            let row = KeyVertexRow {
                base: [-5, 0, 9],
                track: 0,
                word_first: 2,
                widths,
                raw: 0,
            };
            let keys = 40u32;
            let mut bits = Vec::new();
            let value =
                |key: u32, k: usize| (u64::from(key + 1) * 2_654_435_761 * (k as u64 + 1)) & ((1 << widths[k]) - 1);
            for key in 0..keys {
                for k in 0..3 {
                    bits.extend((0..widths[k]).map(|bit| value(key, k) >> bit & 1));
                }
            }
            let mut words = vec![u32::MAX; 2];
            words.extend(
                bits.chunks(32)
                    .map(|word| word.iter().rev().fold(0u32, |sum, bit| sum << 1 | *bit as u32)),
            );
            assert_eq!(words.len() as u64, 2 + row.word_count(keys));
            words.extend([0; KeyVertexRow::CLOSING_WORDS]);
            for key in 0..keys {
                let expected = std::array::from_fn(|k| (row.base[k] + value(key, k) as i32) as f32);
                assert_eq!(row.stored(&words, key), expected, "{widths:?} key {key}");
            }
        }
    }

    #[test]
    fn bounds_contain_every_stored_number() {
        let lattice = KeyVertexRow {
            base: [-5, 0, 9],
            track: 0,
            word_first: 0,
            widths: [3, 0, 4],
            raw: 0,
        };
        let expected = Aabb {
            min: [-5.0, 0.0, 9.0],
            max: [2.0, 0.0, 24.0],
        };
        assert_eq!(lattice.bounds(&[], 7), expected);
        let raw = KeyVertexRow {
            base: [0; 3],
            word_first: 1,
            widths: [0; 3],
            raw: 1,
            ..lattice
        };
        let numbers = [f32::MAX, 1.0, -2.0, 0.0, -3.0, 4.0, 0.5, f32::MAX, f32::MAX];
        let expected = Aabb {
            min: [-3.0, -2.0, 0.0],
            max: [1.0, 4.0, 0.5],
        };
        assert_eq!(raw.bounds(&numbers.map(f32::to_bits), 2), expected);
    }

    #[test]
    fn raw_records_are_the_bits_of_three_floats() {
        let row = KeyVertexRow {
            base: [0; 3],
            track: 0,
            word_first: 1,
            widths: [0; 3],
            raw: 1,
        };
        let points = [[1.5f32, -0.0, 1e-40], [f32::MAX, 3.0, -7.25]];
        let mut words = vec![9];
        words.extend(points.as_flattened().iter().map(|x| x.to_bits()));
        for (key, point) in (0u32..).zip(points) {
            assert_eq!(row.stored(&words, key).map(f32::to_bits), point.map(f32::to_bits));
        }
        assert_eq!(row.word_count(2), 6);
    }
}
