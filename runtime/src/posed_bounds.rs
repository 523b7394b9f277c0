//! World boxes from maps alone: of an instance's clusters, and of the instance. They hold in every pose, inside the pose
//! space or not, and need no inverse.
//!
//! Weights are not negative and sum to exactly one, so a posed vertex is a mix of its images under the bones that move it,
//! and lies in the box around those. Each image lies in the image of the box that holds, in the rest pose, the vertices
//! which that bone moves. What rounding adds is relative to the magnitudes that enter: that of the vertex function
//! ([`Asset::vertex_error`]), and of the boxes themselves 15 roundings, for which 32 u are taken.
//!
//! A tighter box of a cluster, by its own bone and its pose's excess, comes with its frame
//! ([`ClusterFrame`](crate::cluster_frame::ClusterFrame)), which is made when a ray enters this one.

use crate::{Aabb, Affine, Asset, cluster_frame::SMALLEST_NORMAL};
use restpose_formats::{
    ModelView,
    geom::round::{UNIT_ROUNDOFF, f32_above, f32_below},
    rows::{ClusterRow, NONE},
};

/// Roundings of an image of a box in `f32`, twice over.
pub(crate) const IMAGE_ERROR: f64 = 32.0 * UNIT_ROUNDOFF;

/// 2⁻⁹⁶, more than the least normal number, so that no product with [`IMAGE_ERROR`] is subnormal: processors take a hundred
/// cycles for one of those (a third of a crowd's frame went there).
const FLOOR: f32 = 1.0 / (1u128 << 96) as f32;

/// Magnitudes up to this cannot have overflowed on their way.
pub(crate) const LARGEST: f32 = f32::MAX / 8.0;

/// A box by its middle and half its sides. Four lanes: the last is zero.
#[derive(Clone, Copy, Debug, Default)]
struct RestBox {
    center: [f32; 4],
    half: [f32; 4],
}

impl RestBox {
    fn new(bounds: &Aabb) -> Self {
        let mut out = Self::default();
        for k in 0..3 {
            let (min, max) = (f64::from(bounds.min[k]), f64::from(bounds.max[k]));
            out.center[k] = (0.5 * (min + max)) as f32;
            let center = f64::from(out.center[k]);
            out.half[k] = f32_above((max - center).max(center - min));
        }
        out
    }
}

/// What bones move in the rest pose, made ready when an asset is opened.
#[derive(Debug, Default)]
pub(crate) struct RestBoxes {
    /// Per cluster-bone row of clusters without a track.
    of_clusters: Vec<RestBox>,
    /// Per bone row; of bones that move nothing there is none.
    of_bones: Vec<(u32, RestBox)>,
}

impl RestBoxes {
    /// Linear in the cluster bones.
    pub(crate) fn new(model: &ModelView) -> Self {
        let without_track = model.clusters.partition_point(|cluster| cluster.track == NONE);
        let rows = model.clusters[..without_track]
            .last()
            .map_or(0, |last| (last.cluster_bone_first + last.cluster_bone_count) as usize);
        let rows = &model.cluster_bones[..rows];
        let mut of_bones = vec![Aabb::EMPTY; model.bones.len()];
        for row in rows {
            let all = &mut of_bones[row.bone as usize];
            *all = all.union(row.bounds);
        }
        let moving = (0..).zip(&of_bones).filter(|(_, bounds)| !bounds.is_empty());
        Self {
            of_clusters: rows.iter().map(|row| RestBox::new(&row.bounds)).collect(),
            of_bones: moving.map(|(bone, bounds)| (bone, RestBox::new(bounds))).collect(),
        }
    }
}

impl RestBoxes {
    /// Bones that move anything, with the greatest magnitudes of the rest positions that they move.
    pub(crate) fn extents(&self) -> impl Iterator<Item = (u32, [f64; 3])> {
        let reach = |rest: &RestBox, k: usize| f64::from(rest.center[k].abs()) + f64::from(rest.half[k]);
        self.of_bones
            .iter()
            .map(move |(bone, rest)| (*bone, [0, 1, 2].map(|k| reach(rest, k))))
    }
}

/// The hull of images of boxes.
struct Hull {
    min: [f32; 4],
    max: [f32; 4],
    /// Bounds the magnitudes that enter.
    reach: [f32; 4],
}

impl Hull {
    const EMPTY: Self = Self {
        min: [f32::INFINITY; 4],
        max: [f32::NEG_INFINITY; 4],
        reach: [0.0; 4],
    };

    /// Adds the image of a box, widened by `grown` before and by `error` of what enters after.
    #[inline]
    fn add(&mut self, map: &Affine, rest: &RestBox, grown: &[f32; 4], error: f32) {
        let [x, y, z, offset] = map.columns.map(|[x, y, z]| [x, y, z, 0.0f32]);
        let half: [f32; 4] = std::array::from_fn(|k| rest.half[k] + grown[k]);
        let reach: [f32; 4] = std::array::from_fn(|k| (rest.center[k].abs() + half[k]) + FLOOR);
        for k in 0..4 {
            let middle = ((x[k] * rest.center[0] + y[k] * rest.center[1]) + z[k] * rest.center[2]) + offset[k];
            let spread = (x[k].abs() * half[0] + y[k].abs() * half[1]) + z[k].abs() * half[2];
            let [x, y, z, offset] = [&x, &y, &z, &offset].map(|column| column[k].abs() + FLOOR);
            let entering = ((x * reach[0] + y * reach[1]) + z * reach[2]) + offset;
            let spread = spread + (error * entering + FLOOR);
            let (min, max) = (middle - spread, middle + spread);
            self.min[k] = if min < self.min[k] { min } else { self.min[k] };
            self.max[k] = if max > self.max[k] { max } else { self.max[k] };
            // Not a NaN that is lost: one stays.
            self.reach[k] = if entering <= self.reach[k] {
                self.reach[k]
            } else {
                entering
            };
        }
    }

    /// The box; everything where something may have overflowed.
    fn bounds(&self) -> Aabb {
        if !self.reach.iter().all(|x| *x <= LARGEST) {
            return EVERYWHERE;
        }
        let [min, max] = [self.min, self.max].map(|[x, y, z, _]| [x, y, z]);
        Aabb { min, max }
    }
}

/// Every finite point.
pub(crate) const EVERYWHERE: Aabb = Aabb {
    min: [f32::MIN; 3],
    max: [f32::MAX; 3],
};

/// By how much morphs displace a vertex, at most, per axis.
pub(crate) fn morph_extent(model: &ModelView, morph_weights: &[f32]) -> [f64; 3] {
    let mut extent = [0.0; 3];
    for (target, weight) in model.morph_targets.iter().zip(morph_weights) {
        for k in 0..3 {
            extent[k] += f64::from(weight.abs()) * f64::from(target.extent[k]);
        }
    }
    extent
}

fn lanes(extent: [f64; 3]) -> [f32; 4] {
    let [x, y, z] = extent.map(|x| f32_above(x * (1.0 + IMAGE_ERROR)));
    [x, y, z, 0.0]
}

/// World box of a cluster without a track. `posed` holds world space from rest space per bone row, as vertices are posed
/// by it; `morphed` is the [`morph_extent`].
pub(crate) fn cluster_bounds(asset: &Asset, cluster: &ClusterRow, posed: &[Affine], morphed: [f64; 3]) -> Aabb {
    let error = f32_above(asset.vertex_error() + IMAGE_ERROR);
    let grown = lanes(morphed);
    let rows = cluster.cluster_bone_first as usize..;
    let rows = rows.start..rows.start + cluster.cluster_bone_count as usize;
    let bones = &asset.model().cluster_bones[rows.clone()];
    let mut hull = Hull::EMPTY;
    for (row, rest) in bones.iter().zip(&asset.rest_boxes().of_clusters[rows]) {
        hull.add(&posed[row.bone as usize], rest, &grown, error);
    }
    hull.bounds()
}

/// A pose to bound an instance in.
#[derive(Clone, Copy)]
pub(crate) enum BoundedPose<'a> {
    /// Any of a clip's, or the one without a clip: bounded in the file, if at all.
    Clip(Option<u32>),
    /// A palette, and the [`morph_extent`].
    Given(&'a [Affine], [f64; 3]),
}

/// World box of an instance of an asset without vertex caches, from what is in the file or from its palette; `None` where
/// the file does not bound the clip.
pub(crate) fn posed_bounds(asset: &Asset, world_from_asset: &Affine, pose: BoundedPose) -> Option<Aabb> {
    match pose {
        BoundedPose::Clip(clip) => {
            let model = asset.model();
            let row = clip.map_or(model.clips.len(), |clip| clip as usize);
            let clip = model.clip_bounds.get(row).filter(|clip| clip.is_known())?;
            let reach = clip.reach.map(f64::from);
            Some(in_world(
                asset,
                world_from_asset,
                &clip.bounds,
                reach,
                clip.rest_reach.into(),
            ))
        }
        BoundedPose::Given(palette, morphed) => {
            let boxes = asset.rest_boxes();
            let grown = lanes(morphed);
            let mut hull = Hull::EMPTY;
            let mut rest_reach = [0.0f32; 3];
            for (bone, rest) in &boxes.of_bones {
                hull.add(&palette[*bone as usize], rest, &grown, f32_above(IMAGE_ERROR));
                for k in 0..3 {
                    rest_reach[k] = rest_reach[k].max(rest.center[k].abs() + rest.half[k] + grown[k]);
                }
            }
            let bounds = hull.bounds();
            if bounds.is_empty() {
                return Some(bounds);
            }
            let reach = hull.reach.map(f64::from);
            let rest_reach: f64 = rest_reach.iter().map(|x| f64::from(*x)).sum();
            Some(in_world(
                asset,
                world_from_asset,
                &bounds,
                [reach[0], reach[1], reach[2]],
                rest_reach,
            ))
        }
    }
}

/// The box around what a transform makes of vertices that lie, in exact arithmetic, in `bounds`. `reach` bounds `|X|·|p| +
/// |t|` over the bones, per axis, and `rest_reach` the sum of the coordinates of the `p`.
///
/// The product of transform and bone is rounded to `f32`, u of the magnitudes that enter it or the least step of numbers
/// near zero, and the vertex function adds its own error (points 1 and 2 of `cluster_frame`).
fn in_world(asset: &Asset, transform: &Affine, bounds: &Aabb, reach: [f64; 3], rest_reach: f64) -> Aabb {
    let error = asset.vertex_error() + 8.0 * UNIT_ROUNDOFF;
    let columns = transform.columns.map(|column| column.map(f64::from));
    let mut out = EVERYWHERE;
    for k in 0..3 {
        let (mut middle, mut spread, mut entering) = (columns[3][k], 0.0, columns[3][k].abs());
        for j in 0..3 {
            let (min, max) = (f64::from(bounds.min[j]), f64::from(bounds.max[j]));
            middle += columns[j][k] * 0.5 * (min + max);
            spread += columns[j][k].abs() * 0.5 * (max - min);
            entering += (columns[j][k].abs() + SMALLEST_NORMAL) * reach[j];
        }
        let spread = spread + error * entering + SMALLEST_NORMAL * (1.0 + rest_reach);
        let (min, max) = (f32_below(middle - spread), f32_above(middle + spread));
        if spread <= f64::from(LARGEST) && entering <= f64::from(LARGEST) {
            (out.min[k], out.max[k]) = (min, max);
        }
    }
    out
}
