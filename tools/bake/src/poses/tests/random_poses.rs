use super::arm::{ELBOW, HAND, HAND_MATRIX, HAT, SHOULDER, arm, posed};
use crate::{
    BakeError, BakeSettings, JointLimits, JointLimitsError, LimitSettings, NoProgress, PoseSpace,
    poses::{
        SampledPose, random_poses,
        rotation::{between, vector_of},
    },
};
use restpose_formats::{Model, geom::Affine, rows::Local};

fn limits(text: &str, slack_deg: f64) -> PoseSpace {
    PoseSpace::Limits(LimitSettings {
        joints: JointLimits::parse("limits.toml", text).expect("sound limits"),
        slack_deg,
    })
}

fn linear(x: &Affine) -> glam::DMat3 {
    let [x, y, z, _] = x.columns.map(|column| glam::DVec3::from_array(column.map(f64::from)));
    glam::DMat3::from_cols(x, y, z)
}

/// Least and greatest component of the rotation vector that turns a bone from where it is without any clip, degrees.
fn found_ranges(model: &Model, poses: &[SampledPose], bone: usize) -> [[f64; 2]; 3] {
    let Local::Trs { rotation, .. } = model.nodes[bone - 1].local() else {
        panic!("bone {bone} has a matrix")
    };
    let mut ranges = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for pose in poses {
        let now = glam::DQuat::from_mat3(&linear(&pose.palette[bone]))
            .normalize()
            .to_array();
        let vector = vector_of(between(rotation.map(f64::from), now));
        for (range, x) in ranges.iter_mut().zip(vector.map(f64::to_degrees)) {
            *range = [range[0].min(x), range[1].max(x)];
        }
    }
    ranges
}

/// Fails unless the ranges of 500 poses are within `limits` and nearly fill them.
#[track_caller]
fn assert_fill(found: [[f64; 2]; 3], limits: [[f64; 2]; 3]) {
    for (axis, ([least, greatest], [from, to])) in found.into_iter().zip(limits).enumerate() {
        // Palettes are rounded to f32: 2⁻²⁴ of a radian, a few times.
        let rounding = 1e-4;
        assert!(
            from - rounding <= least && greatest <= to + rounding,
            "axis {axis}: {least} to {greatest}"
        );
        // That 500 uniform numbers leave out a twentieth at one end happens once in 10¹¹ times.
        let gap = 0.05 * (to - from) + rounding;
        assert!(
            least <= from + gap && to - gap <= greatest,
            "axis {axis}: {least} to {greatest}"
        );
    }
}

#[test]
fn joints_turn_within_the_limits_of_the_file_and_fill_them() {
    let model = arm();
    let file = "[joints.shoulder]\nx = [-5, 140]\nz = [10, 20]\n[joints.elbow]\n";
    let poses = posed(&model, limits(file, 10.0), 500, 1);
    assert_eq!(poses.len(), 500);
    assert_fill(
        found_ranges(&model, &poses, SHOULDER),
        [[-5.0, 140.0], [0.0, 0.0], [10.0, 20.0]],
    );
    assert_fill(found_ranges(&model, &poses, ELBOW), [[0.0, 0.0]; 3]);
}

#[test]
fn other_joints_turn_as_in_the_clips_and_the_slack() {
    let model = arm();
    let poses = posed(&model, limits("[joints.shoulder]\n", 5.0), 500, 1);
    assert_fill(
        found_ranges(&model, &poses, ELBOW),
        [[-5.0, 5.0], [-5.0, 65.0], [-5.0, 5.0]],
    );
    let none = posed(
        &model,
        PoseSpace::Limits(LimitSettings {
            slack_deg: 180.0,
            ..Default::default()
        }),
        500,
        1,
    );
    let turned = found_ranges(&model, &none, SHOULDER);
    assert!(
        turned
            .iter()
            .all(|[least, greatest]| *least < -120.0 && *greatest > 120.0),
        "{turned:?}"
    );
}

#[test]
fn joints_of_one_name_share_limits() {
    let mut model = arm();
    model.meta.bone_names[SHOULDER] = "elbow".to_owned();
    let poses = posed(&model, limits("[joints.elbow]\ny = [30, 40]\n", 0.0), 500, 1);
    for bone in [SHOULDER, ELBOW] {
        assert_fill(
            found_ranges(&model, &poses, bone),
            [[0.0, 0.0], [30.0, 40.0], [0.0, 0.0]],
        );
    }
}

#[test]
fn names_that_no_joint_has_are_refused() {
    let model = arm();
    let settings = BakeSettings {
        pose_space: limits("[joints.elbow]\n[joints.hat]\n[joints.tail]\n", 0.0),
        ..BakeSettings::default()
    };
    let error = random_poses(&model, &settings, &[], &NoProgress)
        .err()
        .expect("a fault");
    let BakeError::JointLimits(JointLimitsError::Unknown { file, unknown, known }) = error else {
        panic!("{error}")
    };
    assert_eq!(
        (file.as_str(), unknown),
        ("limits.toml", vec!["hat".to_owned(), "tail".to_owned()])
    );
    assert_eq!(known, ["elbow", "hand", "shoulder"]);
}

#[test]
fn arbitrary_poses_turn_every_joint_and_nothing_else() {
    let model = arm();
    let poses = posed(&model, PoseSpace::Arbitrary, 500, 1);
    let hand = glam::DMat3::from_cols_array_2d(&HAND_MATRIX.map(|column| column.map(f64::from)));
    let mut traces = [0.0; 4];
    for pose in &poses {
        for bone in [SHOULDER, ELBOW, HAND, HAT] {
            let own = if bone == HAND {
                hand.inverse()
            } else {
                glam::DMat3::IDENTITY
            };
            let turned = own * linear(&pose.palette[bone]);
            let excess = turned.transpose() * turned - glam::DMat3::IDENTITY;
            // f32 roundings of entries up to 3, through an inverse with entries up to 1.
            assert!(
                excess.to_cols_array().iter().all(|x| x.abs() < 1e-5),
                "bone {bone}: {turned}"
            );
            traces[bone - 1] += turned.x_axis.x + turned.y_axis.y + turned.z_axis.z;
        }
        assert_eq!(
            pose.palette[HAT].columns,
            Affine::from_translation([1.0, 2.0, 3.0]).columns
        );
        assert_eq!(pose.palette[ELBOW].columns[3], [1.0, 2.0, 3.0]);
        assert_eq!(pose.palette[HAND].columns[3], [4.0, 5.0, 6.0]);
    }
    // The trace of a uniform rotation has mean 0 and variance 1, also after a fixed rotation: five standard deviations.
    for trace in &traces[..3] {
        assert!((trace / 500.0).abs() < 5.0 / 500f64.sqrt(), "{traces:?}");
    }
}

#[test]
fn morph_weights_fill_what_the_clips_reach() {
    let model = arm();
    let weights: Vec<f32> = posed(&model, PoseSpace::Arbitrary, 500, 1)
        .iter()
        .map(|pose| pose.morph_weights[0])
        .collect();
    assert!(weights.iter().all(|weight| (0.0..=1.0).contains(weight)));
    // As of joint ranges: half the weights are at either side of the middle.
    assert!(weights.iter().any(|weight| *weight < 0.05) && weights.iter().any(|weight| *weight > 0.95));
}

#[test]
fn the_poses_depend_on_seed_and_number_alone() {
    let model = arm();
    let poses = |threads: usize, count: usize, seed: u64| -> Vec<(Vec<Affine>, Vec<f32>)> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        let poses = pool.install(|| posed(&model, limits("[joints.shoulder]\nx = [-10, 10]\n", 10.0), count, seed));
        poses
            .into_iter()
            .map(|pose| (pose.palette, pose.morph_weights))
            .collect()
    };
    let one = poses(1, 100, 1);
    assert_eq!(one, poses(2, 100, 1));
    assert_eq!(one[..60], poses(2, 60, 1));
    let other = poses(2, 100, 2);
    assert!(one.iter().zip(&other).all(|(a, b)| a != b));
    assert!(one.windows(2).all(|pair| pair[0] != pair[1]));
}

#[test]
fn other_pose_spaces_have_no_random_poses() {
    let mut model = arm();
    for space in [PoseSpace::Clips, PoseSpace::Clip("wave".to_owned())] {
        assert!(posed(&model, space, 100, 1).is_empty());
    }
    model.bones.truncate(1);
    model.channels.truncate(1);
    model.clips[0].channel_count = 1;
    assert!(posed(&model, PoseSpace::Arbitrary, 100, 1).is_empty());
}

#[test]
fn a_pose_that_leaves_the_range_of_f32_is_told() {
    let mut model = arm();
    let far = |x| Local::Trs {
        translation: [x, 0.0, 0.0],
        rotation: [0.0, 0.0, 0.0, 1.0],
        scale: [1.0; 3],
    };
    model.nodes[0] = restpose_formats::rows::NodeRow::new(restpose_formats::rows::NONE, 0, far(3e38));
    // Back where it started without any clip; twice as far out where the shoulder turns round.
    model.nodes[1] = restpose_formats::rows::NodeRow::new(0, 1, far(-3e38));
    let settings = BakeSettings {
        pose_space: PoseSpace::Arbitrary,
        ..BakeSettings::default()
    };
    let error = random_poses(&model, &settings, &[], &NoProgress)
        .err()
        .expect("a fault");
    assert!(
        error
            .to_string()
            .starts_with("bone \"elbow\" leaves the range of f32 in random pose "),
        "{error}"
    );
}
