use super::ray_bundle::lengthened;
use crate::{Aabb, Ray, cluster_frame::SlabLanes, simd::Lanes, triangle::PreparedRay};
use restpose_formats::geom::round::UNIT_ROUNDOFF;

/// Rays that are tested at once.
pub(crate) const GROUP: usize = 8;

/// A bit for each.
const ALL: u32 = (1 << GROUP) - 1;

/// Eight rays, lane by lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayGroup {
    /// In world space, with directions as bundles take them ([`lengthened`]).
    pub slabs: SlabLanes,
    pub direction: [[f32; GROUP]; 3],
    /// `t_min`, and the `t` beyond which no hit matters.
    pub range: [[f32; GROUP]; 2],
    /// Bits of the lanes that hold a ray. The others repeat the last one, and end before they begin.
    pub used: u32,
    shear: [[f32; GROUP]; 2],
    axes: Axes,
}

/// The two axes across which rays run, and the one along which they are longest, as in [`PreparedRay`].
#[derive(Clone, Copy, Debug)]
enum Axes {
    Same([usize; 3]),
    /// The rays do not agree.
    Mixed,
}

/// Hits of eight rays, lane by lane, as in [`TriangleHit`](crate::triangle::TriangleHit).
#[derive(Clone, Copy, Debug)]
pub(crate) struct GroupHits {
    pub t: [f32; GROUP],
    pub u: [f32; GROUP],
    pub v: [f32; GROUP],
}

impl GroupHits {
    pub(crate) const NONE: Self = Self {
        t: [0.0; GROUP],
        u: [0.0; GROUP],
        v: [0.0; GROUP],
    };
}

impl RayGroup {
    pub(super) const NONE: Self = Self {
        slabs: SlabLanes::NONE,
        direction: [[0.0; GROUP]; 3],
        range: [[0.0; GROUP]; 2],
        used: 0,
        shear: [[0.0; GROUP]; 2],
        axes: Axes::Mixed,
    };

    /// Takes one to eight rays. Whether all of them can hit something.
    #[inline(always)]
    pub(super) fn load<S: Lanes>(&mut self, simd: S, rays: &[Ray]) -> bool {
        let last = rays.len() - 1;
        let mut rows = [simd.splat8(0.0); GROUP];
        for lane in 0..GROUP {
            rows[lane] = simd.load8(bytemuck::cast_ref(&rays[lane.min(last)]));
        }
        let rows = simd.transpose8(rows);
        let mut sum = simd.splat8(0.0);
        for k in 0..3 {
            simd.store8(rows[k], &mut self.slabs.origin[k]);
            simd.store8(rows[3 + k], &mut self.direction[k]);
            sum = simd.add8(sum, simd.add8(simd.abs8(rows[k]), simd.abs8(rows[3 + k])));
            for lane in 0..GROUP {
                self.slabs.inverse_direction[k][lane] = 1.0 / lengthened(self.direction[k][lane]);
            }
        }
        self.used = ALL >> (GROUP - 1 - last);
        simd.store8(rows[6], &mut self.range[0]);
        simd.store8(rows[7], &mut self.range[1]);
        self.range[1][last + 1..].fill(f32::NEG_INFINITY);
        self.prepare(simd, [rows[3], rows[4], rows[5]]);
        // Finite only where all six are.
        let finite = simd.lt8(sum, simd.splat8(f32::INFINITY));
        let some = simd.lt8(
            simd.splat8(0.0),
            simd.add8(simd.add8(simd.abs8(rows[3]), simd.abs8(rows[4])), simd.abs8(rows[5])),
        );
        finite & some & simd.le8(rows[6], rows[7]) == ALL
    }

    /// As [`PreparedRay::new`].
    #[inline(always)]
    fn prepare<S: Lanes>(&mut self, simd: S, direction: [S::F8; 3]) {
        let [x, y, z] = [
            simd.abs8(direction[0]),
            simd.abs8(direction[1]),
            simd.abs8(direction[2]),
        ];
        let y_is_longer = simd.lt8(x, y);
        let z_is_longest = simd.lt8(simd.max8(y, x), z);
        let longest = match (y_is_longer & !z_is_longest, z_is_longest) {
            (0, 0) => 0,
            (ALL, 0) => 1,
            (0, ALL) => 2,
            _ => {
                self.axes = Axes::Mixed;
                return;
            }
        };
        let axes = [(longest + 1) % 3, (longest + 2) % 3, longest];
        self.axes = Axes::Same(axes);
        for (shear, axis) in self.shear.iter_mut().zip(axes) {
            simd.store8(simd.div8(direction[axis], direction[longest]), shear);
        }
    }

    /// Per ray, the `t` beyond which no hit matters.
    #[inline]
    pub(super) fn limits(&self) -> &[f32; GROUP] {
        &self.range[1]
    }

    /// As [`Bundled::cut`](super::Bundled::cut).
    #[inline]
    pub(super) fn cut(&mut self, lane: usize, t: f32) {
        self.range[1][lane] = t;
    }

    /// A bit for each ray that hits the triangle in its range, and its hit: bit for bit what [`PreparedRay::intersect`]
    /// says.
    #[inline(always)]
    pub(super) fn hits<S: Lanes>(&self, simd: S, corners: &[[f32; 3]; 3], hits: &mut GroupHits) -> u32 {
        let Axes::Same(axes) = self.axes else {
            return self.hits_one_by_one(corners, hits);
        };
        let [x, y, z] = [axes[0] % 3, axes[1] % 3, axes[2] % 3];
        let (origin_x, origin_y) = (simd.load8(&self.slabs.origin[x]), simd.load8(&self.slabs.origin[y]));
        let origin_z = simd.load8(&self.slabs.origin[z]);
        let (shear_x, shear_y) = (simd.load8(&self.shear[0]), simd.load8(&self.shear[1]));
        let mut sheared = [[origin_x; 3]; 3];
        for (sheared, corner) in sheared.iter_mut().zip(corners) {
            let along_x = simd.sub8(simd.splat8(corner[x]), origin_x);
            let along_y = simd.sub8(simd.splat8(corner[y]), origin_y);
            let along_z = simd.sub8(simd.splat8(corner[z]), origin_z);
            *sheared = [
                simd.sub8(along_x, simd.mul8(shear_x, along_z)),
                simd.sub8(along_y, simd.mul8(shear_y, along_z)),
                along_z,
            ];
        }
        let [a, b, c] = sheared;
        let u = simd.sub8(simd.mul8(c[0], b[1]), simd.mul8(c[1], b[0]));
        let v = simd.sub8(simd.mul8(a[0], c[1]), simd.mul8(a[1], c[0]));
        let w = simd.sub8(simd.mul8(b[0], a[1]), simd.mul8(b[1], a[0]));
        // A NaN is neither below nor above zero. Here it drops out, or hides others, and then rejects less.
        let least = simd.min8(u, simd.min8(v, w));
        let greatest = simd.max8(u, simd.max8(v, w));
        let zero = simd.splat8(0.0);
        let undecided = !(simd.lt8(least, zero) & simd.lt8(zero, greatest)) & self.used;
        if undecided == 0 {
            return 0;
        }
        let [low_z, high_z] = simd.halves(simd.load8(&self.direction[z]));
        let none = (0, [simd.splat4(0.0); 3]);
        // Most often neighbours agree, and one half has nothing to decide.
        let (low, low_hits) = if undecided & 0xf == 0 {
            none
        } else {
            let corners = [widen(simd, a, 0), widen(simd, b, 0), widen(simd, c, 0)];
            decide(simd, corners, simd.to_f64(low_z))
        };
        let (high, high_hits) = if undecided & 0xf0 == 0 {
            none
        } else {
            let corners = [widen(simd, a, 1), widen(simd, b, 1), widen(simd, c, 1)];
            decide(simd, corners, simd.to_f64(high_z))
        };
        let weighted = low | high << 4;
        let t = simd.join(low_hits[0], high_hits[0]);
        simd.store8(t, &mut hits.t);
        simd.store8(simd.join(low_hits[1], high_hits[1]), &mut hits.u);
        simd.store8(simd.join(low_hits[2], high_hits[2]), &mut hits.v);
        let (start, end) = (simd.load8(&self.range[0]), simd.load8(&self.range[1]));
        let finite = simd.lt8(simd.abs8(t), simd.splat8(f32::INFINITY));
        weighted & undecided & finite & simd.le8(start, t) & simd.le8(t, end)
    }

    #[cold]
    fn hits_one_by_one(&self, corners: &[[f32; 3]; 3], hits: &mut GroupHits) -> u32 {
        let mut bits = 0;
        for lane in (0..GROUP).filter(|lane| self.used >> lane & 1 == 1) {
            let lane_of = |rows: &[[f32; GROUP]; 3]| rows.map(|row| row[lane]);
            let mut ray = Ray::new(lane_of(&self.slabs.origin), lane_of(&self.direction));
            (ray.t_min, ray.t_max) = (self.range[0][lane], self.range[1][lane]);
            if let Some(hit) = PreparedRay::new(&ray).and_then(|ray| ray.intersect(corners)) {
                (hits.t[lane], hits.u[lane], hits.v[lane]) = (hit.t, hit.u, hit.v);
                bits |= 1 << lane;
            }
        }
        bits
    }

    /// As [`Bundled::meeting`](super::Bundled::meeting), for rays of a bundle in the space that `slabs` hold them in:
    /// `outwards` is by how much planes move, per axis, and reaches the margin of each of the rays.
    ///
    /// The box is not empty, and none of its sides is NaN.
    #[inline(always)]
    pub(super) fn meeting<S: Lanes>(&self, simd: S, slabs: &SlabLanes, bounds: &Aabb, outwards: [f32; 3]) -> u32 {
        let [enter, exit] = self.clipped(simd, slabs, bounds, outwards);
        simd.le8(enter, exit) & self.used
    }

    /// As [`Self::meeting`]: where each ray may be inside the box, within its range; nowhere where it leaves before it enters, or
    /// leaves at no number.
    #[inline(always)]
    pub(super) fn clipped<S: Lanes>(
        &self,
        simd: S,
        slabs: &SlabLanes,
        bounds: &Aabb,
        outwards: [f32; 3],
    ) -> [S::F8; 2] {
        let [mut enter, mut exit] = widened(simd, simd.load8(&self.range[0]), simd.load8(&self.range[1]));
        for k in 0..3 {
            let origin = simd.load8(&slabs.origin[k]);
            let inverse = simd.load8(&slabs.inverse_direction[k]);
            let outwards = simd.splat8(outwards[k]);
            let low = simd.sub8(simd.splat8(bounds.min[k]), simd.add8(origin, outwards));
            let high = simd.sub8(simd.splat8(bounds.max[k]), simd.sub8(origin, outwards));
            let (low, high) = (simd.mul8(low, inverse), simd.mul8(high, inverse));
            enter = simd.max8(simd.min8(low, high), enter);
            exit = simd.min8(simd.max8(low, high), exit);
        }
        [enter, exit]
    }

    /// What is behind the `t` beyond which no hit matters, per ray; no number for none at all.
    #[inline(always)]
    pub(super) fn widened_limit<S: Lanes>(&self, simd: S) -> S::F8 {
        let limit = simd.load8(&self.range[1]);
        widened(simd, limit, limit)[1]
    }
}

/// A range of `t` that reaches at least to the numbers next to its ends, so that where hits lie that round to these is inside. Where
/// the end is −∞ it is NaN, which `min8` keeps as its second operand and `le8` rejects: no range at all.
///
/// A step is four units of roundoff, relatively, so two units in the last place or more, which rounding the sum cuts by half of one;
/// where that vanishes below the normal numbers, the least of all does. `next_down` and `next_up` for each lane took a seventh of a
/// picture's time.
#[inline(always)]
fn widened<S: Lanes>(simd: S, start: S::F8, end: S::F8) -> [S::F8; 2] {
    let (share, least) = (
        simd.splat8((4.0 * UNIT_ROUNDOFF) as f32),
        simd.splat8(f32::from_bits(1)),
    );
    let before = simd.add8(simd.mul8(simd.abs8(start), share), least);
    let behind = simd.add8(simd.mul8(simd.abs8(end), share), least);
    [simd.sub8(start, before), simd.add8(end, behind)]
}

#[inline(always)]
fn widen<S: Lanes>(simd: S, [x, y, z]: [S::F8; 3], half: usize) -> [S::D4; 3] {
    [
        simd.to_f64(simd.halves(x)[half]),
        simd.to_f64(simd.halves(y)[half]),
        simd.to_f64(simd.halves(z)[half]),
    ]
}

/// The `f64` part of [`PreparedRay::intersect`], but for the range of `t`: a bit for each ray that hits, and `t`, `u`, `v`.
#[inline(always)]
fn decide<S: Lanes>(simd: S, [a, b, c]: [[S::D4; 3]; 3], direction_z: S::D4) -> (u32, [S::F4; 3]) {
    let u = simd.sub4_f64(simd.mul4_f64(c[0], b[1]), simd.mul4_f64(c[1], b[0]));
    let v = simd.sub4_f64(simd.mul4_f64(a[0], c[1]), simd.mul4_f64(a[1], c[0]));
    let w = simd.sub4_f64(simd.mul4_f64(b[0], a[1]), simd.mul4_f64(b[1], a[0]));
    let zero = simd.splat4_f64(0.0);
    let below = simd.lt4_f64(u, zero) | simd.lt4_f64(v, zero) | simd.lt4_f64(w, zero);
    let above = simd.lt4_f64(zero, u) | simd.lt4_f64(zero, v) | simd.lt4_f64(zero, w);
    let determinant = simd.add4_f64(simd.add4_f64(u, v), w);
    let infinity = simd.splat4_f64(f64::INFINITY);
    let negative = simd.lt4_f64(simd.sub4_f64(zero, infinity), determinant) & simd.lt4_f64(determinant, zero);
    let positive = simd.lt4_f64(zero, determinant) & simd.lt4_f64(determinant, infinity);
    let sum = simd.add4_f64(simd.mul4_f64(u, a[2]), simd.mul4_f64(v, b[2]));
    let sum = simd.add4_f64(sum, simd.mul4_f64(w, c[2]));
    let depth = simd.div4_f64(sum, determinant);
    let t = simd.to_f32(simd.div4_f64(depth, direction_z));
    let t = simd.add4(t, simd.splat4(0.0));
    let second = simd.to_f32(simd.div4_f64(v, determinant));
    let third = simd.to_f32(simd.div4_f64(w, determinant));
    (!(below & above) & (negative | positive), [t, second, third])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Portable;

    fn widened<S: Lanes>(simd: S, t: f32) -> [f32; 2] {
        super::widened(simd, simd.splat8(t), simd.splat8(t)).map(|end| {
            let mut lanes = [0.0; GROUP];
            simd.store8(end, &mut lanes);
            lanes[3]
        })
    }

    #[test]
    fn ranges_reach_the_numbers_next_to_their_ends() {
        let mut random = fastrand::Rng::with_seed(47);
        let special = [0.0, f32::from_bits(1), f32::MIN_POSITIVE, 1.0, f32::MAX, f32::INFINITY];
        // Every exponent, with the least and the greatest fraction and others.
        let powers = (0..0x7f80_0000u32).step_by(1 << 23).flat_map(|bits| {
            let random = random.u32(..1 << 23);
            [bits, bits | 0x7f_ffff, bits | random].map(f32::from_bits)
        });
        for t in special.into_iter().chain(powers).flat_map(|t| [t, -t]) {
            let [enter, exit] = widened(Portable, t);
            // Hits are finite, so −∞ and ∞ are next to themselves.
            if t < f32::INFINITY {
                assert!(enter <= t.next_down(), "{t:e}");
            }
            if t > f32::NEG_INFINITY {
                assert!(exit >= t.next_up(), "{t:e}");
            } else {
                assert!(exit.is_nan());
            }
            #[cfg(target_arch = "x86_64")]
            if let Some(simd) = crate::simd::Avx2::new() {
                assert_eq!(
                    widened(simd, t).map(f32::to_bits),
                    [enter, exit].map(f32::to_bits),
                    "{t:e}"
                );
            }
        }
    }
}
