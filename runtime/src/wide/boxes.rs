use super::{WideNode, WideRay};
use crate::simd::Lanes;

/// A node with eight boxes that an `R` can meet: a ray, or several at once.
pub(crate) trait WideBoxes<R> {
    /// Packed [`WideChild`](restpose_formats::rows::WideChild)ren.
    fn children(&self) -> &[u32; 8];

    /// Asks for what [`Self::meet`] reads, apart from the node itself.
    fn prefetch(_at: u32, _ray: &R) {}

    /// Where the ray enters and leaves each box, cut to the range from `start` to `limit`: it may be inside where it enters no
    /// later than it leaves. Places that are empty as children may be among these.
    ///
    /// Both ends of the range are numbers; a plane whose `t` is none restricts nothing.
    /// `at` is the node's index in its tree.
    fn meet<S: Lanes>(&self, simd: S, at: u32, ray: &R, start: f32, limit: f32) -> [S::F8; 2];
}

impl WideBoxes<WideRay> for WideNode {
    #[inline(always)]
    fn children(&self) -> &[u32; 8] {
        &self.children
    }

    #[inline(always)]
    fn meet<S: Lanes>(&self, simd: S, _at: u32, ray: &WideRay, start: f32, limit: f32) -> [S::F8; 2] {
        let (mut enter, mut exit) = (simd.splat8(start), simd.splat8(limit));
        for k in 0..3 {
            let near_row = ray.near_row[k] & 1;
            let (near, far) = (&self.planes[near_row][k], &self.planes[1 - near_row][k]);
            let inverse = simd.splat8(ray.inverse_direction[k]);
            let near = simd.mul8(simd.sub8(simd.load8(near), simd.splat8(ray.near[k])), inverse);
            let far = simd.mul8(simd.sub8(simd.load8(far), simd.splat8(ray.far[k])), inverse);
            enter = simd.max8(near, enter);
            exit = simd.min8(far, exit);
        }
        if ray.unbounded {
            let mut exits = [0.0; 8];
            simd.store8(exit, &mut exits);
            for (place, exit) in exits.iter_mut().enumerate() {
                if (0..3).any(|k| self.planes[0][k][place] > self.planes[1][k][place]) {
                    *exit = f32::NAN;
                }
            }
            exit = simd.load8(&exits);
        }
        [enter, exit]
    }
}
