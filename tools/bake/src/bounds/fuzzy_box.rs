use crate::poses::SampledPose;
use restpose_formats::geom::{
    Aabb, Affine,
    round::{f32_above, f32_below},
};

/// 2⁻⁴⁸: rounding of a fuzzy position in `f64`, relative to the magnitudes that enter it. Its longest sum (morphs aside)
/// has under 32 roundings of 2⁻⁵³.
const F64_ROUNDING: f64 = 1.0 / (1u64 << 48) as f64;

/// A box of fuzzy positions, before it is rounded outwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FuzzyBox {
    min: [f64; 3],
    max: [f64; 3],
}

impl FuzzyBox {
    pub(crate) const EMPTY: Self = Self {
        min: [f64::INFINITY; 3],
        max: [f64::NEG_INFINITY; 3],
    };

    /// Grows to contain `point`, which is finite.
    #[inline]
    pub(crate) fn add(&mut self, point: [f64; 3]) {
        for k in 0..3 {
            // Plain comparisons become single instructions; f64::min would also look after NaN.
            self.min[k] = if point[k] < self.min[k] { point[k] } else { self.min[k] };
            self.max[k] = if point[k] > self.max[k] { point[k] } else { self.max[k] };
        }
    }

    pub(crate) fn union(self, other: Self) -> Self {
        Self {
            min: std::array::from_fn(|k| self.min[k].min(other.min[k])),
            max: std::array::from_fn(|k| self.max[k].max(other.max[k])),
        }
    }

    /// The least corner.
    pub(crate) fn min(&self) -> [f64; 3] {
        self.min
    }

    /// The greatest corner.
    pub(crate) fn max(&self) -> [f64; 3] {
        self.max
    }

    /// The same, further by so much on both sides of each axis.
    pub(crate) fn widened(&self, by: [f64; 3]) -> Self {
        Self {
            min: std::array::from_fn(|k| self.min[k] - by[k]),
            max: std::array::from_fn(|k| self.max[k] + by[k]),
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.min[0] > self.max[0]
    }

    pub(crate) fn surface_area(&self) -> f64 {
        let [x, y, z]: [f64; 3] = std::array::from_fn(|k| (self.max[k] - self.min[k]).max(0.0));
        2.0 * (x * y + y * z + z * x)
    }

    /// The smallest `f32` box that contains it widened by `error` on every side.
    pub(crate) fn rounded_outwards(&self, error: f64) -> Aabb {
        Aabb {
            min: self.min.map(|x| f32_below(x - error)),
            max: self.max.map(|x| f32_above(x + error)),
        }
    }
}

/// A bone's inverse in every sample: what takes vertices into its local space.
pub(crate) struct FrameTrack {
    /// Per usable sample: its index, the rows of the inverse's linear part, and the translation that comes off before.
    steps: Vec<(usize, [[f64; 3]; 3], [f64; 3])>,
    /// Bounds how far a computed fuzzy position is from the exact one, per axis and over all samples.
    pub error: f64,
}

impl FrameTrack {
    /// The track of `bone`. `reach` bounds `|v|` and `Σ w·|X|·|p|` of every vertex in every sample, per sample.
    pub(crate) fn new(poses: &[&SampledPose], bone: usize, reach: &[f64]) -> Self {
        let mut error = 0.0f64;
        let steps = poses.iter().enumerate().filter_map(|(sample, pose)| {
            let inverse = pose.inverses[bone]?;
            let frame = &pose.palette[bone];
            let translation = frame.columns[3].map(f64::from);
            let farthest = reach[sample] + translation.iter().fold(0.0f64, |far, x| far.max(x.abs()));
            let scale = inverse
                .iter()
                .map(|row| row.iter().map(|x| x.abs()).sum::<f64>())
                .fold(0.0, f64::max);
            let fuzzy_reach = scale * farthest;
            let residual = residual_norm(&inverse, frame);
            error = error.max(2.0 * residual * fuzzy_reach + F64_ROUNDING * fuzzy_reach);
            Some((sample, inverse, translation))
        });
        Self {
            steps: steps.collect(),
            error,
        }
    }

    /// Box of a vertex's fuzzy positions over the usable samples.
    pub(crate) fn fuzzy_box(&self, track: &[[f64; 3]]) -> FuzzyBox {
        let mut out = FuzzyBox::EMPTY;
        for (sample, inverse, translation) in &self.steps {
            let v = track[*sample];
            let d = [v[0] - translation[0], v[1] - translation[1], v[2] - translation[2]];
            out.add([
                inverse[0][0] * d[0] + inverse[0][1] * d[1] + inverse[0][2] * d[2],
                inverse[1][0] * d[0] + inverse[1][1] * d[1] + inverse[1][2] * d[2],
                inverse[2][0] * d[0] + inverse[2][1] * d[1] + inverse[2][2] * d[2],
            ]);
        }
        out
    }
}

/// `‖B·X − I‖∞` for a computed inverse B, its own rounding included: with q the exact fuzzy position, `B(v − t) − q` is
/// `(B·X − I)·q`.
fn residual_norm(inverse: &[[f64; 3]; 3], frame: &Affine) -> f64 {
    let x = [0, 1, 2].map(|j: usize| frame.columns[j].map(f64::from));
    inverse.iter().enumerate().fold(0.0, |worst, (k, row)| {
        let sum: f64 = (0..3)
            .map(|j| {
                let products: [f64; 3] = std::array::from_fn(|i| row[i] * x[j][i]);
                let identity = if j == k { 1.0 } else { 0.0 };
                let rounding = F64_ROUNDING * (products.iter().map(|p| p.abs()).sum::<f64>() + identity);
                (products.iter().sum::<f64>() - identity).abs() + rounding
            })
            .sum();
        f64::max(worst, sum)
    })
}
