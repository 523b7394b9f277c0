use restpose_formats::rows::{KdNode, NONE, ReferenceBoxRow, box_steps};
use restpose_runtime::{Aabb, Affine, Asset, Frame, InstanceId};

/// What a cluster's traversal compares a ray with, in the cluster's local space.
#[derive(Clone, Debug)]
pub struct LocalPlanes {
    /// World from local space, rounded to `f32`.
    pub world_from_local: Affine,
    /// Root box.
    pub bounds: Aabb,
    /// Axis and position of every split plane of the fuzzy tree.
    pub splits: Vec<(usize, f32)>,
    /// Boxes of single triangles, on the lattice.
    pub boxes: Vec<ReferenceBoxRow>,
}

impl LocalPlanes {
    /// Position of a lattice plane, rounded to `f32`.
    #[must_use]
    pub fn lattice_plane(&self, axis: usize, coordinate: u16) -> f32 {
        let step = f64::from(box_steps(&self.bounds)[axis]);
        (f64::from(self.bounds.min[axis]) + f64::from(coordinate) * step) as f32
    }
}

/// Where decisions of a frame are made: triangles, cluster boxes, planes of fuzzy trees.
#[derive(Clone, Debug, Default)]
pub struct Landmarks {
    /// Posed triangles whose corners are finite.
    pub triangles: Vec<[[f32; 3]; 3]>,
    /// World boxes of clusters that have any point.
    pub world_boxes: Vec<Aabb>,
    /// Clusters without a track.
    pub local: Vec<LocalPlanes>,
}

impl Landmarks {
    /// Adds what an instance has. `palette` is its palette, `transform` its transform.
    pub fn add(&mut self, frame: &Frame, instance: InstanceId, asset: &Asset, palette: &[Affine], transform: Affine) {
        let model = asset.model();
        let posed = (0..model.triangles.len() as u32).filter_map(|triangle| frame.triangle(instance, triangle));
        self.triangles
            .extend(posed.filter(|corners| corners.as_flattened().iter().all(|x| x.is_finite())));
        for cluster in frame.clusters().filter(|cluster| cluster.instance == instance) {
            if !cluster.bounds_world.is_empty() {
                self.world_boxes.push(cluster.bounds_world);
            }
            let row = &model.clusters[cluster.cluster as usize];
            if row.track != NONE {
                continue;
            }
            let nodes = &model.kd_nodes[row.node_first as usize..][..row.node_count as usize];
            let split = |node: &restpose_formats::rows::KdNodeRow| match node.unpack() {
                KdNode::Inner { axis, split, .. } => Some((axis, split)),
                KdNode::Leaf { .. } => None,
            };
            self.local.push(LocalPlanes {
                world_from_local: transform * palette[row.bone as usize],
                bounds: row.bounds_local,
                splits: nodes.iter().filter_map(split).collect(),
                boxes: model.reference_boxes[row.reference_first as usize..][..row.reference_count as usize].to_vec(),
            });
        }
    }
}
