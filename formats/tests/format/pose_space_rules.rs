//! The rules of pose spaces, as in `row_rules`.

use crate::{
    broken::{at, rules},
    fixture::sample_bounds,
};
use restpose_formats::{Bounds, FormatError::*, Model, RowFault::*, SectionKind::*, rows::ClusterMorphRow};

rules! {
    with_sampled_bounds_there_are_no_pose_spaces:
        |m| m.meta.bounds = Bounds::Sampled => RowsOfSampledBounds { section: PoseSpaces, found: 3 },
    with_sampled_bounds_there_are_no_levers:
        |m| sample_but(m, |m, old| m.levers = old.levers) => RowsOfSampledBounds { section: Levers, found: 5 },
    with_sampled_bounds_there_are_no_cluster_morphs:
        |m| sample_but(m, |m, old| m.cluster_morphs = old.cluster_morphs)
        => RowsOfSampledBounds { section: ClusterMorphs, found: 3 },
    with_sampled_bounds_there_are_no_bone_envelopes:
        |m| sample_but(m, |m, old| m.bone_envelopes = old.bone_envelopes)
        => RowsOfSampledBounds { section: BoneEnvelopes, found: 3 },
    with_sampled_bounds_there_are_no_morph_envelopes:
        |m| sample_but(m, |m, old| m.morph_envelopes = old.morph_envelopes)
        => RowsOfSampledBounds { section: MorphEnvelopes, found: 5 },

    every_cluster_without_a_track_has_a_pose_space:
        |m| { m.pose_spaces.pop(); } => RowCount { section: PoseSpaces, expected: 3, found: 2 },
    a_cluster_with_a_track_has_no_pose_space:
        |m| m.pose_spaces.push(m.pose_spaces[0]) => RowCount { section: PoseSpaces, expected: 3, found: 4 },
    every_bone_of_a_cluster_without_a_track_has_a_lever:
        |m| { m.levers.pop(); } => RowCount { section: Levers, expected: 5, found: 4 },
    a_track_has_no_lever: |m| m.levers.push(m.levers[0]) => RowCount { section: Levers, expected: 5, found: 6 },

    pose_space_reserved_is_zero:
        |m| m.pose_spaces[1].reserved[1] = 1 => at!(PoseSpaces, 1, ReservedNotZero { field: "reserved" }),
    clips_are_inside_pose_spaces_or_not_known_to_be:
        |m| m.pose_spaces[1].clips_inside = 2
        => at!(PoseSpaces, 1, UnknownNumber { field: "clips_inside", found: 2, limit: 2 }),
    a_pose_space_has_an_envelope:
        |m| m.pose_spaces[1].envelope_count = 0 => at!(PoseSpaces, 1, EmptyRange { field: "envelope_count" }),
    a_pose_space_without_rows_has_one_envelope:
        |m| m.pose_spaces[0].envelope_count = u32::MAX
        => at!(PoseSpaces, 0, Count { field: "envelope_count", found: 4_294_967_295, expected: 1 }),
    cluster_morphs_follow_each_other:
        |m| m.pose_spaces[2].morph_first = 1
        => at!(PoseSpaces, 2, RangeNotContiguous { field: "morph_first", found: 1, expected: 2 }),
    cluster_morphs_are_in_range:
        |m| m.pose_spaces[2].morph_count = u32::MAX
        => at!(PoseSpaces, 2, RangeOutOfBounds { field: "morph_first", first: 2, count: 4_294_967_295, limit: 3 }),
    pose_spaces_cover_all_cluster_morphs:
        |m| m.cluster_morphs.push(m.cluster_morphs[2]) => RowCount { section: ClusterMorphs, expected: 3, found: 4 },
    bone_envelopes_follow_each_other:
        |m| m.pose_spaces[2].bone_envelope_first = 1
        => at!(PoseSpaces, 2, RangeNotContiguous { field: "bone_envelope_first", found: 1, expected: 2 }),
    bone_envelopes_are_as_many_as_bones_and_envelopes:
        |m| m.pose_spaces[1].envelope_count = 1
        => at!(PoseSpaces, 2, RangeNotContiguous { field: "bone_envelope_first", found: 2, expected: 1 }),
    bone_envelopes_are_in_range:
        |m| m.pose_spaces[2].envelope_count = u32::MAX
        => at!(PoseSpaces, 2, RangeOutOfBounds { field: "bone_envelope_first", first: 2, count: 4_294_967_295, limit: 3 }),
    pose_spaces_cover_all_bone_envelopes:
        |m| m.bone_envelopes.push(m.bone_envelopes[2]) => RowCount { section: BoneEnvelopes, expected: 3, found: 4 },
    morph_envelopes_follow_each_other:
        |m| m.pose_spaces[2].morph_envelope_first = 2
        => at!(PoseSpaces, 2, RangeNotContiguous { field: "morph_envelope_first", found: 2, expected: 4 }),
    morph_envelopes_are_in_range:
        |m| { m.morph_envelopes.pop(); }
        => at!(PoseSpaces, 2, RangeOutOfBounds { field: "morph_envelope_first", first: 4, count: 1, limit: 4 }),
    morph_envelopes_are_counted_in_64_bits:
        // 2^31 envelopes of two morphs are 2^32 rows, and none in 32 bits.
        |m| { follow_other_bone(m); m.pose_spaces[1].envelope_count = 1 << 31; }
        => at!(PoseSpaces, 1, RangeOutOfBounds { field: "morph_envelope_first", count: 4_294_967_296, .. }),
    pose_spaces_cover_all_morph_envelopes:
        |m| m.morph_envelopes.push(m.morph_envelopes[0]) => RowCount { section: MorphEnvelopes, expected: 5, found: 6 },

    the_lever_of_a_clusters_own_bone_is_zero:
        |m| m.levers[1].weight = 1.0 => at!(Levers, 1, ReservedNotZero { field: "lever of the cluster's own bone" }),
    the_lever_of_a_clusters_own_bone_is_zero_in_all_bits:
        |m| m.levers[4].pivot[2] = -0.0 => at!(Levers, 4, ReservedNotZero { .. }),
    pivots_are_finite: |m| m.levers[2].pivot[1] = f32::NAN => at!(Levers, 2, NotFinite { field: "pivot", .. }),
    levers_are_finite: |m| m.levers[2].lever[1] = f32::INFINITY => at!(Levers, 2, NotFinite { field: "lever", .. }),
    levers_are_not_negative: |m| m.levers[3].lever[1] = -1.0 => at!(Levers, 3, Negative { field: "lever", .. }),
    lever_weights_are_finite: |m| m.levers[2].weight = f32::NAN => at!(Levers, 2, NotFinite { field: "weight", .. }),
    lever_weights_are_not_negative: |m| m.levers[2].weight = -1.0 => at!(Levers, 2, Negative { field: "weight", .. }),
    lever_weights_are_not_above_one:
        |m| m.levers[2].weight = 1.0f32.next_up() => at!(Levers, 2, AboveOne { field: "weight", .. }),
    lever_reserved_is_zero: |m| m.levers[2].reserved = 1 => at!(Levers, 2, ReservedNotZero { field: "reserved" }),
    levers_reach_every_vertex_on_x:
        |m| m.levers[2].lever[0] = 0.25f32.next_down()
        => at!(Levers, 2, TooSmall { field: "lever[0]", least: 0.25, vertex: 5, .. }),
    levers_reach_every_vertex_on_y:
        |m| m.levers[2].lever[1] = 1.0f32.next_down()
        => at!(Levers, 2, TooSmall { field: "lever[1]", least: 1.0, vertex: 7, .. }),
    levers_reach_every_vertex_on_z:
        |m| m.levers[2].lever[2] = 0.5f32.next_down()
        => at!(Levers, 2, TooSmall { field: "lever[2]", least: 0.5, vertex: 7, .. }),
    levers_are_about_their_pivots:
        |m| m.levers[2].pivot[1] = 3.0 => at!(Levers, 2, TooSmall { field: "lever[1]", vertex: 6, .. }),
    levers_reach_vertices_of_the_least_weight:
        |m| m.levers[3].lever[0] = 0.0 => at!(Levers, 3, TooSmall { field: "lever[0]", vertex: 6, .. }),
    lever_weights_reach_every_vertex:
        |m| m.levers[2].weight = 1.0f32.next_down()
        => at!(Levers, 2, TooSmall { field: "weight", least: 1.0, vertex: 7, .. }),

    cluster_morph_targets_are_in_range:
        |m| m.cluster_morphs[1].target = 2
        => at!(ClusterMorphs, 1, IndexOutOfRange { field: "target", found: 2, limit: 2 }),
    cluster_morph_targets_ascend:
        |m| m.cluster_morphs.swap(0, 1)
        => at!(ClusterMorphs, 1, NotAscending { field: "target", found: 0, previous: 1 }),
    cluster_morph_targets_are_distinct:
        |m| m.cluster_morphs[1].target = 0
        => at!(ClusterMorphs, 1, NotAscending { field: "target", found: 0, previous: 0 }),
    cluster_morph_extents_are_finite:
        |m| m.cluster_morphs[0].extent[0] = f32::NAN => at!(ClusterMorphs, 0, NotFinite { field: "extent", .. }),
    cluster_morph_extents_are_not_negative:
        |m| m.cluster_morphs[0].extent[0] = -1.0 => at!(ClusterMorphs, 0, Negative { field: "extent", .. }),
    cluster_morph_extents_reach_every_delta:
        |m| m.cluster_morphs[0].extent[1] = 0.1f32.next_down()
        => at!(ClusterMorphs, 0, TooSmall { field: "extent[1]", vertex: 5, .. }),
    cluster_morph_extents_hold_for_negative_deltas:
        |m| m.cluster_morphs[1].extent[2] = 0.2f32.next_down()
        => at!(ClusterMorphs, 1, TooSmall { field: "extent[2]", vertex: 5, .. }),
    cluster_morph_extents_are_their_clusters_own:
        |m| m.cluster_morphs[2].extent[0] = 0.0 => at!(ClusterMorphs, 2, TooSmall { field: "extent[0]", vertex: 7, .. }),
    every_morph_target_of_a_clusters_vertices_is_listed:
        |m| list_morphs(m, 1, &[(1, [1.0; 3])]) => at!(Clusters, 1, ClusterMorphMissing { target: 0, vertex: 5 }),
    a_morph_target_listed_for_one_cluster_does_not_count_for_the_next:
        |m| list_morphs(m, 2, &[]) => at!(Clusters, 2, ClusterMorphMissing { target: 1, vertex: 7 }),
    only_morph_targets_of_a_clusters_vertices_are_listed:
        |m| list_morphs(m, 2, &[(0, [1.0; 3]), (1, [1.0; 3])]) => at!(ClusterMorphs, 2, ClusterMorphUnused { target: 0 }),

    envelope_centers_are_finite:
        |m| m.bone_envelopes[1].center[11] = f32::NAN => at!(BoneEnvelopes, 1, NotFinite { field: "center", .. }),
    envelope_directions_are_finite:
        |m| m.bone_envelopes[1].direction[0] = f32::INFINITY
        => at!(BoneEnvelopes, 1, NotFinite { field: "direction", .. }),
    envelope_reaches_are_finite:
        |m| m.bone_envelopes[2].reach[5] = f32::INFINITY => at!(BoneEnvelopes, 2, NotFinite { field: "reach", .. }),
    envelope_reaches_are_not_negative:
        |m| m.bone_envelopes[2].reach[5] = -1.0 => at!(BoneEnvelopes, 2, Negative { field: "reach", .. }),
    least_morph_weights_are_finite:
        |m| m.morph_envelopes[3].min = f32::NEG_INFINITY => at!(MorphEnvelopes, 3, NotFinite { field: "min", .. }),
    greatest_morph_weights_are_finite:
        |m| m.morph_envelopes[3].max = f32::NAN => at!(MorphEnvelopes, 3, NotFinite { field: "max", .. }),
    intervals_of_morph_weights_are_not_empty:
        |m| m.morph_envelopes[3].max = -0.5 => at!(MorphEnvelopes, 3, EmptyInterval { min: 0.0, max: -0.5 }),
}

/// Makes the bounds sampled and removes the pose spaces, but for what `keep` brings back from before.
fn sample_but(model: &mut Model, keep: impl FnOnce(&mut Model, Model)) {
    let old = model.clone();
    sample_bounds(model);
    keep(model, old);
}

/// Makes cluster 1 follow what was its other bone, and list no bone but that: it has no bone envelopes then.
fn follow_other_bone(model: &mut Model) {
    model.clusters[1].bone = 2;
    model.clusters[1].cluster_bone_count = 1;
    for cluster in &mut model.clusters[2..] {
        cluster.cluster_bone_first -= 1;
    }
    model.cluster_bones.remove(1);
    model.levers.remove(2);
    model.bone_envelopes.drain(..2);
    model.pose_spaces[2].bone_envelope_first = 0;
}

/// Replaces the morphs of a cluster, whose envelopes all get the weights of row 0.
fn list_morphs(model: &mut Model, cluster: usize, morphs: &[(u32, [f32; 3])]) {
    let space = model.pose_spaces[cluster];
    let rows = |first: u32, count: u32| first as usize..(first + count) as usize;
    let morph_rows = morphs
        .iter()
        .map(|&(target, extent)| ClusterMorphRow { target, extent });
    model
        .cluster_morphs
        .splice(rows(space.morph_first, space.morph_count), morph_rows);
    let weights = vec![model.morph_envelopes[0]; morphs.len() * space.envelope_count as usize];
    let old = rows(space.morph_envelope_first, space.morph_count * space.envelope_count);
    model.morph_envelopes.splice(old, weights);
    model.pose_spaces[cluster].morph_count = morphs.len() as u32;
    let mut ends = [0, 0];
    for space in &mut model.pose_spaces {
        [space.morph_first, space.morph_envelope_first] = ends;
        ends[0] += space.morph_count;
        ends[1] += space.morph_count * space.envelope_count;
    }
}
