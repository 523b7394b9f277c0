//! Passes over long lists that all threads share: Wald 2007, §4.1.
//!
//! Lists are cut into blocks of one length, whatever the number of threads, and what blocks find is joined in an order
//! that does not matter: bounds and counts.

use super::primitive::{Extent, Primitive, list_boxes};
use rayon::prelude::*;
use restpose_formats::geom::Aabb;

/// Primitives per block, 128 KiB: blocks enough for all threads in rather small nodes, and each worth handing out.
pub(super) const BLOCK: usize = 1 << 12;

/// [`list_boxes`] on all threads.
pub(super) fn list_boxes_in_blocks(boxes: &[Aabb], list: &mut [Primitive]) -> Extent {
    boxes
        .par_chunks(BLOCK)
        .zip(list.par_chunks_mut(BLOCK))
        .enumerate()
        .map(|(block, (boxes, list))| list_boxes(boxes, block * BLOCK, list))
        .reduce(|| Extent::EMPTY, |a, b| a.union(&b))
}

/// Copies primitives to `to` grouped by key, in order of keys and else as they were.
///
/// `counts` tells for each block of `from` how many of its primitives have each key. `take` gives a primitive's key and may
/// note what it sees in a state of its own for each block; these are returned.
pub(super) fn distribute<S: Default + Send>(
    from: &[Primitive],
    to: &mut [Primitive],
    counts: &[Vec<usize>],
    take: impl Fn(&mut S, &Primitive) -> usize + Sync,
) -> Vec<S> {
    let key_count = counts.first().map_or(0, Vec::len);
    let mut shelves: Vec<Vec<&mut [Primitive]>> = counts.iter().map(|_| Vec::with_capacity(key_count)).collect();
    let mut rest = to;
    for key in 0..key_count {
        for (shelf, counts) in shelves.iter_mut().zip(counts) {
            let (own, behind) = rest.split_at_mut(counts[key]);
            shelf.push(own);
            rest = behind;
        }
    }
    from.par_chunks(BLOCK)
        .zip(shelves)
        .map(|(block, shelf)| fill_shelf(block, shelf, &take))
        .collect()
}

fn fill_shelf<S: Default>(
    block: &[Primitive],
    mut shelf: Vec<&mut [Primitive]>,
    take: impl Fn(&mut S, &Primitive) -> usize,
) -> S {
    let mut state = S::default();
    let mut filled = vec![0; shelf.len()];
    for primitive in block {
        let key = take(&mut state, primitive);
        shelf[key][filled[key]] = *primitive;
        filled[key] += 1;
    }
    state
}
