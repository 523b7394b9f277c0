use rayon::prelude::*;
use restpose_formats::geom::Aabb;
use restpose_runtime::build::{Bvh, BvhContent, BvhFault, BvhNode, CheckedBoxes};

/// Keeps the nodes and references of `tree` and makes its boxes anew from `boxes`, bottom up.
///
/// Guarantee: a tree that was valid for as many boxes is valid for these.
///
/// # Errors
/// A [`BvhFault`] where nodes, references or boxes are not there; the tree's boxes are then partly old, partly new. Not
/// all that makes a tree invalid is noticed: [`Bvh::validate`] does that.
///
/// Source: Günther, *Ray Tracing of Dynamic Scenes*, 2014, §2.3.
pub fn refit(tree: &mut Bvh, boxes: CheckedBoxes<'_>) -> Result<(), BvhFault> {
    let boxes = boxes.get();
    check_all_listed(tree, boxes)?;
    for index in (0..tree.nodes.len()).rev() {
        tree.nodes[index] = match tree.nodes[index].content() {
            BvhContent::Leaf { first, count } => leaf(index, first, count, &tree.references, boxes)?,
            BvhContent::Inner { left } => inner(index, left, &tree.nodes)?,
        };
    }
    Ok(())
}

/// [`refit`] with the leaves, which look boxes up, on all threads of the current pool; inner nodes, which lie in the order
/// that they are needed in, on one.
///
/// # Errors
/// As [`refit`], though perhaps for another fault where there are several.
pub fn refit_parallel(tree: &mut Bvh, boxes: CheckedBoxes<'_>) -> Result<(), BvhFault> {
    let boxes = boxes.get();
    check_all_listed(tree, boxes)?;
    let references = &tree.references[..];
    tree.nodes.par_iter_mut().enumerate().try_for_each(|(index, node)| {
        if let BvhContent::Leaf { first, count } = node.content() {
            *node = leaf(index, first, count, references, boxes)?;
        }
        Ok(())
    })?;
    for index in (0..tree.nodes.len()).rev() {
        if let BvhContent::Inner { left } = tree.nodes[index].content() {
            tree.nodes[index] = inner(index, left, &tree.nodes)?;
        }
    }
    Ok(())
}

fn check_all_listed(tree: &Bvh, boxes: &[Aabb]) -> Result<(), BvhFault> {
    let listed = tree.references.len();
    if tree.nodes.is_empty() {
        Err(BvhFault::NoNodes)
    } else if listed < boxes.len() {
        // A valid tree lists each box up to the number of its references.
        Err(BvhFault::BoxNotListedOnce { id: listed, times: 0 })
    } else {
        Ok(())
    }
}

fn leaf(node: usize, first: u32, count: u32, references: &[u32], boxes: &[Aabb]) -> Result<BvhNode, BvhFault> {
    let fault = BvhFault::ReferencesOutOfRange {
        node,
        first,
        count,
        available: references.len(),
    };
    let behind = references.get(first as usize..).ok_or_else(|| fault.clone())?;
    let mut bounds = Aabb::EMPTY;
    for id in behind.get(..count as usize).ok_or(fault)? {
        let own = boxes.get(*id as usize).ok_or(BvhFault::UnknownBox {
            node,
            id: *id,
            box_count: boxes.len(),
        })?;
        bounds = bounds.union(*own);
    }
    Ok(BvhNode::leaf(bounds, first, count))
}

fn inner(node: usize, left: u32, nodes: &[BvhNode]) -> Result<BvhNode, BvhFault> {
    let fault = BvhFault::ChildOutOfRange {
        node,
        left,
        node_count: nodes.len(),
    };
    match nodes.get(left as usize..) {
        Some([a, b, ..]) if left as usize > node => Ok(BvhNode::inner(a.bounds().union(b.bounds()), left)),
        _ => Err(fault),
    }
}
