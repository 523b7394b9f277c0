//! Clip playback: node transforms from channels, world transforms from nodes, the palette from bones.

mod arcs;
mod curve;
mod node_local;
mod palette;
mod slerp;

pub use node_local::NodeLocal;

use crate::{affine64::Affine64, simd::SimdLevel};
use arcs::Arcs;
use curve::{Curve, Rotation};
use palette::write_palette;
use restpose_formats::{ModelView, geom::Affine, rows::Path};

/// A pose of an asset.
#[derive(Debug, Default, PartialEq)]
pub struct Pose {
    /// Asset space from rest space, one map per bone row.
    pub palette: Vec<Affine>,
    /// One weight per morph target row.
    pub morph_weights: Vec<f32>,
    /// One frame per cache row: keys count from 0, fractions stand between them, beyond the ends the first or last counts.
    pub cache_frames: Vec<f64>,
}

impl Clone for Pose {
    fn clone(&self) -> Self {
        let mut out = Self::default();
        out.clone_from(self);
        out
    }

    /// Keeps its memory, which the derived one would not.
    fn clone_from(&mut self, source: &Self) {
        self.palette.clone_from(&source.palette);
        self.morph_weights.clone_from(&source.morph_weights);
        self.cache_frames.clone_from(&source.cache_frames);
    }
}

/// Evaluates clips; owns the scratch that this takes, so that poses allocate nothing once it has grown.
#[derive(Debug, Default)]
pub struct PoseEvaluator {
    locals: Vec<NodeLocal>,
    /// Per node, whether a channel turns it.
    turned: Vec<bool>,
    arcs: Arcs,
    worlds: Vec<Affine64>,
}

impl PoseEvaluator {
    /// Writes the pose of `clip` at `seconds`, or the pose without any clip.
    ///
    /// Computed in `f64`, what is `f32` rounded once.
    /// Guarantee: the same bits on every platform. Times outside a channel's keys take its first or last value. A clip
    /// that the model does not have, and a NaN time, give the pose without any clip.
    pub fn evaluate(&mut self, model: &ModelView, clip: Option<usize>, seconds: f32, pose: &mut Pose) {
        self.evaluate_with(model, clip, seconds, pose, |_, _| {});
    }

    /// As [`Self::evaluate`], with a last word on every node: `change` gets each node row's number and its local map, and
    /// may change it. Rotations that it writes are of unit length. This is the way to poses that no clip holds: ragdolls,
    /// inverse kinematics, random poses.
    ///
    /// Guarantee: as [`Self::evaluate`], which it equals bit for bit where `change` changes nothing. Numbers that are not
    /// finite come out of the palette as such.
    pub fn evaluate_with(
        &mut self,
        model: &ModelView,
        clip: Option<usize>,
        seconds: f32,
        pose: &mut Pose,
        mut change: impl FnMut(usize, &mut NodeLocal),
    ) {
        let Pose {
            palette,
            morph_weights,
            cache_frames,
        } = pose;
        let simd = SimdLevel::detect();
        self.locals.clear();
        self.locals
            .extend(model.nodes.iter().map(|row| NodeLocal::as_stored(row.local())));
        self.turned.clear();
        self.turned.resize(model.nodes.len(), false);
        morph_weights.clear();
        morph_weights.extend(model.morph_targets.iter().map(|target| target.default_weight));

        cache_frames.clear();
        cache_frames.resize(model.caches.len(), 0.0);

        self.arcs.clear();
        if let Some(row) = clip
            .and_then(|clip| model.clips.get(clip))
            .filter(|_| !seconds.is_nan())
        {
            let mut later = 0;
            for channel in &model.channels[row.channel_first as usize..][..row.channel_count as usize] {
                let curve = Curve::new(model, channel);
                let target = channel.target as usize;
                let mut scalar = |k| curve.scalar(seconds, &mut later, k);
                match curve.path() {
                    Path::Weights => {
                        let set = model.morph_sets[target];
                        for k in 0..set.target_count as usize {
                            morph_weights[set.target_first as usize + k] = scalar(k) as f32;
                        }
                    }
                    Path::Frame => cache_frames[target] = scalar(0),
                    Path::Translation => self.locals[target].set_translation(std::array::from_fn(scalar)),
                    Path::Scale => self.locals[target].set_scale(std::array::from_fn(scalar)),
                    Path::Rotation => {
                        self.turned[target] = true;
                        match curve.rotation(seconds, &mut later) {
                            Rotation::Here(rotation) => self.locals[target].set_rotation(rotation),
                            Rotation::On(arc) => self.arcs.push(channel.target, arc),
                        }
                    }
                }
            }
            self.arcs.rotate(simd, &mut self.locals);
        }

        // Unit length costs a root and four quotients, which most nodes of a clip need not: they are turned by channels.
        for (local, _) in self.locals.iter_mut().zip(&self.turned).filter(|(_, turned)| !**turned) {
            local.normalize();
        }
        for (node, local) in self.locals.iter_mut().enumerate() {
            change(node, local);
        }

        write_palette(
            simd,
            (model.nodes, model.bones),
            &self.locals,
            &mut self.worlds,
            palette,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use restpose_formats::{
        Model,
        rows::{BoneRow, ChannelRow, ClipRow, Interpolation, NONE, NodeRow},
    };

    /// A rotation of any length turns alike, whether a channel writes it or none does.
    #[test]
    fn rotations_have_unit_length_wherever_they_come_from() {
        let half_turn = [0.0, 0.0, -3.0, 0.0];
        let mut model = Model::default();
        for node in 0..2 {
            let mut row = NodeRow::zeroed();
            row.parent = NONE;
            row.local[3..7].copy_from_slice(&half_turn);
            row.local[7..10].fill(1.0);
            model.nodes.push(row);
            let mut bone = BoneRow::zeroed();
            bone.node = node;
            bone.inverse_bind = bytemuck::cast(Affine::IDENTITY);
            model.bones.push(bone);
        }
        let quarter_turn = [0.0, 0.0, 2.0, 2.0];
        model.key_times.push(0.0);
        model.key_values.extend(quarter_turn);
        model.channels.push(ChannelRow {
            path: Path::Rotation as u32,
            interpolation: Interpolation::Linear as u32,
            width: 4,
            key_count: 1,
            ..ChannelRow::zeroed()
        });
        model.clips.push(ClipRow {
            channel_count: 1,
            ..ClipRow::zeroed()
        });
        let (mut evaluator, mut pose) = (PoseEvaluator::default(), Pose::default());
        for (clip, turned) in [(None, [-1.0, 0.0]), (Some(0), [0.0, 1.0]), (None, [-1.0, 0.0])] {
            evaluator.evaluate(&model.view(), clip, 0.0, &mut pose);
            let [first, second] = [0, 1].map(|bone: usize| pose.palette[bone].columns[0]);
            // The root of a half and its square are rounded.
            let near = |found: [f32; 3], [x, y]: [f32; 2]| {
                let [dx, dy, dz] = [found[0] - x, found[1] - y, found[2]];
                dx.abs() + dy.abs() + dz.abs() <= f32::EPSILON
            };
            assert!(near(first, turned), "{clip:?}: {first:?}");
            assert!(near(second, [-1.0, 0.0]), "{clip:?}: {second:?}");
        }
    }
}
