use super::{F64_CHAIN, SMALLEST_NORMAL};
use crate::{
    affine64::Affine64,
    relative_motions::LargestEntries,
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
                    map: map.map.after(simd, &inner.map),
                    magnitudes: map.magnitudes.after(simd, &inner.magnitudes),
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
            columns[j] = exact.to_point();
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

/// Bounds what enters the products of an instance transform T and some bones' maps X°, `|T||X°|`, by the largest entries of
/// these, row by row: N of point 1 has it times 2⁻²⁴, so a bound is as good as the product.
///
/// Its sums have a dozen roundings in `f64`, each 2⁻⁵³ of a sum of positive numbers. Factors that it meets, as u + γₙ of point 2,
/// have 2⁻⁴⁴ relatively to spare for such ([`vertex_error`](super::vertex_error)).
#[derive(Clone, Copy)]
pub(crate) struct Entering<S: Lanes> {
    /// Of each entry of the product's linear part, and of each of its translation: per world axis, times 2⁻²⁴.
    linear: Doubles<S>,
    offset: Doubles<S>,
    smallest: Doubles<S>,
}

impl<S: Lanes> Entering<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, transform: &Affine, largest: &LargestEntries) -> Self {
        let [x, y, z, offset] = columns(simd, transform);
        let turned = [x.abs(), y.abs(), z.abs()];
        Self {
            linear: weighted_sum(turned, largest.linear) * F64_CHAIN,
            offset: (weighted_sum(turned, largest.offset) + offset.abs()) * F64_CHAIN,
            smallest: Doubles::splat(simd, SMALLEST_NORMAL),
        }
    }

    /// A bone's map to world space, whose product is `map`.
    #[inline(always)]
    pub(crate) fn posed_map(&self, simd: S, map: &Affine) -> PosedMap {
        let [x, y, z, offset] = columns(simd, map);
        let linear = self.linear + self.smallest;
        let offset = offset.abs() + self.offset + self.smallest;
        PosedMap {
            map: *map,
            magnitude: [
                (x.abs() + linear).numbers(),
                (y.abs() + linear).numbers(),
                (z.abs() + linear).numbers(),
                offset.numbers(),
            ],
        }
    }

    /// E of point 2 for points of bone rows, by the greatest magnitudes that each of them moves; `posed` are the bones' maps to
    /// world space. A bone that is not a number moves nothing to any place, and takes nothing from the others.
    #[inline(always)]
    pub(crate) fn reach(&self, simd: S, posed: &[Affine], points: impl Iterator<Item = (u32, [f64; 3])>) -> Doubles<S> {
        let (mut image, mut longest) = (Doubles::splat(simd, 0.0), 0.0f64);
        for (bone, extent) in points {
            image = greatest_image(simd, &posed[bone as usize], extent).max(image);
            longest = longest.max(extent[0] + extent[1] + extent[2]);
        }
        image + (self.linear * longest + self.offset) + self.smallest * (longest + 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Portable;

    fn largest(map: &Affine) -> LargestEntries {
        let of = |columns: &[[f32; 3]], row: usize| {
            let entries = columns.iter().map(|column| f64::from(column[row].abs()));
            entries.fold(0.0, f64::max)
        };
        LargestEntries {
            linear: [0, 1, 2].map(|row| of(&map.columns[..3], row)),
            offset: [0, 1, 2].map(|row| of(&map.columns[3..], row)),
        }
    }

    /// What is known of a bone's map without its product bounds that of the product.
    #[test]
    fn posed_maps_need_no_product() {
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
            let map = product.map;
            let entering = Entering::new(Portable, &transform, &largest(&x));
            let posed = entering.posed_map(Portable, &map);
            let expected = product.reach(Portable, extent).numbers();
            let found = entering.reach(Portable, &[map], [(0, extent)].into_iter()).numbers();
            // A dozen roundings each.
            let rounding = 32.0 * f64::EPSILON;
            for k in 0..3 {
                assert!(
                    found[k] >= expected[k] * (1.0 - rounding),
                    "{round}: {found:?} {expected:?}"
                );
                for j in 0..4 {
                    let (found, expected) = (posed.magnitude[j][k], product.magnitude[j][k]);
                    assert!(found >= expected * (1.0 - rounding), "{round}: {found} {expected}");
                }
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
        let posed = PosedMap::product(Portable, &[&Map64::new(&transform), &Map64::new(&x)]).map;
        assert_eq!(posed, Affine::IDENTITY);
        let entering = Entering::new(Portable, &transform, &largest(&x));
        let reach = entering
            .reach(Portable, &[posed], [(0, [1.0; 3])].into_iter())
            .numbers();
        assert!(
            reach[0] > 1.0 + 2e6 * F64_CHAIN * 0.99 && reach[1] < 1.0 + 1e-6,
            "{reach:?}"
        );
    }

    /// Wherever the bone stands that a chain of others has made no number.
    #[test]
    fn a_bone_that_is_not_a_number_hides_no_other() {
        let far = Affine::from_translation([1e6, 0.0, 0.0]);
        let unknown = Affine::from_translation([f32::NAN; 3]);
        let entering = Entering::new(Portable, &Affine::IDENTITY, &largest(&far));
        for bones in [
            [far, unknown, Affine::IDENTITY],
            [unknown, far, Affine::IDENTITY],
            [Affine::IDENTITY, far, unknown],
        ] {
            let points = (0..3).map(|bone| (bone, [1.0; 3]));
            let [x, ..] = entering.reach(Portable, &bones, points).numbers();
            assert!(x > 1e6, "{x}");
        }
    }
}
