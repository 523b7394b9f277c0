use crate::simd::{Lanes, prefetch};
use restpose_formats::rows::KeyBoxRow;

/// Boxes of the nodes of a cluster's tree at keys, and where between two of these a pose is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KeyBoxes<'a> {
    /// Those of a key together, by nodes.
    pub rows: &'a [KeyBoxRow],
    /// Nodes of the tree.
    pub node_count: u32,
    /// The key before and the key after, counted among these.
    pub keys: [u32; 2],
    /// Weight of the key after, 0 to 1.
    pub weight: f32,
}

impl<'a> KeyBoxes<'a> {
    /// Boxes of a node, by its index in the tree, at the keys before and after.
    #[inline(always)]
    fn of_node(&self, at: u32) -> [&'a KeyBoxRow; 2] {
        let row = |key: u32| key as usize * self.node_count as usize + at as usize;
        [&self.rows[row(self.keys[0])], &self.rows[row(self.keys[1])]]
    }

    /// Asks for what [`Self::planes`] reads.
    #[inline(always)]
    pub(super) fn prefetch(&self, at: u32) {
        let [before, after] = self.of_node(at);
        prefetch(std::slice::from_ref(before));
        prefetch(std::slice::from_ref(after));
    }

    /// Per axis, the least and the greatest sides of a node's eight boxes in the pose, given those that hold in all poses.
    ///
    /// Eight roundings, three relative to 255/223 of a side of these and five to 239/223; with those of the weight they are what
    /// [`cluster_frame`](crate::cluster_frame) counts with.
    // No closures: they would not be compiled for the instructions that the function around them is.
    #[inline(always)]
    pub(super) fn planes<S: Lanes>(&self, simd: S, at: u32, mut planes: [[S::F8; 2]; 3]) -> [[S::F8; 2]; 3] {
        let [before, after] = self.of_node(at);
        let (part, weight) = (simd.splat8(1.0 / KeyBoxRow::PARTS), simd.splat8(self.weight));
        let zero = simd.splat8(KeyBoxRow::ZERO);
        for k in 0..3 {
            let [least, greatest] = planes[k];
            let step = simd.mul8(simd.sub8(greatest, least), part);
            let sides = [[&before.min[k], &after.min[k]], [&before.max[k], &after.max[k]]];
            for side in 0..2 {
                let [from, to] = [simd.widen8_bytes(sides[side][0]), simd.widen8_bytes(sides[side][1])];
                let place = simd.add8(from, simd.mul8(simd.sub8(to, from), weight));
                planes[k][side] = simd.add8(least, simd.mul8(simd.sub8(place, zero), step));
            }
        }
        planes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[cfg(target_arch = "x86_64")]
    use crate::simd::Avx2;
    use crate::simd::Portable;
    use fastrand::Rng;
    use restpose_formats::{geom::round::UNIT_ROUNDOFF, rows::WideNodeRow};

    fn planes<S: Lanes>(simd: S, boxes: &KeyBoxes<'_>, at: u32, node: &WideNodeRow) -> [[[f32; 8]; 2]; 3] {
        let whole = std::array::from_fn(|k| [simd.widen8(&node.min[k]), simd.widen8(&node.max[k])]);
        boxes.planes(simd, at, whole).map(|sides| {
            sides.map(|lanes| {
                let mut out = [0.0; 8];
                simd.store8(lanes, &mut out);
                out
            })
        })
    }

    fn random_node(random: &mut Rng) -> WideNodeRow {
        let mut node = WideNodeRow::EMPTY;
        for (min, max) in node.min.iter_mut().flatten().zip(node.max.iter_mut().flatten()) {
            let size = [1, 300, u16::MAX][random.usize(..3)];
            let ends = [random.u16(..=size), random.u16(..=size)];
            (*min, *max) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        }
        node
    }

    #[test]
    fn planes_are_within_eight_roundings_of_those_between_two_keys() {
        let mut random = Rng::with_seed(3);
        for round in 0..20_000 {
            let node = random_node(&mut random);
            let (key_count, node_count) = (random.u32(2..5), 3);
            let at = random.u32(..node_count);
            let mut row = || KeyBoxRow {
                min: std::array::from_fn(|_| std::array::from_fn(|_| random.u8(..))),
                max: std::array::from_fn(|_| std::array::from_fn(|_| random.u8(..))),
            };
            let rows: Vec<KeyBoxRow> = (0..node_count * key_count).map(|_| row()).collect();
            let key = random.u32(..key_count - 1);
            let boxes = KeyBoxes {
                rows: &rows,
                node_count,
                keys: [key, key + 1],
                weight: [0.0, 1.0, random.f32()][round % 3],
            };
            let found = planes(Portable, &boxes, at, &node);
            #[cfg(target_arch = "x86_64")]
            if let Some(simd) = Avx2::new() {
                assert_eq!(planes(simd, &boxes, at, &node), found);
            }
            let row = |key: u32| &rows[(key * node_count + at) as usize];
            let weight = f64::from(boxes.weight);
            for (k, place) in (0..3).flat_map(|k| (0..8).map(move |place| (k, place))) {
                let [before, after] = [key, key + 1].map(|key| node.box_at(row(key), place)[k]);
                let side = f64::from(node.max[k][place]) - f64::from(node.min[k][place]);
                // What is rounded last is a coordinate of the lattice, which may lie a side further out than the place.
                let magnitude = f64::from(node.max[k][place]).max(239.0 / 223.0 * side);
                for end in 0..2 {
                    let exact = before[end] * (1.0 - weight) + after[end] * weight;
                    let off = (f64::from(found[k][end][place]) - exact).abs();
                    assert!(
                        off <= 8.0 * UNIT_ROUNDOFF * magnitude,
                        "round {round}: {off} of {magnitude}"
                    );
                }
            }
        }
    }
}
