use super::{
    bundled::{Bundled, Together},
    ray_group::GROUP,
};
#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Aabb,
    cluster_frame::BundleFrame,
    simd::{Lanes, Portable, SimdLevel},
};
use restpose_formats::rows::{KdNode, KdNodeRow, MAX_KD_DEPTH};
use std::ops::Range;

/// A child that eight rays come back to, and where each of them enters and leaves it.
#[derive(Clone, Copy, Debug)]
struct Pending {
    node: u32,
    enter: [f32; GROUP],
    exit: [f32; GROUP],
}

/// Room for the pending children of a kd-tree. What is in it means nothing between traversals: keep it.
#[derive(Clone, Debug)]
pub(crate) struct KdStack([Pending; MAX_KD_DEPTH]);

impl KdStack {
    pub(crate) const NONE: Self = Self(
        [Pending {
            node: 0,
            enter: [0.0; GROUP],
            exit: [0.0; GROUP],
        }; MAX_KD_DEPTH],
    );
}

/// A cluster's kd-tree, for rays of a bundle that have [entered](Bundled::in_cluster) the cluster.
pub(crate) struct KdSpace<'a> {
    pub nodes: &'a [KdNodeRow],
    /// Around the cluster's fuzzy boxes, in its local space.
    pub bounds: &'a Aabb,
    pub together: &'a Together<'a>,
    pub frame: &'a BundleFrame,
}

impl KdSpace<'_> {
    /// By how much planes move, per axis.
    #[inline(always)]
    fn outwards(&self) -> [f32; 3] {
        std::array::from_fn(|k| self.together.outwards[k] + self.frame.margin[k])
    }
}

impl Bundled<'_> {
    /// Takes the rays of a group down a kd-tree, each with a way of its own, near children first: `visit` is told of the references
    /// of each leaf that one of them may touch. What it cuts counts from then on; where it says so, the walk is over.
    ///
    /// Based on: Günther, *Ray Tracing of Dynamic Scenes*, §3.5, and Wald et al., *Interactive Rendering with Coherent Ray Tracing*,
    /// 2001: packets in kd-trees, lane by lane. Differs: eight rays for four by four, without a frustum.
    pub(crate) fn walk_kd(
        &mut self,
        level: SimdLevel,
        group: usize,
        space: &KdSpace,
        stack: &mut KdStack,
        visit: &mut impl FnMut(Range<usize>, &mut Bundled) -> bool,
    ) {
        #[cfg(target_arch = "x86_64")]
        if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
            #[target_feature(enable = "avx2,popcnt")]
            fn compiled(
                simd: Avx2,
                bundled: &mut Bundled,
                group: usize,
                space: &KdSpace,
                stack: &mut KdStack,
                visit: &mut impl FnMut(Range<usize>, &mut Bundled) -> bool,
            ) {
                bundled.walk_kd_with(simd, group, space, stack, visit);
            }
            #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
            // SAFETY: an `Avx2` exists only on machines that have both features.
            return unsafe { compiled(simd, self, group, space, stack, visit) };
        }
        self.walk_kd_with(Portable, group, space, stack, visit);
    }

    #[inline(always)]
    fn walk_kd_with<S: Lanes>(
        &mut self,
        simd: S,
        group: usize,
        space: &KdSpace,
        stack: &mut KdStack,
        visit: &mut impl FnMut(Range<usize>, &mut Bundled) -> bool,
    ) {
        let Some(rays) = space.together.rays else {
            unreachable!("rays in a cluster's space")
        };
        let slabs = &rays[group % GROUP];
        let mut inverse = [simd.splat8(f32::NAN); 3];
        let mut forward = [true; 3];
        for k in 0..3 {
            let lanes = simd.load8(&slabs.inverse_direction[k]);
            let backward = simd.lt8(lanes, simd.splat8(0.0));
            forward[k] = backward == 0;
            // Along an axis along which they do not all run the same way, planes restrict none of them.
            if backward == 0 || backward == 0xff {
                inverse[k] = lanes;
            }
        }
        let own = &self.packet.groups[group % GROUP];
        let [mut enter, mut exit] = own.clipped(simd, slabs, space.bounds, space.outwards());
        // Lanes without a ray end before they begin.
        if simd.le8(enter, exit) == 0 {
            return;
        }
        let (mut node, mut pending) = (0, 0);
        loop {
            match space.nodes[node as usize].unpack() {
                KdNode::Inner { axis, split, left } => {
                    let relative = simd.sub8(simd.splat8(split), simd.load8(&slabs.origin[axis]));
                    let margin = simd.splat8(space.frame.margin[axis]);
                    let below = simd.mul8(simd.sub8(relative, margin), inverse[axis]);
                    let above = simd.mul8(simd.add8(relative, margin), inverse[axis]);
                    let (near, far, far_enter, near_exit) = if forward[axis] {
                        (left, left + 1, below, above)
                    } else {
                        (left + 1, left, above, below)
                    };
                    // A NaN restricts neither child.
                    let near_exit = simd.min8(near_exit, exit);
                    let far_enter = simd.max8(far_enter, enter);
                    let visit_near = simd.le8(enter, near_exit) != 0;
                    if simd.le8(far_enter, exit) != 0 {
                        if !visit_near {
                            (node, enter) = (far, far_enter);
                            continue;
                        }
                        let room = &mut stack.0[pending % MAX_KD_DEPTH];
                        room.node = far;
                        simd.store8(far_enter, &mut room.enter);
                        simd.store8(exit, &mut room.exit);
                        pending += 1;
                    }
                    if visit_near {
                        (node, exit) = (near, near_exit);
                        continue;
                    }
                }
                KdNode::Leaf { first, count } => {
                    let leaf = first as usize..first as usize + count as usize;
                    if visit(leaf, self) {
                        return;
                    }
                }
            }
            let limit = self.packet.groups[group % GROUP].widened_limit(simd);
            loop {
                if pending == 0 {
                    return;
                }
                pending -= 1;
                let last = &stack.0[pending % MAX_KD_DEPTH];
                enter = simd.load8(&last.enter);
                exit = simd.min8(simd.load8(&last.exit), limit);
                if simd.le8(enter, exit) != 0 {
                    node = last.node;
                    break;
                }
            }
        }
    }
}
