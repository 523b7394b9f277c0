use super::primitive::Primitive;
use restpose_runtime::build::MAX_BVH_DEPTH;

/// Whether a node with `count` primitives under `depth` inner nodes must be parted into equal halves for all below to
/// stay within [`MAX_BVH_DEPTH`].
///
/// Halving ends in single primitives after ⌈log₂ count⌉ levels. While those still fit below a child of any split, any
/// split is allowed; from the first node on where they might not, every node is halved: ⌈log₂ count⌉ then falls by one
/// with each level, so a leaf never stands deeper.
pub(super) fn must_halve(depth: usize, count: usize) -> bool {
    depth + count.next_power_of_two().trailing_zeros() as usize >= MAX_BVH_DEPTH
}

/// Sorts primitives by their centroids along one axis, those of equal ones by index; how many are in the first half.
pub(super) fn sort_into_halves(primitives: &mut [Primitive], axis: usize) -> usize {
    primitives.sort_unstable_by(|a, b| {
        let by_centroid = a.bounds().center_of(axis).total_cmp(&b.bounds().center_of(axis));
        by_centroid.then(a.id().cmp(&b.id()))
    });
    primitives.len() / 2
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The deepest leaf when each split cuts off a single primitive as long as that is allowed.
    fn deepest(depth: usize, count: usize) -> usize {
        match count {
            1 => depth,
            _ if must_halve(depth, count) => deepest(depth + 1, count.div_ceil(2)),
            _ => deepest(depth + 1, count - 1),
        }
    }

    #[test]
    fn the_worst_splits_stay_within_the_depth() {
        for count in (1..3000).chain([1 << 20, (1 << 20) + 1, 1 << 31]) {
            assert!(deepest(0, count) <= MAX_BVH_DEPTH, "{count}");
        }
        assert_eq!(deepest(0, 1 << 31), MAX_BVH_DEPTH);
        assert!(!must_halve(0, 1 << 31));
    }
}
