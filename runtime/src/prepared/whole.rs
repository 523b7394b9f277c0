use super::Prepared;
use crate::{
    Asset,
    posed_mesh::PosedMesh,
    simd::SimdLevel,
    wide::{WideNode, append_rows, refit_triangles},
};
use restpose_formats::{ModelView, TreeKind, rows::WideChild};

/// An instance of which every vertex was posed, and a tree over its posed triangles: the topologies of its top level, of its fuzzy
/// trees, and of the trees of clusters in free motion, joined, with the boxes of this pose.
#[derive(Debug, Default)]
pub(crate) struct Whole {
    /// World space, per vertex row.
    pub positions: Vec<[f32; 3]>,
    /// Leaves are triangle rows. Empty where the file has kd-trees, which are refitted one by one.
    pub nodes: Vec<WideNode>,
    /// Cluster rows whose trees `nodes` holds, and where each has its root. Before these trees stand as many nodes as there are
    /// clusters, for the tree above them.
    clusters: Vec<(u32, u32)>,
    /// Whether trees of clusters in free motion are among them, whose topologies are of one pose.
    is_of_one_pose: bool,
    /// Wholes that this asset's instances had when it was posed, itself among them.
    pub beside: u32,
}

impl Whole {
    /// Poses everything.
    pub(super) fn pose(&mut self, prepared: &Prepared, asset: &Asset) {
        prepared.pose_all(asset, &mut self.positions);
        let model = asset.model();
        if model.meta.tree != TreeKind::Wide {
            self.nodes.clear();
            self.clusters.clear();
            return;
        }
        self.join(prepared, asset);
        refit_triangles(SimdLevel::detect(), &mut self.nodes, model.triangles, &self.positions);
    }

    /// The model's triangles as they are posed. The tree must not be empty.
    pub(crate) fn mesh<'a>(&'a self, model: &ModelView<'a>) -> PosedMesh<'a> {
        PosedMesh {
            nodes: &self.nodes,
            triangles: model.triangles,
            positions: &self.positions,
        }
    }

    /// Joins the topologies: those of the clusters, where other ones were joined last time, and the one above them, which in an
    /// asset with vertex caches is another in each pose.
    fn join(&mut self, prepared: &Prepared, asset: &Asset) {
        let rows = prepared.clusters.iter().map(|cluster| cluster.row);
        if self.is_of_one_pose || !rows.clone().eq(self.clusters.iter().map(|(row, _)| *row)) {
            self.clusters.clear();
            self.nodes.clear();
            self.nodes.resize(rows.len(), WideNode::EMPTY);
            self.is_of_one_pose = false;
            for (row, cluster) in rows.zip(&prepared.clusters) {
                let root = if let Some(tree) = prepared.tree_of(cluster) {
                    self.is_of_one_pose = true;
                    tree.append(&mut self.nodes)
                } else {
                    append_rows(&mut self.nodes, asset.wide_nodes(row), WideChild::Leaf)
                };
                self.clusters.push((row, root));
            }
        }
        let (above, top) = (&mut self.nodes[..self.clusters.len()], prepared.top_level.nodes());
        // Each of its nodes has two children or more, unless it is the only one.
        debug_assert!(top.len() <= above.len());
        above.fill(WideNode::EMPTY);
        for (node, own) in above.iter_mut().zip(top) {
            *node = *own;
            for word in &mut node.children {
                if let WideChild::Leaf(slot) = WideChild::unpack(*word) {
                    *word = WideChild::Node(self.clusters[slot as usize].1).pack();
                }
            }
        }
    }
}
