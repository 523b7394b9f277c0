//! Pose spaces that keep every rule but barely, and files without them.

use crate::fixture::{Forge, model, read_copy, sample_bounds, sampled_model};
use restpose_formats::{Bounds, Model, write};

fn assert_round_trip(model: &Model) {
    let bytes = write(model).expect("the model is valid");
    assert_eq!(read_copy(&bytes).as_ref(), Ok(model));
    assert!(bytes == Forge::of(model).bytes());
}

#[test]
fn a_model_with_sampled_bounds_round_trips() {
    assert_round_trip(&sampled_model());
}

#[test]
fn a_model_whose_clusters_all_have_tracks_round_trips_with_either_bounds() {
    let mut m = model();
    for triangle in &mut m.triangles[..6] {
        triangle.corners = [triangle.corners[0]; 3];
    }
    m.meta.degenerate_triangle_count = 7;
    sample_bounds(&mut m);
    m.clusters.drain(..3);
    for cluster in &mut m.clusters {
        cluster.node_first -= 5;
        cluster.reference_first -= 6;
        cluster.cluster_bone_first -= 5;
    }
    for segment in &mut m.segments {
        segment.cluster_first -= 3;
    }
    m.kd_nodes.drain(..5);
    m.references.drain(..6);
    m.reference_boxes.drain(..6);
    m.cluster_bones.drain(..5);
    assert_round_trip(&m);
    m.meta.bounds = Bounds::Envelope;
    assert_round_trip(&m);
}

#[test]
fn a_cluster_need_not_have_vertices_that_its_own_bone_moves() {
    let mut m = model();
    m.clusters[0].bone = 1;
    assert!(write(&m).is_err(), "bone 0 needs an envelope");
    m.levers[0].lever = [5.0, 0.0, 5.0];
    m.levers[0].weight = 1.0;
    m.bone_envelopes.insert(0, m.bone_envelopes[0]);
    for space in &mut m.pose_spaces[1..] {
        space.bone_envelope_first += 1;
    }
    assert_round_trip(&m);
}

#[test]
fn numbers_at_their_limits_are_accepted() {
    let mut m = model();
    m.levers[2].lever = [f32::MAX; 3];
    m.levers[2].pivot = [f32::MAX, -f32::MAX, 0.0];
    m.bone_envelopes[0].reach = [0.0; 12];
    m.bone_envelopes[1].center = [f32::MAX; 12];
    m.bone_envelopes[1].direction = [-f32::MAX; 12];
    m.bone_envelopes[1].reach = [f32::MAX; 12];
    (m.morph_envelopes[0].min, m.morph_envelopes[0].max) = (-f32::MAX, f32::MAX);
    (m.morph_envelopes[1].min, m.morph_envelopes[1].max) = (0.5, 0.5);
    assert_round_trip(&m);
}
