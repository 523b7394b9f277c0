use crate::{simd::prefetch, wide::WideNode};
use restpose_formats::rows::TriangleRow;

/// Posed triangles, and a tree over all of them, in world space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PosedMesh<'a> {
    /// The root first; leaves are places in `triangles`. Not empty.
    pub nodes: &'a [WideNode],
    pub triangles: &'a [TriangleRow],
    pub positions: &'a [[f32; 3]],
}

impl PosedMesh<'_> {
    #[inline(always)]
    pub(crate) fn corners(&self, triangle: u32) -> [[f32; 3]; 3] {
        corners(self.triangles, self.positions, triangle)
    }

    /// Asks for what [`Self::corners`] reads.
    #[inline(always)]
    pub(crate) fn prefetch_corners(&self, triangle: u32) {
        for corner in self.triangles[triangle as usize].corners {
            prefetch(std::slice::from_ref(&self.positions[corner as usize]));
        }
    }
}

/// Where the corners of a triangle are.
#[inline(always)]
pub(crate) fn corners(triangles: &[TriangleRow], positions: &[[f32; 3]], triangle: u32) -> [[f32; 3]; 3] {
    let [a, b, c] = triangles[triangle as usize].corners;
    [positions[a as usize], positions[b as usize], positions[c as usize]]
}
