//! Maps between two poses of a point set by weighted least squares, from moments.

use super::jacobi::{eigen_of_covariance, signed_svd};
use glam::{DMat3, DVec3};
use serde::Serialize;

/// Point sets whose RMS radius is below this part of the mesh count as coincident: positions are rounded to `f32`
/// relative to the mesh's size, a quarter of this.
pub(super) const COINCIDENT: f64 = 1.0 / (1u64 << 22) as f64;

/// A direction in which a point set is thinner than this part of its longest direction (as variance: the square of
/// 1/16) does not decide the map there alone: residuals are then of the order of the thickness and would be fitted
/// instead of motion. As much weight as is missing to this limit is put on pseudo-points in that direction, which move
/// by the similarity fit. Sets that are thicker in every direction are fitted without any.
const THIN: f64 = 1.0 / 256.0;

/// Singular values of a fitted map lie within this factor of the similarity's scale, so its condition number is at most
/// the square. Beyond, a local box that holds the motion stretches to a sliver in some key.
pub(super) const STRETCH_LIMIT: f64 = 8.0;

/// Weight of the neighbouring key's rotation in a rotation fit, relative to the data: it decides only what the data do
/// not, like the twist of points on a line.
const CONTINUITY: f64 = 1.0 / (1u64 << 24) as f64;

/// A family of maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FitModel {
    /// Any linear map without mirroring, within a limit of condition.
    Affine,
    /// Rotation and one scale.
    Similarity,
    /// Rotation only.
    Rigid,
}

/// `p = linear · v + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Map {
    pub linear: DMat3,
    pub offset: DVec3,
}

impl Map {
    pub(super) const IDENTITY: Self = Self {
        linear: DMat3::IDENTITY,
        offset: DVec3::ZERO,
    };

    #[inline]
    pub(super) fn apply(&self, v: DVec3) -> DVec3 {
        self.linear * v + self.offset
    }
}

/// How a map was found, from the most general to the least.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Tier {
    /// Least squares alone.
    #[default]
    Affine,
    /// Least squares, with pseudo-points in thin directions.
    Flat,
    /// Least squares, with singular values moved to their limits.
    Limited,
    /// Rotation and scale.
    Similarity,
    /// Rotation.
    Rigid,
    /// The neighbouring key's linear part: the points coincide.
    Translation,
}

/// Number of maps found in each way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct TierCounts {
    /// Plain least squares.
    pub affine: u64,
    /// With pseudo-points in thin directions.
    pub flat: u64,
    /// With singular values moved to their limits.
    pub limited: u64,
    /// Rotation and scale.
    pub similarity: u64,
    /// Rotation.
    pub rigid: u64,
    /// Translation.
    pub translation: u64,
}

impl TierCounts {
    pub(super) fn count(&mut self, tier: Tier) {
        *match tier {
            Tier::Affine => &mut self.affine,
            Tier::Flat => &mut self.flat,
            Tier::Limited => &mut self.limited,
            Tier::Similarity => &mut self.similarity,
            Tier::Rigid => &mut self.rigid,
            Tier::Translation => &mut self.translation,
        } += 1;
    }
}

/// Weighted sums over pairs of a point `v` and where it should go, `r`; both relative to a pivot near the set, so that
/// small sets far from the origin keep their digits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moments {
    pivot_v: DVec3,
    pivot_r: DVec3,
    weight: f64,
    v: DVec3,
    r: DVec3,
    /// Upper triangle of Σ w v vᵀ: xx, yy, zz, xy, xz, yz.
    vv: [f64; 6],
    /// Columns of Σ w r vᵀ.
    rv: [DVec3; 3],
    rr: f64,
}

impl Moments {
    /// Nothing yet, about two pivots.
    pub(super) fn about(pivot_v: DVec3, pivot_r: DVec3) -> Self {
        Self {
            pivot_v,
            pivot_r,
            weight: 0.0,
            v: DVec3::ZERO,
            r: DVec3::ZERO,
            vv: [0.0; 6],
            rv: [DVec3::ZERO; 3],
            rr: 0.0,
        }
    }

    #[inline]
    pub(super) fn add(&mut self, weight: f64, v: DVec3, r: DVec3) {
        let (v, r) = (v - self.pivot_v, r - self.pivot_r);
        let wv = v * weight;
        self.weight += weight;
        self.v += wv;
        self.r += r * weight;
        self.vv[0] += wv.x * v.x;
        self.vv[1] += wv.y * v.y;
        self.vv[2] += wv.z * v.z;
        self.vv[3] += wv.x * v.y;
        self.vv[4] += wv.x * v.z;
        self.vv[5] += wv.y * v.z;
        self.rv[0] += r * wv.x;
        self.rv[1] += r * wv.y;
        self.rv[2] += r * wv.z;
        self.rr += weight * r.dot(r);
    }

    /// The map that takes the points to where they should go with the smallest weighted sum of squares, within what
    /// `model` and the limits above allow. `previous` is the linear part in a neighbouring key.
    ///
    /// Guarantee: finite and invertible, singular values within [`STRETCH_LIMIT`] of one scale, determinant positive.
    pub(super) fn fit(&self, model: FitModel, previous: DMat3) -> (Map, Tier) {
        if self.weight <= 0.0 {
            return (
                Map {
                    linear: previous,
                    offset: self.pivot_r - previous * self.pivot_v,
                },
                Tier::Translation,
            );
        }
        let inverse_weight = 1.0 / self.weight;
        let (mean_v, mean_r) = (self.v * inverse_weight, self.r * inverse_weight);
        let about_means = |linear: DMat3| Map {
            linear,
            offset: (self.pivot_r + mean_r) - linear * (self.pivot_v + mean_v),
        };
        let [xx, yy, zz, xy, xz, yz] = self.vv.map(|sum| sum * inverse_weight);
        let vv = DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz))
            - outer(mean_v, mean_v);
        let rv = DMat3::from_cols_array_2d(&std::array::from_fn(|k| (self.rv[k] * inverse_weight).to_array()))
            - outer(mean_r, mean_v);
        let (size_v, size_r) = (
            (vv.x_axis.x + vv.y_axis.y + vv.z_axis.z).max(0.0).sqrt(),
            (self.rr * inverse_weight - mean_r.length_squared()).max(0.0).sqrt(),
        );
        if size_v <= COINCIDENT || size_r <= COINCIDENT {
            return (about_means(previous), Tier::Translation);
        }
        let scale = size_r / size_v;
        if model == FitModel::Affine
            && let Some(linear) = plain_fit(vv, rv, scale)
        {
            return (about_means(linear), Tier::Affine);
        }
        let rotation = nearest_rotation(rv, size_r * size_v, previous);
        match model {
            FitModel::Rigid => (about_means(rotation), Tier::Rigid),
            FitModel::Similarity => (about_means(rotation * scale), Tier::Similarity),
            FitModel::Affine => {
                let (linear, tier) = limited_fit(vv, rv, rotation, scale);
                (about_means(linear), tier)
            }
        }
    }
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

fn norm(m: DMat3) -> f64 {
    (m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared()).sqrt()
}

/// Least squares alone, where Frobenius norms (which bound singular values) show that no limit is touched.
fn plain_fit(vv: DMat3, rv: DMat3, scale: f64) -> Option<DMat3> {
    let inverse = vv.inverse();
    let spread = norm(vv) * norm(inverse) * THIN;
    if spread.is_nan() || spread > 1.0 {
        return None;
    }
    let linear = rv * inverse;
    let within = linear.determinant() > 0.0
        && norm(linear) <= scale * STRETCH_LIMIT
        && norm(linear.inverse()) * scale <= STRETCH_LIMIT;
    within.then_some(linear)
}

/// The rotation that turns the points nearest to where they should go.
///
/// Source: Kabsch, *A Solution for the Best Rotation to Relate Two Sets of Vectors*, 1976.
fn nearest_rotation(rv: DMat3, size: f64, previous: DMat3) -> DMat3 {
    let before = signed_svd(previous).rotation();
    signed_svd(rv + before * (size * CONTINUITY)).rotation()
}

fn limited_fit(vv: DMat3, rv: DMat3, rotation: DMat3, scale: f64) -> (DMat3, Tier) {
    let (variance, axes) = eigen_of_covariance(vv);
    let similarity = rotation * scale;
    let (mut vv, mut rv, mut tier) = (vv, rv, Tier::Affine);
    for k in 0..3 {
        let missing = THIN * variance.x - variance[k];
        if missing > 0.0 {
            let axis = axes.col(k);
            vv += outer(axis, axis) * missing;
            rv += outer(similarity * axis, axis) * missing;
            tier = Tier::Flat;
        }
    }
    let linear = rv * vv.inverse();
    if !linear.is_finite() {
        return (similarity, Tier::Similarity);
    }
    let svd = signed_svd(linear);
    let (low, high) = (scale / STRETCH_LIMIT, scale * STRETCH_LIMIT);
    let clamped = svd.values.clamp(DVec3::splat(low), DVec3::splat(high));
    if clamped == svd.values {
        (linear, tier)
    } else {
        (svd.with_values(clamped), Tier::Limited)
    }
}

impl std::ops::AddAssign for TierCounts {
    fn add_assign(&mut self, more: Self) {
        self.affine += more.affine;
        self.flat += more.flat;
        self.limited += more.limited;
        self.similarity += more.similarity;
        self.rigid += more.rigid;
        self.translation += more.translation;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vector(random: &mut fastrand::Rng) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| random.f64() - 0.5))
    }

    fn fit(pairs: &[(DVec3, DVec3)], model: FitModel, previous: DMat3) -> (Map, Tier) {
        let mut moments = Moments::about(pairs[0].0, pairs[0].1);
        pairs.iter().for_each(|(v, r)| moments.add(0.3, *v, *r));
        moments.fit(model, previous)
    }

    #[test]
    fn an_affine_map_is_found_exactly_wherever_the_points_are() {
        let mut random = fastrand::Rng::with_seed(1);
        for _ in 0..200 {
            let (at, size) = (vector(&mut random) * 1e3, 10f64.powi(random.i32(-4..1)));
            let linear = DMat3::IDENTITY + DMat3::from_cols_array(&std::array::from_fn(|_| random.f64() * 0.6 - 0.3));
            let points: Vec<DVec3> = (0..20).map(|_| at + vector(&mut random) * size).collect();
            let pairs: Vec<_> = points.iter().map(|v| (*v, linear * (*v - at))).collect();
            let (map, tier) = fit(&pairs, FitModel::Affine, DMat3::IDENTITY);
            assert_eq!(tier, Tier::Affine);
            let worst = pairs
                .iter()
                .map(|(v, r)| (map.apply(*v) - *r).length())
                .fold(0.0, f64::max);
            // Coordinates of a thousand in f64, through a fit of condition a hundred.
            assert!(worst < 1e-10, "{worst}");
        }
    }

    #[test]
    fn every_fit_keeps_its_limits() {
        let mut random = fastrand::Rng::with_seed(2);
        for round in 0..2000 {
            let flatten = |v: DVec3, kind: usize| match kind {
                0 => v,
                1 => v * DVec3::new(1.0, 1.0, 0.0),
                2 => v * DVec3::X,
                3 => DVec3::ONE,
                4 => v * DVec3::new(1.0, 1.0, -1e-3),
                _ => v * 1e-5,
            };
            let (from, to) = (round % 6, round / 6 % 6);
            let pairs: Vec<_> = (0..1 + round % 9)
                .map(|_| (flatten(vector(&mut random), from), flatten(vector(&mut random), to)))
                .collect();
            for model in [FitModel::Affine, FitModel::Similarity, FitModel::Rigid] {
                let (map, _) = fit(&pairs, model, DMat3::IDENTITY);
                let values = signed_svd(map.linear).values;
                assert!(
                    map.offset.is_finite() && values.z > 0.0,
                    "round {round} {model:?}: {values}"
                );
                // The limits, and the rounding of a product of three matrices.
                let limit = STRETCH_LIMIT * STRETCH_LIMIT * 1.000_001;
                assert!(values.x / values.z <= limit, "round {round} {model:?}: {values}");
            }
        }
    }

    #[test]
    fn the_twist_about_a_line_is_that_of_the_neighbouring_key() {
        let twist = DMat3::from_rotation_x(1.0);
        let pairs: Vec<_> = (0..5)
            .map(|x| (DVec3::X * f64::from(x), DVec3::X * f64::from(x)))
            .collect();
        let (map, tier) = fit(&pairs, FitModel::Affine, twist);
        assert_eq!(tier, Tier::Flat);
        // What a weight of 2⁻²⁴ leaves of f64 rounding.
        assert!(
            (map.linear * DVec3::Y - twist * DVec3::Y).length() < 1e-6,
            "{}",
            map.linear
        );
    }
}
