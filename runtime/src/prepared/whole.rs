use super::Prepared;
use crate::{
    Asset,
    simd::SimdLevel,
    wide::{WideNode, append_rows, refit_triangles},
};
use restpose_formats::{TreeKind, rows::WideChild};

/// An instance of which every vertex was posed, and a tree over its posed triangles: the topology of its top level and of
/// its fuzzy trees, joined, with the boxes of this pose.
#[derive(Debug, Default)]
pub(crate) struct Whole {
    /// World space, per vertex row.
    pub positions: Vec<[f32; 3]>,
    /// Leaves are triangle rows. Empty where the file has kd-trees, which are refitted one by one, and where parts are in
    /// free motion, whose trees are over posed triangles anyway.
    pub nodes: Vec<WideNode>,
    roots: Vec<u32>,
}

impl Whole {
    /// Poses everything.
    pub(super) fn pose(&mut self, prepared: &Prepared, asset: &Asset) {
        prepared.pose_all(asset, &mut self.positions);
        let model = asset.model();
        if model.meta.tree != TreeKind::Wide || !prepared.trees.is_empty() {
            self.nodes.clear();
            return;
        }
        // Without vertex caches there is one topology.
        if self.nodes.is_empty() || !model.caches.is_empty() {
            self.join(prepared, asset);
        }
        refit_triangles(SimdLevel::detect(), &mut self.nodes, model.triangles, &self.positions);
    }

    /// Joins the topologies.
    fn join(&mut self, prepared: &Prepared, asset: &Asset) {
        let top = prepared.top_level.nodes();
        self.nodes.clear();
        self.nodes.extend_from_slice(top);
        self.roots.clear();
        for cluster in &prepared.clusters {
            let rows = asset.wide_nodes(cluster.row);
            self.roots.push(append_rows(&mut self.nodes, rows, WideChild::Leaf));
        }
        for node in &mut self.nodes[..top.len()] {
            for word in &mut node.children {
                if let WideChild::Leaf(slot) = WideChild::unpack(*word) {
                    *word = WideChild::Node(self.roots[slot as usize]).pack();
                }
            }
        }
    }
}
