//! The first proof obligation: in every pose every vertex is in its box, widened by the pose's excess alone, and not at all
//! where the box follows the pose. Exact arithmetic, zero tolerance.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use restpose_bake::{
    BakeSettings, LimitSettings, PoseSpace,
    import::{Animation, import},
    verify::{DrawnPose, PoseSource, Poses},
};
use restpose_formats::{Bounds, ModelView, rows::ClusterRow};
use restpose_runtime::{Affine, Asset, Scene};
use restpose_tests::{
    Recipe, baked_with,
    escapes::{Escape, escapes},
    followed_nodes::contradictions,
    following_twin, random_animation, sample_scenes,
};
use std::sync::Arc;

fn baked(animation: &Animation, pose_space: PoseSpace, envelopes: usize) -> Arc<Asset> {
    let settings = BakeSettings {
        bounds: Bounds::Envelope,
        pose_samples: pose_space.is_random().then_some(40),
        pose_space,
        envelopes,
        sample_step_seconds: 0.125,
        ..BakeSettings::default()
    };
    baked_with(animation, &settings)
}

/// What was compared, so that a test that compares nothing fails.
#[derive(Clone, Copy, Debug, Default)]
struct Compared {
    clusters: usize,
    outside: usize,
    /// Nodes of which boxes follow the pose.
    following: usize,
}

impl Compared {
    fn add(&mut self, other: Self) {
        self.clusters += other.clusters;
        self.outside += other.outside;
        self.following += other.following;
    }
}

/// Panics at the first pose with an escape.
fn compare(name: &str, animation: &Animation, asset: &Arc<Asset>, source: PoseSource, count: u64) -> Compared {
    let model = asset.model();
    let following = model.wide_nodes.iter().filter(|node| node.mover_count != 0).count();
    let found = contradictions(model);
    assert_eq!(found.first(), None, "{name}: {} contradictions", found.len());
    let mut poses = Poses::new(animation, model, source, 4, count);
    let drawn: Vec<_> = (0..count).map(|index| poses.pose(index)).collect();
    let of_pose = |pose: &DrawnPose| {
        let mut scene = Scene::new();
        let instance = scene.add(asset);
        pose.set(&mut scene, instance).unwrap();
        let palette = scene.pose(instance).unwrap().palette;
        let morph_weights = scene.pose(instance).unwrap().morph_weights;
        let frame = scene.commit();
        let rows = frame.clusters().filter(|cluster| cluster.has_inverse);
        let excess: Vec<(u32, [f64; 3])> = rows
            .filter(|cluster| (cluster.cluster as usize) < model.pose_spaces.len())
            .map(|cluster| (cluster.cluster, cluster.excess))
            .collect();
        let found: Vec<Escape> = escapes(model, &palette, &morph_weights, excess.iter().copied());
        let first = found.first();
        assert_eq!(
            first,
            None,
            "{name}, pose {} ({:?}): {} escapes, excess {excess:?}",
            pose.index,
            pose.family,
            found.len()
        );
        if source == PoseSource::Clips {
            assert_eq!(frame.stats().clusters_outside, 0, "{name}, {:?}", pose.bones);
            for (row, excess) in &excess {
                let limit = rounding_limit(model, &model.clusters[*row as usize], &palette, &morph_weights);
                let largest = excess.iter().copied().fold(0.0, f64::max);
                assert!(
                    largest <= limit,
                    "{name}, {:?}: cluster {row} is widened by {largest:e}, more than {limit:e}",
                    pose.bones
                );
            }
        }
        Compared {
            clusters: excess.len(),
            outside: frame.stats().clusters_outside as usize,
            following: 0,
        }
    };
    let found: Vec<Compared> = drawn.par_iter().map(of_pose).collect();
    let mut total = Compared {
        following,
        ..Compared::default()
    };
    found.into_iter().for_each(|found| total.add(found));
    total
}

/// What rounding may add to the boxes in a pose of the pose space.
///
/// The inverse L of the cluster frame X is found in `f64` by cofactors, so `L·X − 1` is under a hundred roundings of 2⁻⁵³
/// times the condition of X; every number of a relative motion `X⁻¹·Xᵢ` is off by at most that and a few more, relative to
/// `‖X⁻¹‖·(‖Xᵢ‖ + |tᵢ − t|)`, and moves a vertex by itself times at most the size of the cluster in rest space. 2⁻⁴² leaves
/// room for both and the sums: it is a few hundred-thousandths of what one rounding to `f32` does.
fn rounding_limit(model: &ModelView, cluster: &ClusterRow, palette: &[Affine], morph_weights: &[f32]) -> f64 {
    let linear = |map: &Affine| Matrix3::from_fn(|row, column| f64::from(map.columns[column][row]));
    let translation = |map: &Affine| Vector3::from_fn(|row, _| f64::from(map.columns[3][row]));
    let own = &palette[cluster.bone as usize];
    let singular = linear(own).singular_values();
    let (inverse, condition) = (1.0 / singular.min(), singular.max() / singular.min());
    let morphed: f64 = model
        .morph_targets
        .iter()
        .zip(morph_weights)
        .map(|(target, weight)| f64::from(weight.abs()) * target.extent.iter().map(|x| f64::from(*x)).sum::<f64>())
        .sum();
    let rows = cluster.cluster_bone_first as usize..(cluster.cluster_bone_first + cluster.cluster_bone_count) as usize;
    let mut sum = 0.0;
    for (bone, lever) in model.cluster_bones[rows.clone()].iter().zip(&model.levers[rows]) {
        let length = |x: [f32; 3]| x.iter().map(|x| f64::from(x.abs())).sum::<f64>();
        let map = &palette[bone.bone as usize];
        let reach = length(bone.extent()) + 2.0 * length(lever.pivot) + morphed;
        let offset = translation(map).norm() + translation(own).norm();
        sum += (inverse * linear(map).norm() + 1.0) * reach + inverse * offset;
    }
    condition * sum * 2f64.powi(-42)
}

/// The bundled samples, in their clips and far outside of them.
#[test]
fn vertices_of_samples_stay_in_their_boxes() {
    let mut total = Compared::default();
    for path in sample_scenes() {
        let animation = import(&path).unwrap().animation;
        for envelopes in [1, 16] {
            let asset = baked(&animation, PoseSpace::Clips, envelopes);
            let name = format!("{} in {envelopes} envelopes", path.display());
            compare(&name, &animation, &asset, PoseSource::Clips, 6);
            total.add(compare(&name, &animation, &asset, PoseSource::Random, 11));
        }
    }
    assert!(
        total.outside > 100 && total.outside < total.clusters && total.following > 0,
        "{total:?}"
    );
}

fn recipe(seed: u64) -> Recipe {
    let mut random = fastrand::Rng::with_seed(seed);
    let offset = [0.0, 0.0, 10.0, 1e4, 1e7][random.usize(..5)];
    let wild_scales = random.bool();
    // With wild scales the hierarchy multiplies lengths by up to 40 per joint.
    let exponent = random.i32(if wild_scales { -10..=10 } else { -20..=20 });
    Recipe {
        seed,
        vertices: random.usize(3..24),
        joints: random.usize(2..7),
        scale: 10f32.powi(exponent),
        offset,
        wild_scales,
        morph_targets: random.usize(..3),
    }
}

/// Soups of every kind, in poses of the pose space.
#[test]
fn vertices_of_random_animations_stay_in_their_boxes_in_clips() {
    let mut total = Compared::default();
    for seed in 0..80 {
        let recipe = recipe(seed);
        let animation = random_animation(&recipe);
        let asset = baked(&animation, PoseSpace::Clips, [1, 2, 16][seed as usize % 3]);
        total.add(compare(
            &format!("{recipe:?}"),
            &animation,
            &asset,
            PoseSource::Clips,
            30,
        ));
    }
    assert!(total.clusters > 3_000 && total.following > 0, "{total:?}");
}

/// The same in poses of all families, far outside; then with all nodes following the pose that can.
#[test]
fn vertices_of_random_animations_stay_in_widened_boxes_anywhere() {
    let [mut total, mut following] = [Compared::default(); 2];
    for seed in 100..180 {
        let recipe = recipe(seed);
        let animation = random_animation(&recipe);
        let pose_space = [
            PoseSpace::Clips,
            PoseSpace::Arbitrary,
            PoseSpace::Limits(LimitSettings::default()),
            PoseSpace::Clip("clip".to_owned()),
        ][seed as usize % 4]
            .clone();
        let asset = baked(&animation, pose_space, [1, 2, 16][seed as usize % 3]);
        let name = format!("{recipe:?}");
        total.add(compare(&name, &animation, &asset, PoseSource::Random, 44));
        let twin = following_twin(&asset);
        following.add(compare(&name, &animation, &twin, PoseSource::Random, 44));
    }
    assert!(
        total.outside > 3_000 && total.outside < total.clusters && total.following > 0,
        "{total:?}"
    );
    assert!(following.following > total.following, "{following:?}");
}
