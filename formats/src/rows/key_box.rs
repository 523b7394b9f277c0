use super::{ClusterRow, TrackRow, WideNodeRow};
use bytemuck::{Pod, Zeroable};

/// The boxes of a [`WideNodeRow`] at one key of its cluster's track.
///
/// A coordinate q of a place stands for `min + (max − min)·(q − 16)/223` in exact arithmetic, `min` and `max` being those of
/// the node's row. It may lie outside of that box, so that the boxes between two keys need not be wider than what they hold.
///
/// Between two keys that have boxes, what is below a place lies at every time in the box between theirs: each side as far from
/// the first's to the second's as the time is. In [cut intervals](super::KeyRow::CUT) boxes hold nothing.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct KeyBoxRow {
    /// Least corners: per axis, per child. Zero in empty places, here and in `max`.
    pub min: [[u8; 8]; 3],
    /// Greatest corners; not below the least.
    pub max: [[u8; 8]; 3],
}

impl KeyBoxRow {
    /// The coordinate that stands for `min`.
    pub const ZERO: f32 = 16.0;
    /// Parts into which each side of a box is divided; the coordinate of `max`, less that of `min`.
    pub const PARTS: f32 = 223.0;
}

impl TrackRow {
    /// How many keys have boxes in a segment of so many keys, at least one: one in every interval, the first at the segment's
    /// first key, the last at its last or behind it. None where nodes have boxes for the whole segment alone.
    #[must_use]
    pub fn box_key_count(&self, key_count: u32) -> u32 {
        match self.box_interval {
            0 => 0,
            interval => (key_count - 1).div_ceil(interval) + 1,
        }
    }

    /// Rows of boxes of a cluster that the track moves, in a segment of so many keys. Those of a key stand together, in the order
    /// of the nodes' rows.
    #[must_use]
    pub fn key_box_count(&self, cluster: &ClusterRow, key_count: u32) -> u64 {
        u64::from(self.box_key_count(key_count)) * u64::from(cluster.node_count)
    }
}

impl WideNodeRow {
    /// The box of a place, `[least, greatest]` per axis, in steps of the lattice, at a key whose boxes `row` has. Exact but for
    /// what `f64` rounds in a quotient and a sum.
    #[must_use]
    pub fn box_at(&self, row: &KeyBoxRow, place: usize) -> [[f64; 2]; 3] {
        [0, 1, 2].map(|k| {
            let (min, max) = (f64::from(self.min[k][place]), f64::from(self.max[k][place]));
            let [zero, parts] = [KeyBoxRow::ZERO, KeyBoxRow::PARTS].map(f64::from);
            [row.min[k][place], row.max[k][place]].map(|q| min + (max - min) * (f64::from(q) - zero) / parts)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_so_many_keys_have_boxes_and_the_last_key_is_reached() {
        let track = |box_interval| TrackRow {
            box_interval,
            ..TrackRow::default()
        };
        let counts = |interval| [1, 2, 4, 5, 6, 48].map(|keys| track(interval).box_key_count(keys));
        assert_eq!(counts(0), [0; 6]);
        assert_eq!(counts(1), [1, 2, 4, 5, 6, 48]);
        assert_eq!(counts(4), [1, 2, 2, 2, 3, 13]);
        assert_eq!(counts(u32::MAX), [1, 2, 2, 2, 2, 2]);
        assert_eq!(track(1).box_key_count(u32::MAX), u32::MAX);
    }

    #[test]
    fn coordinates_are_parts_of_the_nodes_box_and_go_a_little_beyond() {
        let mut node = WideNodeRow::EMPTY;
        let mut row = KeyBoxRow::default();
        let sides = [([1000, 1223], [16, 239]), ([1000, 1446], [0, 255]), ([7, 7], [0, 255])];
        for (k, ([least, greatest], [min, max])) in sides.into_iter().enumerate() {
            (node.min[k][5], node.max[k][5]) = (least, greatest);
            (row.min[k][5], row.max[k][5]) = (min, max);
        }
        assert_eq!(node.box_at(&row, 5), [[1000.0, 1223.0], [968.0, 1478.0], [7.0, 7.0]]);
        assert_eq!(size_of::<KeyBoxRow>(), 48);
    }
}
