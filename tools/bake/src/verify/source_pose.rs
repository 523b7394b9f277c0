use super::{BonePose, source_nodes::SourceNodes};
use crate::import::{Animation, Part};
use glam::{DAffine3, DVec3};
use restpose_formats::{
    ModelView,
    rows::{MotionClass, NONE},
};
use restpose_runtime::{Affine, Frame, InstanceId};

/// The source evaluated in `f64`, without going through the baked file: what the runtime's vertices should be.
///
/// Poses are those of the source's clips at any time, or given maps: then the source's rest positions, morph targets and
/// weights are posed by them.
///
/// Source: glTF 2.0, §3.7.3 (skins, morph targets) and appendix C (interpolation).
pub struct SourcePose<'a> {
    animation: &'a Animation,
    parts: Vec<BakedPart>,
    /// Without any clip.
    still: SourceNodes<'a>,
    played: SourceNodes<'a>,
    size: f64,
}

/// What the file says of a part of the source.
#[derive(Default)]
struct BakedPart {
    /// Frozen in the pose without any clip, on bone 0.
    frozen: bool,
    /// Bone row per joint of the skin, or that of the node; `NONE` for what the file lacks.
    bones: Vec<u32>,
    /// First of its morph target rows, if its morph targets are in the file.
    target_first: Option<usize>,
    /// Cache row.
    cache: Option<usize>,
}

/// What poses a part's vertices.
struct PartPose {
    /// Asset space from rest space per joint of the skin, or that of the node.
    maps: Vec<DAffine3>,
    weights: Vec<f64>,
    cache_frame: f64,
}

impl<'a> SourcePose<'a> {
    /// `model` is a bake of `animation`.
    #[must_use]
    pub fn new(animation: &'a Animation, model: &ModelView) -> Self {
        let still = SourceNodes::new(animation, model);
        let mut parts: Vec<BakedPart> = (0..animation.parts.len().min(model.parts.len()))
            .map(|index| BakedPart::new(&animation.parts[index], model, index))
            .collect();
        parts.resize_with(animation.parts.len(), BakedPart::default);
        let mut pose = Self {
            animation,
            parts,
            played: still.clone(),
            still,
            size: 0.0,
        };
        let mut bounds = Bounds::EMPTY;
        for index in 0..animation.parts.len() {
            let part = pose.played_part(index, &pose.still, 0.0);
            pose.visit(index, &part, |point| bounds.add(point));
        }
        pose.size = bounds.diagonal();
        pose
    }

    /// Diagonal of the box around the vertices without any clip.
    #[must_use]
    pub fn size(&self) -> f64 {
        self.size
    }

    /// The greatest distance between a vertex in `frame` and in the source in this pose, relative to the size of the model
    /// as it is posed or without any clip, whichever is greater: a pose may leave it none. The instance stands at the
    /// identity; its caches, by cache row of the file, at `cache_frames`, whatever a clip says.
    ///
    /// Vertices beyond the range of `f32` are left out.
    pub fn greatest_error(
        &mut self,
        frame: &Frame,
        instance: InstanceId,
        bones: &BonePose,
        cache_frames: &[f64],
    ) -> f64 {
        if let BonePose::Clip(at) = bones {
            self.played.play(*at);
        }
        let (mut row, mut bounds, mut greatest) = (0, Bounds::EMPTY, 0.0f64);
        for index in 0..self.parts.len() {
            let baked = &self.parts[index];
            let cache_frame = baked.cache.and_then(|cache| cache_frames.get(cache)).copied();
            let cache_frame = cache_frame.unwrap_or(0.0);
            let part = match bones {
                BonePose::Clip(_) if baked.frozen => self.played_part(index, &self.still, cache_frame),
                BonePose::Clip(_) => self.played_part(index, &self.played, cache_frame),
                BonePose::Palette { palette, morph_weights } => {
                    self.given_part(index, palette, morph_weights, cache_frame)
                }
            };
            self.visit(index, &part, |expected| {
                let found = frame
                    .vertex(instance, row)
                    .map_or(DVec3::NAN, |v| DVec3::from(v.map(f64::from)));
                row += 1;
                if expected.abs().max_element() > f64::from(f32::MAX) {
                    return;
                }
                bounds.add(expected);
                let distance = expected.distance(found);
                greatest = if distance.is_nan() {
                    f64::INFINITY
                } else {
                    greatest.max(distance)
                };
            });
        }
        if greatest == 0.0 {
            0.0
        } else {
            greatest / bounds.diagonal().max(self.size)
        }
    }

    /// A part as its nodes stand.
    fn played_part(&self, index: usize, nodes: &SourceNodes, cache_frame: f64) -> PartPose {
        let part = &self.animation.parts[index];
        let maps = part.skin.map_or_else(
            || vec![nodes.worlds[part.node]],
            |skin| {
                let skin = &self.animation.skins[skin];
                let joints = skin.joints.iter().zip(&skin.inverse_bind);
                joints
                    .map(|(joint, inverse_bind)| nodes.worlds[*joint] * affine(inverse_bind))
                    .collect()
            },
        );
        PartPose {
            maps,
            weights: nodes.weights[part.node].clone(),
            cache_frame,
        }
    }

    /// A part as given maps and weights pose it.
    fn given_part(&self, index: usize, palette: &[Affine], morph_weights: &[f32], cache_frame: f64) -> PartPose {
        let baked = &self.parts[index];
        let mut pose = self.played_part(index, &self.still, cache_frame);
        let map_of = |bone: u32| {
            palette
                .get(bone as usize)
                .map_or(DAffine3::NAN, |map| affine(&map.columns))
        };
        if baked.frozen {
            // Weights sum to one, so the asset's own map can come before the blend.
            pose.maps.iter_mut().for_each(|map| *map = map_of(0) * *map);
        } else {
            pose.maps = baked.bones.iter().map(|bone| map_of(*bone)).collect();
        }
        if let Some(first) = baked.target_first {
            let given = morph_weights.iter().skip(first).map(|weight| f64::from(*weight));
            pose.weights.iter_mut().zip(given).for_each(|(own, given)| *own = given);
        }
        pose
    }

    /// Gives every vertex of a part, in the order of its vertex rows.
    fn visit(&self, index: usize, pose: &PartPose, mut give: impl FnMut(DVec3)) {
        let part = &self.animation.parts[index];
        for (primitive, source) in self.animation.meshes[part.mesh].primitives.iter().enumerate() {
            for vertex in 0..source.positions.len() {
                give(self.vertex(part, pose, primitive, vertex));
            }
        }
    }

    fn vertex(&self, part: &Part, pose: &PartPose, primitive: usize, vertex: usize) -> DVec3 {
        let primitive = &self.animation.meshes[part.mesh].primitives[primitive];
        let point = |p: [f32; 3]| DVec3::from(p.map(f64::from));
        let moved = |joint: usize, p: DVec3| pose.maps.get(joint).map_or(DVec3::NAN, |map| map.transform_point3(p));
        if let Some(cache) = part.cache {
            let cache = &self.animation.caches[cache];
            let at = primitive.points[vertex] as usize;
            let last = (cache.frame_count() - 1) as f64;
            let frame = pose.cache_frame.clamp(0.0, last);
            let before = frame.floor();
            let [a, b] = [before, (before + 1.0).min(last)].map(|frame| point(cache.frame(frame as usize)[at]));
            return moved(0, a + (b - a) * (frame - before));
        }
        let mut p = point(primitive.positions[vertex]);
        for (target, weight) in primitive.morph_targets.iter().zip(&pose.weights) {
            p += *weight * point(target[vertex]);
        }
        if part.skin.is_none() {
            return moved(0, p);
        }
        let influences = &primitive.influences[vertex];
        let sum: f64 = influences.iter().map(|influence| f64::from(influence.weight)).sum();
        influences
            .iter()
            .map(|influence| f64::from(influence.weight) / sum * moved(influence.joint, p))
            .sum()
    }
}

impl BakedPart {
    fn new(part: &Part, model: &ModelView, index: usize) -> Self {
        let row = &model.parts[index];
        let cache = (row.cache != NONE).then_some(row.cache as usize);
        let is_node = |node: u32, source: usize| {
            let row = model.nodes.get(node as usize);
            row.is_some_and(|row| row.source_node as usize == source)
        };
        let bones = if let Some(cache) = cache.and_then(|cache| model.caches.get(cache)) {
            vec![cache.bone]
        } else if let Some(skin) = part.skin {
            let of_skin = model.bones.iter().zip(0u32..);
            let mut joints: Vec<(u32, u32)> = of_skin
                .filter(|(bone, _)| bone.source_skin as usize == skin)
                .map(|(bone, row)| (bone.source_joint, row))
                .collect();
            joints.sort_unstable();
            joints.into_iter().map(|(_, bone)| bone).collect()
        } else {
            let own = model
                .bones
                .iter()
                .position(|bone| bone.source_skin == NONE && is_node(bone.node, part.node));
            vec![own.map_or(NONE, |bone| bone as u32)]
        };
        let target_first = model.morph_sets.get(row.morph_set as usize);
        Self {
            frozen: row.class == MotionClass::Static as u32 && cache.is_none(),
            bones,
            target_first: target_first.map(|set| set.target_first as usize),
            cache,
        }
    }
}

fn affine(columns: &[[f32; 3]; 4]) -> DAffine3 {
    DAffine3::from_cols_array_2d(&columns.map(|column| column.map(f64::from)))
}

struct Bounds(DVec3, DVec3);

impl Bounds {
    const EMPTY: Self = Self(DVec3::INFINITY, DVec3::NEG_INFINITY);

    fn add(&mut self, point: DVec3) {
        *self = Self(self.0.min(point), self.1.max(point));
    }

    /// 0 of nothing.
    fn diagonal(&self) -> f64 {
        (self.1 - self.0).max(DVec3::ZERO).length()
    }
}
