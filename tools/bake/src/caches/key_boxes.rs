use super::key_track::KeyTrack;
use crate::{
    bounds::FuzzyBox,
    cost::{KEYED_TRAVERSAL_COST, wide_tree},
};
use rayon::prelude::*;
use restpose_builders::bvh::WideBvh;
use restpose_formats::rows::{KeyBoxRow, WideChild, WideNodeRow, box_steps};
use std::collections::BTreeMap;

/// Boxes of a wide tree's nodes at keys: as tight as a tree's whose boxes were made for one pose.
#[derive(Clone, Debug, Default)]
pub(crate) struct KeyBoxes {
    /// Keys from one that has boxes to the next; 0 where none has any.
    pub interval: u32,
    /// Those of a node together, by keys.
    pub rows: Vec<KeyBoxRow>,
    /// Expected steps of a ray that meets the tree's bounds, mean over the keys that have boxes; without any, over the whole
    /// segment.
    pub cost: f64,
}

/// Every how many keys boxes are tried, from few to many.
const TRIED_INTERVALS: [u32; 4] = [8, 4, 2, 1];

/// Triangles that one task bounds.
const TRIANGLES_PER_TASK: usize = 2048;

/// 2⁻⁴⁰: covers the rounding of a coordinate in `f64`, relative to the greatest that it can be; far less than a step.
const PLACE_ROUNDING: f64 = 1.0 / (1u64 << 40) as f64;

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
type Boxes = Vec<FuzzyBox>;

impl<P: Fn(u32, usize) -> [f64; 3] + Sync> KeyedCluster<'_, P> {
    /// Boxes at as many keys as pay: more are taken while they save at least `worth` times as great a part of the cost as they add
    /// to the bytes. `cost` and `bytes` are what the cluster has without any.
    pub(super) fn chosen(&self, cost: f64, bytes: f64, worth: f64) -> KeyBoxes {
        let mut best = KeyBoxes {
            cost,
            ..KeyBoxes::default()
        };
        for more in self.boxes(&TRIED_INTERVALS) {
            let size = |boxes: &KeyBoxes| bytes + size_of_val(&boxes.rows[..]) as f64;
            let (saved, added) = (1.0 - more.cost / best.cost, size(&more) / size(&best) - 1.0);
            if saved > 0.0 && saved >= worth * added {
                best = more;
            }
        }
        best
    }

    /// Boxes at every so many keys, for each of the intervals.
    ///
    /// Linear in nodes and keys. The same on any number of threads.
    fn boxes(&self, intervals: &[u32]) -> Vec<KeyBoxes> {
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
        let is_task = |node: usize| below[node] <= TRIANGLES_PER_TASK;
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
                let mut out = self.fillings(intervals);
                let vertices = self.vertices_below(*node, &|_| false);
                let boxes = self.fill(*node, &vertices, &BTreeMap::new(), &mut out);
                (boxes, out)
            })
            .collect();
        let (boxes, parts): (Vec<_>, Vec<_>) = done.into_iter().unzip();
        let known: BTreeMap<usize, Boxes> = tasks.into_iter().zip(boxes).collect();
        let mut out = self.fillings(intervals);
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

    fn fillings(&self, intervals: &[u32]) -> Vec<Filling> {
        let filling = |interval: &u32| Filling {
            interval: *interval as usize,
            nodes: Vec::new(),
            rows: Vec::new(),
            cost: 0.0,
        };
        intervals.iter().map(filling).collect()
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

/// What coordinates of a [`KeyBoxRow`] are counted in.
struct PlaceFrame {
    /// The lattice of the tree.
    origin: [f64; 3],
    steps: [f64; 3],
    error: f64,
    /// Without area, boxes are compared by lengths.
    by_length: bool,
}

impl PlaceFrame {
    fn new(tree: &WideBvh, error: f64) -> Self {
        Self {
            origin: tree.bounds.min.map(f64::from),
            steps: box_steps(&tree.bounds).map(f64::from),
            error,
            by_length: tree.bounds.surface_area() <= 0.0,
        }
    }

    fn measure(&self, [x, y, z]: [f64; 3]) -> f64 {
        if self.by_length {
            x + y + z
        } else {
            2.0 * (x * y + y * z + z * x)
        }
    }
}

/// Rows that are being made, at keys in one interval from each other.
struct Filling {
    interval: usize,
    nodes: Vec<u32>,
    /// Of each of `nodes`, at all keys that have boxes.
    rows: Vec<KeyBoxRow>,
    /// Measure of all places at all those keys, times what it costs to meet one.
    cost: f64,
}

impl Filling {
    /// `places` are boxes at all keys.
    fn add_node(&mut self, node: usize, row: &WideNodeRow, frame: &PlaceFrame, places: &[Boxes]) {
        self.nodes.push(node as u32);
        for (place, (boxes, child)) in places.iter().zip(row.children()).enumerate() {
            let count = (boxes.len() - 1).div_ceil(self.interval) + 1;
            let first = (self.nodes.len() - 1) * count;
            self.rows.resize(first + count, KeyBoxRow::default());
            let mut sides = vec![[0.0; 3]; count];
            for k in 0..3 {
                let (least, greatest) = (f64::from(row.min[k][place]), f64::from(row.max[k][place]));
                let [min, max] = self.coordinates(boxes, frame, k, [least, greatest]);
                let rows = self.rows[first..].iter_mut().zip(&mut sides);
                for ((row, sides), (min, max)) in rows.zip(min.iter().zip(&max)) {
                    (row.min[k][place], row.max[k][place]) = (*min, *max);
                    let parts = f64::from(*max) - f64::from(*min);
                    sides[k] = parts / f64::from(KeyBoxRow::PARTS) * (greatest - least) * frame.steps[k];
                }
            }
            let cost = match child {
                WideChild::Node(_) => KEYED_TRAVERSAL_COST,
                WideChild::Leaf(_) | WideChild::Empty => wide_tree().intersection_cost,
            };
            self.cost += cost * sides.iter().map(|sides| frame.measure(*sides)).sum::<f64>();
        }
    }

    /// Least and greatest coordinates along an axis at the keys that have boxes, in a place that reaches from `least` to
    /// `greatest` on the lattice.
    fn coordinates(
        &self,
        boxes: &[FuzzyBox],
        frame: &PlaceFrame,
        k: usize,
        [least, greatest]: [f64; 2],
    ) -> [Vec<u8>; 2] {
        let [zero, parts] = [KeyBoxRow::ZERO, KeyBoxRow::PARTS].map(f64::from);
        let part = (greatest - least) / parts;
        // A place without length has one coordinate.
        let coordinate = |x: f64| {
            let q = ((x - frame.origin[k]) / frame.steps[k] - least) / part + zero;
            if q.is_finite() { q } else { zero }
        };
        let slack = PLACE_ROUNDING * f64::from(u16::MAX) / part.max(PLACE_ROUNDING);
        let below: Vec<f64> = boxes
            .iter()
            .map(|own| coordinate(own.min()[k] - frame.error) - slack)
            .collect();
        let above: Vec<f64> = boxes
            .iter()
            .map(|own| -(coordinate(own.max()[k] + frame.error) + slack))
            .collect();
        // The casts saturate.
        let min = polyline_below(&below, self.interval, zero);
        let max = polyline_below(&above, self.interval, -(zero + parts));
        [
            min.iter().map(|q| q.floor() as u8).collect(),
            max.iter().map(|q| (-q).ceil() as u8).collect(),
        ]
    }

    fn append(&mut self, mut other: Self) {
        self.nodes.append(&mut other.nodes);
        self.rows.append(&mut other.rows);
        self.cost += other.cost;
    }

    fn finished(self, tree: &WideBvh, key_count: usize) -> KeyBoxes {
        let count = (key_count - 1).div_ceil(self.interval) + 1;
        let mut rows = vec![KeyBoxRow::default(); count * tree.nodes.len()];
        for (node, own) in self.nodes.iter().zip(self.rows.chunks_exact(count)) {
            rows[*node as usize * count..][..count].copy_from_slice(own);
        }
        let frame = PlaceFrame::new(tree, 0.0);
        let sides = [0, 1, 2].map(|k| f64::from(tree.bounds.max[k]) - f64::from(tree.bounds.min[k]));
        let share = self.cost / frame.measure(sides) / count as f64;
        KeyBoxes {
            interval: self.interval as u32,
            rows,
            cost: KEYED_TRAVERSAL_COST + if share.is_finite() { share } else { 0.0 },
        }
    }
}

/// Every `interval`th corner of a polyline that is nowhere above that through all `numbers`, the last corner at the last number or
/// behind it. Where it would fall [too far](KeyBoxRow::ZERO) below `floor`, above which everything is known to lie, it runs along
/// the floor.
fn polyline_below(numbers: &[f64], interval: usize, floor: f64) -> Vec<f64> {
    let last = numbers.len() - 1;
    let count = last.div_ceil(interval) + 1;
    let corners: Vec<f64> = (0..count)
        .map(|corner| numbers[(corner * interval).min(last)])
        .collect();
    let mut out = corners.clone();
    for (corner, ends) in corners.windows(2).enumerate() {
        let above = (1..interval).map(|step| {
            let s = step as f64 / interval as f64;
            (1.0 - s) * ends[0] + s * ends[1] - numbers[(corner * interval + step).min(last)]
        });
        let above = above.fold(0.0, f64::max);
        out[corner] = out[corner].min(ends[0] - above);
        out[corner + 1] = out[corner + 1].min(ends[1] - above);
    }
    let least = floor - f64::from(KeyBoxRow::ZERO);
    let too_low: Vec<usize> = (0..count).filter(|corner| out[*corner] < least).collect();
    for corner in too_low {
        out[corner] = floor;
        // From there the next ones may not rise above what they were, nor above the floor.
        for near in [corner.wrapping_sub(1), corner + 1] {
            if let Some(near) = out.get_mut(near) {
                *near = near.min(floor);
            }
        }
    }
    out
}
