//! The search among bins, against its definition.

use super::super::{
    bvh_bins::{BinMap, Bins},
    bvh_primitive::{BoxLanes, half_area},
};
use super::families::FAMILIES;
use crate::simd::Portable;

/// Its cost, and it as axis and first bin above; of equal ones the lowest axis, there the highest bin.
fn by_definition(
    primitives: &[BoxLanes],
    map: &BinMap<Portable>,
    bins: usize,
    limit: f32,
) -> Option<(f32, (usize, usize))> {
    let (mut best, mut found) = (limit, None);
    for axis in 0..3 {
        for border in (1..bins).rev() {
            let side = |above: bool| {
                let own = primitives
                    .iter()
                    .filter(|own| (map.bins(Portable, own)[axis] as usize >= border) == above);
                let union = own.clone().fold(BoxLanes::EMPTY, |union, own| union.union(own));
                let count = own.count();
                (count > 0).then(|| count as f32 * half_area(Portable, union.0, [1.0; 4]))
            };
            if let (Some(below), Some(above)) = (side(false), side(true))
                && below + above < best
            {
                best = below + above;
                found = Some((best, (axis, border)));
            }
        }
    }
    found
}

#[test]
fn the_best_border_is_that_by_definition_to_the_last_bit() {
    let mut searched = 0;
    for (name, family) in FAMILIES {
        // Without the scale that keeps areas from overflowing.
        if ["huge", "tiny", "largest_and_smallest", "exponential", "unusable"].contains(&name) {
            continue;
        }
        for (seed, bins) in [2, 3, 7, 8, 9, 16, 17, 24, 63, 100, 127, 128].into_iter().enumerate() {
            let boxes = family(5 * bins, seed as u64);
            let primitives: Vec<BoxLanes> = (0..).zip(&boxes).map(|(id, own)| BoxLanes::new(own, id)).collect();
            let map = BinMap::new(Portable, &primitives, bins);
            let mut filled = Bins::EMPTY;
            // What was there before must not matter.
            filled.fill(
                Portable,
                &primitives[..3],
                &BinMap::new(Portable, &primitives[..3], 128),
            );
            filled.best_border(Portable, 128, [1.0; 4], f32::INFINITY);
            filled.fill(Portable, &primitives, &map);
            let expected = by_definition(&primitives, &map, bins, f32::INFINITY);
            let mut found = |limit| {
                let border = filled.best_border(Portable, bins, [1.0; 4], limit);
                border.map(|border| (border.axis, border.bin))
            };
            assert_eq!(
                found(f32::INFINITY),
                expected.map(|(_, border)| border),
                "{name} {bins}"
            );
            if let Some((cost, border)) = expected {
                assert_eq!(
                    (found(cost), found(cost.next_up())),
                    (None, Some(border)),
                    "{name} {bins}"
                );
                searched += 1;
            }
        }
    }
    assert!(searched > 100, "{searched}");
}
