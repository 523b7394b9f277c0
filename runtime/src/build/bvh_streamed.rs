use super::both::both;
use super::bvh::{Bvh, BvhNode, BvhSettings};
use super::bvh_bins::{BinCount, Bins};
use super::bvh_extent::Extent;
use super::bvh_large::{LARGE, build_large};
use super::bvh_primitive::BoxLanes;
use super::bvh_subtree::{Job, Plan};
#[cfg(feature = "parallel")]
use super::bvh_tasks::{Block, build_tasks, close_gaps};
use super::checked_boxes::CheckedBoxes;
use crate::simd::SimdLevel;
use restpose_formats::geom::Aabb;

/// Builds hierarchies by streamed binning, on the threads of the current pool (feature `parallel`); owns all scratch memory.
///
/// Guarantee: the tree depends on the boxes and settings alone, not on threads, instructions or what was built before; a
/// build over no more boxes than an earlier one into the same tree allocates nothing but for its tasks, if it has more than one.
///
/// Memory: 32 bytes per box here, and 64 for nodes and 4 for references in the tree.
///
/// Based on: Günther, *Ray Tracing of Dynamic Scenes*, 2014, §4.2.2. Differs where a choice of the dissertation was beaten
/// (measured against `FusedBvh` of the tools, which keeps to the letter; trees cost the same within 0.5 %): bins are filled
/// in a pass of their own (in the parent's parting pass 13 to 37 % longer), nodes are parted by the map of the bins (by the
/// bin's smallest centroid 1 to 3 % longer), 8 primitives or fewer by exact sweeps (by bins 30 to 35 % longer with AVX2), and
/// of more than 4096 that are all short, 2048 are binned (all of them: 6 to 14 % longer).
// Joining from below was tried in its place: boxes in Morton order, each joined with the best of 4 to 100 neighbours on either
// side, as in Meister and Bittner, *Parallel Locally-Ordered Clustering*, 2018. On even surfaces such trees cost 7 to 13 % more
// than an exact sweep's (ELEPHANT 8 to 10 %), whatever the neighbourhood and what is compared; rotations take back 1 to 2 %.
// In an uneven room they cost 18 % less, and rays took 3 to 9 % less time (those of `obvhs`). Two rounds of it, which leave 0.4
// of the boxes, under a tree from above: 98 to 100 %, but then it is again the tree from above that takes the time.
#[derive(Debug)]
pub struct StreamedBvh {
    count: BinCount,
    level: SimdLevel,
    primitives: Vec<BoxLanes>,
    /// Of builds on one thread.
    bins: Option<Box<Bins>>,
}

impl Default for StreamedBvh {
    /// [`BinCount::ACCURATE`] bins, the best instructions of this machine.
    fn default() -> Self {
        Self::new(BinCount::ACCURATE, SimdLevel::detect())
    }
}

impl StreamedBvh {
    /// A builder that owns no memory yet.
    #[must_use]
    pub fn new(count: BinCount, level: SimdLevel) -> Self {
        Self {
            count,
            level,
            primitives: Vec::new(),
            bins: None,
        }
    }

    /// Replaces `tree` by the hierarchy over `boxes`. What it promises stands at [`Bvh`].
    ///
    /// Ends on any boxes and settings. Complexity: O(n log n).
    pub fn build(&mut self, boxes: CheckedBoxes<'_>, settings: &BvhSettings, tree: &mut Bvh) {
        let boxes = boxes.get();
        let count = boxes.len();
        let (primitives, Bvh { nodes, references }) = (&mut self.primitives, &mut *tree);
        let (extent, ()) = both(
            count > LARGE,
            || {
                primitives.resize(count, BoxLanes::EMPTY);
                set_up(boxes, primitives)
            },
            || {
                references.resize(count, 0);
                nodes.resize(2 * count - 1, BvhNode::leaf(Aabb::EMPTY, 0, 0));
            },
        );
        let plan = Plan {
            level: self.level,
            count: self.count,
            settings: *settings,
        };
        let (root, below) = tree.nodes.split_at_mut(1);
        let job = Job {
            primitives: &mut self.primitives,
            references: &mut tree.references,
            first: 0,
            node: &mut root[0],
            below,
            below_first: 1,
            depth: 0,
            extent,
        };
        #[cfg(feature = "parallel")]
        if count > LARGE && rayon::current_num_threads() > 1 {
            let mut blocks = vec![Block { first: 0, count: 1 }];
            build_tasks(&plan, job, &mut blocks);
            close_gaps(&mut tree.nodes, &blocks);
            return;
        }
        let bins = self.bins.get_or_insert_with(|| Box::new(Bins::EMPTY));
        let used = build_large(&plan, job, bins);
        tree.nodes.truncate(1 + used);
    }
}

/// Fills the list of primitives and says what they are.
fn set_up(boxes: &[Aabb], primitives: &mut [BoxLanes]) -> Extent {
    let part = |(number, (boxes, primitives)): (usize, (&[Aabb], &mut [BoxLanes]))| {
        let mut extent = Extent::NONE;
        for (id, (own, primitive)) in (number * LARGE..).zip(boxes.iter().zip(primitives)) {
            *primitive = BoxLanes::new(own, id as u32);
            let longest = (0..3).map(|axis| own.max[axis] - own.min[axis]).fold(0.0, f32::max);
            extent = extent.join(&Extent {
                bounds: *primitive,
                longest,
            });
        }
        extent
    };
    #[cfg(feature = "parallel")]
    if boxes.len() > LARGE {
        use rayon::prelude::*;
        let parts = boxes.par_chunks(LARGE).zip(primitives.par_chunks_mut(LARGE));
        return parts.enumerate().map(part).reduce(|| Extent::NONE, |a, b| a.join(&b));
    }
    let parts = boxes.chunks(LARGE).zip(primitives.chunks_mut(LARGE));
    parts.enumerate().map(part).fold(Extent::NONE, |a, b| a.join(&b))
}
