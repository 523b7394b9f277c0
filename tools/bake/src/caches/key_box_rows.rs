//! Rows of boxes at keys: coordinates that keep what is below a box inside of it all the way from one key to the next.

use super::key_boxes::{Boxes, KeyBoxes};
use crate::{
    bounds::FuzzyBox,
    cost::{KEYED_TRAVERSAL_COST, wide_tree},
};
use restpose_builders::bvh::WideBvh;
use restpose_formats::rows::{KeyBoxRow, WideChild, WideNodeRow, box_steps};

/// 2⁻⁴⁰: covers the rounding of a coordinate in `f64`, relative to the greatest that it can be; far less than a step.
const PLACE_ROUNDING: f64 = 1.0 / (1u64 << 40) as f64;

/// What coordinates of a [`KeyBoxRow`] are counted in.
pub(super) struct PlaceFrame {
    /// The lattice of the tree.
    origin: [f64; 3],
    steps: [f64; 3],
    error: f64,
    /// Without area, boxes are compared by lengths.
    by_length: bool,
}

impl PlaceFrame {
    pub(super) fn new(tree: &WideBvh, error: f64) -> Self {
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
pub(super) struct Filling {
    interval: usize,
    nodes: Vec<u32>,
    /// Of each of `nodes`, at all keys that have boxes.
    rows: Vec<KeyBoxRow>,
    /// Measure of all places at all those keys, times what it costs to meet one.
    cost: f64,
}

impl Filling {
    pub(super) fn new(interval: u32) -> Self {
        Self {
            interval: interval as usize,
            nodes: Vec::new(),
            rows: Vec::new(),
            cost: 0.0,
        }
    }

    /// `places` are boxes at all keys.
    pub(super) fn add_node(&mut self, node: usize, row: &WideNodeRow, frame: &PlaceFrame, places: &[Boxes]) {
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

    pub(super) fn append(&mut self, mut other: Self) {
        self.nodes.append(&mut other.nodes);
        self.rows.append(&mut other.rows);
        self.cost += other.cost;
    }

    pub(super) fn finished(self, tree: &WideBvh, key_count: usize) -> KeyBoxes {
        let count = (key_count - 1).div_ceil(self.interval) + 1;
        let mut rows = vec![KeyBoxRow::default(); count * tree.nodes.len()];
        for (node, own) in self.nodes.iter().zip(self.rows.chunks_exact(count)) {
            for (of_key, row) in rows.chunks_exact_mut(tree.nodes.len()).zip(own) {
                of_key[*node as usize] = *row;
            }
        }
        let frame = PlaceFrame::new(tree, 0.0);
        let sides = [0, 1, 2].map(|k| f64::from(tree.bounds.max[k]) - f64::from(tree.bounds.min[k]));
        let share = self.cost / frame.measure(sides) / count as f64;
        KeyBoxes {
            interval: self.interval as u32,
            rows,
            cost: KEYED_TRAVERSAL_COST + if share.is_finite() { share } else { f64::INFINITY },
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Nowhere above what may not be cut off: the numbers, between which it is as straight as what they stand for, or the floor.
    #[test]
    fn polylines_are_below_the_numbers_or_the_floor_and_within_coordinates() {
        let mut random = fastrand::Rng::with_seed(9);
        let (mut along_floor, mut touching) = (0, 0);
        for round in 0..20_000 {
            let (interval, count) = (random.usize(1..10), random.usize(2..31));
            let floor = f64::from([KeyBoxRow::ZERO, -KeyBoxRow::ZERO - KeyBoxRow::PARTS][round % 2]);
            let height = [0.0, 3.0, 40.0, 200.0][random.usize(..4)];
            // What is rounded may come out below the floor.
            let mut number = || floor - 1e-6 + height * random.f64();
            let numbers: Vec<f64> = (0..count).map(|_| number()).collect();
            let corners = polyline_below(&numbers, interval, floor);
            assert_eq!(corners.len(), (count - 1).div_ceil(interval) + 1);
            let least = floor - f64::from(KeyBoxRow::ZERO);
            assert!(
                corners.iter().all(|corner| *corner >= least),
                "round {round}: {corners:?}"
            );
            for eighth in 0..=8 * (count - 1) {
                let (at, key) = (eighth as f64 / 8.0, (eighth / 8).min(count - 2));
                let between = |ends: [f64; 2], s: f64| (1.0 - s) * ends[0] + s * ends[1];
                let number = between([numbers[key], numbers[key + 1]], at - key as f64);
                let corner = (key / interval).min(corners.len() - 2);
                let s = (at - (corner * interval) as f64) / interval as f64;
                let line = between([corners[corner], corners[corner + 1]], s);
                assert!(
                    line <= number.max(floor) + 1e-9,
                    "round {round} at {at}: {line} above {number}"
                );
                touching += usize::from(line >= number - 1e-9);
            }
            along_floor += usize::from(corners.contains(&floor));
        }
        assert!(along_floor > 1_000 && touching > 50_000, "{along_floor}, {touching}");
    }
}
