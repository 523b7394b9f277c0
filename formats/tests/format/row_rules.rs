//! For each rule that rows keep, a model that breaks it: the writer refuses it by name, and so does the reader when
//! the same model is forged into a file with valid checksums.

use crate::{
    broken::{at, rules},
    fixture::{model, sample_bounds},
};
use restpose_formats::{
    FormatError::*,
    Model,
    RowFault::*,
    SectionKind::*,
    TreeKind,
    geom::Aabb,
    rows::{
        BoneRow, ChannelRow, ClipRow, InfluenceRow, KdNode, KdNodeRow, KeyBoxRow, Local, MorphSetRow, NONE,
        NodeMoverRow, NodeRow, ReferenceBoxRow, SampleRow, TriangleRow, VertexRow, WideNodeRow,
    },
    write,
};

rules! {
    part_names_have_one_entry_per_part:
        |m| { m.meta.part_names.pop(); }
        => MetaListLength { list: "part_names", section: Parts, expected: 4, found: 3 },
    bone_names_have_one_entry_per_bone:
        |m| m.meta.bone_names.push("x".into())
        => MetaListLength { list: "bone_names", section: Bones, expected: 3, found: 4 },
    clip_names_have_one_entry_per_clip:
        |m| m.meta.clip_names.clear()
        => MetaListLength { list: "clip_names", section: Clips, expected: 2, found: 0 },
    degenerate_triangles_are_counted:
        |m| m.meta.degenerate_triangle_count = 3
        => DegenerateTriangleCount { expected: 2, found: 3 },

    a_file_without_triangles_is_refused: |m| *m = only_root_bone() => NoTriangles,

    node_parents_are_in_range: |m| m.nodes[2].parent = 3 => at!(Nodes, 2, ParentNotBefore { found: 3 }),
    node_parents_stand_before: |m| m.nodes[1].parent = 1 => at!(Nodes, 1, ParentNotBefore { found: 1 }),
    node_maps_are_finite:
        |m| m.nodes[1].local[4] = f32::NAN => at!(Nodes, 1, NotFinite { field: "local", .. }),
    node_kinds_are_known:
        |m| m.nodes[1].local_kind = 2 => at!(Nodes, 1, UnknownNumber { field: "local_kind", found: 2, limit: 2 }),
    node_unused_places_are_zero:
        |m| m.nodes[1].local[11] = -0.0 => at!(Nodes, 1, ReservedNotZero { field: "local[10..12]" }),
    node_reserved_is_zero: |m| m.nodes[0].reserved = 1 => at!(Nodes, 0, ReservedNotZero { .. }),

    there_is_a_bone:
        |m| { m.bones.clear(); m.meta.bone_names.clear(); } => RowCount { section: Bones, expected: 1, found: 0 },
    bone_0_has_no_node: |m| m.bones[0].node = 0 => at!(Bones, 0, NotRootBone),
    bone_0_is_the_identity: |m| m.bones[0].inverse_bind[9] = 1.0 => at!(Bones, 0, NotRootBone),
    only_bone_0_has_no_node: |m| m.bones[2].node = NONE => at!(Bones, 2, SecondRootBone),
    bone_nodes_are_in_range:
        |m| m.bones[2].node = 3 => at!(Bones, 2, IndexOutOfRange { field: "node", found: 3, limit: 3 }),
    inverse_binds_are_finite:
        |m| m.bones[1].inverse_bind[0] = f32::INFINITY => at!(Bones, 1, NotFinite { .. }),
    bone_reserved_is_zero: |m| m.bones[1].reserved = 1 => at!(Bones, 1, ReservedNotZero { .. }),

    part_classes_are_known:
        |m| m.parts[0].class = 5 => at!(Parts, 0, UnknownNumber { field: "class", found: 5, limit: 5 }),
    part_morph_sets_are_in_range:
        |m| m.parts[1].morph_set = 1 => at!(Parts, 1, IndexOutOfRange { field: "morph_set", .. }),
    part_vertices_follow_each_other:
        |m| m.parts[1].vertex_first = 3
        => at!(Parts, 1, RangeNotContiguous { field: "vertex_first", found: 3, expected: 4 }),
    part_vertices_are_in_range:
        |m| m.parts[3].vertex_count = 4
        => at!(Parts, 3, RangeOutOfBounds { field: "vertex_first", first: 14, count: 4, limit: 17 }),
    parts_cover_all_vertices:
        |m| m.vertices.insert(17, VertexRow { position_rest: [0.0; 3], influence_first: 19 })
        => RowCount { section: Vertices, expected: 18, found: 19 },
    part_triangles_follow_each_other:
        |m| m.parts[1].triangle_first = 3 => at!(Parts, 1, RangeNotContiguous { field: "triangle_first", .. }),
    part_triangles_are_in_range:
        |m| m.parts[1].triangle_count = u32::MAX => at!(Parts, 1, RangeOutOfBounds { field: "triangle_first", .. }),
    parts_cover_all_triangles:
        |m| m.triangles.push(TriangleRow { corners: [4; 3] })
        => RowCount { section: Triangles, expected: 10, found: 11 },
    part_primitives_follow_each_other:
        |m| m.parts[1].primitive_first = 2 => at!(Parts, 1, RangeNotContiguous { field: "primitive_first", .. }),
    part_primitives_are_in_range:
        |m| m.parts[3].primitive_count = 2 => at!(Parts, 3, RangeOutOfBounds { field: "primitive_first", .. }),
    parts_cover_all_primitives:
        |m| m.primitives.push(m.primitives[2]) => RowCount { section: Primitives, expected: 5, found: 6 },
    primitive_triangles_follow_each_other:
        |m| m.primitives[2].triangle_first = 5
        => at!(Primitives, 2, RangeNotContiguous { field: "triangle_first", found: 5, expected: 4 }),
    primitive_triangles_stay_in_their_part:
        |m| m.primitives[0].triangle_count = 3 => at!(Primitives, 0, RangeOutOfBounds { first: 0, count: 3, limit: 2, .. }),
    primitives_cover_their_part:
        |m| m.primitives[2].triangle_count = 1
        => at!(Parts, 1, Count { field: "triangle_count", found: 4, expected: 3 }),
    primitive_reserved_is_zero: |m| m.primitives[0].reserved = 1 => at!(Primitives, 0, ReservedNotZero { .. }),
    corners_are_in_range:
        |m| m.triangles[3].corners[1] = 9
        => at!(Triangles, 3, IndexOutsideRange { field: "corners", found: 9, first: 4, limit: 9 }),
    corners_stay_in_their_part:
        |m| m.triangles[3].corners[1] = 3 => at!(Triangles, 3, IndexOutsideRange { found: 3, .. }),

    positions_are_finite:
        |m| m.vertices[5].position_rest[1] = f32::NAN => at!(Vertices, 5, NotFinite { field: "position_rest", .. }),
    the_closing_vertex_is_zero:
        |m| m.vertices[17].position_rest[0] = 1.0 => at!(Vertices, 17, ReservedNotZero { .. }),
    influences_begin_at_zero:
        |m| m.vertices[0].influence_first = 1 => at!(Vertices, 0, RangeNotContiguous { found: 1, expected: 0, .. }),
    every_vertex_has_an_influence:
        |m| m.vertices[5].influence_first = 4
        => at!(Vertices, 5, NotAscending { field: "influence_first", found: 4, previous: 4 }),
    influence_ranges_ascend: |m| m.vertices[6].influence_first = 1 => at!(Vertices, 6, NotAscending { .. }),
    influence_ranges_end_with_the_section:
        |m| m.vertices[17].influence_first = 20 => RowCount { section: Influences, expected: 20, found: 19 },
    influence_bones_are_in_range:
        |m| m.influences[5].bone = 3 => at!(Influences, 5, IndexOutOfRange { field: "bone", found: 3, limit: 3 }),
    influence_bones_of_a_vertex_are_distinct:
        |m| m.influences[6].bone = 1 => at!(Vertices, 5, RepeatedInfluence { bone: 1 }),
    weights_are_above_zero: |m| m.influences[5].weight = 0.0 => at!(Influences, 5, Weight { .. }),
    weights_are_not_above_one: |m| m.influences[4].weight = 1.5 => at!(Influences, 4, Weight { .. }),
    weights_are_numbers: |m| m.influences[4].weight = f32::NAN => at!(Influences, 4, Weight { .. }),
    weights_are_multiples_of_the_step:
        |m| m.influences[6].weight = 0.25f32.next_up() => at!(Influences, 6, Weight { .. }),
    weights_sum_to_one_exactly:
        |m| m.influences[7].weight = 1.0 - 2.0 / 16_777_216.0
        => at!(Vertices, 6, WeightSum { found_steps: 16_777_215 }),
    weights_do_not_sum_to_more:
        |m| m.influences[5].weight = 1.0 => at!(Vertices, 5, WeightSum { found_steps: 20_971_520 }),

    morph_sets_follow_each_other:
        |m| m.morph_sets[0].target_first = 1 => at!(MorphSets, 0, RangeNotContiguous { .. }),
    morph_sets_are_in_range: |m| m.morph_sets[0].target_count = 3 => at!(MorphSets, 0, RangeOutOfBounds { .. }),
    morph_sets_cover_all_targets:
        |m| m.morph_sets[0].target_count = 1 => RowCount { section: MorphTargets, expected: 1, found: 2 },
    morph_set_reserved_is_zero: |m| m.morph_sets[0].reserved = 1 => at!(MorphSets, 0, ReservedNotZero { .. }),
    morph_weights_are_finite:
        |m| m.morph_targets[1].default_weight = f32::NAN => at!(MorphTargets, 1, NotFinite { .. }),
    morph_extents_are_finite:
        |m| m.morph_targets[1].extent[2] = f32::INFINITY => at!(MorphTargets, 1, NotFinite { field: "extent", .. }),
    morph_extents_are_not_negative:
        |m| m.morph_targets[1].extent[2] = -1.0 => at!(MorphTargets, 1, Negative { field: "extent", .. }),
    morph_firsts_are_one_per_vertex_row:
        |m| { m.morph_first.pop(); } => RowCount { section: MorphFirst, expected: 18, found: 17 },
    morph_firsts_are_needed_where_there_are_deltas:
        |m| m.morph_first.clear() => RowCount { section: MorphFirst, expected: 18, found: 0 },
    morph_firsts_are_absent_where_there_are_no_deltas:
        |m| m.morph_deltas.clear() => RowCount { section: MorphFirst, expected: 0, found: 18 },
    morph_firsts_begin_at_zero:
        |m| m.morph_first[0] = 1 => at!(MorphFirst, 0, RangeNotContiguous { found: 1, expected: 0, .. }),
    morph_firsts_do_not_fall:
        |m| m.morph_first[7] = 1 => at!(MorphFirst, 7, Descending { found: 1, previous: 2, .. }),
    morph_firsts_end_with_the_section:
        |m| m.morph_first[17] = 4 => RowCount { section: MorphDeltas, expected: 4, found: 3 },
    morph_targets_belong_to_the_parts_set:
        |m| m.morph_deltas[2].target = 2
        => at!(MorphDeltas, 2, IndexOutsideRange { field: "target", found: 2, first: 0, limit: 2 }),
    deltas_need_a_morph_set:
        |m| m.parts[1].morph_set = NONE => at!(MorphDeltas, 0, DeltaWithoutMorphSet { vertex: 5 }),
    morph_targets_of_a_vertex_ascend:
        |m| m.morph_deltas.swap(0, 1) => at!(MorphDeltas, 1, NotAscending { field: "target", found: 0, previous: 1 }),
    morph_targets_of_a_vertex_are_distinct:
        |m| m.morph_deltas[1].target = 0 => at!(MorphDeltas, 1, NotAscending { found: 0, previous: 0, .. }),
    deltas_are_finite:
        |m| m.morph_deltas[0].delta[0] = f32::NAN => at!(MorphDeltas, 0, NotFinite { field: "delta", .. }),
    deltas_stay_within_their_targets_extent:
        |m| m.morph_deltas[2].delta[1] = (-0.05f32).next_down()
        => at!(MorphDeltas, 2, BeyondExtent { field: "delta", axis: 1, extent_row: 1, .. }),

    key_times_are_finite: |m| m.key_times[1] = f32::INFINITY => at!(KeyTimes, 1, NotFinite { .. }),
    key_values_are_finite: |m| m.key_values[3] = f32::NAN => at!(KeyValues, 3, NotFinite { .. }),
    clip_channels_follow_each_other:
        |m| m.clips[1].channel_first = 2 => at!(Clips, 1, RangeNotContiguous { .. }),
    clip_channels_are_in_range: |m| m.clips[1].channel_count = 3 => at!(Clips, 1, RangeOutOfBounds { .. }),
    clips_cover_all_channels:
        |m| m.channels.push(m.channels[0]) => RowCount { section: Channels, expected: 5, found: 6 },
    clip_starts_are_the_first_keys:
        |m| m.clips[0].start_seconds = -0.4 => at!(Clips, 0, ClipTime { field: "start_seconds", expected: -0.5, .. }),
    clip_ends_are_the_last_keys:
        |m| m.clips[0].end_seconds = 2.5 => at!(Clips, 0, ClipTime { field: "end_seconds", expected: 2.0, .. }),
    clip_times_are_finite: |m| m.clips[0].end_seconds = f32::NAN => at!(Clips, 0, NotFinite { .. }),
    clips_without_channels_last_no_time:
        |m| {
            m.clips.push(ClipRow { start_seconds: 0.0, end_seconds: 1.0, channel_first: 5, channel_count: 0 });
            m.meta.clip_names.push(String::new());
            m.clip_bounds.clear();
        }
        => at!(Clips, 2, ClipTime { field: "end_seconds", expected: 0.0, .. }),
    channel_paths_are_known:
        |m| m.channels[0].path = 5 => at!(Channels, 0, UnknownNumber { field: "path", found: 5, limit: 5 }),
    channel_interpolations_are_known:
        |m| m.channels[0].interpolation = 3 => at!(Channels, 0, UnknownNumber { field: "interpolation", .. }),
    channel_nodes_are_in_range:
        |m| m.channels[1].target = 3 => at!(Channels, 1, IndexOutOfRange { field: "target", found: 3, limit: 3 }),
    channel_morph_sets_are_in_range:
        |m| m.channels[2].target = 1 => at!(Channels, 2, IndexOutOfRange { field: "target", found: 1, limit: 1 }),
    matrix_nodes_are_not_moved:
        |m| m.channels[1].target = 0 => at!(Channels, 1, MatrixNodeAnimated { node: 0 }),
    translation_width_is_three:
        |m| m.channels[1].width = 4 => at!(Channels, 1, Count { field: "width", found: 4, expected: 3 }),
    rotation_width_is_four:
        |m| m.channels[0].width = 3 => at!(Channels, 0, Count { field: "width", found: 3, expected: 4 }),
    scale_width_is_three: |m| m.channels[3].width = 1 => at!(Channels, 3, Count { field: "width", .. }),
    weights_width_is_the_target_count:
        |m| m.channels[2].width = 3 => at!(Channels, 2, Count { field: "width", found: 3, expected: 2 }),
    a_set_without_targets_is_not_animated:
        |m| {
            m.morph_sets.push(MorphSetRow { source_node: 9, target_first: 2, target_count: 0, reserved: 0 });
            m.channels[2].target = 1;
            m.channels[2].width = 0;
        }
        => at!(Channels, 2, EmptyRange { field: "width" }),
    a_channel_has_a_key: |m| m.channels[1].key_count = 0 => at!(Channels, 1, EmptyRange { field: "key_count" }),
    channel_times_are_in_range:
        |m| m.channels[3].time_first = 10 => at!(Channels, 3, RangeOutOfBounds { field: "time_first", .. }),
    channel_times_increase: |m| m.key_times[4] = 0.5 => at!(Channels, 1, TimesNotIncreasing { key: 1 }),
    channel_times_do_not_fall: |m| m.key_times[3] = 0.0 => at!(Channels, 1, TimesNotIncreasing { key: 0 }),
    channel_values_are_in_range:
        |m| m.channels[3].value_first = 32 => at!(Channels, 3, RangeOutOfBounds { field: "value_first", .. }),
    channel_tangents_are_in_range:
        |m| m.key_values.truncate(28) => at!(Channels, 2, RangeOutOfBounds { field: "value_first", count: 12, .. }),
    channel_reserved_is_zero: |m| m.channels[0].reserved = 1 => at!(Channels, 0, ReservedNotZero { .. }),
    a_property_is_moved_once_per_clip:
        |m| {
            m.channels[0] = ChannelRow { time_first: 2, ..m.channels[1] };
        }
        => at!(Channels, 1, RepeatedChannel),
    sample_clips_are_in_range:
        |m| m.samples[1].clip = 2 => at!(Samples, 1, IndexOutOfRange { field: "clip", found: 2, limit: 2 }),
    sample_times_are_finite:
        |m| m.samples.push(SampleRow { clip: NONE, seconds: f32::NAN }) => at!(Samples, 2, NotFinite { .. }),

    clip_bounds_are_one_per_stretch_of_each_clip_and_one_more:
        |m| { m.clip_bounds.pop(); } => RowCount { section: ClipBounds, expected: 65, found: 64 },
    clip_bounds_are_not_one_per_clip:
        |m| m.clip_bounds.truncate(3) => RowCount { section: ClipBounds, expected: 65, found: 3 },
    clip_bounds_are_finite:
        |m| m.clip_bounds[31].bounds.max[1] = f32::INFINITY
        => at!(ClipBounds, 31, NotFinite { field: "bounds", .. }),
    clip_bounds_are_not_empty:
        |m| m.clip_bounds[64].bounds.max[2] = -6.0 => at!(ClipBounds, 64, EmptyBox { field: "bounds", axis: 2, .. }),
    clip_bounds_are_empty_where_they_are_unknown:
        |m| m.clip_bounds[63].bounds.max[2] = 0.0 => at!(ClipBounds, 63, UnknownBounds),
    clip_bounds_are_known_or_not:
        |m| m.clip_bounds[31].known = 2 => at!(ClipBounds, 31, UnknownNumber { field: "known", found: 2, limit: 2 }),
    clip_bounds_reach_no_less_than_nothing:
        |m| m.clip_bounds[31].reach[2] = -1.0 => at!(ClipBounds, 31, Negative { field: "reach", .. }),
    clip_bounds_reach_finitely_far:
        |m| m.clip_bounds[64].rest_reach = f32::NAN => at!(ClipBounds, 64, NotFinite { field: "rest_reach", .. }),
    clip_bounds_reach_nowhere_where_they_are_unknown:
        |m| m.clip_bounds[63].reach[0] = 1.0 => at!(ClipBounds, 63, UnknownBounds),

    cluster_bones_in_frames_are_in_range:
        |m| m.clusters[1].bone = 3 => at!(Clusters, 1, IndexOutOfRange { field: "bone", .. }),
    cluster_bounds_are_finite:
        |m| m.clusters[1].bounds_local.max[2] = f32::INFINITY => at!(Clusters, 1, NotFinite { .. }),
    cluster_bounds_are_not_empty:
        |m| m.clusters[1].bounds_local = Aabb { min: [0.0, 2.0, 0.0], max: [1.0; 3] }
        => at!(Clusters, 1, EmptyBox { axis: 1, .. }),
    cluster_nodes_follow_each_other:
        |m| m.clusters[1].node_first = 0 => at!(Clusters, 1, RangeNotContiguous { field: "node_first", .. }),
    cluster_nodes_are_in_range:
        |m| m.clusters[6].node_count = 2 => at!(Clusters, 6, RangeOutOfBounds { field: "node_first", .. }),
    clusters_cover_all_nodes:
        |m| m.kd_nodes.push(m.kd_nodes[4]) => RowCount { section: KdNodes, expected: 8, found: 9 },
    kd_files_have_no_wide_nodes:
        |m| m.wide_nodes.push(WideNodeRow::EMPTY)
        => RowsOfOtherTrees { section: WideNodes, found: 1, tree: TreeKind::Kd },
    kd_files_have_no_movers:
        |m| m.node_movers.push(NodeMoverRow::default())
        => RowsOfOtherTrees { section: NodeMovers, found: 1, tree: TreeKind::Kd },
    kd_files_have_no_boxes_at_keys:
        |m| m.key_boxes.push(KeyBoxRow::default())
        => RowsOfOtherTrees { section: KeyBoxes, found: 1, tree: TreeKind::Kd },
    a_tree_has_a_root:
        |m| m.clusters[2].node_count = 0 => at!(Clusters, 2, EmptyRange { field: "node_count" }),
    cluster_references_follow_each_other:
        |m| m.clusters[1].reference_first = 1 => at!(Clusters, 1, RangeNotContiguous { field: "reference_first", .. }),
    cluster_references_are_in_range:
        |m| m.clusters[7].reference_count = 2 => at!(Clusters, 7, RangeOutOfBounds { field: "reference_first", .. }),
    clusters_cover_all_references:
        |m| m.references.push(4) => RowCount { section: References, expected: 11, found: 12 },
    cluster_bone_rows_follow_each_other:
        |m| m.clusters[1].cluster_bone_first = 2 => at!(Clusters, 1, RangeNotContiguous { field: "cluster_bone_first", .. }),
    cluster_bone_rows_are_in_range:
        |m| m.clusters[7].cluster_bone_count = 3 => at!(Clusters, 7, RangeOutOfBounds { field: "cluster_bone_first", .. }),
    clusters_cover_all_cluster_bones:
        |m| m.cluster_bones.push(m.cluster_bones[4]) => RowCount { section: ClusterBones, expected: 13, found: 14 },
    cluster_reserved_is_zero: |m| m.clusters[0].reserved = 1 => at!(Clusters, 0, ReservedNotZero { .. }),
    cluster_triangles_are_counted:
        |m| m.clusters[1].triangle_count = 3
        => at!(Clusters, 1, Count { field: "triangle_count", found: 3, expected: 2 }),

    cluster_bones_are_in_range: |m| m.cluster_bones[2].bone = 3 => at!(ClusterBones, 2, IndexOutOfRange { .. }),
    cluster_bones_ascend:
        |m| { sample_bounds(m); m.cluster_bones.swap(1, 2); }
        => at!(ClusterBones, 2, NotAscending { field: "bone", found: 1, previous: 2 }),
    cluster_bones_are_distinct:
        |m| { sample_bounds(m); m.cluster_bones[2].bone = 1; }
        => at!(ClusterBones, 2, NotAscending { found: 1, previous: 1, .. }),
    cluster_bone_boxes_are_finite:
        |m| m.cluster_bones[0].bounds.min[1] = f32::NAN => at!(ClusterBones, 0, NotFinite { field: "bounds", .. }),
    cluster_bone_boxes_are_not_empty:
        |m| m.cluster_bones[0].bounds.max[1] = -1.0 => at!(ClusterBones, 0, EmptyBox { field: "bounds", axis: 1, .. }),
    cluster_bone_boxes_contain_every_vertex:
        |m| m.cluster_bones[2].bounds.max[2] = 0.5f32.next_down()
        => at!(Vertices, 7, OutsideBox { field: "position_rest", axis: 2, box_row: 2, .. }),
    cluster_bone_boxes_contain_negative_coordinates:
        |m| m.cluster_bones[0].bounds.min[0] = -4.5 => at!(Vertices, 0, OutsideBox { axis: 0, box_row: 0, .. }),
    cluster_bone_reserved_is_zero:
        |m| m.cluster_bones[4].reserved = 1 => at!(ClusterBones, 4, ReservedNotZero { .. }),
    every_bone_of_a_clusters_vertices_is_listed:
        |m| {
            sample_bounds(m);
            m.cluster_bones.remove(3);
            m.clusters[2].cluster_bone_count = 1;
            m.clusters[3..].iter_mut().for_each(|cluster| cluster.cluster_bone_first -= 1);
        }
        => at!(Clusters, 2, ClusterBoneMissing { bone: 1, vertex: 6 }),
    a_bone_listed_for_one_cluster_does_not_count_for_the_next:
        |m| {
            sample_bounds(m);
            m.cluster_bones.remove(1);
            m.clusters[1].cluster_bone_count = 1;
            m.clusters[2..].iter_mut().for_each(|cluster| cluster.cluster_bone_first -= 1);
        }
        => at!(Clusters, 1, ClusterBoneMissing { bone: 1, vertex: 4 }),
    only_bones_of_a_clusters_vertices_are_listed:
        |m| {
            sample_bounds(m);
            m.cluster_bones.insert(1, m.cluster_bones[0]);
            m.cluster_bones[1].bone = 2;
            m.clusters[0].cluster_bone_count = 2;
            m.clusters[1..].iter_mut().for_each(|cluster| cluster.cluster_bone_first += 1);
        }
        => at!(ClusterBones, 1, ClusterBoneUnused { bone: 2 }),

    kd_children_are_in_range:
        |m| m.kd_nodes[1] = inner(0.5, 2) => at!(KdNodes, 1, IndexOutOfRange { field: "child", found: 3, limit: 3 }),
    kd_children_stand_behind:
        |m| m.kd_nodes[1] = inner(0.5, 0) => at!(KdNodes, 1, ChildNotBehind { found: 0, own: 0 }),
    kd_splits_are_finite:
        |m| m.kd_nodes[1] = inner(f32::NAN, 1) => at!(KdNodes, 1, NotFinite { field: "split", .. }),
    kd_nodes_have_one_parent:
        |m| {
            m.kd_nodes[2] = inner(0.25, 2);
            m.kd_nodes.insert(4, leaf(0, 0));
            m.clusters[1].node_count = 4;
            m.clusters[2..].iter_mut().for_each(|cluster| cluster.node_first += 1);
        }
        => at!(KdNodes, 2, TwoParents { child: 2 }),
    kd_nodes_but_the_root_have_a_parent:
        |m| {
            m.kd_nodes.insert(1, leaf(0, 0));
            m.clusters[0].node_count = 2;
            m.clusters[1..].iter_mut().for_each(|cluster| cluster.node_first += 1);
        }
        => at!(KdNodes, 1, NoParent),
    kd_leaves_stay_within_the_clusters_references:
        |m| m.kd_nodes[4] = leaf(0, 2)
        => at!(KdNodes, 4, RangeOutOfBounds { field: "reference", first: 0, count: 2, limit: 1 }),
    kd_leaf_ranges_do_not_wrap:
        |m| m.kd_nodes[4] = leaf(u32::MAX, 1) => at!(KdNodes, 4, RangeOutOfBounds { .. }),
    kd_leaves_do_not_share_references:
        |m| m.kd_nodes[3] = leaf(0, 2) => at!(KdNodes, 3, ReferenceShared { reference: 0 }),
    every_reference_is_in_a_leaf: |m| m.kd_nodes[3] = leaf(1, 1) => at!(References, 4, ReferenceUnused),
    a_kd_tree_is_not_too_deep: |m| deepen(m, 63) => at!(KdNodes, 128, TooDeep { found: 63, limit: 62 }),

    references_are_triangles:
        |m| m.references[5] = 10 => at!(References, 5, IndexOutOfRange { field: "triangle", found: 10, limit: 10 }),
    a_triangle_belongs_to_one_cluster:
        |m| m.references[5] = 3 => at!(References, 5, TriangleInTwoClusters { triangle: 3, other: 1 }),
    a_triangle_with_area_belongs_to_a_cluster:
        |m| {
            m.references[1] = 0;
            m.clusters[0].triangle_count = 1;
        }
        => at!(Triangles, 1, TriangleInNoCluster),
    a_degenerate_triangle_belongs_to_no_cluster:
        |m| m.references[5] = 5 => at!(References, 5, DegenerateReferenced { triangle: 5 }),

    every_reference_has_a_box:
        |m| { m.reference_boxes.pop(); } => RowCount { section: ReferenceBoxes, expected: 11, found: 10 },
    no_box_is_without_a_reference:
        |m| m.reference_boxes.push(m.reference_boxes[0])
        => RowCount { section: ReferenceBoxes, expected: 11, found: 12 },
    boxes_are_not_empty:
        |m| (m.reference_boxes[8].min[2], m.reference_boxes[8].max[2]) = (9, 8)
        => at!(ReferenceBoxes, 8, EmptyBox { field: "box", axis: 2, min: 9.0, max: 8.0 }),
}

fn inner(split: f32, left: u32) -> KdNodeRow {
    KdNodeRow::pack(KdNode::Inner { axis: 2, split, left })
}

fn leaf(first: u32, count: u32) -> KdNodeRow {
    KdNodeRow::pack(KdNode::Leaf { first, count })
}

/// Gives the last cluster without a track a chain of `depth` inner nodes.
fn deepen(model: &mut Model, depth: u32) {
    let first = model.clusters[2].node_first as usize;
    let mut nodes = vec![inner(0.0, 1)];
    for level in 1..depth {
        nodes.extend([leaf(0, 0), inner(0.0, level * 2 + 1)]);
    }
    nodes.extend([leaf(0, 0), leaf(0, 1)]);
    model.clusters[2].node_count = nodes.len() as u32;
    for cluster in &mut model.clusters[3..] {
        cluster.node_first += 2 * depth;
    }
    model.kd_nodes.splice(first..=first, nodes);
}

#[test]
fn a_kd_tree_of_the_greatest_depth_is_accepted() {
    let mut model = model();
    deepen(&mut model, 62);
    assert!(write(&model).is_ok());
}

#[test]
fn a_triangle_may_stand_in_several_leaves() {
    let mut model = model();
    model.kd_nodes[2] = leaf(0, 2);
    model.kd_nodes[3] = leaf(2, 1);
    assert!(write(&model).is_ok());
}

#[test]
fn boxes_may_lie_in_a_plane_and_fill_the_lattice() {
    let mut model = model();
    model.reference_boxes[2].min = [0, 0, 65535];
    model.reference_boxes[2].max = [65535; 3];
    model.reference_boxes[7] = ReferenceBoxRow::default();
    assert!(write(&model).is_ok());
}

#[test]
fn a_vertex_with_a_million_influences_is_checked_in_linear_time() {
    // A search for repeated bones by pairs would take 10^12 steps.
    const COUNT: u32 = 1 << 20;
    let mut model = model();
    let node = NodeRow::new(NONE, 0, Local::Matrix([[0.0; 3]; 4]));
    model.nodes.push(node);
    let bone = BoneRow {
        node: 3,
        ..model.bones[1]
    };
    model.bones.resize(COUNT as usize, bone);
    model.meta.bone_names.resize(COUNT as usize, String::new());
    let all = (0..COUNT).map(|bone| InfluenceRow {
        bone,
        weight: 1.0 / COUNT as f32,
    });
    model.influences.splice(10..11, all);
    for vertex in &mut model.vertices[9..] {
        vertex.influence_first += COUNT - 1;
    }
    let fault = write(&model);
    let expected = ClusterBoneMissing { bone: 0, vertex: 8 };
    assert_eq!(
        fault,
        Err(Row {
            section: Clusters,
            row: 2,
            fault: expected
        })
    );
}

/// A root bone and nothing else.
fn only_root_bone() -> Model {
    let mut empty = Model {
        bones: model().bones[..1].to_vec(),
        ..Model::default()
    };
    empty.meta.bone_names.push(String::new());
    empty
}
