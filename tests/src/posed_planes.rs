use nalgebra::{Matrix3, Vector3};
use restpose_formats::{
    ModelView,
    rows::{ClusterRow, MOVER_WEIGHTS, NodeMoverRow, RestLattice, WideNodeRow},
};
use restpose_runtime::Affine;

/// Where the boxes of a cluster's nodes with movers are in a pose, in `f64`: near enough to aim at.
pub(crate) struct PosedPlanes<'a> {
    movers: &'a [NodeMoverRow],
    lattice: RestLattice,
    /// E and d of each mover.
    motions: Vec<(Matrix3<f64>, Vector3<f64>)>,
    morphed: Vector3<f64>,
}

impl<'a> PosedPlanes<'a> {
    pub(crate) fn new(model: &ModelView<'a>, cluster: &ClusterRow, palette: &[Affine], morph_weights: &[f32]) -> Self {
        let rows = &model.cluster_bones[cluster.cluster_bone_first as usize..][..cluster.cluster_bone_count as usize];
        let map = |bone: u32| {
            let columns = palette[bone as usize].columns.map(|column| column.map(f64::from));
            (
                Matrix3::from_fn(|row, column| columns[column][row]),
                Vector3::from(columns[3]),
            )
        };
        let own = map(cluster.bone);
        // Of a map without an inverse no plane is finite.
        let inverse = own.0.try_inverse().unwrap_or_else(|| Matrix3::repeat(f64::NAN));
        let others = rows.iter().filter(|row| row.bone != cluster.bone);
        let motions = others.map(|row| {
            let (linear, translation) = map(row.bone);
            (inverse * linear - Matrix3::identity(), inverse * (translation - own.1))
        });
        let targets = model.morph_targets.iter().zip(morph_weights);
        let morphed = targets
            .map(|(target, weight)| Vector3::from(target.extent.map(|x| f64::from(x) * f64::from(weight.abs()))))
            .sum();
        Self {
            movers: model.node_movers,
            lattice: RestLattice::new(rows),
            motions: motions.collect(),
            morphed,
        }
    }

    /// Least and greatest corner of a place's box, rounded to `f32`.
    pub(crate) fn of_place(&self, node: &WideNodeRow, place: usize) -> [[f32; 3]; 2] {
        let corner = |sides: &[[u16; 8]; 3]| {
            Vector3::from_fn(|k, _| {
                f64::from(self.lattice.origin[k]) + f64::from(sides[k][place]) * f64::from(self.lattice.step)
            })
        };
        let (min, max) = (corner(&node.min), corner(&node.max));
        let (center, side) = ((min + max) * 0.5, (max - min) * 0.5 + self.morphed);
        let (mut middle, mut half) = (center, side);
        for row in node.movers(self.movers) {
            let (linear, offset) = &self.motions[row.mover as usize];
            let [weight, spread] =
                [row.weight[place], row.spread[place]].map(|parts| f64::from(parts) / f64::from(MOVER_WEIGHTS));
            let moved = linear * center + offset;
            middle += moved * weight;
            half += moved.abs() * spread + linear.abs() * side * (weight + spread);
        }
        [middle - half, middle + half].map(|corner| corner.map(|x| x as f32).into())
    }
}
