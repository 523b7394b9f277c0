use crate::{
    Progress,
    bounds::{FrameTrack, FuzzyBox, vertex_track},
    poses::SampledPose,
};
use rayon::prelude::*;
use restpose_formats::{
    Bounds, Model,
    geom::Aabb,
    rows::{MotionClass, NONE, ROOT_BONE, TriangleRow},
};

/// Poses, spread evenly over all, by which a triangle's bone is chosen.
const CHOICE_POSES: usize = 48;

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

/// Assigns every triangle with area to the bone in whose local space its fuzzy box has the smallest surface, by search over
/// the bones that move it; ties go to the lowest bone. The boxes hold in the sampled poses; with `bounds` by envelopes they
/// are those of a few poses only, for others to widen.
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
    bounds: Bounds,
    progress: &dyn Progress,
) -> Vec<Carried> {
    let count = poses.len().min(CHOICE_POSES);
    let choice = Tracks::new(
        model,
        (0..count).map(|place| &poses[place * poses.len() / count]).collect(),
    );
    let all = (bounds == Bounds::Sampled).then(|| Tracks::new(model, poses.iter().collect()));
    let usable: Vec<usize> = (0..model.bones.len())
        .map(|bone| poses.iter().filter(|pose| pose.inverses[bone].is_some()).count())
        .collect();
    let search = Search {
        model,
        usable: &usable,
        choice: &choice,
        all: all.as_ref(),
    };
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
                    search.carry(bones, first, triangles)
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

/// Poses, and every bone's frames in them.
struct Tracks<'a> {
    poses: Vec<&'a SampledPose>,
    frames: Vec<FrameTrack>,
}

impl<'a> Tracks<'a> {
    fn new(model: &Model, poses: Vec<&'a SampledPose>) -> Self {
        let reach: Vec<f64> = poses.iter().map(|pose| vertex_reach(model, pose)).collect();
        let frames = (0..model.bones.len())
            .into_par_iter()
            .map(|bone| FrameTrack::new(&poses, bone, &reach))
            .collect();
        Self { poses, frames }
    }
}

/// The search for the bones of skinned triangles.
struct Search<'a> {
    model: &'a Model,
    /// Per bone, poses in which it can carry a cluster.
    usable: &'a [usize],
    /// By which bones are chosen.
    choice: &'a Tracks<'a>,
    /// In which the boxes hold, if they are not those of `choice`.
    all: Option<&'a Tracks<'a>>,
}

impl Search<'_> {
    /// `bones` are those of the part, of which some may move nothing; triangles stand in rows from `first` on.
    fn carry(&self, bones: &[u32], first: usize, triangles: &[TriangleRow]) -> Vec<Carried> {
        let corners = triangles.iter().filter(|t| has_area(t)).flat_map(|t| t.corners);
        let vertices = ascending(corners.collect());
        let movers = |vertex: u32| self.model.influences_of(vertex as usize).iter().map(|row| row.bone);
        let candidates = ascending(vertices.iter().flat_map(|vertex| movers(*vertex)).collect());
        // One row per vertex, one box per candidate.
        let mut boxes: Vec<FuzzyBox> = Vec::with_capacity(vertices.len() * candidates.len());
        let mut track = Vec::new();
        for vertex in &vertices {
            vertex_track(self.model, &self.choice.poses, *vertex as usize, &mut track);
            let frames = candidates.iter().map(|bone| &self.choice.frames[*bone as usize]);
            boxes.extend(frames.map(|frame| frame.fuzzy_box(&track)));
        }
        let mut chosen: Vec<Carried> = Vec::with_capacity(triangles.len());
        for (index, triangle) in triangles.iter().enumerate().filter(|(_, triangle)| has_area(triangle)) {
            let id = (first + index) as u32;
            if let Some(bone) = only_bone(self.model, triangle) {
                chosen.push(Carried {
                    triangle: id,
                    bone,
                    fuzzy_box: rest_box(self.model, triangle),
                });
                continue;
            }
            let own = ascending(triangle.corners.into_iter().flat_map(movers).collect());
            let most_usable = own.iter().map(|bone| self.usable[*bone as usize]).max().unwrap_or(0);
            let rows = triangle
                .corners
                .map(|corner| vertices.partition_point(|vertex| *vertex < corner) * candidates.len());
            let mut best: Option<(f64, u32, FuzzyBox)> = None;
            for bone in own {
                if self.usable[bone as usize] < most_usable {
                    continue;
                }
                let place = candidates.partition_point(|candidate| *candidate < bone);
                let fuzzy = rows
                    .iter()
                    .fold(FuzzyBox::EMPTY, |fuzzy, row| fuzzy.union(boxes[row + place]));
                let area = fuzzy.surface_area();
                if best.is_none_or(|(least, ..)| area < least) {
                    best = Some((area, bone, fuzzy));
                }
            }
            // Where no bone is usable in any sample the tree serves no pose; any box keeps it well-formed.
            let fallback = (
                bones.first().copied().unwrap_or(ROOT_BONE),
                rest_box(self.model, triangle),
            );
            let (bone, fuzzy_box) = match best {
                Some((_, bone, fuzzy)) if !fuzzy.is_empty() => {
                    (bone, fuzzy.rounded_outwards(self.choice.frames[bone as usize].error))
                }
                _ => fallback,
            };
            chosen.push(Carried {
                triangle: id,
                bone,
                fuzzy_box,
            });
        }
        if let Some(all) = self.all {
            self.bound(all, &mut chosen);
        }
        chosen
    }

    /// Makes the boxes those of all poses.
    fn bound(&self, all: &Tracks, chosen: &mut [Carried]) {
        let mut moving: Vec<(&mut Carried, FuzzyBox)> = chosen
            .iter_mut()
            .filter(|carried| only_bone(self.model, &self.model.triangles[carried.triangle as usize]).is_none())
            .map(|carried| (carried, FuzzyBox::EMPTY))
            .collect();
        // Triangles by their corners, so that each vertex is posed once.
        let mut uses: Vec<(u32, usize)> = Vec::new();
        for (place, (carried, _)) in moving.iter().enumerate() {
            let corners = self.model.triangles[carried.triangle as usize].corners;
            uses.extend(corners.map(|corner| (corner, place)));
        }
        uses.sort_unstable();
        let mut track = Vec::new();
        for uses in uses.chunk_by(|a, b| a.0 == b.0) {
            vertex_track(self.model, &all.poses, uses[0].0 as usize, &mut track);
            let mut known: Option<(u32, FuzzyBox)> = None;
            for (_, place) in uses {
                let (carried, bounds) = &mut moving[*place];
                let fuzzy = match known {
                    Some((bone, fuzzy)) if bone == carried.bone => fuzzy,
                    _ => all.frames[carried.bone as usize].fuzzy_box(&track),
                };
                known = Some((carried.bone, fuzzy));
                *bounds = bounds.union(fuzzy);
            }
        }
        for (carried, bounds) in moving {
            if !bounds.is_empty() {
                carried.fuzzy_box = bounds.rounded_outwards(all.frames[carried.bone as usize].error);
            }
        }
    }
}

fn ascending(mut rows: Vec<u32>) -> Vec<u32> {
    rows.sort_unstable();
    rows.dedup();
    rows
}
