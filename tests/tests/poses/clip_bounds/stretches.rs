//! What a clip's boxes gain by being one per stretch, and what happens at the borders.

use super::{assert_contains, moved_tube, sampled};
use fastrand::Rng;
use restpose_bake::import::{Channel, ChannelTarget};
use restpose_formats::rows::{ClipBoundsRow, Interpolation, STRETCHES};
use restpose_runtime::{Aabb, Pose, PoseError, PoseEvaluator, Scene};
use restpose_samples::solids::lathe;
use restpose_tests::{MeshRecipe, baked_asset, baked_with, jointed_mesh, source_scenes};

/// Jumps at the numbers at and beside every border, where rounding decides which stretch a time is in; each to another place.
#[test]
fn steps_at_borders_stay_in_the_boxes() {
    let mut random = Rng::with_seed(5);
    for (start, length) in [
        (0.0, 1.0),
        (0.1, 0.7),
        (-7.3, 19.0),
        (100.0, 1.3),
        (-3e-3, 1e-2),
        (1e6, 40.0),
    ] {
        let asset = moved_tube(|animation| {
            let mut times = Vec::new();
            for border in 0..=STRETCHES {
                let border: f32 = start + length * border as f32 / STRETCHES as f32;
                let mut time = border.next_down().next_down();
                for _ in 0..5 {
                    times.push(time);
                    time = time.next_up();
                }
            }
            let values = times.iter().flat_map(|_| [0, 1, 2].map(|_| random.f32() * 1e3));
            animation.clips[0].channels = vec![Channel {
                node: animation.skins[0].joints[0],
                target: ChannelTarget::Translation,
                interpolation: Interpolation::Step,
                values: values.collect(),
                times,
            }];
        });
        let name = format!("steps from {start} s on for {length} s");
        assert_eq!(assert_contains(&name, &asset, 100, 9), 0);
    }
}

/// A clip of fewer numbers than stretches: some have no time, and every time has one.
#[test]
fn clips_of_few_times_stay_in_the_boxes() {
    let asset = moved_tube(|animation| {
        for channel in &mut animation.clips[0].channels {
            let mut time = 1e6f32;
            for own in &mut channel.times {
                *own = time;
                time = (0..5).fold(time, |time, _| time.next_up());
            }
        }
    });
    let row = &asset.model().clips[0];
    assert!(
        (row.end_seconds - row.start_seconds) / (row.start_seconds.next_up() - row.start_seconds) < STRETCHES as f32
    );
    assert_eq!(assert_contains("few times", &asset, 10, 9), 0);
}

/// A clip of one key lasts no time and has one pose.
#[test]
fn clips_without_length_stay_in_the_boxes() {
    let asset = moved_tube(|animation| {
        for channel in &mut animation.clips[0].channels {
            channel.times.truncate(1);
            let width = channel.values.len() / 3;
            channel.values.truncate(width);
        }
    });
    assert_eq!(assert_contains("one key", &asset, 10, 9), 0);
}

/// No scene takes such a time. Who evaluates a clip at it gets the pose without any clip, and so the row says.
#[test]
fn what_is_no_time_is_bounded_as_the_pose_that_it_gives() {
    let asset = moved_tube(|_| {});
    let model = asset.model();
    let mut scene = Scene::new();
    let instance = scene.add(&asset);
    let refused = scene.play(instance, 0, f32::NAN);
    assert!(matches!(refused, Err(PoseError::TimeNotFinite { .. })), "{refused:?}");
    let (mut evaluator, mut pose, mut without) = (PoseEvaluator::default(), Pose::default(), Pose::default());
    evaluator.evaluate(model, Some(0), f32::NAN, &mut pose);
    evaluator.evaluate(model, None, 0.0, &mut without);
    assert_eq!(pose, without);
    assert_eq!(
        ClipBoundsRow::row_at(model.clips, Some(0), f32::NAN),
        model.clip_bounds.len() - 1
    );
}

/// A bar without width that turns half a turn about its end sweeps a half-disc, whose box has an area of 4 lengths squared;
/// at rest at some angle it fills one of 2·|sin·cos|, on average 2/π: 0.16 of that. This one is a 25th of its length wide and
/// turns by 5.6 degrees per stretch, a tenth of its length at the end, which adds half as much again at most.
#[test]
fn stretches_of_a_swing_are_a_fraction_of_it() {
    let profile: Vec<(f64, f64)> = (0..=20).map(|ring| (0.02, f64::from(ring) / 20.0 - 0.5)).collect();
    let mut animation = jointed_mesh(&MeshRecipe::new(&lathe(&profile, 6), 1));
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turned = [[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, half, half], [0.0, 0.0, 1.0, 0.0]];
    animation.clips[0].channels[0].values = turned.concat();
    let asset = baked_with(&animation, &sampled(1.0));
    let model = asset.model();
    assert_eq!(assert_contains("swing", &asset, 200, 10), 0);
    let whole = ClipBoundsRow::around_clip(model.clip_bounds, 0).unwrap();
    let mut scene = Scene::new();
    let instance = scene.add(&asset);
    let steps = 1_000;
    let areas = (0..=steps).map(|step| {
        scene.play(instance, 0, step as f32 / steps as f32).unwrap();
        scene.commit().instance_bounds(instance).unwrap().surface_area()
    });
    let ratio = areas.sum::<f64>() / f64::from(steps + 1) / whole.surface_area();
    assert!(ratio < 0.24, "{ratio}");
}

/// Beside what a frame would know from its palettes, the boxes of bones as they are, a stretch's box has little to spare.
#[test]
fn boxes_are_little_larger_than_those_of_their_poses() {
    const STEPS: usize = 16;
    for path in source_scenes() {
        let (_, asset) = baked_asset(&path);
        let model = asset.model();
        if model.clip_bounds.is_empty() {
            continue;
        }
        let mut scene = Scene::new();
        let instance = scene.add(&asset);
        let (mut evaluator, mut pose) = (PoseEvaluator::default(), Pose::default());
        for (clip, row) in model.clips.iter().enumerate() {
            let boxes: Vec<Aabb> = (0..=STRETCHES * STEPS)
                .map(|step| {
                    let part = step as f32 / (STRETCHES * STEPS) as f32;
                    let seconds = row.start_seconds + (row.end_seconds - row.start_seconds) * part;
                    evaluator.evaluate(model, Some(clip), seconds, &mut pose);
                    scene.set_palette(instance, &pose.palette, &pose.morph_weights).unwrap();
                    scene.commit().instance_bounds(instance).unwrap()
                })
                .collect();
            for stretch in 0..STRETCHES {
                // Both borders, on either side of which it is nearly the same.
                let own = &boxes[stretch * STEPS..=(stretch + 1) * STEPS];
                let posed = own.iter().fold(Aabb::EMPTY, |all, own| all.union(*own));
                let bounds = model.clip_bounds[clip * STRETCHES + stretch].bounds;
                let ratio = bounds.surface_area() / posed.surface_area();
                // A side is longer by at most its 128th part, and by what the clip does between those times.
                assert!(
                    ratio <= 1.03,
                    "{}, clip {clip}, stretch {stretch}: {ratio}",
                    path.display()
                );
            }
        }
    }
}
