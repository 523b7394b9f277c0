use super::lane_box::LaneBox;
use restpose_runtime::build::BvhSettings;
use wide::f32x4;

/// Measures boxes inside one node, for Eq. 4.3: in proportion to their surface areas, in `f32`.
///
/// Lengths are scaled by a power of two that brings the node's longest side near 1, so nothing overflows. A measure errs by
/// at most 8 · 2⁻²⁴ of itself, from as many operations, and 2⁻⁴⁰ of the node's, from what underflows.
///
/// Boxes in a node without area are measured by their lengths, as in [`Bvh::sah_cost`]: the node is a line, and passes for
/// a ribbon 1 wide. So does one whose area is less than [`LINE`] of the square over its longest side.
///
/// [`Bvh::sah_cost`]: restpose_runtime::build::Bvh::sah_cost
#[derive(Clone, Copy, Debug)]
pub(super) struct Measure {
    /// ½ where lengths could overflow, else 1.
    half: f32x4,
    scale: f32x4,
    width: f32x4,
    node: f32,
}

/// 2⁻⁹⁶: so much above the smallest normal number that areas in the node keep their digits.
const LINE: f32 = f32::from_bits((127 - 96) << 23);

impl Measure {
    pub(super) fn new(node: &LaneBox) -> Self {
        let axis = node.longest_axis();
        let whole = node.length(axis);
        let half = if whole > f64::from(f32::MAX) { 0.5 } else { 1.0 };
        let longest = (f64::from(half) * whole) as f32;
        // With biased exponent e it lies in 2^(e−127) to 2^(e−126); the scale is 2^(126−e), as far as it is a normal number.
        let exponent = longest.to_bits() >> 23;
        let mut measure = Self {
            half: f32x4::splat(half),
            scale: f32x4::splat(f32::from_bits(253_u32.saturating_sub(exponent).max(1) << 23)),
            width: f32x4::ZERO,
            node: 0.0,
        };
        measure.node = measure.of(node);
        if measure.node < LINE {
            measure.width.as_mut_array()[(axis + 1) % 3] = 1.0;
            measure.node = measure.of(node);
        }
        measure
    }

    /// The measure of `part`, a box inside the node.
    #[inline]
    pub(super) fn of(&self, part: &LaneBox) -> f32 {
        let sides = (part.upper * self.half - part.lower * self.half) * self.scale + self.width;
        let [x, y, z, _] = sides.to_array();
        x * y + y * z + z * x
    }

    /// Whether Eq. 4.3 is less than the cost of a leaf with `count` primitives; `parts` is n_l SA(N_l) + n_r SA(N_r) in
    /// this measure. False for settings that cannot be compared.
    #[inline]
    pub(super) fn split_pays(&self, parts: f32, count: usize, settings: &BvhSettings) -> bool {
        let node = f64::from(self.node);
        let split = settings.traversal_cost * node + settings.intersection_cost * f64::from(parts);
        split < settings.intersection_cost * count as f64 * node
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use restpose_formats::geom::Aabb;

    fn share(node: &Aabb, part: &Aabb) -> f64 {
        let measure = Measure::new(&LaneBox::from(node));
        f64::from(measure.of(&LaneBox::from(part))) / f64::from(measure.node)
    }

    #[test]
    fn shares_are_those_of_areas_at_every_scale() {
        for exponent in [-126, -100, -60, 0, 60, 100, 126, 127] {
            let unit = f64::from(exponent).exp2() as f32;
            let node = Aabb {
                min: [-unit, 0.25 * unit, 0.0],
                max: [unit, unit, 0.125 * unit],
            };
            let part = Aabb {
                min: [-0.5 * unit, 0.25 * unit, 0.0],
                max: [unit, 0.5 * unit, 0.125 * unit],
            };
            let expected = part.surface_area() / node.surface_area();
            // All sides are short binary fractions: products and sums round, by what `Measure` states twice over.
            let error = (share(&node, &part) / expected - 1.0).abs();
            assert!(error <= 16.0 * f64::exp2(-24.0), "2^{exponent}: {error}");
        }
    }

    #[test]
    fn lines_are_measured_by_length_and_points_never_pay() {
        for axis in 0..3 {
            let line = |a: f32, b: f32| {
                let mut bounds = Aabb {
                    min: [7.0, -3.0, f32::MAX],
                    max: [7.0, -3.0, f32::MAX],
                };
                (bounds.min[axis], bounds.max[axis]) = (a, b);
                bounds
            };
            assert_eq!(
                share(&line(0.0, 1e-40), &line(0.0, 5e-41)),
                share(&line(0.0, 4.0), &line(1.0, 3.0))
            );
            assert_eq!(share(&line(f32::MIN, f32::MAX), &line(0.0, f32::MAX)), 0.5);
        }
        let point = LaneBox::from(&Aabb {
            min: [3.0; 3],
            max: [3.0; 3],
        });
        assert!(!Measure::new(&point).split_pays(0.0, 9, &BvhSettings::default()));
    }
}
