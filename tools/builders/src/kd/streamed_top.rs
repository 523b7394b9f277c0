use super::bins::Bins;
use super::cell_cost::CellCost;
use super::cut::{Cut, cheapest_cut};
use super::fragment::{Fragment, bounds_of, sift};
use super::growth::OpenNode;
use restpose_formats::geom::Aabb;
use restpose_runtime::build::{KdSettings, KdTree};

/// A sub-tree that is still to be built.
#[derive(Debug)]
pub(super) struct Job {
    pub node: OpenNode,
    pub fragments: Vec<Fragment>,
}

/// Works off the nodes that are too large for the caches: each fragment is read once per level.
#[derive(Debug, Default)]
pub(super) struct TopLevels {
    /// Bins that no node uses.
    idle: Vec<Bins>,
}

/// A large node, its bins filled.
#[derive(Debug)]
struct LargeNode {
    node: OpenNode,
    fragments: Vec<Fragment>,
    bounds: Aabb,
    bins: Bins,
}

/// Fragments that are sifted before the children count them, while they are in the nearest cache.
const BLOCK: usize = 256;

impl TopLevels {
    /// Starts the tree at its root; the nodes of at most `job_size` fragments, left open, in the order in which a
    /// depth-first build reaches them.
    pub(super) fn grow(
        &mut self,
        fragments: impl Iterator<Item = Fragment>,
        job_size: usize,
        settings: &KdSettings,
        tree: &mut KdTree,
    ) -> Vec<Job> {
        let fragments: Vec<_> = fragments.collect();
        tree.bounds = bounds_of(&fragments);
        let node = OpenNode::root(tree.bounds, fragments.len());
        let mut bins = self.bins(&tree.bounds);
        bins.add(&fragments);
        let mut open = vec![LargeNode {
            node,
            fragments,
            bounds: tree.bounds,
            bins,
        }];
        let mut jobs = Vec::new();
        while let Some(large) = open.pop() {
            if large.fragments.len() <= job_size {
                self.idle.push(large.bins);
                jobs.push(Job {
                    node: large.node,
                    fragments: large.fragments,
                });
            } else {
                open.extend(self.split(large, settings, tree).into_iter().flatten());
            }
        }
        jobs
    }

    fn bins(&mut self, cell: &Aabb) -> Bins {
        let mut bins = self.idle.pop().unwrap_or_else(Bins::new);
        bins.lay(cell, Bins::MAX_COUNT);
        bins
    }

    /// Both children of a node, right above left; none if it became a leaf.
    fn split(&mut self, large: LargeNode, settings: &KdSettings, tree: &mut KdTree) -> Option<[LargeNode; 2]> {
        let LargeNode {
            mut node,
            mut fragments,
            bounds,
            mut bins,
        } = large;
        let count = fragments.len();
        let mut shrunk = false;
        let plane = loop {
            if std::mem::take(&mut shrunk) {
                bins.lay(&node.cell, Bins::MAX_COUNT);
                bins.add(&fragments);
            }
            let cost = CellCost::new(&node.cell, settings);
            let cut = cheapest_cut(&fragments, &node.cell, &bounds, &bins, &cost, false).map(|priced| priced.cut);
            match cut.filter(|cut| node.allows(cut.references(count))) {
                None => {
                    self.idle.push(bins);
                    node.close(&fragments, tree);
                    return None;
                }
                Some(Cut::Part { plane, .. }) => break plane,
                Some(Cut::EmptyBelow { axis, position }) => node.shrink(axis, position, true, count, tree),
                Some(Cut::EmptyAbove { axis, position }) => node.shrink(axis, position, false, count, tree),
            }
            shrunk = true;
        };
        self.idle.push(bins);
        let (mut lower, mut upper) = (node.cell, node.cell);
        lower.max[plane.axis] = plane.position;
        upper.min[plane.axis] = plane.position;
        let (mut lower_bins, mut upper_bins) = (self.bins(&lower), self.bins(&upper));
        let (mut lower_bounds, mut upper_bounds) = (Aabb::EMPTY, Aabb::EMPTY);
        let mut right = Vec::with_capacity(count);
        let mut left = 0;
        let mut block = [Fragment::default(); BLOCK];
        let mut spare = [Fragment::default(); BLOCK];
        for begin in (0..count).step_by(BLOCK) {
            let length = BLOCK.min(count - begin);
            block[..length].copy_from_slice(&fragments[begin..begin + length]);
            let [l, r] = sift(&mut block[..length], &mut spare, plane);
            fragments[left..left + l].copy_from_slice(&block[..l]);
            left += l;
            right.extend_from_slice(&spare[..r]);
            lower_bins.add(&block[..l]);
            upper_bins.add(&spare[..r]);
            lower_bounds = lower_bounds.union(bounds_of(&block[..l]));
            upper_bounds = upper_bounds.union(bounds_of(&spare[..r]));
        }
        fragments.truncate(left);
        let [below, above] = node.cut(plane.axis, plane.position, left, right.len(), tree);
        Some([
            LargeNode {
                node: below,
                fragments,
                bounds: lower_bounds,
                bins: lower_bins,
            },
            LargeNode {
                node: above,
                fragments: right,
                bounds: upper_bounds,
                bins: upper_bins,
            },
        ])
    }
}
