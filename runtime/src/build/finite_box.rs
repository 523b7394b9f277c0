use restpose_formats::geom::Aabb;

/// The finite box that stands for `bounds` in a tree; `None` when it is empty.
///
/// Guarantee: contains every finite point of `bounds`. An axis with a NaN side is covered from `f32::MIN` to
/// `f32::MAX`, an infinite side is moved to the nearest of the two, and no zero is negative.
pub(crate) fn finite_box(bounds: &Aabb) -> Option<Aabb> {
    if bounds.is_empty() {
        return None;
    }
    let mut out = *bounds;
    for k in 0..3 {
        if out.min[k].is_nan() || out.max[k].is_nan() {
            (out.min[k], out.max[k]) = (f32::MIN, f32::MAX);
        }
        // Adding zero turns −0 into +0, so that equal positions have equal bits.
        out.min[k] = out.min[k].clamp(f32::MIN, f32::MAX) + 0.0;
        out.max[k] = out.max[k].clamp(f32::MIN, f32::MAX) + 0.0;
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unusable_sides_become_everything_and_empty_boxes_stay_empty() {
        assert_eq!(finite_box(&Aabb::EMPTY), None);
        assert_eq!(
            finite_box(&Aabb {
                min: [0.0, 2.0, 0.0],
                max: [1.0, 1.0, f32::NAN]
            }),
            None
        );
        let everything = Aabb {
            min: [f32::MIN; 3],
            max: [f32::MAX; 3],
        };
        assert_eq!(finite_box(&Aabb::EVERYTHING), Some(everything));
        assert_eq!(
            finite_box(&Aabb {
                min: [f32::NAN; 3],
                max: [0.0; 3]
            }),
            Some(everything)
        );
        let half = Aabb {
            min: [-1.0, f32::NEG_INFINITY, 3.0],
            max: [-0.0, 2.0, f32::INFINITY],
        };
        let found = finite_box(&half).map(|b| (b.min.map(f32::to_bits), b.max.map(f32::to_bits)));
        let expected = (
            [-1.0, f32::MIN, 3.0].map(f32::to_bits),
            [0.0, 2.0, f32::MAX].map(f32::to_bits),
        );
        assert_eq!(found, Some(expected));
    }
}
