use super::{WideNode, WideRay};
use crate::simd::Lanes;

/// A node with eight boxes that an `R` can meet: a ray, or several at once.
pub(crate) trait WideBoxes<R> {
    /// Packed [`WideChild`](restpose_formats::rows::WideChild)ren.
    fn children(&self) -> &[u32; 8];

    /// Where the ray enters each box, and a bit for each box that it may be inside of between `start` and `limit`. Places
    /// that are empty as children may be among them.
    ///
    /// Both ends of the range are numbers; a plane whose `t` is none restricts nothing.
    fn meet<S: Lanes>(&self, simd: S, ray: &R, start: f32, limit: f32) -> (S::F8, u32);
}

impl WideBoxes<WideRay> for WideNode {
    #[inline(always)]
    fn children(&self) -> &[u32; 8] {
        &self.children
    }

    #[inline(always)]
    fn meet<S: Lanes>(&self, simd: S, ray: &WideRay, start: f32, limit: f32) -> (S::F8, u32) {
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
        let mut met = simd.le8(enter, exit);
        if ray.unbounded {
            for k in 0..3 {
                met &= simd.le8(simd.load8(&self.planes[0][k]), simd.load8(&self.planes[1][k]));
            }
        }
        (enter, met)
    }
}
