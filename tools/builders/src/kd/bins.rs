use super::cell_cost::CellCost;
use super::float_order::{number, order};
use super::fragment::Fragment;
use restpose_formats::geom::Aabb;

/// Counters of where fragments begin and end, in up to [`Bins::MAX_COUNT`] equal bins per axis.
///
/// The three axes are lanes of one vector, so that all are binned and summed at once.
///
/// Source: Günther, *Ray Tracing of Dynamic Scenes*, 2014, §4.2.1.
#[derive(Clone, Debug)]
pub(super) struct Bins {
    starts: Vec<[u32; 4]>,
    ends: Vec<[u32; 4]>,
    count: usize,
    min: [f32; 4],
    /// Bins per two units of length.
    scale: [f32; 4],
    max: [f32; 4],
}

/// The cheapest border between two bins of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Border {
    pub cost: f32,
    pub axis: usize,
    /// Bins below it.
    pub below: usize,
    /// Fragments that begin below it.
    pub left: usize,
    /// Fragments that end above it, or at it.
    pub right: usize,
}

/// Adding this leaves the nearest whole number in the low bits of the sum.
const ROUNDING: f32 = 8_388_608.0;

impl Bins {
    /// Bins per axis of the thesis.
    pub(super) const MAX_COUNT: usize = 1024;

    pub(super) fn new() -> Self {
        Self {
            starts: vec![[0; 4]; Self::MAX_COUNT],
            ends: vec![[0; 4]; Self::MAX_COUNT],
            count: 1,
            min: [0.0; 4],
            scale: [0.0; 4],
            max: [0.0; 4],
        }
    }

    /// Empties `count` bins and lays them over `range`. At most [`Bins::MAX_COUNT`] are laid.
    pub(super) fn lay(&mut self, range: &Aabb, count: usize) {
        self.count = count.clamp(1, Self::MAX_COUNT);
        self.starts[..self.count].fill([0; 4]);
        self.ends[..self.count].fill([0; 4]);
        for k in 0..3 {
            self.min[k] = range.min[k];
            self.max[k] = range.max[k];
            let length = f64::from(range.max[k]) - f64::from(range.min[k]);
            // The outer bins are half as long: positions are rounded to the nearest bin.
            let scale = (2.0 * (self.count - 1) as f64 / length) as f32;
            self.scale[k] = if scale.is_finite() { scale } else { 0.0 };
        }
    }

    /// Lays as many bins over `range` as there are fragments, from 16 to 256. More gain no quality that can be measured.
    pub(super) fn lay_adaptive(&mut self, range: &Aabb, fragments: usize) {
        self.lay(range, fragments.clamp(16, 256));
    }

    /// Counts fragments within the range.
    #[inline]
    pub(super) fn add(&mut self, fragments: &[Fragment]) {
        let last = self.count as u32 - 1;
        let (starts, ends) = (&mut self.starts[..self.count], &mut self.ends[..self.count]);
        for fragment in fragments {
            let (mut first, mut end) = ([0; 4], [0; 4]);
            for k in 0..4 {
                first[k] = bin(fragment.min[k], self.min[k], self.scale[k]);
                end[k] = bin(fragment.max[k], self.min[k], self.scale[k]);
            }
            for k in 0..3 {
                starts[first[k].min(last) as usize][k] += 1;
                ends[end[k].min(last) as usize][k] += 1;
            }
        }
    }

    /// The cheapest border for `total` fragments, by the counts of the bins; of equal ones the lowest axis, then the
    /// lowest position.
    ///
    /// Borders with nothing on one side are none of it. The areas of both sides change by a constant from border to
    /// border.
    pub(super) fn cheapest_border(&self, cost: &CellCost, total: usize) -> Option<Border> {
        let (mut left, mut right) = ([0u32; 4], [total as u32; 4]);
        let (mut best, mut at) = ([f32::INFINITY; 4], [0u32; 4]);
        let (mut rim, mut step) = ([0.0; 4], [0.0; 4]);
        for k in 0..3 {
            let bin = if self.scale[k] > 0.0 {
                2.0 / self.scale[k]
            } else {
                f32::NAN
            };
            let slope = 1.0 - cost.flat[k];
            step[k] = bin * cost.inverse[k] * slope;
            rim[k] = cost.share(k, self.min[k]) * slope - 0.5 * step[k];
        }
        for below in 1..self.count {
            for k in 0..4 {
                left[k] += self.starts[below - 1][k];
                right[k] -= self.ends[below - 1][k];
                rim[k] += step[k];
                let (l, r) = (left[k] as i32 as f32, right[k] as i32 as f32);
                let tests = l * (cost.flat[k] + rim[k]) + r * (1.0 - rim[k]);
                let better = (tests < best[k]) & (l > 0.0) & (r > 0.0);
                best[k] = if better { tests } else { best[k] };
                at[k] = if better { below as u32 } else { at[k] };
            }
        }
        let (mut axis, mut price) = (3, f32::INFINITY);
        for k in 0..3 {
            if at[k] > 0 && best[k] < price {
                (axis, price) = (k, best[k]);
            }
        }
        if axis == 3 {
            return None;
        }
        let below = at[axis] as usize;
        let sum = |counts: &[[u32; 4]]| counts.iter().map(|bin| bin[axis] as usize).sum();
        let ended: usize = sum(&self.ends[..below]);
        Some(Border {
            cost: cost.traversal + cost.intersection * price,
            axis,
            below,
            left: sum(&self.starts[..below]),
            right: total - ended,
        })
    }

    /// The least number that falls into a bin at or above `below` along `axis`.
    ///
    /// Bins are found by operations that round monotonically, so exactly the numbers below it fall below the border: a
    /// fragment begins left of the position if and only if it was counted so. What ends right of it was counted so too;
    /// what ends or lies just at it was counted right, so the count there is never too small.
    ///
    /// Found among all floats between the sides of the range by bisection, not computed from the bin.
    pub(super) fn position(&self, axis: usize, below: usize) -> f32 {
        let (mut lower, mut upper) = (order(self.min[axis]), order(self.max[axis]));
        while lower < upper {
            let middle = lower + (upper - lower) / 2;
            let found = bin(number(middle), self.min[axis], self.scale[axis]);
            if found as usize >= below {
                upper = middle;
            } else {
                lower = middle + 1;
            }
        }
        // Adding zero turns −0 into +0.
        number(lower) + 0.0
    }

    /// About where the border lies.
    pub(super) fn near(&self, axis: usize, below: usize) -> f32 {
        self.min[axis] + (2 * below - 1) as f32 / self.scale[axis]
    }
}

/// The bin of a position at or above `min`. Halves, since the length of a cell may be no number.
#[inline]
fn bin(position: f32, min: f32, scale: f32) -> u32 {
    ((0.5 * position - 0.5 * min) * scale + ROUNDING).to_bits() & 0x007f_ffff
}

#[cfg(test)]
mod tests {
    use super::*;
    use restpose_runtime::build::KdSettings;

    fn scattered(count: u32, seed: u64) -> Vec<Fragment> {
        let mut random = fastrand::Rng::with_seed(seed);
        let boxes = (0..count).map(|id| {
            let min = [0; 3].map(|_| random.f32() * 8.0 - 3.0);
            let max = min.map(|x| x + random.f32().powi(4) * 4.0);
            Fragment::of(&Aabb { min, max }, id)
        });
        boxes.collect()
    }

    #[test]
    fn counts_at_a_border_are_those_of_its_position() {
        for seed in 0..20 {
            let fragments = scattered(200, seed);
            let cell = super::super::fragment::bounds_of(&fragments);
            let mut bins = Bins::new();
            for count in [2, 7, 64, Bins::MAX_COUNT] {
                bins.lay(&cell, count);
                bins.add(&fragments);
                for axis in 0..3 {
                    let (mut left, mut ended) = (0, 0);
                    for below in 1..count {
                        left += bins.starts[below - 1][axis] as usize;
                        ended += bins.ends[below - 1][axis] as usize;
                        let position = bins.position(axis, below);
                        let begun = fragments.iter().filter(|f| f.min[axis] < position).count();
                        let ends = fragments.iter().filter(|f| f.max[axis] >= position).count();
                        assert_eq!(
                            (left, 200 - ended),
                            (begun, ends),
                            "border {below} of {count} on axis {axis}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn the_cheapest_border_is_that_of_brute_force() {
        for seed in 0..50 {
            let fragments = scattered(40, seed);
            let cell = super::super::fragment::bounds_of(&fragments);
            let cost = CellCost::new(&cell, &KdSettings::default());
            let mut bins = Bins::new();
            bins.lay(&cell, Bins::MAX_COUNT);
            bins.add(&fragments);
            let found = bins.cheapest_border(&cost, fragments.len()).unwrap();
            let mut least = f32::INFINITY;
            for axis in 0..3 {
                for below in 1..Bins::MAX_COUNT {
                    let position = bins.position(axis, below);
                    let left = fragments.iter().filter(|f| f.min[axis] < position).count();
                    let right = fragments.iter().filter(|f| f.max[axis] >= position).count();
                    if left > 0 && right > 0 {
                        let t = cost.share(axis, position);
                        least = least.min(cost.cut(axis, t, left as f32, right as f32));
                    }
                }
            }
            // The sum of 1,023 steps of a share below one, in single precision.
            assert!(
                (found.cost - least).abs() <= 1e-4 * least,
                "{} against {least}",
                found.cost
            );
        }
    }

    #[test]
    fn the_longest_cells_have_bins() {
        let ends = [f32::MIN, f32::MAX];
        let fragments: Vec<_> = ends
            .iter()
            .zip(0..)
            .map(|(&x, id)| {
                Fragment::of(
                    &Aabb {
                        min: [x; 3],
                        max: [x; 3],
                    },
                    id,
                )
            })
            .collect();
        let mut bins = Bins::new();
        bins.lay(&super::super::fragment::bounds_of(&fragments), 16);
        bins.add(&fragments);
        assert_eq!((bins.starts[0], bins.ends[15]), ([1, 1, 1, 0], [1, 1, 1, 0]));
        assert!(bins.position(0, 8).abs() < 1e38, "about the middle");
    }
}
