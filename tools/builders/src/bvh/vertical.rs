use super::primitive::Extent;
use super::subtree::{Span, SubtreeBuilder};
use rayon::prelude::*;
use restpose_runtime::build::{BvhNode, BvhSettings};

/// A sub-tree to be built, and where to.
struct Job<'a> {
    span: Span<'a>,
    extent: Extent,
    nodes: &'a mut Vec<BvhNode>,
}

/// Builds each sub-tree on one thread, the largest first: Wald 2007, §4.1.3.
///
/// `scratch` gets the nodes of all, in order, and keeps the memory of more.
pub(super) fn build_subtrees(
    spans: Vec<(Span<'_>, Extent)>,
    settings: &BvhSettings,
    leaf_size: usize,
    scratch: &mut Vec<Vec<BvhNode>>,
) {
    if scratch.len() < spans.len() {
        scratch.resize_with(spans.len(), Vec::new);
    }
    let mut jobs: Vec<_> = spans
        .into_iter()
        .zip(scratch)
        .map(|((span, extent), nodes)| Job { span, extent, nodes })
        .collect();
    jobs.sort_by_key(|job| std::cmp::Reverse(job.span.primitives.len()));
    // Each thread takes the next job when it is done with its last.
    jobs.into_iter().par_bridge().for_each(|job| {
        SubtreeBuilder::new(settings, leaf_size).build(job.span, &job.extent, job.nodes);
    });
}
