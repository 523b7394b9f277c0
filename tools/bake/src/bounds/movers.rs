use super::pivot::pivot;
use crate::poses::SampledPose;
use restpose_formats::{
    Model,
    geom::round::f32_above,
    rows::{ClusterMorphRow, LeverRow},
};
use std::collections::BTreeMap;

/// A bone that moves vertices of a cluster, beside the cluster's own.
pub(super) struct Mover {
    pub bone: u32,
    pub lever: LeverRow,
}

/// The bones beside the cluster's own that move its vertices, ascending, with pivots and levers.
pub(super) fn movers(model: &Model, poses: &[SampledPose], bone: u32, vertices: &[u32]) -> Vec<Mover> {
    /// Sum of weights, weighed sum of positions.
    #[derive(Default)]
    struct Mass {
        weight: f64,
        moment: [f64; 3],
    }
    let mut masses: BTreeMap<u32, Mass> = BTreeMap::new();
    let influences = || {
        vertices.iter().flat_map(|vertex| {
            let position = model.vertices[*vertex as usize].position_rest;
            let influences = model.influences_of(*vertex as usize).iter();
            influences
                .filter(|influence| influence.bone != bone)
                .map(move |influence| (position, influence))
        })
    };
    for (position, influence) in influences() {
        let mass = masses.entry(influence.bone).or_default();
        let weight = f64::from(influence.weight);
        mass.weight += weight;
        mass.moment = std::array::from_fn(|k| mass.moment[k] + weight * f64::from(position[k]));
    }
    let mut levers: BTreeMap<u32, LeverRow> = masses
        .into_iter()
        .map(|(mover, mass)| {
            let center = mass.moment.map(|x| x / mass.weight);
            let own = influences().filter(|(_, influence)| influence.bone == mover);
            let spread = own.fold(0.0, |spread: f64, (position, _)| {
                (0..3).fold(spread, |spread, k| {
                    spread.max((f64::from(position[k]) - center[k]).abs())
                })
            });
            let row = LeverRow {
                pivot: pivot(poses, bone as usize, mover as usize, center, spread),
                lever: [0.0; 3],
                weight: 0.0,
                reserved: 0,
            };
            (mover, row)
        })
        .collect();
    for (position, influence) in influences() {
        if let Some(row) = levers.get_mut(&influence.bone) {
            row.weight = row.weight.max(influence.weight);
            let arm = row.arm(position, influence.weight);
            row.lever = std::array::from_fn(|k| row.lever[k].max(f32_above(arm[k])));
        }
    }
    levers.into_iter().map(|(bone, lever)| Mover { bone, lever }).collect()
}

/// The morph targets that displace these vertices, ascending, with the extent of their deltas.
pub(super) fn cluster_morphs(model: &Model, vertices: &[u32]) -> Vec<ClusterMorphRow> {
    let mut rows: BTreeMap<u32, ClusterMorphRow> = BTreeMap::new();
    for delta in vertices
        .iter()
        .flat_map(|vertex| model.morph_deltas_of(*vertex as usize))
    {
        let row = rows.entry(delta.target).or_insert(ClusterMorphRow {
            target: delta.target,
            extent: [0.0; 3],
        });
        row.extent = std::array::from_fn(|k| row.extent[k].max(delta.delta[k].abs()));
    }
    rows.into_values().collect()
}
