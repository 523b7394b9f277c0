//! The surface area heuristic: what a tree is expected to cost a ray.
//!
//! Based on: Günther, *Ray Tracing of Dynamic Scenes*, 2014, §4.1.1.

use restpose_formats::geom::Aabb;
use restpose_formats::rows::{KdNode, KdNodeRow, MAX_KD_DEPTH};

/// Constants of the cost model. Only their ratios matter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KdSettings {
    /// Cost of visiting an inner node, K_Trav. Default 1.
    pub traversal_cost: f64,
    /// Cost of testing one primitive, K_Isec. Default 1.5.
    pub intersection_cost: f64,
    /// Factor on the cost of a split that leaves one side empty, 0 to 1; below 1 such splits win sooner.
    /// Default 0.8, the value of Wald and Havran 2006.
    pub empty_bonus: f64,
}

impl Default for KdSettings {
    fn default() -> Self {
        Self {
            traversal_cost: 1.0,
            intersection_cost: 1.5,
            empty_bonus: 0.8,
        }
    }
}

/// How likely a ray that meets a cell is to meet either part of it, for planes across one axis.
///
/// A cell's measure is half its surface area: for a part of length d along the axis, `cross + d · rim`. A cell that is
/// a mere line segment has no area, and its length takes that place.
#[derive(Clone, Copy, Debug)]
pub(super) struct CutMeasure {
    cross: f64,
    rim: f64,
    whole: f64,
}

impl CutMeasure {
    /// `None` when the cell has no extent along `axis`.
    pub(super) fn new(cell: &Aabb, axis: usize) -> Option<Self> {
        let side = sides(cell);
        let length = side[axis];
        if length <= 0.0 {
            return None;
        }
        let (a, b) = (side[(axis + 1) % 3], side[(axis + 2) % 3]);
        let whole = a * b + length * (a + b);
        Some(if whole > 0.0 {
            Self {
                cross: a * b,
                rim: a + b,
                whole,
            }
        } else {
            Self {
                cross: 0.0,
                rim: 1.0,
                whole: length,
            }
        })
    }
}

/// Costs of splitting one cell across one axis, Eq. 4.3.
#[derive(Clone, Copy, Debug)]
pub(super) struct CutCost {
    measure: CutMeasure,
    scale: f64,
    settings: KdSettings,
}

impl CutCost {
    pub(super) fn new(measure: CutMeasure, settings: &KdSettings) -> Self {
        Self {
            measure,
            scale: settings.intersection_cost / measure.whole,
            settings: *settings,
        }
    }

    /// C_Part of parts `lower` and `upper` long with `left` and `right` primitives, times the bonus if one is zero.
    #[inline]
    pub(super) fn at(&self, lower: f64, upper: f64, left: u32, right: u32) -> f64 {
        let CutMeasure { cross, rim, .. } = self.measure;
        let tests = f64::from(left) * (cross + lower * rim) + f64::from(right) * (cross + upper * rim);
        let cost = self.settings.traversal_cost + self.scale * tests;
        if left == 0 || right == 0 {
            cost * self.settings.empty_bonus
        } else {
            cost
        }
    }
}

/// Lengths of the box's sides, without overflow.
fn sides(cell: &Aabb) -> [f64; 3] {
    std::array::from_fn(|k| f64::from(cell.max[k]) - f64::from(cell.min[k]))
}

/// The expected cost of a ray that meets `bounds`: C_Tree.
///
/// `nodes[0]` is the root, `bounds` its cell; K_Trav is charged for inner nodes, K_Isec for the references of leaves.
/// A tree whose bounds have no area is measured by lengths instead. The empty bonus guides a build and is no part of
/// the cost. Ends on any rows; the result means something for those of a valid tree.
///
/// Source: Eq. 4.1.
#[must_use]
pub fn sah_cost(nodes: &[KdNodeRow], bounds: &Aabb, settings: &KdSettings) -> f64 {
    let measure = |cell: &Aabb, by_length: bool| {
        let [x, y, z] = sides(cell);
        if by_length { x + y + z } else { x * y + y * z + z * x }
    };
    let by_length = measure(bounds, false) <= 0.0;
    let whole = measure(bounds, by_length);
    let mut cost = 0.0;
    let mut open = Vec::with_capacity(MAX_KD_DEPTH + 1);
    open.push((0usize, *bounds));
    // A valid tree has each node visited once: the count keeps rows that share children from being walked for ever.
    for _ in 0..nodes.len() {
        let Some((index, cell)) = open.pop() else {
            break;
        };
        let Some(row) = nodes.get(index) else {
            continue;
        };
        let chance = if whole > 0.0 {
            measure(&cell, by_length) / whole
        } else {
            1.0
        };
        match row.unpack() {
            KdNode::Leaf { count, .. } => cost += settings.intersection_cost * chance * f64::from(count),
            KdNode::Inner { axis, split, left } => {
                cost += settings.traversal_cost * chance;
                let (mut lower, mut upper) = (cell, cell);
                lower.max[axis] = split;
                upper.min[axis] = split;
                open.push((left as usize + 1, upper));
                open.push((left as usize, lower));
            }
        }
    }
    cost
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: KdSettings = KdSettings {
        traversal_cost: 2.0,
        intersection_cost: 3.0,
        empty_bonus: 0.5,
    };

    #[test]
    fn a_cut_costs_what_equation_4_3_says() {
        // A cell of 4 × 2 × 1 has half area 14; its parts 1 and 3 long have 1·3 + 2 = 5 and 3·3 + 2 = 11.
        let cell = Aabb {
            min: [0.0; 3],
            max: [4.0, 2.0, 1.0],
        };
        let cut = CutCost::new(CutMeasure::new(&cell, 0).unwrap(), &SETTINGS);
        let expected = 2.0 + 3.0 * (7.0 * 5.0 + 2.0 * 11.0) / 14.0;
        assert!(
            (cut.at(1.0, 3.0, 7, 2) - expected).abs() < 1e-12,
            "rounding of six operations"
        );
        let empty = 0.5 * (2.0 + 3.0 * 7.0 * 5.0 / 14.0);
        assert!(
            (cut.at(1.0, 3.0, 7, 0) - empty).abs() < 1e-12,
            "rounding of six operations"
        );
    }

    #[test]
    fn segments_are_measured_by_length_and_flat_axes_not_at_all() {
        let cell = Aabb {
            min: [0.0; 3],
            max: [0.0, 8.0, 0.0],
        };
        assert!(CutMeasure::new(&cell, 0).is_none());
        let cut = CutCost::new(CutMeasure::new(&cell, 1).unwrap(), &SETTINGS);
        assert_eq!(cut.at(2.0, 6.0, 4, 4), 2.0 + 3.0 * 4.0);
    }

    #[test]
    fn a_tree_costs_what_equation_4_1_says() {
        let bounds = Aabb {
            min: [0.0; 3],
            max: [4.0, 2.0, 1.0],
        };
        let nodes = [
            KdNodeRow::pack(KdNode::Inner {
                axis: 0,
                split: 1.0,
                left: 1,
            }),
            KdNodeRow::pack(KdNode::Leaf { first: 0, count: 7 }),
            KdNodeRow::pack(KdNode::Leaf { first: 7, count: 2 }),
        ];
        let expected = 2.0 + 3.0 * (7.0 * 5.0 + 2.0 * 11.0) / 14.0;
        assert!(
            (sah_cost(&nodes, &bounds, &SETTINGS) - expected).abs() < 1e-12,
            "rounding of a few operations"
        );
        assert_eq!(sah_cost(&nodes[1..2], &bounds, &SETTINGS), 21.0);
        assert_eq!(
            sah_cost(
                &nodes[1..2],
                &Aabb {
                    min: [1.0; 3],
                    max: [1.0; 3]
                },
                &SETTINGS
            ),
            21.0
        );
        assert_eq!(sah_cost(&[], &bounds, &SETTINGS), 0.0);
    }

    #[test]
    fn rows_that_form_no_tree_still_end() {
        let bounds = Aabb {
            min: [0.0; 3],
            max: [1.0; 3],
        };
        let round = [KdNodeRow::pack(KdNode::Inner {
            axis: 0,
            split: 0.5,
            left: 0,
        }); 2];
        assert!(sah_cost(&round, &bounds, &SETTINGS).is_finite());
        let outside = [KdNodeRow::pack(KdNode::Inner {
            axis: 2,
            split: f32::NAN,
            left: 9,
        })];
        assert_eq!(sah_cost(&outside, &bounds, &SETTINGS), 2.0);
    }
}
