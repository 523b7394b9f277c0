use crate::{BakeError, Progress, assemble::row_count, cost::fuzzy_tree, motion::Carried};
use rayon::prelude::*;
use restpose_formats::{
    Model,
    geom::Aabb,
    rows::{ClusterBoneRow, ClusterRow, NONE, ReferenceBoxRow},
};
use restpose_runtime::build::{KdBuilder, KdTree};

/// Builds one cluster with its fuzzy kd-tree for every bone that carries triangles, bones ascending.
pub(crate) fn add_clusters(
    model: &mut Model,
    mut carried: Vec<Carried>,
    progress: &dyn Progress,
) -> Result<(), BakeError> {
    carried.sort_by_key(|carried| (carried.bone, carried.triangle));
    let groups: Vec<&[Carried]> = carried.chunk_by(|a, b| a.bone == b.bone).collect();
    let trees: Vec<KdTree> = groups
        .par_iter()
        .map(|group| {
            let boxes: Vec<Aabb> = group.iter().map(|carried| carried.fuzzy_box).collect();
            let mut tree = KdTree::default();
            KdBuilder::new().build(&boxes, &fuzzy_tree(), &mut tree);
            debug_assert_eq!(tree.validate(&boxes), Ok(()));
            progress.advance(group.len() as u64);
            tree
        })
        .collect();
    for (group, tree) in groups.into_iter().zip(trees) {
        let cluster_bones = cluster_bones(model, group);
        model.clusters.push(ClusterRow {
            bone: group[0].bone,
            node_first: row_count("tree nodes", model.kd_nodes.len())?,
            node_count: row_count("tree nodes", tree.nodes.len())?,
            reference_first: row_count("triangle references", model.references.len())?,
            reference_count: row_count("triangle references", tree.references.len())?,
            cluster_bone_first: row_count("cluster bones", model.cluster_bones.len())?,
            cluster_bone_count: row_count("cluster bones", cluster_bones.len())?,
            triangle_count: row_count("triangles", group.len())?,
            bounds_local: tree.bounds,
            track: NONE,
            reserved: 0,
        });
        model.kd_nodes.extend_from_slice(&tree.nodes);
        model
            .references
            .extend(tree.references.iter().map(|index| group[*index as usize].triangle));
        let boxes = tree.references.iter();
        model
            .reference_boxes
            .extend(boxes.map(|index| ReferenceBoxRow::around(&group[*index as usize].fuzzy_box, &tree.bounds)));
        model.cluster_bones.extend(cluster_bones);
    }
    row_count("tree nodes", model.kd_nodes.len())?;
    row_count("triangle references", model.references.len())?;
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
