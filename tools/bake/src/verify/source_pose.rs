use crate::{
    import::{Animation, Channel, ChannelTarget, Local, Part},
    motion::parents_first,
};
use glam::{DAffine3, DMat4, DQuat, DVec3, DVec4};
use restpose_formats::{
    ModelView,
    rows::{Interpolation, MotionClass, NONE, SampleRow},
};
use restpose_runtime::{Frame, InstanceId};

/// The source evaluated in `f64`, without going through the baked file: what the runtime's vertices should be.
///
/// Source: glTF 2.0, §3.7.3 (skins, morph targets) and appendix C (interpolation).
pub struct SourcePose<'a> {
    animation: &'a Animation,
    /// Per clip of the file: its number in the source.
    clips: Vec<usize>,
    /// Per part: whether it was frozen in the pose without clips, by class.
    frozen: Vec<bool>,
    order: Vec<usize>,
    worlds: Vec<DAffine3>,
    weights: Vec<Vec<f64>>,
    /// Per vertex cache: its frame.
    frames: Vec<f64>,
    /// Per part: the cache row of the file.
    cache_rows: Vec<Option<usize>>,
}

impl<'a> SourcePose<'a> {
    /// `model` is a bake of `animation`.
    #[must_use]
    pub fn new(animation: &'a Animation, model: &ModelView) -> Self {
        let clips = source_clips(animation, model);
        let frozen = model
            .parts
            .iter()
            .map(|part| part.class == MotionClass::Static as u32)
            .collect();
        Self {
            animation,
            clips,
            frozen,
            order: parents_first(animation),
            worlds: vec![DAffine3::IDENTITY; animation.nodes.len()],
            weights: vec![Vec::new(); animation.nodes.len()],
            frames: vec![0.0; animation.caches.len()],
            cache_rows: model
                .parts
                .iter()
                .map(|part| (part.cache != NONE).then_some(part.cache as usize))
                .collect(),
        }
    }

    /// The greatest distance between a vertex in `frame` and in the source at `sample`, relative to the diagonal of
    /// the box around the source's vertices. The instance stands at the identity; its caches, by cache row of the file, at
    /// `cache_frames`, whatever the sample says.
    pub fn greatest_error(
        &mut self,
        frame: &Frame,
        instance: InstanceId,
        sample: SampleRow,
        cache_frames: &[f64],
    ) -> f64 {
        let mut row = 0;
        let (mut low, mut high, mut greatest) = (DVec3::INFINITY, DVec3::NEG_INFINITY, 0.0f64);
        for (index, part) in self.animation.parts.iter().enumerate() {
            let clip = if sample.clip == NONE || self.frozen.get(index).copied().unwrap_or(true) {
                None
            } else {
                self.clips.get(sample.clip as usize).copied()
            };
            self.pose_nodes(clip, f64::from(sample.seconds));
            if let (Some(cache), Some(row)) = (part.cache, self.cache_rows[index]) {
                self.frames[cache] = cache_frames[row];
            }
            for (primitive, source) in self.animation.meshes[part.mesh].primitives.iter().enumerate() {
                for vertex in 0..source.positions.len() {
                    let expected = self.vertex(part, primitive, vertex);
                    let found = frame
                        .vertex(instance, row)
                        .map_or(DVec3::NAN, |v| DVec3::from(v.map(f64::from)));
                    row += 1;
                    (low, high) = (low.min(expected), high.max(expected));
                    let distance = expected.distance(found);
                    greatest = if distance.is_nan() {
                        f64::INFINITY
                    } else {
                        greatest.max(distance)
                    };
                }
            }
        }
        let size = low.distance(high);
        if greatest == 0.0 { 0.0 } else { greatest / size }
    }

    fn pose_nodes(&mut self, clip: Option<usize>, seconds: f64) {
        let animation = self.animation;
        let mut locals: Vec<Local64> = animation.nodes.iter().map(|node| Local64::new(&node.local)).collect();
        for (weights, node) in self.weights.iter_mut().zip(&animation.nodes) {
            weights.clear();
            weights.extend(node.weights.iter().map(|weight| f64::from(*weight)));
        }
        self.frames.fill(0.0);
        for channel in clip.into_iter().flat_map(|clip| &animation.clips[clip].channels) {
            let value = value(channel, seconds);
            match channel.target {
                ChannelTarget::Translation => locals[channel.node].translation = DVec3::from_slice(&value),
                ChannelTarget::Scale => locals[channel.node].scale = DVec3::from_slice(&value),
                ChannelTarget::Rotation => locals[channel.node].rotation = DQuat::from_slice(&value),
                ChannelTarget::Weights => self.weights[channel.node] = value,
                ChannelTarget::Frame => self.frames[channel.node] = value[0],
            }
        }
        for node in self.order.iter().copied() {
            let local = locals[node].affine();
            self.worlds[node] = animation.nodes[node]
                .parent
                .map_or(local, |parent| self.worlds[parent] * local);
        }
    }

    fn vertex(&self, part: &Part, primitive: usize, vertex: usize) -> DVec3 {
        let primitive = &self.animation.meshes[part.mesh].primitives[primitive];
        let point = |p: [f32; 3]| DVec3::from(p.map(f64::from));
        if let Some(cache) = part.cache {
            let cache = &self.animation.caches[cache];
            let at = primitive.points[vertex] as usize;
            let frame = self.frames[part.cache.unwrap_or(0)].clamp(0.0, (cache.frame_count() - 1) as f64);
            let before = frame.floor();
            let [a, b] = [before, (before + 1.0).min((cache.frame_count() - 1) as f64)]
                .map(|frame| point(cache.frame(frame as usize)[at]));
            return self.worlds[part.node].transform_point3(a + (b - a) * (frame - before));
        }
        let mut p = point(primitive.positions[vertex]);
        for (target, weight) in primitive.morph_targets.iter().zip(&self.weights[part.node]) {
            p += *weight * point(target[vertex]);
        }
        let Some(skin) = part.skin else {
            return self.worlds[part.node].transform_point3(p);
        };
        let skin = &self.animation.skins[skin];
        let influences = &primitive.influences[vertex];
        let sum: f64 = influences.iter().map(|influence| f64::from(influence.weight)).sum();
        let moved = |joint: usize| {
            let inverse_bind = DAffine3::from_cols_array_2d(&skin.inverse_bind[joint].map(|c| c.map(f64::from)));
            (self.worlds[skin.joints[joint]] * inverse_bind).transform_point3(p)
        };
        influences
            .iter()
            .map(|influence| f64::from(influence.weight) / sum * moved(influence.joint))
            .sum()
    }
}

/// Per clip of the file: its number in the source.
pub(super) fn source_clips(animation: &Animation, model: &ModelView) -> Vec<usize> {
    // The file keeps selected clips in source order under their labels; clips of one label are selected together.
    let mut clips = Vec::new();
    let mut labels = animation
        .clips
        .iter()
        .enumerate()
        .map(|(number, clip)| clip.label(number));
    let mut number = 0;
    for name in &model.meta.clip_names {
        number += labels.by_ref().take_while(|label| label != name).count();
        clips.push(number);
        number += 1;
    }
    clips
}

struct Local64 {
    translation: DVec3,
    rotation: DQuat,
    scale: DVec3,
    matrix: Option<DAffine3>,
}

impl Local64 {
    fn new(local: &Local) -> Self {
        let mut out = Self {
            translation: DVec3::ZERO,
            rotation: DQuat::IDENTITY,
            scale: DVec3::ONE,
            matrix: None,
        };
        match *local {
            Local::Matrix(columns) => {
                out.matrix = Some(DAffine3::from_cols_array_2d(
                    &columns.map(|column| column.map(f64::from)),
                ));
            }
            Local::Trs {
                translation,
                rotation,
                scale,
            } => {
                out.translation = translation.map(f64::from).into();
                out.rotation = DQuat::from_array(rotation.map(f64::from));
                out.scale = scale.map(f64::from).into();
            }
        }
        out
    }

    fn affine(&self) -> DAffine3 {
        let trs = || {
            DMat4::from_translation(self.translation)
                * DMat4::from_quat(self.rotation.normalize())
                * DMat4::from_scale(self.scale)
        };
        self.matrix.unwrap_or_else(|| DAffine3::from_mat4(trs()))
    }
}

/// A channel's value at a time.
fn value(channel: &Channel, seconds: f64) -> Vec<f64> {
    let per_key = channel.values.len() / channel.times.len();
    let width = per_key / channel.interpolation.values_per_key() as usize;
    let key = |key: usize, part: usize| -> Vec<f64> {
        let begin = key * per_key
            + if channel.interpolation == Interpolation::CubicSpline {
                part * width
            } else {
                0
            };
        channel.values[begin..begin + width]
            .iter()
            .map(|x| f64::from(*x))
            .collect()
    };
    let last = channel.times.len() - 1;
    let next = channel
        .times
        .iter()
        .position(|time| f64::from(*time) > seconds)
        .unwrap_or(last + 1);
    if next == 0 {
        return key(0, 1);
    }
    if next > last || channel.interpolation == Interpolation::Step {
        return key(next - 1, 1);
    }
    let (begin, end) = (f64::from(channel.times[next - 1]), f64::from(channel.times[next]));
    let (step, s) = (end - begin, (seconds - begin) / (end - begin));
    let (a, b) = (key(next - 1, 1), key(next, 1));
    if channel.interpolation == Interpolation::Linear {
        if channel.target == ChannelTarget::Rotation {
            return slerp(&a, &b, s).to_vec();
        }
        return a.iter().zip(&b).map(|(a, b)| a + (b - a) * s).collect();
    }
    let (out, into) = (key(next - 1, 2), key(next, 0));
    let hermite = |k: usize| {
        (2.0 * s.powi(3) - 3.0 * s.powi(2) + 1.0) * a[k]
            + step * (s.powi(3) - 2.0 * s.powi(2) + s) * out[k]
            + (3.0 * s.powi(2) - 2.0 * s.powi(3)) * b[k]
            + step * (s.powi(3) - s.powi(2)) * into[k]
    };
    (0..width).map(hermite).collect()
}

fn slerp(a: &[f64], b: &[f64], s: f64) -> [f64; 4] {
    let (a, mut b) = (DVec4::from_slice(a).normalize(), DVec4::from_slice(b).normalize());
    if a.dot(b) < 0.0 {
        b = -b;
    }
    // Exponential of a fraction of the logarithm, another way than the runtime's.
    let across = b - a * a.dot(b);
    let (sine, cosine) = (across.length(), a.dot(b));
    if sine == 0.0 {
        return a.to_array();
    }
    let angle = s * sine.atan2(cosine);
    (a * angle.cos() + across / sine * angle.sin()).to_array()
}
