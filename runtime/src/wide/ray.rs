use crate::cluster_frame::SlabRay;
use restpose_formats::geom::round::UNIT_ROUNDOFF;

/// Two units in the last place of a coordinate, relatively: see [`WideRay`].
pub(super) const ORIGIN_SLACK: f32 = (4.0 * UNIT_ROUNDOFF) as f32;

/// A ray ready for nodes whose boxes are `f32`, the margin folded into its origin.
///
/// # Why it is no narrower than a [`SlabRay`]
///
/// With the origin o, the margin m, both as stored, and u = 2⁻²⁴, a plane that bounds from below counts from
/// `o⁺ = fl(o + fl(4u·|o| + m))`, one that bounds from above from `o⁻ = fl(o − fl(4u·|o| + m))`. Each of the two sums is
/// off by u relatively, so `o⁺ ≥ o + 2u·|o| + m·(1 − 2u)`: the plane moves outwards by the margin but for 2u·m, which the
/// spare part of the margin (`cluster_frame`, points 5 to 7: ten or more u·D needed of sixteen, m being about 16u·D)
/// outweighs by far. What is computed per plane, `(plane − o⁺)·(1/d)`, then has three roundings, relative to
/// `|plane − o⁺| ≤ |plane − o| + m + 6u·|o|`: within point 7's four relative to `|plane − o|`, since the third term enters
/// with the 2u·|o| to spare above, and 3u·m is again outweighed.
///
/// Where the sums overflow, the planes of the axis restrict nothing; nor does a plane whose `t` is NaN.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WideRay {
    /// Origin for the planes that the ray meets first.
    pub near: [f32; 4],
    /// Origin for those that it meets last.
    pub far: [f32; 4],
    pub inverse_direction: [f32; 4],
    /// Which planes the ray meets first: 0 for the least ones, 1 for the greatest.
    pub near_row: [usize; 3],
    /// Some axis restricts nothing: not even empty boxes, which must be told apart then.
    pub unbounded: bool,
}

impl WideRay {
    /// Stands where no ray is.
    pub(crate) const NONE: Self = Self {
        near: [0.0; 4],
        far: [0.0; 4],
        inverse_direction: [0.0; 4],
        near_row: [0; 3],
        unbounded: false,
    };

    #[inline]
    pub(crate) fn new(ray: &SlabRay) -> Self {
        // Four lanes, so that a compiler makes one vector of them.
        let pad = |v: [f32; 3]| [v[0], v[1], v[2], 0.0];
        let (origin, margin, inverse) = (pad(ray.origin), pad(ray.margin), pad(ray.inverse_direction));
        let outwards: [f32; 4] =
            std::array::from_fn(|k| (ORIGIN_SLACK * origin[k].abs() + margin[k]).copysign(inverse[k]));
        let near: [f32; 4] = std::array::from_fn(|k| origin[k] + outwards[k]);
        let far: [f32; 4] = std::array::from_fn(|k| origin[k] - outwards[k]);
        // A sum that overflows though no term does only costs the time to look for empty boxes.
        let reach: [f32; 4] = std::array::from_fn(|k| near[k].abs() + far[k].abs());
        let unbounded = !((reach[0] + reach[2]) + (reach[1] + reach[3])).is_finite();
        Self {
            near,
            far,
            inverse_direction: inverse,
            near_row: std::array::from_fn(|k| usize::from(inverse[k].is_sign_negative())),
            unbounded,
        }
    }
}
