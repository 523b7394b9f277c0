use crate::posed_planes::PosedPlanes;
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
    /// Axis and position of the sides of single triangles' boxes.
    pub sides: Vec<(usize, f32)>,
}

impl LocalPlanes {
    fn new(
        model: &ModelView,
        row: &ClusterRow,
        palette: &[Affine],
        morph_weights: &[f32],
        world_from_local: Affine,
    ) -> Self {
        let mut planes = Self {
            world_from_local,
            bounds: row.bounds_local,
            splits: Vec::new(),
            sides: Vec::new(),
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
                for own in &model.reference_boxes[rows] {
                    planes.sides.extend(sides(planes.fuzzy_sides(own)));
                }
            }
            TreeKind::Wide => {
                let posed = PosedPlanes::new(model, row, palette, morph_weights);
                let nodes = &model.wide_nodes[row.node_first as usize..][..row.node_count as usize];
                for node in nodes {
                    for (place, (child, own)) in wide_boxes(node).enumerate() {
                        let sides = sides(if node.mover_count == 0 {
                            planes.fuzzy_sides(&own)
                        } else {
                            posed.of_place(node, place)
                        });
                        match child {
                            WideChild::Leaf(_) => planes.sides.extend(sides),
                            WideChild::Node(_) | WideChild::Empty => planes.splits.extend(sides),
                        }
                    }
                }
            }
        }
        planes
    }

    /// Least and greatest corner of a box on the lattice of the fuzzy boxes, rounded to `f32`.
    fn fuzzy_sides(&self, own: &ReferenceBoxRow) -> [[f32; 3]; 2] {
        let steps = box_steps(&self.bounds).map(f64::from);
        [own.min, own.max].map(|corner| {
            std::array::from_fn(|k| (f64::from(self.bounds.min[k]) + f64::from(corner[k]) * steps[k]) as f32)
        })
    }
}

/// Those that can be aimed at: boxes of a pose far out may have others.
fn sides(corners: [[f32; 3]; 2]) -> impl Iterator<Item = (usize, f32)> {
    let sides = corners.into_iter().flat_map(|corner| (0..3).zip(corner));
    sides.filter(|(_, side)| side.is_finite())
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
    /// Adds what an instance has. `transform` is its transform.
    pub fn add(
        &mut self,
        frame: &Frame,
        instance: InstanceId,
        asset: &Asset,
        (palette, morph_weights): (&[Affine], &[f32]),
        transform: Affine,
    ) {
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
            let planes = LocalPlanes::new(model, row, palette, morph_weights, world_from_local);
            self.local.push(planes);
        }
    }
}
