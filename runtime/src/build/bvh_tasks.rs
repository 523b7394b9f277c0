use super::bvh::{BvhContent, BvhNode};
use super::bvh_bins::Bins;
use super::bvh_large::{LARGE, LargeSplit, split_large};
use super::bvh_subtree::{Job, Plan, build_subtree};
use rayon::prelude::*;

/// A range of the list of nodes that is in use.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    pub first: usize,
    pub count: usize,
}

/// Builds the tree of a job, in tasks; appends the blocks of nodes that they use, ascending.
pub(super) fn build_tasks(plan: &Plan, mut job: Job<'_>, blocks: &mut Vec<Block>) {
    let mut bins = Box::new(Bins::EMPTY);
    if job.primitives.len() <= LARGE {
        let first = job.below_first as usize;
        let count = build_subtree(plan, job, &mut bins);
        blocks.push(Block { first, count });
        return;
    }
    let Some(LargeSplit { left, sides }) = split_large(plan, &mut job, &mut bins) else {
        return;
    };
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
        extent: sides[0],
    };
    let right_job = Job {
        primitives: primitives.1,
        references: references.1,
        first: job.first + left as u32,
        node: &mut nodes.1[0],
        below: below.1,
        below_first: job.below_first + 2 + room as u32,
        depth: job.depth + 1,
        extent: sides[1],
    };
    drop(bins);
    let mut right_blocks = Vec::new();
    rayon::join(
        || build_tasks(plan, left_job, blocks),
        || build_tasks(plan, right_job, &mut right_blocks),
    );
    blocks.append(&mut right_blocks);
}

/// Moves the blocks together, on all threads.
pub(super) fn close_gaps(nodes: &mut Vec<BvhNode>, blocks: &[Block]) {
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
    let mut number = 0;
    while number < blocks.len() {
        // As many as move to where nothing is left that has to move.
        let (to, from) = (moved[number], blocks[number].first);
        let many = (number..blocks.len())
            .take_while(|next| moved[*next] + blocks[*next].count <= from)
            .count();
        if many == 0 {
            let Block { first, count } = blocks[number];
            for place in 0..count {
                nodes[to + place] = moved_node(nodes[first + place], number, blocks, &moved);
            }
        }
        let (low, high) = nodes.split_at_mut(from);
        let mut rest = &mut low[to..];
        let mut moves = Vec::with_capacity(many);
        for number in number..number + many {
            let Block { first, count } = blocks[number];
            let (room, behind) = rest.split_at_mut(count);
            moves.push((number, &high[first - from..][..count], room));
            rest = behind;
        }
        moves.into_par_iter().for_each(|(number, block, room)| {
            for (to, node) in room.iter_mut().zip(block) {
                *to = moved_node(*node, number, blocks, &moved);
            }
        });
        number += many.max(1);
    }
    nodes.truncate(end);
}

/// What a node of a block is when all blocks have moved.
fn moved_node(node: BvhNode, number: usize, blocks: &[Block], moved: &[usize]) -> BvhNode {
    let block = blocks[number];
    match node.content() {
        BvhContent::Leaf { .. } => node,
        BvhContent::Inner { left } if (left as usize) < block.first + block.count => {
            BvhNode::inner(node.bounds(), left - (block.first - moved[number]) as u32)
        }
        BvhContent::Inner { left } => {
            // Children of a node that was parted alone begin a block.
            let child = number + blocks[number..].partition_point(|block| block.first < left as usize);
            BvhNode::inner(node.bounds(), moved[child] as u32)
        }
    }
}
