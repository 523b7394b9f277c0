use super::{boxes::WideBoxes, key_boxes::KeyBoxes};
use crate::{cluster_frame::LatticeRay, mover_maps::MoverMaps, simd::Lanes};
use restpose_formats::rows::{MAX_MOVERS, MOVER_WEIGHTS, NodeMoverRow, WideNodeRow};

/// Where the boxes of a cluster's wide tree are in a pose, on one of its two lattices.
#[derive(Clone, Copy)]
pub(crate) struct FuzzyBoxes<'a> {
    /// Boxes of all nodes at keys, where they have any; none of them has movers then.
    pub keys: Option<KeyBoxes<'a>>,
    /// How the cluster's movers move against it.
    pub motions: &'a MoverMaps,
    /// The file's rows.
    pub movers: &'a [NodeMoverRow],
}

impl FuzzyBoxes<'_> {
    /// Asks for what [`Self::planes`] reads, apart from the node itself.
    #[inline(always)]
    pub(super) fn prefetch(&self, at: u32) {
        if let Some(keys) = &self.keys {
            keys.prefetch(at);
        }
    }

    /// Per axis, the least and the greatest sides of a node's eight boxes, in steps of the lattice of fuzzy boxes, or where they
    /// [follow](follows) the pose, of rest positions.
    #[inline(always)]
    pub(super) fn planes<S: Lanes>(&self, simd: S, node: &WideNodeRow, at: u32) -> [[S::F8; 2]; 3] {
        let stored = stored_planes(simd, node);
        if let Some(keys) = &self.keys {
            keys.planes(simd, at, stored)
        } else if follows(node) {
            posed_planes(simd, node, stored, self)
        } else {
            stored
        }
    }
}

/// Whether a node's boxes follow the pose.
#[inline(always)]
pub(super) fn follows(node: &WideNodeRow) -> bool {
    node.mover_count != 0
}

/// A ray ready for the nodes of a cluster's wide tree, in its local space.
#[derive(Clone, Copy)]
pub(crate) struct FuzzyRay<'a> {
    pub boxes: FuzzyBoxes<'a>,
    /// On the lattice of the fuzzy boxes.
    pub fuzzy: LatticeRay,
    /// On the lattice of the rest positions.
    pub posed: LatticeRay,
}

impl WideBoxes<FuzzyRay<'_>> for WideNodeRow {
    #[inline(always)]
    fn children(&self) -> &[u32; 8] {
        &self.children
    }

    #[inline(always)]
    fn prefetch(at: u32, ray: &FuzzyRay<'_>) {
        ray.boxes.prefetch(at);
    }

    #[inline(always)]
    fn meet<S: Lanes>(&self, simd: S, at: u32, ray: &FuzzyRay<'_>, start: f32, limit: f32) -> [S::F8; 2] {
        let planes = ray.boxes.planes(simd, self, at);
        let lattice = if follows(self) { &ray.posed } else { &ray.fuzzy };
        meet_planes(simd, planes, lattice, start, limit)
    }
}

// No closures below: they would not be compiled for the instructions that the function around them is.

/// Per axis, the least and the greatest sides of the eight boxes.
#[inline(always)]
fn stored_planes<S: Lanes>(simd: S, node: &WideNodeRow) -> [[S::F8; 2]; 3] {
    let mut planes = [[simd.splat8(0.0); 2]; 3];
    for k in 0..3 {
        planes[k] = [simd.widen8(&node.min[k]), simd.widen8(&node.max[k])];
    }
    planes
}

#[inline(always)]
fn meet_planes<S: Lanes>(simd: S, planes: [[S::F8; 2]; 3], ray: &LatticeRay, start: f32, limit: f32) -> [S::F8; 2] {
    let (mut enter, mut exit) = (simd.splat8(start), simd.splat8(limit));
    for k in 0..3 {
        let [min, max] = planes[k];
        let (near, far) = if ray.forward[k] { (min, max) } else { (max, min) };
        let rate = simd.splat8(ray.rate[k]);
        let near = simd.add8(simd.mul8(near, rate), simd.splat8(ray.near[k]));
        let far = simd.add8(simd.mul8(far, rate), simd.splat8(ray.far[k]));
        enter = simd.max8(near, enter);
        exit = simd.min8(far, exit);
    }
    [enter, exit]
}

/// Boxes around where this pose takes what is below each place.
///
/// A vertex in the box with the middle c and half the sides h is at p = c + e, |e| ≤ h. With the motion E·p + d of each
/// mover against the cluster and the weights w = w̄ ± s, its fuzzy position is
///
/// ```text
/// p + Σ w·(E·p + d) = c + Σ w̄·(E·c + d)  +  e + Σ (w − w̄)·(E·c + d) + Σ w·E·e
/// ```
///
/// of which what stands behind the middle is at most `h + Σ s·|E·c + d| + (w̄ + s)·|E|·h`. Rounding is in the ray's margin
/// ([`MoverMaps`]).
///
/// Based on: Kavan and Žára, *Fast Collision Detection for Skeletally Deformable Models*, Computer Graphics Forum 24(3),
/// 2005: bounding volumes of skinned vertices follow the bones by their weights. Differs: boxes for spheres; weights vary
/// within a box; eight at a time, when a ray asks.
#[inline(always)]
fn posed_planes<S: Lanes>(
    simd: S,
    node: &WideNodeRow,
    mut planes: [[S::F8; 2]; 3],
    boxes: &FuzzyBoxes<'_>,
) -> [[S::F8; 2]; 3] {
    let part = simd.splat8(0.5);
    let (mut center, mut half) = ([part; 3], [part; 3]);
    for k in 0..3 {
        let [min, max] = planes[k];
        center[k] = simd.mul8(simd.add8(min, max), part);
        let side = simd.mul8(simd.sub8(max, min), part);
        half[k] = simd.add8(side, simd.splat8(boxes.motions.morphed[k]));
    }
    let (mut middle, mut reach) = (center, half);
    let unit = simd.splat8(1.0 / MOVER_WEIGHTS);
    for row in node.movers(boxes.movers) {
        let map = &boxes.motions.maps[row.mover as usize % MAX_MOVERS];
        let weight = simd.mul8(simd.widen8(&row.weight), unit);
        let spread = simd.mul8(simd.widen8(&row.spread), unit);
        let most = simd.add8(weight, spread);
        for k in 0..3 {
            let (mut moved, mut spun) = (simd.splat8(map.columns[3][k]), simd.splat8(0.0));
            for j in 0..3 {
                let entry = simd.splat8(map.columns[j][k]);
                moved = simd.add8(moved, simd.mul8(entry, center[j]));
                spun = simd.add8(spun, simd.mul8(simd.abs8(entry), half[j]));
            }
            middle[k] = simd.add8(middle[k], simd.mul8(weight, moved));
            let wider = simd.add8(simd.mul8(spread, simd.abs8(moved)), simd.mul8(most, spun));
            reach[k] = simd.add8(reach[k], wider);
        }
    }
    for k in 0..3 {
        planes[k] = [simd.sub8(middle[k], reach[k]), simd.add8(middle[k], reach[k])];
    }
    planes
}
