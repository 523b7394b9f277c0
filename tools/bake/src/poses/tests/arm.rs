use crate::{
    BakeSettings, NoProgress, PoseSpace,
    poses::{SampledPose, evaluate, random_poses, sample_rows},
};
use restpose_formats::{
    Model,
    geom::Affine,
    rows::{BoneRow, ChannelRow, ClipRow, Interpolation, Local, MorphSetRow, MorphTargetRow, NONE, NodeRow, Path},
};

/// What bone rows 1 to 4 hang on, one node each.
pub(super) const SHOULDER: usize = 1;
pub(super) const ELBOW: usize = 2;
/// A matrix node.
pub(super) const HAND: usize = 3;
/// Carries a rigid part: no joint.
pub(super) const HAT: usize = 4;

/// The elbow's rotation without any clip: a quarter turn about x.
const ELBOW_ROTATION: [f32; 4] = [
    std::f32::consts::FRAC_1_SQRT_2,
    0.0,
    0.0,
    std::f32::consts::FRAC_1_SQRT_2,
];
/// The hand's linear part.
pub(super) const HAND_MATRIX: [[f32; 3]; 3] = [[2.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, -3.0]];

/// Four nodes that hang on nothing, so that a palette entry is a local map: a shoulder without rotation, an elbow with one,
/// a hand with a matrix, a hat. One clip turns the elbow, in its own axes, about y from 0 to 60 degrees, and moves a morph
/// weight from 0 to 1, which is 0.25 without it.
pub(super) fn arm() -> Model {
    let trs = |rotation| Local::Trs {
        translation: [1.0, 2.0, 3.0],
        rotation,
        scale: [1.0; 3],
    };
    let still = [0.0, 0.0, 0.0, 1.0];
    let [x, y, z] = HAND_MATRIX;
    let locals = [
        trs(still),
        trs(ELBOW_ROTATION),
        Local::Matrix([x, y, z, [4.0, 5.0, 6.0]]),
        trs(still),
    ];
    let bone = |node, source_skin| BoneRow {
        node,
        source_skin,
        source_joint: source_skin,
        reserved: 0,
        inverse_bind: bytemuck::cast(Affine::IDENTITY.columns),
    };
    let channel = |target, path, width, key, value| ChannelRow {
        target,
        path: path as u32,
        interpolation: Interpolation::Linear as u32,
        width,
        time_first: key,
        key_count: 2,
        value_first: value,
        reserved: 0,
    };
    let half = 30f32.to_radians();
    // The elbow's own quarter turn about x, then the half angle of 60 degrees about the y axis that this leaves.
    let turned = [
        ELBOW_ROTATION[0] * half.cos(),
        ELBOW_ROTATION[3] * half.sin(),
        ELBOW_ROTATION[0] * half.sin(),
        ELBOW_ROTATION[3] * half.cos(),
    ];
    let mut model = Model {
        nodes: (0..4)
            .map(|node| NodeRow::new(NONE, node, locals[node as usize]))
            .collect(),
        bones: vec![bone(NONE, NONE), bone(0, 0), bone(1, 0), bone(2, 0), bone(3, NONE)],
        clips: vec![ClipRow {
            start_seconds: 0.0,
            end_seconds: 1.0,
            channel_first: 0,
            channel_count: 2,
        }],
        channels: vec![channel(1, Path::Rotation, 4, 0, 0), channel(0, Path::Weights, 1, 0, 8)],
        key_times: vec![0.0, 1.0],
        key_values: [&ELBOW_ROTATION[..], &turned, &[0.0, 1.0]].concat(),
        morph_sets: vec![MorphSetRow {
            target_first: 0,
            target_count: 1,
            ..bytemuck::Zeroable::zeroed()
        }],
        morph_targets: vec![MorphTargetRow {
            default_weight: 0.25,
            ..bytemuck::Zeroable::zeroed()
        }],
        ..Model::default()
    };
    model.meta.bone_names = ["root", "shoulder", "elbow", "hand", "hat"].map(str::to_owned).into();
    model.meta.clip_names = vec!["wave".to_owned()];
    model
}

/// The random poses of a pose space.
pub(super) fn posed(model: &Model, pose_space: PoseSpace, count: usize, seed: u64) -> Vec<SampledPose> {
    let settings = BakeSettings {
        pose_space,
        pose_samples: Some(count),
        seed,
        ..BakeSettings::default()
    };
    let mut model = model.clone();
    let clips: Vec<usize> = (0..model.clips.len()).collect();
    model.samples = sample_rows(&model, &clips, &settings).expect("few samples");
    let clip_poses = evaluate(&model, &model.samples, &NoProgress).expect("finite poses");
    random_poses(&model, &settings, &clip_poses, &NoProgress).expect("finite poses")
}
