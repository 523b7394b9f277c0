use super::{F64_CHAIN, SMALLEST_NORMAL};
use crate::{
    affine64::Affine64,
    simd::{Doubles, Four, Lanes, four, weighted_sum},
};
use restpose_formats::geom::Affine;

/// An affine map in `f64`, with bounds of the magnitudes that entered its entries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Map64 {
    map: Affine64,
    magnitudes: Affine64,
}

impl Map64 {
    /// A stored map, exactly.
    #[inline(always)]
    pub(crate) fn new(map: &Affine) -> Self {
        let map = Affine64::from_affine(map);
        let [x, y, z, offset] = map.columns;
        let columns = [magnitude(x), magnitude(y), magnitude(z), magnitude(offset)];
        Self {
            map,
            magnitudes: Affine64 { columns },
        }
    }

    /// `q ↦ origin + step·q`, exactly.
    pub(crate) fn lattice(origin: [f32; 3], step: f32) -> Self {
        Self::new(&Affine {
            columns: [[step, 0.0, 0.0], [0.0, step, 0.0], [0.0, 0.0, step], origin],
        })
    }

    /// `Σ weight·map` over two maps; weights are not negative.
    pub(crate) fn blend(weights: [f64; 2], [a, b]: &[Self; 2]) -> Self {
        let mix = |a: &Affine64, b: &Affine64| Affine64 {
            columns: std::array::from_fn(|j| four(|k| weights[0] * a.columns[j][k] + weights[1] * b.columns[j][k])),
        };
        Self {
            map: mix(&a.map, &b.map),
            magnitudes: mix(&a.magnitudes, &b.magnitudes),
        }
    }
}

#[inline(always)]
fn magnitude(column: Four) -> Four {
    four(|k| column[k].abs())
}

/// The map of [`PosedMap::product`] alone, the same bits: what vertices are posed by.
#[inline(always)]
pub(crate) fn posed_map(transform: &Map64, x: &Affine) -> Affine {
    if transform.map.is_identity() {
        *x
    } else if *x == Affine::IDENTITY {
        transform.map.to_affine()
    } else {
        transform.map.after(&Affine64::from_affine(x)).to_affine()
    }
}

/// A map to world space, rounded to `f32` once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PosedMap {
    pub map: Affine,
    /// N of point 1: bounds `|X|` and, times u, the error of X.
    magnitude: [Four; 4],
}

impl PosedMap {
    /// The product of maps, the first one applied last.
    ///
    /// Complexity: identities are left out, which keeps them exact and the bound small.
    #[inline(always)]
    pub(crate) fn product<S: Lanes>(simd: S, maps: &[&Map64]) -> Self {
        Self::weighted(simd, 1.0, maps)
    }

    /// `weight` times the product of maps: images of points are `weight` times theirs under the product.
    #[inline(always)]
    pub(crate) fn weighted<S: Lanes>(simd: S, weight: f64, maps: &[&Map64]) -> Self {
        let mut total: Option<Map64> = None;
        for map in maps.iter().rev() {
            if map.map.is_identity() {
                continue;
            }
            total = Some(match total {
                None => **map,
                Some(inner) => Map64 {
                    map: map.map.after_in(simd, &inner.map),
                    magnitudes: map.magnitudes.after_in(simd, &inner.magnitudes),
                },
            });
        }
        let Map64 { map, magnitudes } = match total {
            Some(total) => total,
            None => Map64::new(&Affine::IDENTITY),
        };
        let (mut columns, mut magnitude) = ([[0.0; 3]; 4], [[0.0; 4]; 4]);
        for j in 0..4 {
            let exact = Doubles::new(simd, &map.columns[j]) * weight;
            let [x, y, z, _] = exact.to_f32();
            columns[j] = [x, y, z];
            let entering = Doubles::new(simd, &magnitudes.columns[j]) * weight * F64_CHAIN;
            // A subnormal entry is rounded by up to 2⁻¹⁵⁰, which is u times the last term.
            let sum = exact.rounded().abs() + entering + Doubles::splat(simd, SMALLEST_NORMAL);
            magnitude[j] = sum.numbers();
        }
        Self {
            map: Affine { columns },
            magnitude,
        }
    }

    /// The map's columns.
    #[inline(always)]
    pub(super) fn columns<S: Lanes>(&self, simd: S) -> [Doubles<S>; 4] {
        columns(simd, &self.map)
    }

    /// `N·(|p|, 1)` for points with `|p| ≤ extent`.
    #[inline(always)]
    pub(crate) fn reach<S: Lanes>(&self, simd: S, extent: [f64; 3]) -> Doubles<S> {
        let [x, y, z, offset] = &self.magnitude;
        let linear = [Doubles::new(simd, x), Doubles::new(simd, y), Doubles::new(simd, z)];
        weighted_sum(linear, extent) + Doubles::new(simd, offset)
    }
}

#[inline(always)]
fn columns<S: Lanes>(simd: S, map: &Affine) -> [Doubles<S>; 4] {
    let [x, y, z, offset] = map.columns;
    [
        Doubles::from_point(simd, x),
        Doubles::from_point(simd, y),
        Doubles::from_point(simd, z),
        Doubles::from_point(simd, offset),
    ]
}

/// `|X|·(|p|, 1)` for points with `|p| ≤ extent`.
#[inline(always)]
fn greatest_image<S: Lanes>(simd: S, map: &Affine, extent: [f64; 3]) -> Doubles<S> {
    let [x, y, z, offset] = columns(simd, map);
    weighted_sum([x.abs(), y.abs(), z.abs()], extent) + offset.abs()
}

/// What [`PosedMap::reach`] of the product of a transform and a bone's map is, without that product: `posed` is its map. With
/// `|T||X|·p = |T|·(|X|·p)` a third of the multiplications are left.
///
/// It is E of point 2 but for the order of a dozen roundings in `f64`, each 2⁻⁵³ of a sum of positive numbers. The factor
/// that E gets, u + γₙ, has 2⁻⁴⁴ relatively to spare for such ([`vertex_error`](super::vertex_error)).
#[inline(always)]
pub(crate) fn posed_reach<S: Lanes>(
    simd: S,
    transform: &Affine,
    x: &Affine,
    posed: &Affine,
    extent: [f64; 3],
) -> Doubles<S> {
    let [a, b, c, _] = greatest_image(simd, x, extent).numbers();
    let entering = greatest_image(simd, transform, [a, b, c]);
    let reach = greatest_image(simd, posed, extent);
    let smallest = SMALLEST_NORMAL * (extent[0] + extent[1] + extent[2] + 1.0);
    reach + entering * F64_CHAIN + Doubles::splat(simd, smallest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Portable;

    /// The reach of a product, by two ways.
    #[test]
    fn reach_needs_no_product() {
        let mut random = fastrand::Rng::with_seed(9);
        for round in 0..20_000 {
            let mut map = |identity: bool| {
                if identity {
                    return Affine::IDENTITY;
                }
                let scale = 10f32.powi(random.i32(-20..18));
                let mut column = || std::array::from_fn(|_| (random.f32() - 0.5) * scale);
                Affine {
                    columns: std::array::from_fn(|_| column()),
                }
            };
            let (transform, x) = (map(round % 5 == 0), map(round % 7 == 0));
            let extent: [f64; 3] = std::array::from_fn(|_| random.f64() * 10f64.powi(random.i32(-9..9)));
            let product = PosedMap::product(Portable, &[&Map64::new(&transform), &Map64::new(&x)]);
            let posed = posed_map(&Map64::new(&transform), &x);
            assert_eq!(posed, product.map);
            let expected = product.reach(Portable, extent).numbers();
            let found = posed_reach(Portable, &transform, &x, &posed, extent).numbers();
            for k in 0..3 {
                // A dozen roundings each.
                let difference = (found[k] - expected[k]).abs();
                assert!(
                    difference <= 32.0 * f64::EPSILON * expected[k],
                    "{round}: {found:?} {expected:?}"
                );
            }
        }
    }

    /// What enters counts where products cancel: the map alone does not tell.
    #[test]
    fn reach_counts_what_cancels() {
        let shift = |by: f32| Affine {
            columns: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [by, 0.0, 0.0]],
        };
        let (transform, x) = (shift(1e6), shift(-1e6));
        let posed = posed_map(&Map64::new(&transform), &x);
        assert_eq!(posed, Affine::IDENTITY);
        let reach = posed_reach(Portable, &transform, &x, &posed, [1.0; 3]).numbers();
        assert!(
            reach[0] > 1.0 + 2e6 * F64_CHAIN * 0.99 && reach[1] < 1.0 + 1e-6,
            "{reach:?}"
        );
    }
}
