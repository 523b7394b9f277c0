use super::bvh::{Bvh, BvhContent, BvhNode, BvhSettings};
use super::bvh_bins::{BinCount, Bins};
use super::bvh_primitive::BoxLanes;
use super::bvh_split::Split;
use super::bvh_subtree::{Job, Plan, build_subtree, split_one};
use super::checked_boxes::CheckedBoxes;
use crate::simd::SimdLevel;
use restpose_formats::geom::Aabb;

/// Nodes with more primitives are parted one by one, their children in parallel; the others are one task each.
///
/// To part nodes of more than 65,536 on all threads, in chunks whose bins are merged and whose misplaced ranges trade places, took
/// 20 % longer on one thread (1M boxes), and no less on two; what it gains on many was not measured.
const TASK_PRIMITIVES: usize = 4096;

/// Builds hierarchies by streamed binning, on the threads of the current pool (feature `parallel`); owns all scratch memory.
///
/// Guarantee: the tree depends on the boxes and settings alone, not on threads, instructions or what was built before; a
/// build over no more boxes than an earlier one into the same tree allocates nothing but for its tasks, if it has more than one.
///
/// Memory: 32 bytes per box here, and 64 for nodes and 4 for references in the tree.
///
/// Based on: Günther, *Ray Tracing of Dynamic Scenes*, 2014, §4.2.2. Differs where a choice of the dissertation was beaten
/// (measured against `FusedBvh` of the tools, which keeps to the letter; trees cost the same within 0.2 %): bins are filled
/// in a pass of their own (in the parent's parting pass 13 to 37 % longer), nodes are parted by the map of the bins (by the
/// bin's smallest centroid 1 to 3 % longer), and 8 primitives or fewer by exact sweeps (by bins 30 to 35 % longer with
/// AVX2).
#[derive(Debug)]
pub struct StreamedBvh {
    count: BinCount,
    level: SimdLevel,
    primitives: Vec<BoxLanes>,
    /// Of builds that are one task.
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
        self.primitives.resize(count, BoxLanes::EMPTY);
        tree.references.resize(count, 0);
        tree.nodes.resize(2 * count - 1, BvhNode::leaf(Aabb::EMPTY, 0, 0));
        let bounds = set_up(boxes, &mut self.primitives);
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
            bounds,
        };
        let bins = self.bins.get_or_insert_with(|| Box::new(Bins::EMPTY));
        if count <= TASK_PRIMITIVES {
            let used = build_subtree(&plan, job, bins);
            tree.nodes.truncate(1 + used);
        } else {
            let mut blocks = vec![Block { first: 0, count: 1 }];
            build_tasks(&plan, job, &mut blocks);
            close_gaps(&mut tree.nodes, &blocks);
        }
    }
}

/// Fills the list of primitives; the box around all.
fn set_up(boxes: &[Aabb], primitives: &mut [BoxLanes]) -> BoxLanes {
    let part = |(number, (boxes, primitives)): (usize, (&[Aabb], &mut [BoxLanes]))| {
        let mut bounds = BoxLanes::EMPTY;
        for (id, (own, primitive)) in (number * TASK_PRIMITIVES..).zip(boxes.iter().zip(primitives)) {
            *primitive = BoxLanes::new(own, id as u32);
            bounds = bounds.union(primitive);
        }
        bounds
    };
    #[cfg(feature = "parallel")]
    if boxes.len() > TASK_PRIMITIVES {
        use rayon::prelude::*;
        let parts = boxes
            .par_chunks(TASK_PRIMITIVES)
            .zip(primitives.par_chunks_mut(TASK_PRIMITIVES));
        return parts
            .enumerate()
            .map(part)
            .reduce(|| BoxLanes::EMPTY, |a, b| a.union(&b));
    }
    let parts = boxes
        .chunks(TASK_PRIMITIVES)
        .zip(primitives.chunks_mut(TASK_PRIMITIVES));
    parts.enumerate().map(part).fold(BoxLanes::EMPTY, |a, b| a.union(&b))
}

/// A range of the list of nodes that is in use.
#[derive(Clone, Copy, Debug)]
struct Block {
    first: usize,
    count: usize,
}

/// Builds the tree of a job, in tasks; appends the blocks of nodes that they use, ascending.
fn build_tasks(plan: &Plan, mut job: Job<'_>, blocks: &mut Vec<Block>) {
    let mut bins = Box::new(Bins::EMPTY);
    if job.primitives.len() <= TASK_PRIMITIVES {
        let first = job.below_first as usize;
        let count = build_subtree(plan, job, &mut bins);
        blocks.push(Block { first, count });
        return;
    }
    let Some(Split { left, bounds }) = split_one(plan, &mut job, &mut bins) else {
        let count = job.primitives.len() as u32;
        *job.node = BvhNode::leaf(job.bounds.aabb(), job.first, count);
        for (reference, primitive) in job.references.iter_mut().zip(job.primitives.iter()) {
            *reference = primitive.id();
        }
        return;
    };
    *job.node = BvhNode::inner(job.bounds.aabb(), job.below_first);
    blocks.push(Block {
        first: job.below_first as usize,
        count: 2,
    });
    let (primitives, references) = (job.primitives.split_at_mut(left), job.references.split_at_mut(left));
    let (pair, below) = job.below.split_at_mut(2);
    let room = 2 * (left - 1);
    let (nodes, below) = (pair.split_at_mut(1), below.split_at_mut(room));
    let left_job = Job {
        primitives: primitives.0,
        references: references.0,
        first: job.first,
        node: &mut nodes.0[0],
        below: below.0,
        below_first: job.below_first + 2,
        depth: job.depth + 1,
        bounds: bounds[0],
    };
    let right_job = Job {
        primitives: primitives.1,
        references: references.1,
        first: job.first + left as u32,
        node: &mut nodes.1[0],
        below: below.1,
        below_first: job.below_first + 2 + room as u32,
        depth: job.depth + 1,
        bounds: bounds[1],
    };
    drop(bins);
    let mut right_blocks = Vec::new();
    #[cfg(feature = "parallel")]
    rayon::join(
        || build_tasks(plan, left_job, blocks),
        || build_tasks(plan, right_job, &mut right_blocks),
    );
    #[cfg(not(feature = "parallel"))]
    {
        build_tasks(plan, left_job, blocks);
        build_tasks(plan, right_job, &mut right_blocks);
    }
    blocks.append(&mut right_blocks);
}

/// Moves the blocks together.
fn close_gaps(nodes: &mut Vec<BvhNode>, blocks: &[Block]) {
    // Where each block will be.
    let mut end = 0;
    let moved: Vec<usize> = blocks
        .iter()
        .map(|block| {
            let to = end;
            end += block.count;
            to
        })
        .collect();
    for (number, (block, to)) in blocks.iter().zip(&moved).enumerate() {
        let shift = block.first - to;
        for place in 0..block.count {
            let node = nodes[block.first + place];
            nodes[to + place] = match node.content() {
                BvhContent::Leaf { .. } => node,
                BvhContent::Inner { left } if (left as usize) < block.first + block.count => {
                    BvhNode::inner(node.bounds(), left - shift as u32)
                }
                BvhContent::Inner { left } => {
                    // Children of a node that was parted alone begin a block.
                    let child = number + blocks[number..].partition_point(|block| block.first < left as usize);
                    BvhNode::inner(node.bounds(), moved[child] as u32)
                }
            };
        }
    }
    nodes.truncate(end);
}
