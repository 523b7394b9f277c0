use super::source_curve::value;
use crate::{
    import::{Animation, ChannelTarget, Local},
    motion::parents_first,
};
use glam::{DAffine3, DMat4, DQuat, DVec3};
use restpose_formats::{ModelView, rows::SampleRow};

/// The source's nodes in a pose, evaluated in `f64` without going through the baked file.
///
/// Source: glTF 2.0, §3.5 (nodes) and appendix C (interpolation).
#[derive(Clone)]
pub(super) struct SourceNodes<'a> {
    animation: &'a Animation,
    /// Per clip of the file: its number in the source.
    clips: Vec<usize>,
    order: Vec<usize>,
    /// Per node: parent from node.
    pub locals: Vec<SourceLocal>,
    /// Per node: world from node.
    pub worlds: Vec<DAffine3>,
    /// Per node: morph weights.
    pub weights: Vec<Vec<f64>>,
}

/// A node's local map, its parts apart as long as it has any.
#[derive(Clone, Copy)]
pub(super) enum SourceLocal {
    Trs {
        translation: DVec3,
        rotation: DQuat,
        scale: DVec3,
    },
    Matrix(DAffine3),
}

impl<'a> SourceNodes<'a> {
    /// The pose without any clip. `model` is a bake of `animation`.
    pub fn new(animation: &'a Animation, model: &ModelView) -> Self {
        let mut nodes = Self {
            animation,
            clips: source_clips(animation, model),
            order: parents_first(animation),
            locals: Vec::new(),
            worlds: vec![DAffine3::IDENTITY; animation.nodes.len()],
            weights: Vec::new(),
        };
        nodes.reset();
        nodes.update_worlds();
        nodes
    }

    /// Poses all nodes by a clip of the file; a clip that the file does not have gives the pose without any.
    pub fn play(&mut self, at: SampleRow) {
        self.reset();
        self.set_channels(at, None);
        self.update_worlds();
    }

    /// Takes one node's local map and weights from a clip, as [`SourceNodes::play`]; the worlds stay as they are.
    pub fn play_node(&mut self, node: usize, at: SampleRow) {
        let source = &self.animation.nodes[node];
        self.locals[node] = SourceLocal::new(&source.local);
        self.weights[node] = weights(&source.weights);
        self.set_channels(at, Some(node));
    }

    fn reset(&mut self) {
        let nodes = &self.animation.nodes;
        self.locals.clear();
        self.locals
            .extend(nodes.iter().map(|node| SourceLocal::new(&node.local)));
        self.weights.clear();
        self.weights.extend(nodes.iter().map(|node| weights(&node.weights)));
    }

    fn set_channels(&mut self, at: SampleRow, only: Option<usize>) {
        let clip = self
            .clips
            .get(at.clip as usize)
            .map(|clip| &self.animation.clips[*clip]);
        for channel in clip.into_iter().flat_map(|clip| &clip.channels) {
            // The channel of a vertex cache does not name a node.
            if channel.target == ChannelTarget::Frame || only.is_some_and(|only| only != channel.node) {
                continue;
            }
            let value = value(channel, f64::from(at.seconds));
            match channel.target {
                ChannelTarget::Weights => self.weights[channel.node] = value,
                target => self.locals[channel.node].set(target, &value),
            }
        }
    }

    /// Makes the worlds of the locals.
    pub fn update_worlds(&mut self) {
        for node in self.order.iter().copied() {
            let local = self.locals[node].affine();
            self.worlds[node] = self.animation.nodes[node]
                .parent
                .map_or(local, |parent| self.worlds[parent] * local);
        }
    }
}

fn weights(weights: &[f32]) -> Vec<f64> {
    weights.iter().map(|weight| f64::from(*weight)).collect()
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

impl SourceLocal {
    fn new(local: &Local) -> Self {
        match *local {
            Local::Matrix(columns) => Self::Matrix(DAffine3::from_cols_array_2d(
                &columns.map(|column| column.map(f64::from)),
            )),
            Local::Trs {
                translation,
                rotation,
                scale,
            } => Self::Trs {
                translation: translation.map(f64::from).into(),
                rotation: DQuat::from_array(rotation.map(f64::from)),
                scale: scale.map(f64::from).into(),
            },
        }
    }

    /// Takes a channel's value; a matrix has none that a channel could move.
    fn set(&mut self, target: ChannelTarget, value: &[f64]) {
        let Self::Trs {
            translation,
            rotation,
            scale,
        } = self
        else {
            return;
        };
        match target {
            ChannelTarget::Translation => *translation = DVec3::from_slice(value),
            ChannelTarget::Scale => *scale = DVec3::from_slice(value),
            ChannelTarget::Rotation => *rotation = DQuat::from_slice(value),
            ChannelTarget::Weights | ChannelTarget::Frame => {}
        }
    }

    /// Turns the node about its own axes, before its scale.
    pub fn turn(&mut self, by: DQuat) {
        match self {
            Self::Trs { rotation, .. } => *rotation = rotation.normalize() * by,
            Self::Matrix(matrix) => *matrix *= DAffine3::from_quat(by),
        }
    }

    fn affine(&self) -> DAffine3 {
        match *self {
            Self::Matrix(matrix) => matrix,
            Self::Trs {
                translation,
                rotation,
                scale,
            } => DAffine3::from_mat4(
                DMat4::from_translation(translation)
                    * DMat4::from_quat(rotation.normalize())
                    * DMat4::from_scale(scale),
            ),
        }
    }
}
