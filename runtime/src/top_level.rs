use crate::{
    Aabb,
    box_tree::BoxTree,
    build::BvhSettings,
    wide::{WideNode, refit},
};

/// To enter what stands in a leaf takes as long as eight steps: so leaves have one, where boxes differ at all.
const SETTINGS: BvhSettings = BvhSettings {
    traversal_cost: 1.0,
    intersection_cost: 8.0,
};

/// A wide tree in world space over a scene's instances, or an instance's clusters.
#[derive(Debug)]
pub(crate) struct TopLevel {
    builder: BoxTree,
    nodes: Vec<WideNode>,
    bounds: Aabb,
}

impl Default for TopLevel {
    fn default() -> Self {
        Self {
            builder: BoxTree::default(),
            nodes: Vec::new(),
            bounds: Aabb::EMPTY,
        }
    }
}

impl TopLevel {
    /// Builds it over `ids`, each of them named once. What has an empty box is in no leaf.
    pub(crate) fn rebuild(&mut self, ids: impl Iterator<Item = u32>, bound: impl Fn(u32) -> Aabb + Sync) {
        self.builder.rebuild(ids, bound, &SETTINGS);
        self.nodes.clear();
        self.builder.collapse(&mut self.nodes);
        self.bounds = self.nodes.first().map_or(Aabb::EMPTY, WideNode::around);
    }

    /// Takes the topology of a tree that was built over the same ids, with the boxes of now.
    ///
    /// The topology of an earlier call is kept: it is that of the same tree.
    pub(crate) fn refit(&mut self, topology: &Self, bound: impl Fn(u32) -> Aabb) {
        if self.nodes.len() != topology.nodes.len() {
            self.nodes.clone_from(&topology.nodes);
        }
        refit(&mut self.nodes, bound);
        self.bounds = self.nodes.first().map_or(Aabb::EMPTY, WideNode::around);
    }

    /// The root first; empty until built.
    pub(crate) fn nodes(&self) -> &[WideNode] {
        &self.nodes
    }

    /// Box around everything; empty where there is nothing.
    pub(crate) fn bounds(&self) -> Aabb {
        self.bounds
    }
}
