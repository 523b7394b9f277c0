use restpose_formats::{
    TreeKind,
    geom::Aabb,
    rows::{ReferenceBoxRow, WideChild, WideNodeRow, box_steps},
};
use restpose_runtime::{
    Asset,
    build::{KdBuilder, KdSettings, KdTree},
};
use std::sync::Arc;

/// The same asset with kd-trees in place of its wide ones, over the boxes that these have: what holds for the one must hold
/// for the other.
///
/// # Panics
/// When its trees are not wide.
#[must_use]
pub fn kd_twin(asset: &Asset) -> Arc<Asset> {
    let mut model = asset.model().to_model();
    assert_eq!(model.meta.tree, TreeKind::Wide);
    model.meta.tree = TreeKind::Kd;
    let nodes = std::mem::take(&mut model.wide_nodes);
    model.node_movers.clear();
    model.key_boxes.clear();
    for track in &mut model.tracks {
        (track.box_first, track.box_interval) = (0, 0);
    }
    let triangles = std::mem::take(&mut model.references);
    for cluster in &mut model.clusters {
        let own = &triangles[cluster.reference_first as usize..][..cluster.reference_count as usize];
        let first = cluster.node_first as usize;
        let rows = leaves(&nodes[first..first + cluster.node_count as usize]);
        cluster.node_first = model.kd_nodes.len() as u32;
        cluster.reference_first = model.references.len() as u32;
        if rows.is_empty() {
            // Free motion has a list and no tree.
            model.references.extend_from_slice(own);
            model.reference_boxes.extend(own.iter().map(|_| ReferenceBoxRow {
                min: [0; 3],
                max: [0; 3],
            }));
            continue;
        }
        let bounds = cluster.bounds_local;
        let boxes: Vec<Aabb> = rows.iter().map(|(_, row)| decoded(row, &bounds)).collect();
        let mut tree = KdTree::default();
        KdBuilder::new().build(&boxes, &KdSettings::default(), &mut tree);
        cluster.node_count = tree.nodes.len() as u32;
        cluster.reference_count = tree.references.len() as u32;
        model.kd_nodes.extend_from_slice(&tree.nodes);
        let referenced = tree.references.iter().map(|place| rows[*place as usize]);
        let (triangles, boxes): (Vec<u32>, Vec<ReferenceBoxRow>) = referenced.unzip();
        model.references.extend(triangles);
        model.reference_boxes.extend(boxes);
    }
    let bytes = restpose_formats::write(&model).unwrap_or_else(|error| panic!("{error}"));
    Arc::new(Asset::from_bytes(&bytes).unwrap_or_else(|error| panic!("{error}")))
}

/// The triangles of a wide tree with their fuzzy boxes; where nodes follow the pose instead, with that of the last node
/// above that has one.
fn leaves(nodes: &[WideNodeRow]) -> Vec<(u32, ReferenceBoxRow)> {
    let mut above = vec![
        ReferenceBoxRow {
            min: [0; 3],
            max: [u16::MAX; 3],
        };
        nodes.len()
    ];
    let mut out = Vec::new();
    for (at, node) in nodes.iter().enumerate() {
        for (place, child) in node.children().enumerate() {
            let [min, max] = [&node.min, &node.max].map(|corner| corner.map(|axis| axis[place]));
            let own = match node.mover_count {
                0 => ReferenceBoxRow { min, max },
                _ => above[at],
            };
            match child {
                WideChild::Leaf(triangle) => out.push((triangle, own)),
                WideChild::Node(index) => above[index as usize] = own,
                WideChild::Empty => {}
            }
        }
    }
    out
}

/// The box of a row in a cluster's local space, no smaller, and within the cluster's.
fn decoded(row: &ReferenceBoxRow, bounds: &Aabb) -> Aabb {
    let steps = box_steps(bounds);
    let plane = |k: usize, q: u16| f64::from(bounds.min[k]) + f64::from(q) * f64::from(steps[k]);
    let outwards = |x: f64, up: bool| {
        let rounded = x as f32;
        match up {
            true if f64::from(rounded) < x => rounded.next_up(),
            false if f64::from(rounded) > x => rounded.next_down(),
            _ => rounded,
        }
    };
    Aabb {
        min: std::array::from_fn(|k| outwards(plane(k, row.min[k]), false).max(bounds.min[k])),
        max: std::array::from_fn(|k| outwards(plane(k, row.max[k]), true).min(bounds.max[k])),
    }
}
