use super::{
    pose_source::PoseFamily,
    random_map::{direction, distortion, rotation, rounded, rounded_number, small_turn},
    source_nodes::SourceNodes,
};
use crate::import::Animation;
use fastrand::Rng;
use glam::{DAffine3, DQuat};
use restpose_formats::{
    ModelView,
    rows::{BoneRow, NONE, SampleRow},
};
use restpose_runtime::Affine;

/// How far [`PoseFamily::Far`] moves a bone, in sizes of the model.
const FAR: f64 = 1000.0;

/// Draws poses far outside any clip, from the source's nodes and the file's bones and without the runtime.
pub(super) struct RandomPoses<'a> {
    model: &'a ModelView<'a>,
    nodes: SourceNodes<'a>,
    /// Source nodes that bones hang on.
    joints: Vec<usize>,
    /// Bones that move vertices.
    carriers: Vec<usize>,
    size: f64,
}

/// Maps and weights before they are rounded.
struct Drawn {
    palette: Vec<DAffine3>,
    weights: Vec<f64>,
}

impl<'a> RandomPoses<'a> {
    /// `model` is a bake of `animation`, and without any clip as large as `size`.
    pub fn new(animation: &'a Animation, model: &'a ModelView<'a>, size: f64) -> Self {
        let nodes = SourceNodes::new(animation, model);
        let mut joints: Vec<usize> = model.bones.iter().filter_map(|bone| source_node(model, bone)).collect();
        joints.retain(|node| *node < nodes.worlds.len());
        joints.sort_unstable();
        joints.dedup();
        let of_vertices = model.influences.iter().map(|influence| influence.bone as usize);
        let of_caches = model.caches.iter().map(|cache| cache.bone as usize);
        let mut carriers: Vec<usize> = of_vertices.chain(of_caches).collect();
        carriers.sort_unstable();
        carriers.dedup();
        Self {
            model,
            nodes,
            joints,
            carriers,
            size,
        }
    }

    /// The families that make sense for the file, in the order of [`PoseFamily::ALL`].
    pub fn families(&self) -> Vec<PoseFamily> {
        let makes_sense = |family: &PoseFamily| match family {
            PoseFamily::Ragdoll | PoseFamily::SmallTurns => !self.joints.is_empty(),
            PoseFamily::Blend | PoseFamily::Mix => !self.model.clips.is_empty(),
            PoseFamily::Morphs => !self.model.morph_targets.is_empty(),
            PoseFamily::Scaled
            | PoseFamily::Sheared
            | PoseFamily::Mirrored
            | PoseFamily::Vanished
            | PoseFamily::Far
            | PoseFamily::NearSingular => !self.carriers.is_empty(),
        };
        PoseFamily::ALL.into_iter().filter(makes_sense).collect()
    }

    /// Draws a pose: a map per bone row, a weight per morph target row, all finite.
    pub fn draw(&mut self, family: PoseFamily, random: &mut Rng) -> (Vec<Affine>, Vec<f32>) {
        self.nodes.play(clip_time(self.model, false, random));
        match family {
            PoseFamily::Ragdoll => self.turn_joints(rotation, random),
            PoseFamily::SmallTurns => self.turn_joints(small_turn, random),
            PoseFamily::Mix => {
                for node in 0..self.nodes.worlds.len() {
                    self.nodes.play_node(node, clip_time(self.model, false, random));
                }
                self.nodes.update_worlds();
            }
            _ => {}
        }
        let mut drawn = self.drawn();
        match family {
            PoseFamily::Blend => {
                self.nodes.play(clip_time(self.model, false, random));
                drawn = drawn.blended(&self.drawn(), random.f64());
            }
            PoseFamily::Vanished => self.distort(&mut drawn, family, 1, random),
            PoseFamily::Scaled | PoseFamily::Sheared | PoseFamily::Mirrored | PoseFamily::NearSingular => {
                let count = random.usize(1..=3);
                self.distort(&mut drawn, family, count, random);
            }
            PoseFamily::Far => {
                if let Some(bone) = random.choice(&self.carriers) {
                    drawn.palette[*bone].translation += direction(random) * (FAR * self.size);
                }
            }
            PoseFamily::Morphs => drawn
                .weights
                .iter_mut()
                .for_each(|weight| *weight = random.f64() * 5.0 - 2.0),
            PoseFamily::Ragdoll | PoseFamily::SmallTurns | PoseFamily::Mix => {}
        }
        let palette = drawn.palette.iter().map(rounded).collect();
        let weights = drawn.weights.iter().map(|weight| rounded_number(*weight)).collect();
        (palette, weights)
    }

    fn turn_joints(&mut self, turn: impl Fn(&mut Rng) -> DQuat, random: &mut Rng) {
        for joint in self.joints.iter().copied() {
            // An even rotation after any other is even.
            self.nodes.locals[joint].turn(turn(random));
        }
        self.nodes.update_worlds();
    }

    fn distort(&self, drawn: &mut Drawn, family: PoseFamily, count: usize, random: &mut Rng) {
        for _ in 0..count {
            if let Some(bone) = random.choice(&self.carriers) {
                drawn.palette[*bone] = self.map(&self.model.bones[*bone], &distortion(family, random));
            }
        }
    }

    fn drawn(&self) -> Drawn {
        let bones = self.model.bones.iter();
        let targets = self.model.morph_targets.iter();
        let mut weights: Vec<f64> = targets.map(|target| f64::from(target.default_weight)).collect();
        for set in self.model.morph_sets {
            let rows = weights.iter_mut().skip(set.target_first as usize);
            let own = self.nodes.weights.get(set.source_node as usize).into_iter().flatten();
            rows.take(set.target_count as usize)
                .zip(own)
                .for_each(|(row, own)| *row = *own);
        }
        Drawn {
            palette: bones.map(|bone| self.map(bone, &DAffine3::IDENTITY)).collect(),
            weights,
        }
    }

    /// Asset space from rest space by way of a bone that `distortion` changes in its joint's space.
    fn map(&self, bone: &BoneRow, distortion: &DAffine3) -> DAffine3 {
        let world = source_node(self.model, bone).and_then(|node| self.nodes.worlds.get(node));
        let Some(world) = world else {
            return *distortion;
        };
        let inverse_bind = bone.inverse_bind().columns.map(|column| column.map(f64::from));
        *world * *distortion * DAffine3::from_cols_array_2d(&inverse_bind)
    }
}

impl Drawn {
    fn blended(&self, other: &Self, share: f64) -> Self {
        let maps = self.palette.iter().zip(&other.palette);
        let weights = self.weights.iter().zip(&other.weights);
        Self {
            palette: maps
                .map(|(a, b)| DAffine3 {
                    matrix3: a.matrix3 * (1.0 - share) + b.matrix3 * share,
                    translation: a.translation * (1.0 - share) + b.translation * share,
                })
                .collect(),
            weights: weights.map(|(a, b)| a * (1.0 - share) + b * share).collect(),
        }
    }
}

/// A clip of the file at a random time, or at a random key of one of its channels; without clips the pose without any.
pub(super) fn clip_time(model: &ModelView, at_key: bool, random: &mut Rng) -> SampleRow {
    let clip = random.usize(..model.clips.len().max(1));
    let Some(row) = model.clips.get(clip) else {
        return SampleRow {
            clip: NONE,
            seconds: 0.0,
        };
    };
    let channels = &model.channels[row.channel_first as usize..][..row.channel_count as usize];
    let key = random.choice(channels).filter(|_| at_key);
    let seconds = match key {
        Some(channel) => {
            let keys = &model.key_times[channel.time_first as usize..][..channel.key_count as usize];
            random.choice(keys).copied().unwrap_or(row.start_seconds)
        }
        None => {
            let (start, end) = (f64::from(row.start_seconds), f64::from(row.end_seconds));
            (start + (end - start) * random.f64()) as f32
        }
    };
    SampleRow {
        clip: clip as u32,
        seconds,
    }
}

/// The source node that a bone hangs on; none for the asset's own.
fn source_node(model: &ModelView, bone: &BoneRow) -> Option<usize> {
    Some(model.nodes.get(bone.node as usize)?.source_node as usize)
}
