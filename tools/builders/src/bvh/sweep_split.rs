use super::lane_box::LaneBox;
use super::measure::Measure;
use super::primitive::Primitive;

/// Where a node's primitives are parted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SweepSplit {
    pub(super) axis: usize,
    /// Primitives on the left.
    pub(super) left: usize,
    /// n_l SA(N_l) + n_r SA(N_r), in the node's measure.
    pub(super) parts: f32,
}

/// The cheapest split by Eq. 4.3 over all planes between different centroids on all axes; of equal ones the lowest axis, then
/// the lowest plane. `None` where all centroids coincide.
///
/// `lists` hold the node's primitives by their centroids on each axis; `left_parts` is scratch of the same length.
pub(super) fn cheapest_split(
    lists: [&[Primitive]; 3],
    measure: &Measure,
    left_parts: &mut [f32],
) -> Option<SweepSplit> {
    let mut best: Option<SweepSplit> = None;
    for (axis, list) in lists.into_iter().enumerate() {
        let split = cheapest_on_axis(list, axis, measure, left_parts);
        if split.is_some_and(|split| best.is_none_or(|best| split.parts < best.parts)) {
            best = split;
        }
    }
    best
}

fn cheapest_on_axis(list: &[Primitive], axis: usize, measure: &Measure, left_parts: &mut [f32]) -> Option<SweepSplit> {
    let (first, last) = (list.first()?, list.last()?);
    if first.bounds().center_of(axis) == last.bounds().center_of(axis) {
        return None;
    }
    let mut bounds = LaneBox::EMPTY;
    let mut count = 0_u32;
    for (primitive, left_part) in list.iter().zip(left_parts.iter_mut()) {
        bounds.grow(primitive.bounds());
        count += 1;
        *left_part = measure.of(&bounds) * count as f32;
    }
    bounds = LaneBox::EMPTY;
    count = 0;
    let mut above = f32::NEG_INFINITY;
    let mut best = (f32::INFINITY, 0);
    for (index, (primitive, left_part)) in list.iter().zip(left_parts.iter()).enumerate().rev() {
        let centroid = primitive.bounds().center_of(axis);
        // At the last primitive nothing is above.
        let parts = left_part + measure.of(&bounds) * count as f32;
        if centroid < above && parts <= best.0 {
            best = (parts, index + 1);
        }
        bounds.grow(primitive.bounds());
        count += 1;
        above = centroid;
    }
    Some(SweepSplit {
        axis,
        left: best.1,
        parts: best.0,
    })
}
