use super::axis_sides::AxisSides;
use super::bins::Bins;
use super::cell_cost::CellCost;
use super::cut::{Cut, PricedCut, cut_beside};
use super::fragment::{Fragment, Plane};
use super::line_search::{GOLDEN, minimum};
use restpose_formats::geom::Aabb;

/// Finds the plane of a node; owns all scratch memory.
#[derive(Debug)]
pub(super) struct PlaneSearch {
    sides: AxisSides,
    bins: Bins,
}

/// A plane and where it lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FoundPlane {
    pub priced: PricedCut,
    pub axis: usize,
    /// Along the box around the node's fragments: 0 at its lower side, 1 at its upper.
    pub share: f32,
}

/// The search ends within a five-hundredth of a node's length; a side of a fragment next to it is then taken.
const TOLERANCE: f32 = 2e-3;

/// How far from a prediction the search looks, in lengths: four standard deviations of the filter's process.
const WINDOW: f32 = 4e-2;

/// Evaluations after which a search ends wherever it is.
const MOST_STEPS: u32 = 12;

impl PlaneSearch {
    pub(super) fn new() -> Self {
        Self {
            sides: AxisSides::default(),
            bins: Bins::new(),
        }
    }

    /// A cheap plane along `axis` near `predicted`, and the evaluations that took.
    pub(super) fn near(
        &mut self,
        fragments: &[Fragment],
        bounds: &Aabb,
        cost: &CellCost,
        axis: usize,
        predicted: f32,
    ) -> (Option<FoundPlane>, u32) {
        let start = predicted.clamp(0.0, 1.0);
        let bracket = [(start - WINDOW).max(0.0), (start + WINDOW).min(1.0)];
        self.along(fragments, bounds, cost, axis, bracket, start)
    }

    /// The cheapest plane that searches from the extremes of all three axes find, and the evaluations they took.
    pub(super) fn over_all_axes(
        &mut self,
        fragments: &[Fragment],
        bounds: &Aabb,
        cost: &CellCost,
    ) -> (Option<FoundPlane>, u32) {
        let (mut best, mut total) = (None::<FoundPlane>, 0);
        for axis in 0..3 {
            let (found, steps) = self.along(fragments, bounds, cost, axis, [0.0, 1.0], GOLDEN);
            total += steps;
            if let Some(found) = found
                && best.is_none_or(|best| found.priced.cost < best.priced.cost)
            {
                best = Some(found);
            }
        }
        (best, total)
    }

    /// The cheapest plane by bins on all three axes.
    pub(super) fn by_bins(&mut self, fragments: &[Fragment], bounds: &Aabb, cost: &CellCost) -> Option<FoundPlane> {
        self.bins.lay_adaptive(bounds, fragments.len());
        self.bins.add(fragments);
        let border = self.bins.cheapest_border(cost, fragments.len())?;
        let near = self.bins.near(border.axis, border.below);
        let priced = cut_beside(fragments, bounds, cost, border.axis, near, f32::INFINITY)?;
        found_at(priced, bounds)
    }

    fn along(
        &mut self,
        fragments: &[Fragment],
        bounds: &Aabb,
        cost: &CellCost,
        axis: usize,
        bracket: [f32; 2],
        start: f32,
    ) -> (Option<FoundPlane>, u32) {
        let (min, max) = (bounds.min[axis], bounds.max[axis]);
        let length = max - min;
        if length <= 0.0 || !length.is_finite() {
            return (None, 0);
        }
        self.sides.fill(fragments, axis);
        let sides = &self.sides;
        let price = |position: f32| {
            let [left, right] = sides.counts(position);
            cost.cut(axis, cost.share(axis, position), left as f32, right as f32)
        };
        let found = minimum(|t| price(min + t * length), bracket, start, TOLERANCE, MOST_STEPS);
        let near = min + found.at * length;
        let [left, right] = sides.counts(near);
        let beside = sides.beside(near);
        // The cost is linear between neighbouring sides: the end towards the larger child is no dearer.
        let ends = if left > right {
            [beside.below, beside.above]
        } else {
            [beside.above, beside.below]
        };
        let position = ends.into_iter().find(|&end| min < end && end < max);
        let plane = position.and_then(|position| {
            let t = cost.share(axis, position);
            let plane = Plane {
                axis,
                position,
                planar_left: t <= 0.5,
            };
            let priced = PricedCut {
                cost: cost.cut(axis, t, left as f32, right as f32),
                cut: Cut::Part {
                    plane,
                    left: left as usize,
                    right: right as usize,
                },
            };
            found_at(priced, bounds)
        });
        (plane, found.steps)
    }
}

fn found_at(priced: PricedCut, bounds: &Aabb) -> Option<FoundPlane> {
    let Cut::Part { plane, .. } = priced.cut else {
        return None;
    };
    let (min, max) = (bounds.min[plane.axis], bounds.max[plane.axis]);
    Some(FoundPlane {
        priced,
        axis: plane.axis,
        share: (plane.position - min) / (max - min),
    })
}
