mod enter;

use super::{context::ClusterContext, traveller::Traveller};
use crate::{
    Asset, InstanceId,
    posed_mesh::PosedMesh,
    prepared::Prepared,
    simd::{Lanes, prefetch},
    stats::Count,
    wide::{DEPTHS, Descent, FuzzyRay, WideNode, WideRay, WideStack},
};
use restpose_formats::rows::{NONE, WideChild, WideNodeRow};

/// An asset of up to so many triangles is taken to be in near caches, a mebibyte or so of its rows being read: there rays that take
/// turns at every node lose more than they wait.
const NEAR_TRIANGLES: usize = 1 << 15;

/// The same of the nodes of the tree over instances.
const NEAR_NODES: usize = 1 << 12;

/// A ray on its way through a scene, which it takes in steps: each ends where memory is needed that may be far, which is asked
/// for. So other rays can take theirs before it comes.
///
/// A step into an instance is up to the caller, who knows the scene.
pub(super) struct Flight<'a> {
    pub traveller: Traveller,
    /// Scaled `t` at which the ray begins.
    pub start: f32,
    pub next: Next,
    /// The tree that the ray is in.
    tree: Tree,
    /// The trees in world space that it is in, and the ray ready for them, by [depth](Tree::depth).
    world: [(&'a [WideNode], WideRay); DEPTHS],
    /// A cluster's tree in its local space.
    fuzzy: Option<(&'a [WideNodeRow], FuzzyRay<'a>)>,
    /// Pending children of all trees that it is in.
    count: usize,
    /// How many of them are of trees above the one at a depth.
    floors: [usize; DEPTHS],
    /// Whether the tree at a depth is in no near cache.
    is_far: [bool; DEPTHS],
    actor: Option<Actor<'a>>,
    supplied: Option<(InstanceId, PosedMesh<'a>)>,
    /// Whether all vertices of the instance were posed when the ray came.
    is_whole: bool,
    /// Triangles tested before it entered the instance.
    tests_before: u32,
    /// The cache row that moves the cluster, or `NONE`.
    cache: u32,
}

/// What a ray does when it is its turn again.
#[derive(Clone, Copy)]
pub(super) enum Next {
    /// The last of the pending children.
    TakePending,
    MeetNode(u32),
    /// A step of the caller's.
    FindInstance(u32),
    /// A step of the caller's.
    EnterInstance(u32),
    /// At a node of the instance's tree, its root most often.
    EnterRoot(u32),
    /// By its place in the instance.
    EnterCluster(u32),
    FindCorners(u32),
    FindStored(u32),
    TestTriangle(u32),
}

/// Where in an instance a ray goes.
#[derive(Clone, Copy)]
pub(super) enum Inside {
    All,
    /// Below a node of the tree over its clusters.
    Node(u32),
    /// By its place in the instance.
    Cluster(u32),
}

/// What a tree is over, and so what its leaves are.
#[derive(Clone, Copy, PartialEq)]
enum Tree {
    Instances,
    Clusters,
    /// Over all triangles of an instance.
    Whole,
    /// Over geometry of the caller's.
    Supplied,
    /// Over those of a cluster, in its local space.
    Fuzzy,
    /// Over those of a cluster, posed.
    Refitted,
}

impl Tree {
    #[inline(always)]
    fn depth(self) -> usize {
        match self {
            Self::Instances => 0,
            Self::Clusters | Self::Whole | Self::Supplied => 1,
            Self::Fuzzy | Self::Refitted => 2,
        }
    }
}

/// An instance that a ray is in.
#[derive(Clone, Copy)]
pub(super) struct Actor<'a> {
    pub id: InstanceId,
    pub asset: &'a Asset,
    pub prepared: &'a Prepared,
}

impl<'a> Flight<'a> {
    /// A ray at a node of the tree over instances.
    #[inline(always)]
    pub(super) fn in_scene(traveller: Traveller, start: f32, nodes: &'a [WideNode], ray: WideRay, node: u32) -> Self {
        Self {
            traveller,
            start,
            next: Next::MeetNode(node),
            tree: Tree::Instances,
            world: [(nodes, ray); DEPTHS],
            fuzzy: None,
            count: 0,
            floors: [0; DEPTHS],
            is_far: [nodes.len() > NEAR_NODES, true, true],
            actor: None,
            supplied: None,
            is_whole: false,
            tests_before: 0,
            cache: NONE,
        }
    }

    /// Goes on until memory is needed that may be far, or an instance has been found. False when the ray has landed.
    #[inline(always)]
    pub(super) fn step<const ANY: bool, S: Lanes, C: Count>(
        &mut self,
        simd: S,
        stack: &mut WideStack,
        context: &mut ClusterContext,
        counters: &mut C,
    ) -> bool {
        let mut child = None;
        match self.next {
            Next::MeetNode(node) => child = Some(node),
            Next::EnterRoot(node) => {
                let depth = self.tree.depth();
                self.world[depth].1 = self.ray_in_world(self.world[depth].0);
                child = Some(node);
            }
            Next::EnterCluster(slot) => {
                if self.enter_cluster::<ANY, C>(slot, context, counters) {
                    self.leave();
                    return false;
                }
                if self.tree != Tree::Clusters {
                    child = Some(0);
                }
            }
            Next::TestTriangle(triangle) => {
                if self.test::<ANY, S, C>(simd, triangle, counters) {
                    return false;
                }
            }
            Next::FindCorners(triangle) if self.tree == Tree::Supplied => {
                self.supplied().1.prefetch_corners(triangle);
                self.next = Next::TestTriangle(triangle);
                return true;
            }
            Next::FindCorners(triangle) => {
                let actor = self.actor();
                actor
                    .prepared
                    .prefetch_corners(actor.asset.model(), self.cache, triangle);
                self.next = if self.cache == NONE || self.is_whole || actor.prepared.is_remembered() {
                    Next::TestTriangle(triangle)
                } else {
                    Next::FindStored(triangle)
                };
                return true;
            }
            Next::FindStored(triangle) => {
                let actor = self.actor();
                actor
                    .prepared
                    .prefetch_stored(actor.asset.model(), self.cache, triangle);
                self.next = Next::TestTriangle(triangle);
                return true;
            }
            Next::TakePending | Next::FindInstance(_) | Next::EnterInstance(_) => {}
        }
        loop {
            let depth = self.tree.depth();
            let is_far = self.is_far[depth];
            let way = Descent {
                start: self.start,
                limit: self.traveller.limit,
                floor: self.floors[depth],
                is_far,
            };
            let found = if self.tree == Tree::Fuzzy {
                let Some((nodes, ray)) = &self.fuzzy else {
                    unreachable!("set where the tree is entered")
                };
                way.next(simd, nodes, ray, child, stack, &mut self.count, counters)
            } else {
                let (nodes, ray) = &self.world[depth];
                way.next(simd, nodes, ray, child, stack, &mut self.count, counters)
            };
            child = None;
            let Some(found) = found else {
                self.tree = match self.tree {
                    Tree::Instances => return false,
                    Tree::Clusters | Tree::Whole => {
                        self.leave();
                        Tree::Instances
                    }
                    Tree::Supplied => Tree::Instances,
                    Tree::Fuzzy | Tree::Refitted => Tree::Clusters,
                };
                continue;
            };
            let leaf = found & !WideChild::LEAF_BIT;
            if leaf == found {
                self.next = Next::MeetNode(found);
                return true;
            }
            match self.tree {
                Tree::Instances => {
                    self.next = Next::FindInstance(leaf);
                    return true;
                }
                Tree::Clusters => {
                    prefetch(std::slice::from_ref(&self.actor().prepared.clusters[leaf as usize]));
                    self.next = Next::EnterCluster(leaf);
                    return true;
                }
                _ if is_far => {
                    let triangles = match self.tree {
                        Tree::Supplied => self.supplied().1.triangles,
                        _ => self.actor().asset.model().triangles,
                    };
                    prefetch(std::slice::from_ref(&triangles[leaf as usize]));
                    self.next = Next::FindCorners(leaf);
                    return true;
                }
                _ => {
                    if self.test::<ANY, S, C>(simd, leaf, counters) {
                        return false;
                    }
                }
            }
        }
    }

    /// Tests a triangle; true when the search is over.
    #[inline(always)]
    fn test<const ANY: bool, S: Lanes, C: Count>(&mut self, simd: S, triangle: u32, counters: &mut C) -> bool {
        counters.triangle();
        if self.tree == Tree::Supplied {
            let (id, mesh) = self.supplied();
            return self.traveller.test(&mesh.corners(triangle), id, triangle) && ANY;
        }
        let Actor { id, asset, prepared } = self.actor();
        let corners = prepared.pose_triangle(simd, asset.model(), self.cache, triangle, counters);
        let is_over = self.traveller.test(&corners, id, triangle) && ANY;
        if is_over {
            self.leave();
        }
        is_over
    }

    #[inline(always)]
    fn supplied(&self) -> (InstanceId, PosedMesh<'a>) {
        match self.supplied {
            Some(supplied) => supplied,
            None => unreachable!("set where geometry is entered"),
        }
    }

    #[inline(always)]
    fn actor(&self) -> Actor<'a> {
        match self.actor {
            Some(actor) => actor,
            None => unreachable!("set where an instance is entered"),
        }
    }

    /// Says what the instance that the ray leaves has cost it.
    #[inline(always)]
    fn leave(&mut self) {
        if let Some(actor) = self.actor.take()
            && !self.is_whole
        {
            actor
                .prepared
                .count(self.traveller.tests.wrapping_sub(self.tests_before));
        }
    }
}
