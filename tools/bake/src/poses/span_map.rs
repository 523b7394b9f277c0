//! Affine maps over a span of time, with bounds of what happens between its ends.

/// Twelve numbers of an affine map, columns first.
pub(crate) type Numbers = [f64; 12];

const IDENTITY: Numbers = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];

/// A twice differentiable affine map over a span of time, which counts from 0 to 1.
///
/// Guarantee: each number stays within `curvature / 8` of the straight line between its ends, for
/// `|f(s) − chord(s)| ≤ s(1 − s)/2 · sup|f″|`. Rounding in `f64` is not in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpanMap {
    pub begin: Numbers,
    pub end: Numbers,
    /// Bounds `|f′|`.
    pub rate: Numbers,
    /// Bounds `|f″|`.
    pub curvature: Numbers,
}

impl SpanMap {
    pub(crate) fn constant(columns: [[f64; 3]; 4]) -> Self {
        let mut numbers = [0.0; 12];
        numbers.copy_from_slice(columns.as_flattened());
        Self {
            begin: numbers,
            end: numbers,
            rate: [0.0; 12],
            curvature: [0.0; 12],
        }
    }

    pub(crate) fn translation(by: [SpanNumber; 3]) -> Self {
        let mut out = Self::constant([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]]);
        for k in 0..3 {
            out.set(9 + k, by[k]);
        }
        out
    }

    pub(crate) fn scale(by: [SpanNumber; 3]) -> Self {
        let mut out = Self::constant([[0.0; 3]; 4]);
        for k in 0..3 {
            out.set(4 * k, by[k]);
        }
        out
    }

    /// A rotation between these matrices, columns first, at an angular velocity of at most `speed` and an angular
    /// acceleration of at most `acceleration`, radians per span: `M′ = [ω]×·M` and `M″ = ([ω]×² + [ω′]×)·M`.
    pub(crate) fn rotation(begin: [[f64; 3]; 3], end: [[f64; 3]; 3], speed: f64, acceleration: f64) -> Self {
        let mut out = Self::constant([[0.0; 3]; 4]);
        out.begin[..9].copy_from_slice(begin.as_flattened());
        out.end[..9].copy_from_slice(end.as_flattened());
        out.rate[..9].fill(speed);
        out.curvature[..9].fill(speed * speed + acceleration);
        out
    }

    fn set(&mut self, n: usize, number: SpanNumber) {
        self.begin[n] = number.begin;
        self.end[n] = number.end;
        self.rate[n] = number.rate;
        self.curvature[n] = number.curvature;
    }

    /// Bounds `|f|`.
    pub(crate) fn magnitude(&self) -> Numbers {
        std::array::from_fn(|n| self.begin[n].abs().max(self.end[n].abs()) + 0.125 * self.curvature[n])
    }

    /// This map after `inner`.
    pub(crate) fn after(&self, inner: &Self) -> Self {
        let (outer_size, inner_size) = (self.magnitude(), inner.magnitude());
        let mut rate = product(&self.rate, &inner_size, &self.rate);
        let mut curvature = product(&self.curvature, &inner_size, &self.curvature);
        let swung = product(&outer_size, &inner.rate, &[0.0; 12]);
        let both = product(&self.rate, &inner.rate, &[0.0; 12]);
        let bent = product(&outer_size, &inner.curvature, &[0.0; 12]);
        for n in 0..12 {
            rate[n] += swung[n];
            curvature[n] += 2.0 * both[n] + bent[n];
        }
        Self {
            begin: product(&self.begin, &inner.begin, &self.begin),
            end: product(&self.end, &inner.end, &self.end),
            rate,
            curvature,
        }
    }
}

/// The linear part of `a` times `b`, plus the translation of `offset`.
pub(super) fn product(a: &Numbers, b: &Numbers, offset: &Numbers) -> Numbers {
    std::array::from_fn(|n| {
        let (j, k) = (n / 3, n % 3);
        let linear = a[k] * b[3 * j] + a[3 + k] * b[3 * j + 1] + a[6 + k] * b[3 * j + 2];
        if j == 3 { linear + offset[9 + k] } else { linear }
    })
}

/// A number over a span of time; fields as in [`SpanMap`], and one more.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SpanNumber {
    pub begin: f64,
    pub end: f64,
    pub rate: f64,
    pub curvature: f64,
    /// Bounds the sum of the magnitudes that enter it: rounding is relative to that.
    pub terms: f64,
}

impl SpanNumber {
    pub(crate) fn constant(value: f64) -> Self {
        Self {
            begin: value,
            end: value,
            rate: 0.0,
            curvature: 0.0,
            terms: value.abs(),
        }
    }

    /// Everything it takes, as least and greatest.
    pub(crate) fn range(&self) -> (f64, f64) {
        let bend = 0.125 * self.curvature;
        (self.begin.min(self.end) - bend, self.begin.max(self.end) + bend)
    }

    pub(crate) fn negated(self) -> Self {
        Self {
            begin: -self.begin,
            end: -self.end,
            ..self
        }
    }

    /// One over it; `None` where it may be zero.
    pub(crate) fn inverted(self) -> Option<Self> {
        let (least, greatest) = self.range();
        let nearest = if least > 0.0 {
            least
        } else if greatest < 0.0 {
            -greatest
        } else {
            return None;
        };
        let out = Self {
            begin: 1.0 / self.begin,
            end: 1.0 / self.end,
            rate: self.rate / (nearest * nearest),
            curvature: (2.0 * self.rate * self.rate / nearest + self.curvature) / (nearest * nearest),
            terms: self.terms / (nearest * nearest),
        };
        (out.begin.is_finite() && out.end.is_finite() && out.curvature.is_finite()).then_some(out)
    }
}

/// The identity's numbers off, so that what is left is how a map displaces points.
pub(crate) fn less_identity(numbers: &Numbers) -> Numbers {
    std::array::from_fn(|n| numbers[n] - IDENTITY[n])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A turn about a skew axis with growing scale and a shift along a parabola, seen through its inverse: what the
    /// bounds say holds at many times in between.
    #[test]
    fn chains_stay_within_their_bounds() {
        let mut random = fastrand::Rng::with_seed(4);
        for _ in 0..200 {
            let mut signed = |size: f64| (random.f64() * 2.0 - 1.0) * size;
            let axis = glam::DVec3::new(signed(1.0), signed(1.0), signed(1.0) + 1.5).normalize();
            let angle = signed(0.6);
            let (shift, bend) = (glam::DVec3::new(signed(2.0), signed(2.0), signed(2.0)), signed(0.5));
            let scale = [1.0, 1.0 + signed(0.4)];
            let place = |s: f64| shift * s + glam::DVec3::X * bend * s * s;
            let at = |s: f64| {
                let linear = glam::DMat3::from_axis_angle(axis, angle * s) * (scale[0] + (scale[1] - scale[0]) * s);
                glam::DAffine3::from_mat3_translation(linear, place(s))
            };
            let along = |k: usize| SpanNumber {
                begin: place(0.0)[k],
                end: place(1.0)[k],
                rate: shift[k].abs() + if k == 0 { 2.0 * bend.abs() } else { 0.0 },
                curvature: if k == 0 { 2.0 * bend.abs() } else { 0.0 },
                terms: 0.0,
            };
            let size = SpanNumber {
                begin: scale[0],
                end: scale[1],
                rate: (scale[1] - scale[0]).abs(),
                curvature: 0.0,
                terms: 0.0,
            };
            let turned = |s: f64| glam::DMat3::from_axis_angle(axis, angle * s).to_cols_array_2d();
            let rotation = SpanMap::rotation(turned(0.0), turned(1.0), angle.abs(), 0.0);
            let back = glam::DMat3::from_axis_angle(axis, angle).transpose().to_cols_array_2d();
            let unturned = SpanMap::rotation(turned(0.0), back, angle.abs(), 0.0);
            let forward =
                SpanMap::translation([along(0), along(1), along(2)]).after(&rotation.after(&SpanMap::scale([size; 3])));
            let inverse = SpanMap::scale([size.inverted().unwrap(); 3])
                .after(&unturned)
                .after(&SpanMap::translation([0, 1, 2].map(|k| along(k).negated())));
            let still = SpanMap::constant([[0.3, 1.0, 0.0], [-1.0, 0.2, 0.5], [0.0, 0.1, 2.0], [1.0, 2.0, 3.0]]);
            let chain = inverse.after(&still).after(&forward);
            let constant = glam::DAffine3::from_cols_array(&still.begin);
            for step in 0..=50 {
                let s = f64::from(step) / 50.0;
                let exact = (at(s).inverse() * constant * at(s)).to_cols_array();
                for n in 0..12 {
                    let chord = (1.0 - s) * chain.begin[n] + s * chain.end[n];
                    // Twelve digits: products of a dozen numbers of size one in f64.
                    let bound = 0.5 * s * (1.0 - s) * chain.curvature[n] + 1e-12;
                    assert!(
                        (exact[n] - chord).abs() <= bound,
                        "{n} at {s}: {} {chord} {bound}",
                        exact[n]
                    );
                }
            }
        }
    }

    #[test]
    fn what_may_vanish_has_no_inverse() {
        let number = |begin, end, curvature| SpanNumber {
            begin,
            end,
            rate: 1.0,
            curvature,
            terms: 0.0,
        };
        assert!(number(1.0, 2.0, 0.0).inverted().is_some() && number(-1.0, -2.0, 7.9).inverted().is_some());
        assert_eq!(number(-1.0, 1.0, 0.0).inverted(), None);
        assert_eq!(number(1.0, 2.0, 8.0).inverted(), None);
    }
}
