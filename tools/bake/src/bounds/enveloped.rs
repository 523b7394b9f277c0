use super::{ClusterSpace, Poses};
use crate::{Progress, motion::Carried};
use rayon::prelude::*;
use restpose_formats::Model;

/// Gives every triangle the fuzzy box that holds in all poses of its cluster's envelopes, and returns the pose spaces,
/// bones ascending.
///
/// Complexity: per vertex, envelope and influence, not per sample.
pub(crate) fn bound_by_envelopes(
    model: &Model,
    carried: &mut [Carried],
    poses: &Poses,
    most_envelopes: usize,
    progress: &dyn Progress,
) -> Vec<ClusterSpace> {
    let mut order: Vec<usize> = (0..carried.len()).collect();
    order.sort_by_key(|place| (carried[*place].bone, carried[*place].triangle));
    let groups: Vec<&[usize]> = order.chunk_by(|a, b| carried[*a].bone == carried[*b].bone).collect();
    let bounded: Vec<_> = groups
        .par_iter()
        .map(|group| {
            let triangles: Vec<u32> = group.iter().map(|place| carried[*place].triangle).collect();
            let space = ClusterSpace::new(model, poses, carried[group[0]].bone, &triangles, most_envelopes);
            let boxes = space.fuzzy_boxes(model, &triangles);
            progress.advance(group.len() as u64);
            (space, boxes)
        })
        .collect();
    let mut spaces = Vec::with_capacity(bounded.len());
    for (group, (space, boxes)) in groups.into_iter().zip(bounded) {
        for (place, fuzzy_box) in group.iter().zip(boxes) {
            carried[*place].fuzzy_box = fuzzy_box;
        }
        spaces.push(space);
    }
    spaces
}
