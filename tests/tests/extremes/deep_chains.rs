//! Long chains of joints, such as tails and ropes: boxes near the last joint are as tight as those near the first.

use restpose_bake::{
    BakeSettings, NoProgress, bake,
    verify::{PoseSource, VerifySettings, verify},
};
use restpose_formats::geom::Aabb;
use restpose_samples::solids::lathe;
use restpose_tests::{MeshRecipe, baked_with, jointed_mesh};

fn longest_side(bounds: &Aabb) -> f32 {
    (0..3).fold(0.0, |longest, k| longest.max(bounds.max[k] - bounds.min[k]))
}

#[test]
fn boxes_do_not_grow_along_a_chain_of_joints() {
    let profile: Vec<(f64, f64)> = (0..=100).map(|ring| (0.02, f64::from(ring) / 100.0 - 0.5)).collect();
    let animation = jointed_mesh(&MeshRecipe::new(&lathe(&profile, 6), 50));
    let model = bake(&animation, &BakeSettings::default(), &NoProgress).unwrap().model;
    assert!(model.clusters.len() > 40, "{} clusters", model.clusters.len());
    for cluster in &model.clusters {
        let first = cluster.cluster_bone_first as usize;
        let bones = &model.cluster_bones[first..first + cluster.cluster_bone_count as usize];
        let rest = bones.iter().fold(Aabb::EMPTY, |rest, row| rest.union(row.bounds));
        let (fuzzy, rest) = (longest_side(&cluster.bounds_local), longest_side(&rest));
        // Joints turn by up to 80 degrees in a second.
        assert!(
            fuzzy < 1.5 * rest,
            "the cluster of bone {} is {rest} long in rest and {fuzzy} in its poses",
            cluster.bone
        );
    }
    let settings = VerifySettings {
        rays: 4_000,
        poses: 40,
        pose_source: Some(PoseSource::Clips),
        seed: 8,
    };
    let report = verify(
        &baked_with(&animation, &BakeSettings::default()),
        &animation,
        &settings,
        &NoProgress,
    )
    .unwrap();
    assert_eq!((report.missed, report.wrong), (0, 0), "{:#?}", report.failures);
}
