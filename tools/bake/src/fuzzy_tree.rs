//! The trees over the fuzzy boxes of a cluster, of either kind, and their rows.

use crate::{
    BakeError,
    assemble::row_count,
    cost::{fuzzy_tree, wide_tree},
    posed_nodes::FollowedCluster,
};
use restpose_builders::bvh::{WideBuilder, WideBvh};
use restpose_formats::{
    Model, TreeKind,
    geom::Aabb,
    rows::{ClusterRow, KdNodeRow, NodeMoverRow, ReferenceBoxRow, WideChild, WideNodeRow},
};
use restpose_runtime::build::{CheckedBoxes, KdBuilder, KdTree, sah_cost};

/// A tree over the fuzzy boxes of one cluster.
#[derive(Clone, Debug)]
pub(crate) enum FuzzyTree {
    Kd(KdTree),
    /// With the movers of its nodes.
    Wide(WideBvh, Vec<NodeMoverRow>),
}

/// Builds trees of one kind; keeps its memory from one to the next.
pub(crate) struct FuzzyTreeBuilder {
    kind: TreeKind,
    kd: KdBuilder,
    wide: WideBuilder,
}

impl FuzzyTreeBuilder {
    pub(crate) fn new(kind: TreeKind) -> Self {
        Self {
            kind,
            kd: KdBuilder::new(),
            wide: WideBuilder::default(),
        }
    }

    /// The tree over `boxes`, none of which is empty.
    pub(crate) fn build(&mut self, boxes: &[Aabb]) -> FuzzyTree {
        match self.kind {
            TreeKind::Kd => {
                let mut tree = KdTree::default();
                self.kd.build(boxes, &fuzzy_tree(), &mut tree);
                debug_assert_eq!(tree.validate(boxes), Ok(()));
                FuzzyTree::Kd(tree)
            }
            TreeKind::Wide => {
                let finite: Vec<Aabb> = boxes.iter().map(finite).collect();
                let mut tree = WideBvh::default();
                let built = CheckedBoxes::new(&finite).map(|checked| self.wide.build(checked, &mut tree));
                // What is refused, no box or too many of them, leaves a tree without nodes, which the format refuses.
                debug_assert!(built != Ok(Ok(())) || tree.validate(&finite) == Ok(()));
                FuzzyTree::Wide(tree, Vec::new())
            }
        }
    }
}

impl FuzzyTree {
    /// Lets boxes of nodes follow the pose where that pays; of kd-trees none can. `triangle` says which row of a triangle a box
    /// is of.
    pub(crate) fn follow(&mut self, cluster: &FollowedCluster, triangle: impl Fn(u32) -> u32) {
        if let Self::Wide(tree, movers) = self {
            *movers = cluster.follow(tree, triangle);
        }
    }

    pub(crate) fn bounds(&self) -> Aabb {
        match self {
            Self::Kd(tree) => tree.bounds,
            Self::Wide(tree, _) => tree.bounds,
        }
    }

    /// Expected steps of a ray that meets the tree's bounds.
    pub(crate) fn cost(&self) -> f64 {
        match self {
            Self::Kd(tree) => sah_cost(&tree.nodes, &tree.bounds, &fuzzy_tree()),
            Self::Wide(tree, _) => tree.sah_cost(&wide_tree()),
        }
    }

    /// Bytes of its rows in the file.
    pub(crate) fn byte_count(&self) -> usize {
        let reference = size_of::<u32>();
        match self {
            Self::Kd(tree) => {
                tree.nodes.len() * size_of::<KdNodeRow>()
                    + tree.references.len() * (reference + size_of::<ReferenceBoxRow>())
            }
            Self::Wide(tree, movers) => {
                tree.nodes.len() * size_of::<WideNodeRow>()
                    + size_of_val(&movers[..])
                    + tree.references.len() * reference
            }
        }
    }

    /// Adds its rows to `model`, where `boxes` are those that it was built over and `triangle` says which row of a triangle a
    /// box is of. Fills in what `cluster` says of them.
    ///
    /// # Errors
    /// [`BakeError::TooMany`], where rows cannot be counted.
    pub(crate) fn add_rows(
        &self,
        model: &mut Model,
        boxes: &[Aabb],
        triangle: impl Fn(u32) -> u32,
        cluster: &mut ClusterRow,
    ) -> Result<(), BakeError> {
        let (nodes, references) = match self {
            Self::Kd(tree) => (model.kd_nodes.len(), &tree.references),
            Self::Wide(tree, _) => (model.wide_nodes.len(), &tree.references),
        };
        cluster.node_first = row_count("tree nodes", nodes)?;
        cluster.reference_first = row_count("triangle references", model.references.len())?;
        cluster.reference_count = row_count("triangle references", references.len())?;
        cluster.bounds_local = self.bounds();
        model.references.extend(references.iter().map(|place| triangle(*place)));
        row_count("triangle references", model.references.len())?;
        match self {
            Self::Kd(tree) => {
                cluster.node_count = row_count("tree nodes", tree.nodes.len())?;
                model.kd_nodes.extend_from_slice(&tree.nodes);
                row_count("tree nodes", model.kd_nodes.len())?;
                let boxes = references.iter().map(|place| &boxes[*place as usize]);
                model
                    .reference_boxes
                    .extend(boxes.map(|fuzzy| ReferenceBoxRow::around(fuzzy, &tree.bounds)));
            }
            Self::Wide(tree, movers) => {
                cluster.node_count = row_count("tree nodes", tree.nodes.len())?;
                let first = model.wide_nodes.len();
                model.wide_nodes.extend_from_slice(&tree.nodes);
                row_count("tree nodes", model.wide_nodes.len())?;
                let first_mover = row_count("movers of tree nodes", model.node_movers.len())?;
                model.node_movers.extend_from_slice(movers);
                row_count("movers of tree nodes", model.node_movers.len())?;
                for node in &mut model.wide_nodes[first..] {
                    node.mover_first += first_mover;
                }
                for word in model.wide_nodes[first..].iter_mut().flat_map(|node| &mut node.children) {
                    if let WideChild::Leaf(place) = WideChild::unpack(*word) {
                        *word = leaf_of(triangle(place))?;
                    }
                }
            }
        }
        Ok(())
    }
}

fn leaf_of(triangle: u32) -> Result<u32, BakeError> {
    if triangle <= WideChild::MAX_INDEX {
        Ok(WideChild::Leaf(triangle).pack())
    } else {
        Err(BakeError::TooMany {
            what: "triangles in wide trees",
            found: u64::from(triangle) + 1,
        })
    }
}

/// The box, cut off at the ends of `f32`; an axis with a NaN side reaches from one to the other.
fn finite(bounds: &Aabb) -> Aabb {
    let mut out = *bounds;
    for k in 0..3 {
        if out.min[k].is_nan() || out.max[k].is_nan() {
            (out.min[k], out.max[k]) = (f32::MIN, f32::MAX);
        }
        out.min[k] = out.min[k].clamp(f32::MIN, f32::MAX);
        out.max[k] = out.max[k].clamp(f32::MIN, f32::MAX);
    }
    out
}
