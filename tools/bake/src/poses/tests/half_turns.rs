use crate::poses::{Span, WorldSpan};
use restpose_formats::{
    Model,
    geom::Affine,
    rows::{BoneRow, ChannelRow, ClipRow, Interpolation, Local, NONE, NodeRow, Path},
};
use restpose_runtime::{Pose, PoseEvaluator};

/// A node that turns from one key to the other in a second.
fn turning(keys: [[f32; 4]; 2]) -> Model {
    let still = Local::Trs {
        translation: [0.0; 3],
        rotation: [0.0, 0.0, 0.0, 1.0],
        scale: [1.0; 3],
    };
    Model {
        nodes: vec![NodeRow::new(NONE, 0, still)],
        bones: vec![BoneRow {
            node: 0,
            source_skin: NONE,
            source_joint: NONE,
            reserved: 0,
            inverse_bind: bytemuck::cast(Affine::IDENTITY.columns),
        }],
        clips: vec![ClipRow {
            start_seconds: 0.0,
            end_seconds: 1.0,
            channel_first: 0,
            channel_count: 1,
        }],
        channels: vec![ChannelRow {
            target: 0,
            path: Path::Rotation as u32,
            interpolation: Interpolation::Linear as u32,
            width: 4,
            time_first: 0,
            key_count: 2,
            value_first: 0,
            reserved: 0,
        }],
        key_times: vec![0.0, 1.0],
        key_values: keys.concat(),
        ..Model::default()
    }
}

/// Keys at right angles, so that either arc is as short. Which one it is must not depend on how lengths are rounded.
#[test]
fn half_turns_are_bounded_the_way_that_they_are_evaluated() {
    let mut random = fastrand::Rng::with_seed(7);
    let mut evaluator = PoseEvaluator::default();
    let mut pose = Pose::default();
    for _ in 0..2000 {
        // Whole numbers, of which the product is exactly zero.
        let mut whole = || random.i32(-9..=9) as f32;
        let ([x, y, z, w], p, q) = ([whole(), whole(), whole(), whole()], whole(), whole());
        let model = turning([[x, y, z, w], [-y * p, x * p, -w * q, z * q]]);
        evaluator.evaluate(&model.view(), Some(0), 0.5, &mut pose);
        let span = WorldSpan::all(&model, &Span::of_clip(&model, 0, 0.5, 0.5))[0];
        for (k, found) in pose.palette[0].columns.as_flattened()[..9].iter().enumerate() {
            let expected = span.begin[k];
            // What the evaluator rounds to f32 is at most one.
            assert!(
                (f64::from(*found) - expected).abs() < 1e-7,
                "{:?}: {found} is not {expected}",
                model.key_values
            );
        }
    }
}
