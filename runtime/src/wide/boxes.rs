use super::{WideNode, WideRay};
use crate::{cluster_frame::LatticeRay, simd::Lanes};
use restpose_formats::rows::WideNodeRow;

/// A node with eight boxes that a ray can meet.
pub(crate) trait WideBoxes {
    /// The ray, ready for boxes of this kind.
    type Ray;

    /// Packed [`WideChild`](restpose_formats::rows::WideChild)ren.
    fn children(&self) -> &[u32; 8];

    /// Where the ray enters each box, and a bit for each box that it may be inside of between `start` and `limit`. Places
    /// that are empty as children may be among them.
    ///
    /// Both ends of the range are numbers; a plane whose `t` is none restricts nothing.
    fn meet<S: Lanes>(&self, simd: S, ray: &Self::Ray, start: f32, limit: f32) -> (S::F8, u32);
}

impl WideBoxes for WideNode {
    type Ray = WideRay;

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

impl WideBoxes for WideNodeRow {
    type Ray = LatticeRay;

    #[inline(always)]
    fn children(&self) -> &[u32; 8] {
        &self.children
    }

    #[inline(always)]
    fn meet<S: Lanes>(&self, simd: S, ray: &LatticeRay, start: f32, limit: f32) -> (S::F8, u32) {
        let (mut enter, mut exit) = (simd.splat8(start), simd.splat8(limit));
        for k in 0..3 {
            let (near, far) = if ray.forward[k] {
                (&self.min[k], &self.max[k])
            } else {
                (&self.max[k], &self.min[k])
            };
            let rate = simd.splat8(ray.rate[k]);
            let near = simd.add8(simd.mul8(simd.widen8(near), rate), simd.splat8(ray.near[k]));
            let far = simd.add8(simd.mul8(simd.widen8(far), rate), simd.splat8(ray.far[k]));
            enter = simd.max8(near, enter);
            exit = simd.min8(far, exit);
        }
        (enter, simd.le8(enter, exit))
    }
}
