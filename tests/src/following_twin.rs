use crate::followed_nodes::{cluster_bones, nodes, triangles_below, triangles_by_place};
use restpose_formats::{
    Model, ModelView,
    geom::Aabb,
    rows::{ClusterRow, MAX_MOVERS, MOVER_WEIGHTS, NONE, NodeMoverRow, RestLattice, WideNodeRow},
};
use restpose_runtime::Asset;
use std::{collections::BTreeSet, sync::Arc};

/// The same asset with every node following the pose that can: the baker lets few do so, and none where it does not pay,
/// but what holds for the one must hold for the other.
///
/// # Panics
/// When the file with these nodes is refused.
#[must_use]
pub fn following_twin(asset: &Asset) -> Arc<Asset> {
    let view = asset.model();
    let mut model = view.to_model();
    model.node_movers.clear();
    for cluster in view.clusters {
        follow(view, cluster, &mut model);
    }
    let bytes = restpose_formats::write(&model).unwrap_or_else(|error| panic!("{error}"));
    Arc::new(Asset::from_bytes(&bytes).unwrap_or_else(|error| panic!("{error}")))
}

fn follow(view: &ModelView, cluster: &ClusterRow, model: &mut Model) {
    let lattice = RestLattice::new(cluster_bones(view, cluster));
    let bones = cluster_bones(view, cluster).iter().map(|row| row.bone);
    let movers: Vec<u32> = bones.filter(|bone| *bone != cluster.bone).take(MAX_MOVERS).collect();
    let can_follow = cluster.track == NONE && lattice.is_usable() && !movers.is_empty();
    let below = triangles_below(nodes(view, cluster));
    for (at, node) in nodes(view, cluster).iter().enumerate() {
        let own = &mut model.wide_nodes[cluster.node_first as usize + at];
        (own.mover_first, own.mover_count) = (model.node_movers.len() as u32, 0);
        let places: Vec<BTreeSet<u32>> = triangles_by_place(node, &below).collect();
        let moves_otherwise = |vertex: usize| {
            let mut bones = view.influences_of(vertex).iter().map(|influence| influence.bone);
            bones.any(|bone| bone != cluster.bone && !movers.contains(&bone))
        };
        let corner = |triangle: &u32| view.triangles[*triangle as usize].corners;
        if !can_follow
            || places
                .iter()
                .flatten()
                .flat_map(corner)
                .any(|vertex| moves_otherwise(vertex as usize))
        {
            // Those of the file may have been others.
            if node.mover_count != 0 {
                own.mover_count = node.mover_count;
                model.node_movers.extend_from_slice(node.movers(view.node_movers));
            }
            continue;
        }
        own.mover_count = movers.len() as u32;
        let mut rows: Vec<NodeMoverRow> = (0..movers.len() as u32)
            .map(|mover| NodeMoverRow {
                mover,
                ..NodeMoverRow::default()
            })
            .collect();
        for (place, triangles) in places.iter().enumerate() {
            let vertices: Vec<usize> = triangles
                .iter()
                .flat_map(corner)
                .map(|vertex| vertex as usize)
                .collect();
            set_place(view, &lattice, own, place, &vertices);
            for (row, mover) in rows.iter_mut().zip(&movers) {
                (row.weight[place], row.spread[place]) = weight_and_spread(view, *mover, &vertices);
            }
        }
        model.node_movers.extend(rows);
    }
}

fn set_place(view: &ModelView, lattice: &RestLattice, node: &mut WideNodeRow, place: usize, vertices: &[usize]) {
    let rest = Aabb::around(vertices.iter().map(|vertex| view.vertices[*vertex].position_rest));
    let [min, max] = lattice.around(&rest);
    for k in 0..3 {
        (node.min[k][place], node.max[k][place]) = (min[k], max[k]);
    }
}

/// Not the smallest spread: the middle is rounded down.
fn weight_and_spread(view: &ModelView, mover: u32, vertices: &[usize]) -> (u16, u16) {
    let parts = vertices.iter().map(|vertex| {
        let influences = view
            .influences_of(*vertex)
            .iter()
            .filter(|influence| influence.bone == mover);
        influences.map(|influence| f64::from(influence.weight)).sum::<f64>() * f64::from(MOVER_WEIGHTS)
    });
    let (least, greatest) = parts.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), x| (a.min(x), b.max(x)));
    // The casts saturate.
    let weight = least.midpoint(greatest).floor() as u16;
    let off = (greatest - f64::from(weight)).max(f64::from(weight) - least);
    (weight, off.ceil() as u16)
}
