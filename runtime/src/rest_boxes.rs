//! What bones move in the rest pose, and boxes around its images: the part of [`posed_bounds`](crate::posed_bounds) that
//! is per cluster and bone. That module says why they hold.

#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Aabb, Affine, Asset,
    posed_bounds::{IMAGE_ERROR, LARGEST},
    simd::{Lanes, Portable, SimdLevel},
    vertex::columns4,
};
use restpose_formats::{
    ModelView,
    geom::round::f32_above,
    rows::{ClusterRow, NONE},
};
use std::ops::Range;

/// 2⁻⁹⁶, more than the least normal number, so that no product with [`IMAGE_ERROR`] is subnormal: processors take a hundred
/// cycles for one of those (a third of a crowd's frame went there).
const FLOOR: f32 = 1.0 / (1u128 << 96) as f32;

/// A box by its middle and half its sides, per axis: four times the middle, four times the half side.
#[repr(align(32))]
#[derive(Clone, Copy, Debug)]
struct RestBox([[f32; 8]; 3]);

impl RestBox {
    fn new(bounds: &Aabb) -> Self {
        Self(std::array::from_fn(|k| {
            let (min, max) = (f64::from(bounds.min[k]), f64::from(bounds.max[k]));
            let center = (0.5 * (min + max)) as f32;
            let half = f32_above((max - f64::from(center)).max(f64::from(center) - min));
            let [c, h] = [center, half];
            [c, c, c, c, h, h, h, h]
        }))
    }

    /// The greatest magnitudes in it.
    fn reach(&self) -> [f64; 3] {
        self.0.map(|lanes| f64::from(lanes[0].abs()) + f64::from(lanes[4]))
    }
}

/// What a bone moves in the rest pose.
#[derive(Clone, Copy, Debug)]
struct RestBone {
    /// Bone row.
    bone: u32,
    bounds: RestBox,
    /// Bounds the magnitudes in the boxes of all of its rows, and in `bounds`.
    reach: [f32; 3],
}

/// What bones move in the rest pose, made ready when an asset is opened.
#[derive(Debug, Default)]
pub(crate) struct RestBoxes {
    /// Bones that move anything, by row.
    bones: Vec<RestBone>,
    /// Per cluster-bone row of clusters without a track: what the bone moves there, and its place in `bones`.
    rows: Vec<(RestBox, u32)>,
    /// Per cluster without a track, its range of `rows`.
    of_clusters: Vec<Range<usize>>,
}

impl RestBoxes {
    /// Linear in the cluster bones.
    pub(crate) fn new(model: &ModelView) -> Self {
        let mut out = Self::default();
        let without_track = model.clusters.partition_point(|cluster| cluster.track == NONE);
        let clusters = &model.clusters[..without_track];
        let rows = clusters
            .last()
            .map_or(0, |last| (last.cluster_bone_first + last.cluster_bone_count) as usize);
        let rows = &model.cluster_bones[..rows];
        let mut of_bones = vec![Aabb::EMPTY; model.bones.len()];
        for row in rows {
            let all = &mut of_bones[row.bone as usize];
            *all = all.union(row.bounds);
        }
        let mut places = vec![0; model.bones.len()];
        for (bone, bounds) in (0u32..).zip(&of_bones) {
            places[bone as usize] = out.bones.len() as u32;
            if !bounds.is_empty() {
                let bounds = RestBox::new(bounds);
                let reach = bounds.reach().map(f32_above);
                out.bones.push(RestBone { bone, bounds, reach });
            }
        }
        for row in rows {
            let (bounds, place) = (RestBox::new(&row.bounds), places[row.bone as usize]);
            let bone = &mut out.bones[place as usize];
            let reach = bounds.reach().map(f32_above);
            bone.reach = std::array::from_fn(|k| bone.reach[k].max(reach[k]));
            out.rows.push((bounds, place));
        }
        let rows_of = |cluster: &ClusterRow| {
            let first = cluster.cluster_bone_first as usize;
            first..first + cluster.cluster_bone_count as usize
        };
        out.of_clusters = clusters.iter().map(rows_of).collect();
        out
    }

    /// Bones that move anything, with the greatest magnitudes of the rest positions that they move.
    pub(crate) fn extents(&self) -> impl Iterator<Item = (u32, [f64; 3])> {
        self.bones.iter().map(|rest| (rest.bone, rest.reach.map(f64::from)))
    }
}

/// The hull of images of boxes.
#[derive(Clone, Copy)]
struct Hull<S: Lanes> {
    min: S::F4,
    max: S::F4,
}

impl<S: Lanes> Hull<S> {
    #[inline(always)]
    fn empty(simd: S) -> Self {
        Self {
            min: simd.splat4(f32::INFINITY),
            max: simd.splat4(f32::NEG_INFINITY),
        }
    }

    /// Adds the image of a box. `rest` is in the reach that the bone's image was made for.
    #[inline(always)]
    fn add(&mut self, simd: S, [x, y, z, offset]: &[S::F8; 4], rest: &RestBox) {
        let [a, b, c] = &rest.0;
        let sum = simd.add8(simd.mul8(*x, simd.load8(a)), simd.mul8(*y, simd.load8(b)));
        let sum = simd.add8(simd.add8(sum, simd.mul8(*z, simd.load8(c))), *offset);
        let [middle, spread] = simd.halves(sum);
        self.min = simd.min4(self.min, simd.sub4(middle, spread));
        self.max = simd.max4(self.max, simd.add4(middle, spread));
    }

    /// The box, cut off at the greatest number.
    #[inline(always)]
    fn bounds(&self, simd: S) -> Aabb {
        let [x, y, z, _] = simd.store4(simd.max4(self.min, simd.splat4(f32::MIN)));
        let min = [x, y, z];
        let [x, y, z, _] = simd.store4(simd.min4(self.max, simd.splat4(f32::MAX)));
        Aabb { min, max: [x, y, z] }
    }
}

/// A bone's map, made ready for the boxes that it moves, and what enters. Per column: the map's numbers, then their
/// magnitudes; in the last the offset, then what is added to the spread of every box: by what morphs add, and the error.
///
/// Where something may overflow, it maps every box to all of space.
#[inline(always)]
fn image<S: Lanes>(simd: S, map: &Affine, rest: &RestBone, grown: [f32; 3], error: f32) -> ([S::F8; 4], S::F4) {
    let floor = simd.splat4(FLOOR);
    let [x, y, z, offset] = columns4(simd, map);
    let columns = [x, y, z];
    let mut out = [simd.splat8(0.0); 4];
    let mut entering = simd.add4(magnitudes(simd, offset), floor);
    let mut growth = simd.splat4(0.0);
    for k in 0..3 {
        let size = magnitudes(simd, columns[k]);
        out[k] = simd.join(columns[k], size);
        let reach = simd.splat4((rest.reach[k] + grown[k]) + FLOOR);
        entering = simd.add4(entering, simd.mul4(simd.add4(size, floor), reach));
        growth = simd.add4(growth, simd.mul4(size, simd.splat4(grown[k])));
    }
    let [a, b, c, _] = simd.store4(entering);
    if !(a <= LARGEST && b <= LARGEST && c <= LARGEST) {
        let everything = simd.join(simd.splat4(0.0), simd.splat4(f32::INFINITY));
        let nothing = simd.splat8(0.0);
        return ([nothing, nothing, nothing, everything], simd.splat4(f32::INFINITY));
    }
    let error = simd.add4(simd.mul4(simd.splat4(error), entering), floor);
    out[3] = simd.join(offset, simd.add4(growth, error));
    (out, entering)
}

#[inline(always)]
fn magnitudes<S: Lanes>(simd: S, a: S::F4) -> S::F4 {
    simd.max4(a, simd.sub4(simd.splat4(0.0), a))
}

/// Memory for [`cluster_bounds`]: of the bones that move anything, what [`image`] makes of them.
#[derive(Debug, Default)]
pub(crate) struct BoneImages(Vec<BoneImage>);

#[repr(align(32))]
#[derive(Clone, Copy, Debug)]
struct BoneImage([[f32; 8]; 4]);

/// Writes the world boxes of the clusters without a track, by row, in place of what is in `out`. `posed` holds world space
/// from rest space per bone row, as vertices are posed by it; `morphed` is the [`morph_extent`](crate::posed_bounds::morph_extent).
pub(crate) fn cluster_bounds(
    level: SimdLevel,
    asset: &Asset,
    posed: &[Affine],
    morphed: [f64; 3],
    images: &mut BoneImages,
    out: &mut Vec<Aabb>,
) {
    let (boxes, error) = (asset.rest_boxes(), f32_above(asset.vertex_error() + IMAGE_ERROR));
    let grown = widened(morphed);
    #[cfg(target_arch = "x86_64")]
    if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
        #[target_feature(enable = "avx2,popcnt")]
        fn compiled(
            simd: Avx2,
            boxes: &RestBoxes,
            posed: &[Affine],
            grown: [f32; 3],
            error: f32,
            images: &mut BoneImages,
            out: &mut Vec<Aabb>,
        ) {
            cluster_bounds_with(simd, boxes, posed, grown, error, images, out);
        }
        #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
        // SAFETY: an `Avx2` exists only on machines that have both features.
        return unsafe { compiled(simd, boxes, posed, grown, error, images, out) };
    }
    cluster_bounds_with(Portable, boxes, posed, grown, error, images, out);
}

#[inline(always)]
fn cluster_bounds_with<S: Lanes>(
    simd: S,
    boxes: &RestBoxes,
    posed: &[Affine],
    grown: [f32; 3],
    error: f32,
    BoneImages(images): &mut BoneImages,
    out: &mut Vec<Aabb>,
) {
    images.resize(boxes.bones.len(), BoneImage([[0.0; 8]; 4]));
    for (rest, stored) in boxes.bones.iter().zip(&mut *images) {
        let (columns, _) = image(simd, &posed[rest.bone as usize], rest, grown, error);
        for j in 0..4 {
            simd.store8(columns[j], &mut stored.0[j]);
        }
    }
    out.resize(boxes.of_clusters.len(), Aabb::EMPTY);
    for (rows, bounds) in boxes.of_clusters.iter().zip(out) {
        let mut hull = Hull::empty(simd);
        for (rest, place) in &boxes.rows[rows.clone()] {
            let [x, y, z, offset] = &images[*place as usize].0;
            let columns = [simd.load8(x), simd.load8(y), simd.load8(z), simd.load8(offset)];
            hull.add(simd, &columns, rest);
        }
        *bounds = hull.bounds(simd);
    }
}

/// The images of what bones move, together.
pub(crate) struct Images {
    pub bounds: Aabb,
    /// Bounds what enters them, per axis.
    pub reach: [f64; 3],
    /// Bounds the sum of the coordinates of what bones move.
    pub rest_reach: f64,
}

/// The images of what bones move. `morphed` is the [`morph_extent`](crate::posed_bounds::morph_extent).
pub(crate) fn images(level: SimdLevel, boxes: &RestBoxes, palette: &[Affine], morphed: [f64; 3]) -> Images {
    let grown = widened(morphed);
    #[cfg(target_arch = "x86_64")]
    if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
        #[target_feature(enable = "avx2,popcnt")]
        fn compiled(simd: Avx2, boxes: &RestBoxes, palette: &[Affine], grown: [f32; 3]) -> Images {
            images_with(simd, boxes, palette, grown)
        }
        #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
        // SAFETY: an `Avx2` exists only on machines that have both features.
        return unsafe { compiled(simd, boxes, palette, grown) };
    }
    images_with(Portable, boxes, palette, grown)
}

#[inline(always)]
fn images_with<S: Lanes>(simd: S, boxes: &RestBoxes, palette: &[Affine], grown: [f32; 3]) -> Images {
    let mut hull = Hull::empty(simd);
    let (mut reach, mut rest_reach) = (simd.splat4(0.0), [0.0f32; 3]);
    for rest in &boxes.bones {
        let (columns, entering) = image(simd, &palette[rest.bone as usize], rest, grown, f32_above(IMAGE_ERROR));
        hull.add(simd, &columns, &rest.bounds);
        reach = simd.max4(entering, reach);
        rest_reach = std::array::from_fn(|k| rest_reach[k].max(rest.reach[k] + grown[k]));
    }
    let [x, y, z, _] = simd.store4(reach).map(f64::from);
    Images {
        bounds: hull.bounds(simd),
        reach: [x, y, z],
        rest_reach: rest_reach.iter().map(|x| f64::from(*x)).sum(),
    }
}

/// An extent in `f32`, with room for the roundings of sums with it.
fn widened(extent: [f64; 3]) -> [f32; 3] {
    extent.map(|x| f32_above(x * (1.0 + IMAGE_ERROR)))
}

#[cfg(test)]
mod tests;
