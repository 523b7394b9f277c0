//! That boxes at keys hold what is below them at every time between two keys, in exact arithmetic and widened by nothing.
//!
//! Written from `FORMAT.md`, sections 5.4, 6.2, 6.8 and 6.10; it shares no arithmetic with the baker or the runtime.

use crate::{
    Dyadic,
    escapes::{Frame, Point, exact},
};
use restpose_formats::{
    ModelView,
    rows::{CacheRow, ClusterRow, KeyBoxRow, NONE, SegmentRow, WideChild, WideNodeRow, box_steps},
};
use std::collections::{BTreeMap, BTreeSet};

/// A side of a box at keys that a vertex has passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PassedSide {
    /// Node row.
    pub node: u32,
    /// Place in it.
    pub place: u8,
    /// 0 for x.
    pub axis: u8,
    /// Whether it is the greatest.
    pub is_greatest: bool,
}

/// A time in a segment: a key of it that is not the last, and how much of the way to the next has passed.
#[derive(Clone, Copy, Debug)]
pub struct SegmentTime {
    /// Counted from the segment's first.
    pub key: u32,
    /// 0 to 1.
    pub weight: f32,
}

/// Sides of boxes at keys that vertices of a cluster, which has such boxes, have passed at a time of a segment of the cache.
///
/// # Panics
/// When a frame has no inverse or a number is not finite.
#[must_use]
pub fn passed_sides(
    model: &ModelView,
    (cache, segment): (&CacheRow, &SegmentRow),
    cluster: &ClusterRow,
    time: SegmentTime,
) -> BTreeSet<PassedSide> {
    let posed = Posed {
        model,
        time,
        segment,
        vertex_first: model.parts[cache.part as usize].vertex_first,
    };
    let frame = Frame::new(&posed.blended(cluster.track));
    let mut walk = Walk {
        posed,
        cluster,
        frame,
        points: BTreeMap::new(),
        passed: BTreeSet::new(),
    };
    walk.node(0, &mut BTreeSet::new());
    walk.passed
}

struct Posed<'a> {
    model: &'a ModelView<'a>,
    time: SegmentTime,
    segment: &'a SegmentRow,
    vertex_first: u32,
}

impl Posed<'_> {
    /// Both keys with their weights.
    fn keys(&self) -> [(u32, Dyadic); 2] {
        let (key, weight) = (self.time.key, f64::from(self.time.weight));
        [(key, Dyadic::from(1.0 - weight)), (key + 1, Dyadic::from(weight))]
    }

    /// Columns of a track's map at a key.
    fn map(&self, track: u32, key: u32) -> [Point; 4] {
        match self.model.tracks[track as usize].key_first {
            NONE => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]].map(exact),
            first => self.model.keys[(first + key) as usize].map().columns.map(exact),
        }
    }

    fn blended(&self, track: u32) -> [Point; 4] {
        let [(a, before), (b, after)] = self.keys();
        let [a, b] = [self.map(track, a), self.map(track, b)];
        std::array::from_fn(|j| std::array::from_fn(|k| &(&before * &a[j][k]) + &(&after * &b[j][k])))
    }

    /// Where a vertex is in the cache's space.
    fn vertex(&self, vertex: u32) -> Point {
        let row = &self.model.key_vertices[(self.segment.key_vertex_first + vertex - self.vertex_first) as usize];
        let track = &self.model.tracks[row.track as usize];
        let at_key = |(key, weight): (u32, Dyadic)| -> Point {
            let [x, y, z, t] = self.map(row.track, key);
            let stored = exact(row.stored(self.segment.key_words(self.model.key_words, key)));
            let (origin, step) = (exact(track.origin), Dyadic::from(track.step));
            let local: Point = std::array::from_fn(|k| &origin[k] + &(&step * &stored[k]));
            std::array::from_fn(|k| {
                let turned = &(&(&x[k] * &local[0]) + &(&y[k] * &local[1])) + &(&z[k] * &local[2]);
                &weight * &(&turned + &t[k])
            })
        };
        let [a, b] = self.keys().map(at_key);
        std::array::from_fn(|k| &a[k] + &b[k])
    }
}

struct Walk<'a> {
    posed: Posed<'a>,
    cluster: &'a ClusterRow,
    frame: Frame,
    /// Fuzzy positions, times the frame's scale.
    points: BTreeMap<u32, Point>,
    passed: BTreeSet<PassedSide>,
}

impl Walk<'_> {
    /// Looks at a node, by its index in the tree, and all below it; adds the vertices that are there.
    fn node(&mut self, at: u32, below: &mut BTreeSet<u32>) {
        let model = self.posed.model;
        let node = &model.wide_nodes[(self.cluster.node_first + at) as usize];
        for (place, child) in node.children().enumerate() {
            let mut held = BTreeSet::new();
            match child {
                WideChild::Node(child) => self.node(child, &mut held),
                WideChild::Leaf(triangle) => held.extend(model.triangles[triangle as usize].corners),
                WideChild::Empty => {}
            }
            for axis in 0..3 {
                self.look(at, node, (place, axis), &held);
            }
            below.append(&mut held);
        }
    }

    fn look(&mut self, at: u32, node: &WideNodeRow, (place, axis): (usize, usize), held: &BTreeSet<u32>) {
        let model = self.posed.model;
        let track = &model.tracks[self.cluster.track as usize];
        let SegmentTime { key, weight } = self.posed.time;
        let (interval, before) = (track.box_interval, key / track.box_interval);
        let row = |key: u32| &model.key_boxes[(track.box_first + key * self.cluster.node_count + at) as usize];
        let rows = [row(before), row(before + 1)];
        // Everything times the interval and what a side is divided into, so that nothing is divided.
        let passed = f64::from(key % interval) + f64::from(weight);
        let weights = [f64::from(interval) - passed, passed].map(Dyadic::from);
        let parts = Dyadic::from(f64::from(KeyBoxRow::PARTS));
        let unit = &Dyadic::from(f64::from(interval)) * &parts;
        let (min, max) = (f64::from(node.min[axis][place]), f64::from(node.max[axis][place]));
        let coordinate = |q: u8| {
            let along = &Dyadic::from(max - min) * &Dyadic::from(f64::from(q) - f64::from(KeyBoxRow::ZERO));
            &(&Dyadic::from(min) * &parts) + &along
        };
        let bounds = &self.cluster.bounds_local;
        let (zero, step) = (Dyadic::from(bounds.min[axis]), Dyadic::from(box_steps(bounds)[axis]));
        for is_greatest in [false, true] {
            let [a, b] = rows.map(|row| coordinate(if is_greatest { &row.max } else { &row.min }[axis][place]));
            let steps = &(&weights[0] * &a) + &(&weights[1] * &b);
            let plane = &(&(&zero * &unit) + &(&step * &steps)) * &self.frame.scale;
            for vertex in held {
                let (posed, frame) = (&self.posed, &self.frame);
                let points = self.points.entry(*vertex);
                let point = points.or_insert_with(|| frame.scaled_fuzzy_position(&posed.vertex(*vertex)));
                let beyond = &(&point[axis] * &unit) - &plane;
                let beyond = if is_greatest { beyond } else { -&beyond };
                if !beyond.is_negative() && !beyond.is_zero() {
                    self.passed.insert(PassedSide {
                        node: self.cluster.node_first + at,
                        place: place as u8,
                        axis: axis as u8,
                        is_greatest,
                    });
                }
            }
        }
    }
}
