#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Aabb, Ray,
    simd::{Lanes, Portable, SimdLevel},
};

/// Rays that are tested at once.
pub(crate) const GROUP: usize = 8;

/// A bit for each.
const ALL: u32 = (1 << GROUP) - 1;

/// Eight rays, lane by lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayGroup {
    /// Origin, direction, `t_min`, and the `t` beyond which no hit matters.
    pub rows: [[f32; GROUP]; 8],
    /// Bits of the lanes that hold a ray. The others repeat the last one, and end before they begin.
    pub used: u32,
    shear: [[f32; GROUP]; 2],
    axes: Axes,
}

/// The two axes across which rays run, and the one along which they are longest, as in
/// [`PreparedRay`](crate::triangle::PreparedRay).
#[derive(Clone, Copy, Debug)]
enum Axes {
    /// No triangle has been tested yet.
    Unknown,
    Same([usize; 3]),
    /// The rays do not agree.
    Mixed,
}

impl RayGroup {
    pub(super) const NONE: Self = Self {
        rows: [[0.0; GROUP]; 8],
        used: 0,
        shear: [[0.0; GROUP]; 2],
        axes: Axes::Unknown,
    };

    /// Takes one to eight rays.
    #[inline(always)]
    pub(super) fn load<S: Lanes>(&mut self, simd: S, rays: &[Ray]) {
        let last = rays.len() - 1;
        let mut rows = [simd.splat8(0.0); GROUP];
        for lane in 0..GROUP {
            rows[lane] = simd.load8(bytemuck::cast_ref(&rays[lane.min(last)]));
        }
        let rows = simd.transpose8(rows);
        for row in 0..8 {
            simd.store8(rows[row], &mut self.rows[row]);
        }
        self.used = ALL >> (GROUP - 1 - last);
        self.rows[7][last + 1..].fill(f32::NEG_INFINITY);
        self.axes = Axes::Unknown;
    }

    /// Per ray, the `t` beyond which no hit matters.
    #[inline]
    pub(super) fn limits(&self) -> &[f32; GROUP] {
        &self.rows[7]
    }

    /// As [`Bundled::cut`](super::Bundled::cut).
    #[inline]
    pub(super) fn cut(&mut self, lane: usize, t: f32) {
        self.rows[7][lane] = t;
    }

    /// As [`Bundled::candidates`](super::Bundled::candidates).
    pub(super) fn candidates(&mut self, level: SimdLevel, corners: &[[f32; 3]; 3]) -> u32 {
        if let Axes::Unknown = self.axes {
            self.prepare();
        }
        let Axes::Same(axes) = self.axes else {
            return self.used;
        };
        #[cfg(target_arch = "x86_64")]
        if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
            #[target_feature(enable = "avx2,popcnt")]
            fn compiled(simd: Avx2, group: &RayGroup, axes: [usize; 3], corners: &[[f32; 3]; 3]) -> u32 {
                group.not_rejected(simd, axes, corners)
            }
            #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
            // SAFETY: an `Avx2` exists only on machines that have both features.
            return unsafe { compiled(simd, self, axes, corners) };
        }
        self.not_rejected(Portable, axes, corners)
    }

    #[cold]
    fn prepare(&mut self) {
        let direction = [&self.rows[3], &self.rows[4], &self.rows[5]];
        let longest = |lane: usize| {
            let length = |axis: usize| direction[axis][lane].abs();
            (1..3).fold(0, |best, axis| if length(axis) > length(best) { axis } else { best })
        };
        let z = longest(0);
        if (1..GROUP).any(|lane| longest(lane) != z) {
            self.axes = Axes::Mixed;
            return;
        }
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        self.axes = Axes::Same(axes);
        for (shear, axis) in self.shear.iter_mut().zip(axes) {
            *shear = std::array::from_fn(|lane| direction[axis][lane] / direction[z][lane]);
        }
    }

    /// The rays that [`PreparedRay::intersect`](crate::triangle::PreparedRay::intersect) does not reject at once: the very
    /// numbers of its `f32` edge functions.
    #[inline(always)]
    fn not_rejected<S: Lanes>(&self, simd: S, axes: [usize; 3], corners: &[[f32; 3]; 3]) -> u32 {
        let [x, y, z] = [axes[0] % 3, axes[1] % 3, axes[2] % 3];
        let (origin_x, origin_y) = (simd.load8(&self.rows[x]), simd.load8(&self.rows[y]));
        let origin_z = simd.load8(&self.rows[z]);
        let (shear_x, shear_y) = (simd.load8(&self.shear[0]), simd.load8(&self.shear[1]));
        let mut sheared = [[origin_x; 2]; 3];
        for (sheared, corner) in sheared.iter_mut().zip(corners) {
            let along_x = simd.sub8(simd.splat8(corner[x]), origin_x);
            let along_y = simd.sub8(simd.splat8(corner[y]), origin_y);
            let along_z = simd.sub8(simd.splat8(corner[z]), origin_z);
            *sheared = [
                simd.sub8(along_x, simd.mul8(shear_x, along_z)),
                simd.sub8(along_y, simd.mul8(shear_y, along_z)),
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
        !(simd.lt8(least, zero) & simd.lt8(zero, greatest)) & self.used
    }

    /// As [`Bundled::meeting`](super::Bundled::meeting), for rays of a bundle: `outwards` is by how much planes move, per
    /// axis, and reaches the margin of each of the rays.
    pub(super) fn meeting(&self, level: SimdLevel, bounds: &Aabb, outwards: [f32; 3]) -> u32 {
        #[cfg(target_arch = "x86_64")]
        if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
            #[target_feature(enable = "avx2,popcnt")]
            fn compiled(simd: Avx2, group: &RayGroup, bounds: &Aabb, outwards: [f32; 3]) -> u32 {
                group.meeting_with(simd, bounds, outwards)
            }
            #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
            // SAFETY: an `Avx2` exists only on machines that have both features.
            return unsafe { compiled(simd, self, bounds, outwards) };
        }
        self.meeting_with(Portable, bounds, outwards)
    }

    #[inline(always)]
    fn meeting_with<S: Lanes>(&self, simd: S, bounds: &Aabb, outwards: [f32; 3]) -> u32 {
        let mut enter = [0.0; GROUP];
        let mut exit = [0.0; GROUP];
        for lane in 0..GROUP {
            enter[lane] = self.rows[6][lane].next_down();
            exit[lane] = self.rows[7][lane].next_up();
        }
        let (mut enter, mut exit) = (simd.load8(&enter), simd.load8(&exit));
        for k in 0..3 {
            let origin = simd.load8(&self.rows[k]);
            let inverse = simd.div8(simd.splat8(1.0), simd.load8(&self.rows[3 + k]));
            let outwards = simd.splat8(outwards[k]);
            let low = simd.sub8(simd.splat8(bounds.min[k]), simd.add8(origin, outwards));
            let high = simd.sub8(simd.splat8(bounds.max[k]), simd.sub8(origin, outwards));
            let (low, high) = (simd.mul8(low, inverse), simd.mul8(high, inverse));
            // All rays of a bundle run the same way.
            let (near, far) = if self.rows[3 + k][0] > 0.0 {
                (low, high)
            } else {
                (high, low)
            };
            enter = simd.max8(near, enter);
            exit = simd.min8(far, exit);
        }
        simd.le8(enter, exit) & self.used
    }
}
