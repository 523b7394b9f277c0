use super::{F64_CHAIN, SMALLEST_NORMAL};
use crate::simd::{Four, four};
use restpose_formats::geom::Affine;

/// An affine map in `f64`, with bounds of the magnitudes that entered its entries. Columns of three, and a number that means
/// nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Map64 {
    columns: [Four; 4],
    magnitudes: [Four; 4],
}

impl Map64 {
    /// A stored map, exactly.
    #[inline(always)]
    pub(crate) fn new(map: &Affine) -> Self {
        let columns = widened(map);
        let [x, y, z, offset] = columns;
        Self {
            columns,
            magnitudes: [magnitude(x), magnitude(y), magnitude(z), magnitude(offset)],
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
        let mix = |a: &[Four; 4], b: &[Four; 4]| {
            std::array::from_fn(|j| four(|k| weights[0] * a[j][k] + weights[1] * b[j][k]))
        };
        Self {
            columns: mix(&a.columns, &b.columns),
            magnitudes: mix(&a.magnitudes, &b.magnitudes),
        }
    }

    #[inline(always)]
    fn is_identity(&self) -> bool {
        self.columns == IDENTITY
    }
}

const IDENTITY: [Four; 4] = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
    [0.0; 4],
];

#[inline(always)]
fn widened(map: &Affine) -> [Four; 4] {
    let wide = |[x, y, z]: [f32; 3]| [f64::from(x), f64::from(y), f64::from(z), 0.0];
    let [x, y, z, offset] = map.columns;
    [wide(x), wide(y), wide(z), wide(offset)]
}

#[inline(always)]
fn magnitude(column: Four) -> Four {
    four(|k| column[k].abs())
}

/// The columns of `a` after `b`.
#[inline(always)]
fn product([x, y, z, offset]: &[Four; 4], b: &[Four; 4]) -> [Four; 4] {
    let turned = |v: &Four, offset: &Four| four(|k| x[k] * v[0] + y[k] * v[1] + z[k] * v[2] + offset[k]);
    let [a, b, c, d] = b;
    // Adding zero turns −0 into +0.
    let zero = [0.0; 4];
    [turned(a, &zero), turned(b, &zero), turned(c, &zero), turned(d, offset)]
}

/// The map of [`PosedMap::product`] alone, the same bits: what vertices are posed by.
#[inline(always)]
pub(crate) fn posed_map(transform: &Map64, x: &Affine) -> Affine {
    if transform.is_identity() {
        *x
    } else if *x == Affine::IDENTITY {
        rounded(&transform.columns)
    } else {
        rounded(&product(&transform.columns, &widened(x)))
    }
}

#[inline(always)]
fn rounded(columns: &[Four; 4]) -> Affine {
    let round = |[x, y, z, _]: Four| [x as f32, y as f32, z as f32];
    let [x, y, z, offset] = *columns;
    Affine {
        columns: [round(x), round(y), round(z), round(offset)],
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
    pub(crate) fn product(maps: &[&Map64]) -> Self {
        Self::weighted(1.0, maps)
    }

    /// `weight` times the product of maps: images of points are `weight` times theirs under the product.
    #[inline(always)]
    pub(crate) fn weighted(weight: f64, maps: &[&Map64]) -> Self {
        let mut total: Option<Map64> = None;
        for map in maps.iter().rev() {
            if map.is_identity() {
                continue;
            }
            total = Some(match total {
                None => **map,
                Some(inner) => Map64 {
                    columns: product(&map.columns, &inner.columns),
                    magnitudes: product(&map.magnitudes, &inner.magnitudes),
                },
            });
        }
        let total = match total {
            Some(total) => total,
            None => Map64::new(&Affine::IDENTITY),
        };
        let mut columns = total.columns;
        for column in &mut columns {
            *column = four(|k| column[k] * weight);
        }
        let map = rounded(&columns);
        let (kept, entering) = (widened(&map), &total.magnitudes);
        let mut magnitude = [[0.0; 4]; 4];
        for j in 0..4 {
            // A subnormal entry is rounded by up to 2⁻¹⁵⁰, which is u times the last term.
            magnitude[j] = four(|k| kept[j][k].abs() + entering[j][k] * weight * F64_CHAIN + SMALLEST_NORMAL);
        }
        Self { map, magnitude }
    }

    /// The map's columns.
    #[inline(always)]
    pub(super) fn columns(&self) -> [Four; 4] {
        widened(&self.map)
    }

    /// `N·(|p|, 1)` for points with `|p| ≤ extent`.
    #[inline(always)]
    pub(crate) fn reach(&self, [a, b, c]: [f64; 3]) -> Four {
        let [x, y, z, offset] = &self.magnitude;
        four(|k| x[k] * a + y[k] * b + z[k] * c + offset[k])
    }
}

/// What [`PosedMap::reach`] of the product of a transform and a bone's map is, without that product: `posed` is its map. With
/// `|T||X|·p = |T|·(|X|·p)` a third of the multiplications are left.
///
/// It is E of point 2 but for the order of a dozen roundings in `f64`, each 2⁻⁵³ of a sum of positive numbers. The factor that
/// E gets, u + γₙ, has [`F64_SLACK`] of 2⁻⁴⁴ relatively for such ([`vertex_error`]).
#[inline(always)]
pub(crate) fn posed_reach(transform: &Affine, x: &Affine, posed: &Affine, extent: [f64; 3]) -> Four {
    let images = |map: &Affine, p: [f64; 3]| {
        let [x, y, z, offset] = widened(map);
        four(|k| x[k].abs() * p[0] + y[k].abs() * p[1] + z[k].abs() * p[2] + offset[k].abs())
    };
    let [a, b, c, _] = images(x, extent);
    let entering = images(transform, [a, b, c]);
    let reach = images(posed, extent);
    let smallest = SMALLEST_NORMAL * (extent[0] + extent[1] + extent[2] + 1.0);
    four(|k| reach[k] + F64_CHAIN * entering[k] + smallest)
}

#[cfg(test)]
mod tests {
    use super::*;

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
            let product = PosedMap::product(&[&Map64::new(&transform), &Map64::new(&x)]);
            let posed = posed_map(&Map64::new(&transform), &x);
            assert_eq!(posed, product.map);
            let (expected, found) = (product.reach(extent), posed_reach(&transform, &x, &posed, extent));
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
        let reach = posed_reach(&transform, &x, &posed, [1.0; 3]);
        assert!(
            reach[0] > 1.0 + 2e6 * F64_CHAIN * 0.99 && reach[1] < 1.0 + 1e-6,
            "{reach:?}"
        );
    }
}
