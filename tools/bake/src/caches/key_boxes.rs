use super::{
    key_box_rows::{Filling, PlaceFrame},
    key_track::KeyTrack,
};
use crate::bounds::FuzzyBox;
use rayon::prelude::*;
use restpose_builders::bvh::WideBvh;
use restpose_formats::rows::{KeyBoxRow, WideChild};
use std::collections::BTreeMap;

/// Boxes of a wide tree's nodes at keys: as tight as a tree's whose boxes were made for one pose.
#[derive(Clone, Debug, Default)]
pub(crate) struct KeyBoxes {
    /// Keys from one that has boxes to the next; 0 where none has any.
    pub interval: u32,
    /// Those of a key together, by nodes.
    pub rows: Vec<KeyBoxRow>,
    /// Expected steps of a ray that meets the tree's bounds, mean over the keys that have boxes; without any, over the whole
    /// segment.
    pub cost: f64,
}

/// Every how many keys boxes are tried, from few to many.
const TRIED_INTERVALS: [u32; 4] = [8, 4, 2, 1];

/// Triangles that one task bounds, times the keys.
const BOXES_PER_TASK: usize = 1 << 17;

/// A cluster's triangles at the keys of its segment, at least two.
pub(super) struct KeyedCluster<'a, P> {
    pub tree: &'a WideBvh,
    pub track: &'a KeyTrack,
    pub key_count: usize,
    /// Vertices of its triangles, by their places in the cluster.
    pub triangles: &'a [[u32; 3]],
    /// A vertex's position at a key, in local space.
    pub local: P,
    /// Bounds how far these are from the exact ones.
    pub error: f64,
}

/// The box of what is below a node or in a place at each key, so wide that the one between two contains it at every time
/// between them.
pub(super) type Boxes = Vec<FuzzyBox>;

impl<P: Fn(u32, usize) -> [f64; 3] + Sync> KeyedCluster<'_, P> {
    /// Boxes at as many keys as pay: more are taken while they save at least `worth` times as great a part of the cost as they add
    /// to the bytes. `cost` and `bytes` are what the cluster has without any.
    pub(super) fn chosen(&self, cost: f64, bytes: f64, worth: f64) -> KeyBoxes {
        let mut best = KeyBoxes {
            cost,
            ..KeyBoxes::default()
        };
        // Where keys are few, several intervals come to the same.
        let mut intervals = TRIED_INTERVALS.to_vec();
        intervals.dedup_by_key(|interval| self.box_keys(*interval));
        // No more than all of the cost can be saved.
        let least = self.box_keys(intervals[0]) * self.tree.nodes.len() * size_of::<KeyBoxRow>();
        if worth * (least as f64 / bytes) >= 1.0 {
            return best;
        }
        for more in self.boxes(&intervals, BOXES_PER_TASK) {
            let size = |boxes: &KeyBoxes| bytes + size_of_val(&boxes.rows[..]) as f64;
            let (saved, added) = (1.0 - more.cost / best.cost, size(&more) / size(&best) - 1.0);
            if saved > 0.0 && saved >= worth * added {
                best = more;
            }
        }
        best
    }

    /// How many keys have boxes.
    fn box_keys(&self, interval: u32) -> usize {
        (self.key_count - 1).div_ceil(interval as usize) + 1
    }

    /// Boxes at every so many keys, for each of the intervals.
    ///
    /// Linear in nodes and keys. The same on any number of threads.
    fn boxes(&self, intervals: &[u32], boxes_per_task: usize) -> Vec<KeyBoxes> {
        let nodes = &self.tree.nodes;
        if nodes.is_empty() {
            return Vec::new();
        }
        // Children stand behind their parents.
        let mut below = vec![0; nodes.len()];
        for at in (0..nodes.len()).rev() {
            let held = nodes[at].children().map(|child| match child {
                WideChild::Node(child) => below[child as usize],
                _ => 1,
            });
            below[at] = held.sum::<usize>();
        }
        let fillings = || -> Vec<Filling> { intervals.iter().map(|interval| Filling::new(*interval)).collect() };
        let is_task = |node: usize| below[node] <= 8.max(boxes_per_task / self.key_count);
        let mut tasks = Vec::new();
        let mut open = vec![0];
        while let Some(at) = open.pop() {
            if is_task(at) {
                tasks.push(at);
                continue;
            }
            open.extend(nodes[at].children().filter_map(|child| match child {
                WideChild::Node(child) => Some(child as usize),
                _ => None,
            }));
        }
        let done: Vec<(Boxes, Vec<Filling>)> = tasks
            .par_iter()
            .map(|node| {
                let mut out = fillings();
                let vertices = self.vertices_below(*node, &|_| false);
                let boxes = self.fill(*node, &vertices, &BTreeMap::new(), &mut out);
                (boxes, out)
            })
            .collect();
        let (boxes, parts): (Vec<_>, Vec<_>) = done.into_iter().unzip();
        let known: BTreeMap<usize, Boxes> = tasks.into_iter().zip(boxes).collect();
        let mut out = fillings();
        if !is_task(0) {
            let vertices = self.vertices_below(0, &is_task);
            self.fill(0, &vertices, &known, &mut out);
        }
        for parts in parts {
            out.iter_mut().zip(parts).for_each(|(all, part)| all.append(part));
        }
        out.into_iter()
            .map(|filling| filling.finished(self.tree, self.key_count))
            .collect()
    }

    /// Where the vertices below a node are at all keys, but for those below nodes that are left out.
    fn vertices_below(&self, node: usize, is_left_out: &dyn Fn(usize) -> bool) -> Vertices {
        let mut vertices = Vec::new();
        let mut open = vec![node];
        while let Some(at) = open.pop() {
            for child in self.tree.nodes[at].children() {
                match child {
                    WideChild::Node(child) if is_left_out(child as usize) => {}
                    WideChild::Node(child) => open.push(child as usize),
                    WideChild::Leaf(triangle) => vertices.extend(self.triangles[triangle as usize]),
                    WideChild::Empty => {}
                }
            }
        }
        vertices.sort_unstable();
        vertices.dedup();
        let at_keys = |vertex: &u32| {
            (0..self.key_count)
                .map(|key| (self.local)(*vertex, key))
                .collect::<Vec<_>>()
        };
        Vertices {
            positions: vertices.iter().flat_map(at_keys).collect(),
            vertices,
        }
    }

    /// Fills in the rows of a node and of what is below it, but for nodes whose boxes are known. Its boxes.
    fn fill(&self, node: usize, vertices: &Vertices, known: &BTreeMap<usize, Boxes>, out: &mut [Filling]) -> Boxes {
        let row = &self.tree.nodes[node];
        let mut places = Vec::with_capacity(row.children.len());
        for child in row.children() {
            places.push(match child {
                WideChild::Node(child) => match known.get(&(child as usize)) {
                    Some(boxes) => boxes.clone(),
                    None => self.fill(child as usize, vertices, known, out),
                },
                WideChild::Leaf(triangle) => self.triangle(triangle, vertices),
                WideChild::Empty => Vec::new(),
            });
        }
        let frame = PlaceFrame::new(self.tree, self.error);
        for filling in out {
            filling.add_node(node, row, &frame, &places);
        }
        let mut all = vec![FuzzyBox::EMPTY; self.key_count];
        for boxes in &places {
            all.iter_mut().zip(boxes).for_each(|(all, own)| *all = all.union(*own));
        }
        all
    }

    fn triangle(&self, triangle: u32, vertices: &Vertices) -> Boxes {
        let corners = self.triangles[triangle as usize].map(|vertex| vertices.at_keys(vertex, self.key_count));
        let mut boxes: Boxes = Vec::with_capacity(self.key_count);
        let mut bulge_before = [0.0f64; 3];
        for key in 0..self.key_count {
            let mut own = FuzzyBox::EMPTY;
            corners.iter().for_each(|corner| own.add(corner[key]));
            let mut bulge = [0.0f64; 3];
            if key + 1 < self.key_count {
                for corner in corners {
                    let one = self.track.bulge(key, &corner[key], &corner[key + 1]);
                    bulge = std::array::from_fn(|k| bulge[k].max(one[k]));
                }
            }
            boxes.push(own.widened(std::array::from_fn(|k| bulge[k].max(bulge_before[k]))));
            bulge_before = bulge;
        }
        boxes
    }
}

/// Vertices at all keys.
#[derive(Default)]
struct Vertices {
    /// Ascending.
    vertices: Vec<u32>,
    /// Those of one at all keys together.
    positions: Vec<[f64; 3]>,
}

impl Vertices {
    fn at_keys(&self, vertex: u32, key_count: usize) -> &[[f64; 3]] {
        let place = self.vertices.partition_point(|other| *other < vertex);
        &self.positions[place * key_count..][..key_count]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use restpose_builders::bvh::WideBuilder;
    use restpose_formats::geom::{Aabb, Affine};
    use restpose_runtime::build::CheckedBoxes;

    /// Tasks end anywhere in the tree: above them leaves and nodes of others stand side by side.
    #[test]
    fn rows_do_not_depend_on_how_the_tree_is_divided() {
        const KEYS: usize = 9;
        let mut random = fastrand::Rng::with_seed(4);
        let mut point = |size: f64| -> [f64; 3] { std::array::from_fn(|_| size * random.f64()) };
        let rest: Vec<[f64; 3]> = (0..700).map(|_| point(100.0)).collect();
        let moved: Vec<Vec<[f64; 3]>> = rest
            .iter()
            .map(|p| {
                (0..KEYS)
                    .map(|_| point(2.0))
                    .map(|d| std::array::from_fn(|k| p[k] + d[k]))
                    .collect()
            })
            .collect();
        let triangles: Vec<[u32; 3]> = (0..698).map(|first| [first, first + 1, first + 2]).collect();
        let around = |triangle: &[u32; 3]| {
            let corners = triangle.iter().flat_map(|vertex| &moved[*vertex as usize]);
            Aabb::around(corners.map(|p| p.map(|x| x as f32)))
        };
        let boxes: Vec<Aabb> = triangles.iter().map(around).collect();
        let mut tree = WideBvh::default();
        let checked = CheckedBoxes::new(&boxes).expect("finite boxes");
        WideBuilder::default().build(checked, &mut tree).expect("few boxes");
        let cluster = KeyedCluster {
            tree: &tree,
            track: &KeyTrack::new(&[Affine::IDENTITY; KEYS]),
            key_count: KEYS,
            triangles: &triangles,
            local: |vertex: u32, key: usize| moved[vertex as usize][key],
            error: 0.0,
        };
        let whole = cluster.boxes(&[1, 4], usize::MAX);
        for tasks in [0, 20 * KEYS, 300 * KEYS] {
            for (divided, whole) in cluster.boxes(&[1, 4], tasks).iter().zip(&whole) {
                assert!(divided.rows == whole.rows, "{tasks}");
                // Sums of the same numbers in another order.
                assert!((divided.cost / whole.cost - 1.0).abs() < 1e-9, "{tasks}");
            }
        }
        let used = whole[0].rows.iter().filter(|row| **row != KeyBoxRow::default()).count();
        assert!(used == whole[0].rows.len() && used > 9 * 90, "{used}");
    }
}
