use restpose_builders::bvh::BvhBuilder;
use restpose_formats::geom::Aabb;
use restpose_runtime::build::{Bvh, BvhContent, BvhSettings, CheckedBoxes};

/// A fresh tree over good boxes.
pub(crate) fn built(builder: &mut dyn BvhBuilder, boxes: &[Aabb], settings: &BvhSettings) -> Bvh {
    let mut tree = Bvh::default();
    builder.build(CheckedBoxes::new(boxes).unwrap(), settings, &mut tree);
    tree
}

/// Children of an inner node.
pub(crate) fn children(tree: &Bvh, node: usize) -> Option<[usize; 2]> {
    match tree.nodes[node].content() {
        BvhContent::Inner { left } => Some([left as usize, left as usize + 1]),
        BvhContent::Leaf { .. } => None,
    }
}

/// Boxes listed below a node, ascending.
pub(crate) fn listed(tree: &Bvh, node: usize) -> Vec<u32> {
    let (mut ids, mut open) = (Vec::new(), vec![node]);
    while let Some(node) = open.pop() {
        match tree.nodes[node].content() {
            BvhContent::Leaf { first, count } => ids.extend(&tree.references[first as usize..][..count as usize]),
            BvhContent::Inner { left } => open.extend([left as usize, left as usize + 1]),
        }
    }
    ids.sort_unstable();
    ids
}

/// All that a tree holds, as bits.
pub(crate) fn bits(tree: &Bvh) -> (Vec<[u32; 6]>, Vec<BvhContent>, Vec<u32>) {
    let sides = tree.nodes.iter().map(|node| {
        let Aabb { min, max } = node.bounds();
        std::array::from_fn(|k| if k < 3 { min[k] } else { max[k - 3] }.to_bits())
    });
    let contents = tree.nodes.iter().map(|node| node.content());
    (sides.collect(), contents.collect(), tree.references.clone())
}

/// Inner nodes above each node.
pub(crate) fn depths(tree: &Bvh) -> Vec<usize> {
    let mut depths = vec![0; tree.nodes.len()];
    for node in 0..tree.nodes.len() {
        for child in children(tree, node).into_iter().flatten() {
            depths[child] = depths[node] + 1;
        }
    }
    depths
}
