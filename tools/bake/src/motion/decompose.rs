use crate::{
    Progress,
    bounds::{FrameTrack, FuzzyBox, vertex_track},
    poses::SampledPose,
};
use rayon::prelude::*;
use restpose_formats::{
    Model,
    geom::Aabb,
    rows::{MotionClass, NONE, ROOT_BONE, TriangleRow},
};

/// Triangles that one task bounds; their vertices are posed once for all of them.
const TRIANGLES_PER_TASK: usize = 512;

/// A triangle's place in the decomposition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Carried {
    /// Triangle row.
    pub triangle: u32,
    /// Bone in whose local space it is bounded.
    pub bone: u32,
    /// Its fuzzy box there.
    pub fuzzy_box: Aabb,
}

/// Assigns every triangle with area to the bone in whose local space its fuzzy box has the smallest surface, by
/// exhaustive search over the bones of its part's skin; ties go to the lowest bone.
///
/// A triangle that follows one bone exactly is that bone's, with its rest box: nothing moves there. Bones that have no
/// usable inverse in some sample lose to those that have one in more samples, because without it a pose is traced
/// without the tree.
///
/// Source: Günther, *Ray Tracing of Dynamic Scenes*, §3.4.2.
pub(crate) fn decompose(
    model: &Model,
    bones_of_part: &[Vec<u32>],
    poses: &[SampledPose],
    progress: &dyn Progress,
) -> Vec<Carried> {
    let reach: Vec<f64> = poses.iter().map(|pose| vertex_reach(model, pose)).collect();
    let frames: Vec<FrameTrack> = (0..model.bones.len())
        .into_par_iter()
        .map(|bone| FrameTrack::new(poses, bone, &reach))
        .collect();
    let mut out = Vec::new();
    for (part, bones) in model.parts.iter().zip(bones_of_part) {
        if part.cache != NONE {
            progress.advance(u64::from(part.triangle_count));
            continue;
        }
        let first = part.triangle_first as usize;
        let triangles = &model.triangles[first..][..part.triangle_count as usize];
        let chunks: Vec<Vec<Carried>> = triangles
            .par_chunks(TRIANGLES_PER_TASK)
            .enumerate()
            .map(|(chunk, triangles)| {
                let first = first + chunk * TRIANGLES_PER_TASK;
                let carried = if part.class == MotionClass::Skinned as u32 {
                    carry_skinned(model, bones, poses, &frames, first, triangles)
                } else {
                    carry_exactly(model, first, triangles)
                };
                progress.advance(triangles.len() as u64);
                carried
            })
            .collect();
        out.extend(chunks.into_iter().flatten());
    }
    out
}

/// Bounds `|v|` and `Σ w·|X|·|p|` over all vertices in one pose.
fn vertex_reach(model: &Model, pose: &SampledPose) -> f64 {
    let mut extent = [0.0f64; 3];
    for row in &model.vertices {
        extent = std::array::from_fn(|k| extent[k].max(f64::from(row.position_rest[k].abs())));
    }
    for (target, weight) in model.morph_targets.iter().zip(&pose.morph_weights) {
        extent = std::array::from_fn(|k| extent[k] + f64::from(weight.abs()) * f64::from(target.extent[k]));
    }
    pose.palette.iter().fold(0.0, |far, x| {
        let c = x.columns.map(|column| column.map(|entry| f64::from(entry.abs())));
        (0..3)
            .map(|k| c[0][k] * extent[0] + c[1][k] * extent[1] + c[2][k] * extent[2] + c[3][k])
            .fold(far, f64::max)
    })
}

fn has_area(triangle: &TriangleRow) -> bool {
    triangle.corners[0] != triangle.corners[1]
}

/// The one bone that moves all three corners, if there is one and nothing morphs.
fn only_bone(model: &Model, triangle: &TriangleRow) -> Option<u32> {
    let mut found = None;
    for corner in triangle.corners.map(|corner| corner as usize) {
        let morphs = !model.morph_deltas_of(corner).is_empty();
        match model.influences_of(corner) {
            [only] if !morphs && found.is_none_or(|bone| bone == only.bone) => found = Some(only.bone),
            _ => return None,
        }
    }
    found
}

fn rest_box(model: &Model, triangle: &TriangleRow) -> Aabb {
    Aabb::around(
        triangle
            .corners
            .map(|corner| model.vertices[corner as usize].position_rest),
    )
}

fn carry_exactly(model: &Model, first: usize, triangles: &[TriangleRow]) -> Vec<Carried> {
    let carry = |(index, triangle): (usize, &TriangleRow)| {
        has_area(triangle).then(|| Carried {
            triangle: (first + index) as u32,
            bone: only_bone(model, triangle).unwrap_or(ROOT_BONE),
            fuzzy_box: rest_box(model, triangle),
        })
    };
    triangles.iter().enumerate().filter_map(carry).collect()
}

fn carry_skinned(
    model: &Model,
    bones: &[u32],
    poses: &[SampledPose],
    frames: &[FrameTrack],
    first: usize,
    triangles: &[TriangleRow],
) -> Vec<Carried> {
    let mut vertices: Vec<u32> = triangles
        .iter()
        .filter(|t| has_area(t))
        .flat_map(|t| t.corners)
        .collect();
    vertices.sort_unstable();
    vertices.dedup();
    // One row per vertex, one box per candidate bone.
    let mut boxes: Vec<FuzzyBox> = Vec::with_capacity(vertices.len() * bones.len());
    let mut track = Vec::new();
    for vertex in &vertices {
        vertex_track(model, poses, *vertex as usize, &mut track);
        boxes.extend(bones.iter().map(|bone| frames[*bone as usize].fuzzy_box(&track)));
    }
    let most_usable = bones
        .iter()
        .map(|bone| frames[*bone as usize].usable())
        .max()
        .unwrap_or(0);

    let mut out = Vec::with_capacity(triangles.len());
    for (index, triangle) in triangles.iter().enumerate().filter(|(_, triangle)| has_area(triangle)) {
        let id = (first + index) as u32;
        if let Some(bone) = only_bone(model, triangle) {
            out.push(Carried {
                triangle: id,
                bone,
                fuzzy_box: rest_box(model, triangle),
            });
            continue;
        }
        let rows = triangle
            .corners
            .map(|corner| vertices.partition_point(|vertex| *vertex < corner) * bones.len());
        let mut best: Option<(f64, u32, FuzzyBox)> = None;
        for (place, bone) in bones.iter().enumerate() {
            if frames[*bone as usize].usable() < most_usable {
                continue;
            }
            let fuzzy = rows
                .iter()
                .fold(FuzzyBox::EMPTY, |fuzzy, row| fuzzy.union(boxes[row + place]));
            let area = fuzzy.surface_area();
            if best.is_none_or(|(least, ..)| area < least) {
                best = Some((area, *bone, fuzzy));
            }
        }
        // Where no bone is usable in any sample the tree serves no pose; any box keeps it well-formed.
        let fallback = (bones.first().copied().unwrap_or(ROOT_BONE), rest_box(model, triangle));
        let (bone, fuzzy_box) = match best {
            Some((_, bone, fuzzy)) if !fuzzy.is_empty() => (bone, fuzzy.rounded_outwards(frames[bone as usize].error)),
            _ => fallback,
        };
        out.push(Carried {
            triangle: id,
            bone,
            fuzzy_box,
        });
    }
    out
}
