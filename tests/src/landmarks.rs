use restpose_formats::{
    ModelView, TreeKind,
    rows::{ClusterRow, KdNode, NONE, ReferenceBoxRow, WideChild, WideNodeRow, box_steps},
};
use restpose_runtime::{Aabb, Affine, Asset, Frame, InstanceId};

/// What stands in a wide node's places, each with its box.
pub fn wide_boxes(node: &WideNodeRow) -> impl Iterator<Item = (WideChild, ReferenceBoxRow)> {
    node.children().enumerate().map(|(place, child)| {
        let corner = |sides: &[[u16; 8]; 3]| std::array::from_fn(|k| sides[k][place]);
        let (min, max) = (corner(&node.min), corner(&node.max));
        (child, ReferenceBoxRow { min, max })
    })
}

/// What a cluster's traversal compares a ray with, in the cluster's local space.
#[derive(Clone, Debug)]
pub struct LocalPlanes {
    /// World from local space, rounded to `f32`.
    pub world_from_local: Affine,
    /// Root box.
    pub bounds: Aabb,
    /// Axis and position of every plane between nodes of the fuzzy tree: its split planes, or the sides of their boxes.
    pub splits: Vec<(usize, f32)>,
    /// Boxes of single triangles, on the lattice.
    pub boxes: Vec<ReferenceBoxRow>,
}

impl LocalPlanes {
    fn new(model: &ModelView, row: &ClusterRow, world_from_local: Affine) -> Self {
        let mut planes = Self {
            world_from_local,
            bounds: row.bounds_local,
            splits: Vec::new(),
            boxes: Vec::new(),
        };
        match model.meta.tree {
            TreeKind::Kd => {
                let nodes = &model.kd_nodes[row.node_first as usize..][..row.node_count as usize];
                planes
                    .splits
                    .extend(nodes.iter().filter_map(|node| match node.unpack() {
                        KdNode::Inner { axis, split, .. } => Some((axis, split)),
                        KdNode::Leaf { .. } => None,
                    }));
                let rows = row.reference_first as usize..(row.reference_first + row.reference_count) as usize;
                planes.boxes.extend_from_slice(&model.reference_boxes[rows]);
            }
            TreeKind::Wide => {
                let nodes = &model.wide_nodes[row.node_first as usize..][..row.node_count as usize];
                for (child, own) in nodes.iter().flat_map(wide_boxes) {
                    if let WideChild::Leaf(_) = child {
                        planes.boxes.push(own);
                        continue;
                    }
                    for axis in 0..3 {
                        for side in [own.min[axis], own.max[axis]] {
                            planes.splits.push((axis, planes.lattice_plane(axis, side)));
                        }
                    }
                }
            }
        }
        planes
    }

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
            let world_from_local = transform * palette[row.bone as usize];
            self.local.push(LocalPlanes::new(model, row, world_from_local));
        }
    }
}
