use crate::{
    BakeError, Progress, assemble::row_count, fuzzy_tree::FuzzyTreeBuilder, motion::Carried,
    posed_nodes::FollowedCluster, poses::SampledPose,
};
use rayon::prelude::*;
use restpose_formats::{
    Model, TreeKind,
    geom::Aabb,
    rows::{ClusterBoneRow, ClusterRow, NONE},
};

/// Builds one cluster with its fuzzy tree for every bone that carries triangles, bones ascending.
pub(crate) fn add_clusters(
    model: &mut Model,
    mut carried: Vec<Carried>,
    poses: &[SampledPose],
    kind: TreeKind,
    progress: &dyn Progress,
) -> Result<(), BakeError> {
    carried.sort_by_key(|carried| (carried.bone, carried.triangle));
    let groups: Vec<&[Carried]> = carried.chunk_by(|a, b| a.bone == b.bone).collect();
    let built: Vec<_> = groups
        .par_iter()
        .map_init(
            || FuzzyTreeBuilder::new(kind),
            |builder, group| {
                let boxes: Vec<Aabb> = group.iter().map(|carried| carried.fuzzy_box).collect();
                let mut tree = builder.build(&boxes);
                let cluster_bones = cluster_bones(model, group);
                let cluster = FollowedCluster {
                    model,
                    bone: group[0].bone,
                    cluster_bones: &cluster_bones,
                    poses,
                };
                tree.follow(&cluster, |place| group[place as usize].triangle);
                progress.advance(group.len() as u64);
                (boxes, tree, cluster_bones)
            },
        )
        .collect();
    for (group, (boxes, tree, cluster_bones)) in groups.into_iter().zip(built) {
        let mut cluster = ClusterRow {
            bone: group[0].bone,
            node_first: 0,
            node_count: 0,
            reference_first: 0,
            reference_count: 0,
            cluster_bone_first: row_count("cluster bones", model.cluster_bones.len())?,
            cluster_bone_count: row_count("cluster bones", cluster_bones.len())?,
            triangle_count: row_count("triangles", group.len())?,
            bounds_local: Aabb::EMPTY,
            track: NONE,
            reserved: 0,
        };
        let triangle = |place: u32| group[place as usize].triangle;
        tree.add_rows(model, &boxes, triangle, &mut cluster)?;
        model.clusters.push(cluster);
        model.cluster_bones.extend(cluster_bones);
    }
    Ok(())
}

/// The bones that move vertices of these triangles, ascending, with the box of those vertices.
fn cluster_bones(model: &Model, group: &[Carried]) -> Vec<ClusterBoneRow> {
    let mut boxes = vec![Aabb::EMPTY; model.bones.len()];
    for corner in group
        .iter()
        .flat_map(|carried| model.triangles[carried.triangle as usize].corners)
    {
        let position = model.vertices[corner as usize].position_rest;
        for influence in model.influences_of(corner as usize) {
            let bounds = &mut boxes[influence.bone as usize];
            *bounds = bounds.with_point(position);
        }
    }
    let moved = (0u32..).zip(boxes).filter(|(_, bounds)| !bounds.is_empty());
    let row = |(bone, bounds)| ClusterBoneRow {
        bone,
        bounds,
        reserved: 0,
    };
    moved.map(row).collect()
}
