//! The rules of vertex caches, as in `row_rules`.

use crate::{
    broken::{at, rules},
    fixture::FLAG_CACHE,
};
use restpose_formats::{
    FormatError::*,
    Model,
    RowFault::*,
    SectionKind::*,
    geom::Aabb,
    rows::{CacheRow, InfluenceRow, KdNode, KdNodeRow, KeyRow, MotionClass, NONE, ReferenceBoxRow},
};

rules! {
    part_caches_are_in_range:
        |m| m.parts[2].cache = 2 => at!(Parts, 2, IndexOutOfRange { field: "cache", found: 2, limit: 2 }),
    a_keyframed_part_has_a_cache:
        |m| m.parts[2].cache = NONE => at!(Parts, 2, CacheMissing { class: MotionClass::Keyframed }),
    a_free_part_has_a_cache:
        |m| m.parts[3].cache = NONE => at!(Parts, 3, CacheMissing { class: MotionClass::Free }),
    a_static_part_has_no_cache:
        |m| m.parts[2].class = MotionClass::Static as u32
        => at!(Parts, 2, CacheNotAllowed { class: MotionClass::Static, found: 1 }),
    a_skinned_part_has_no_cache:
        |m| m.parts[2].class = MotionClass::Skinned as u32
        => at!(Parts, 2, CacheNotAllowed { class: MotionClass::Skinned, found: 1 }),
    two_parts_do_not_share_a_cache:
        |m| m.parts[3].cache = FLAG_CACHE => at!(Parts, 3, NotPaired { field: "cache", found: 1, back: "part" }),
    a_part_with_a_cache_has_no_skin:
        |m| m.parts[2].source_skin = 0 => at!(Parts, 2, NotNoneWithCache { field: "source_skin", found: 0 }),
    a_part_with_a_cache_has_no_morph_set:
        |m| m.parts[2].morph_set = 0 => at!(Parts, 2, NotNoneWithCache { field: "morph_set", found: 0 }),

    cache_parts_are_in_range:
        |m| m.caches.push(CacheRow { part: 4, ..m.caches[0] })
        => at!(Caches, 2, IndexOutOfRange { field: "part", found: 4, limit: 4 }),
    every_cache_is_named_by_its_part:
        |m| m.caches.push(CacheRow { part: 1, ..m.caches[0] })
        => at!(Caches, 2, NotPaired { field: "part", found: 1, back: "cache" }),
    a_cache_is_not_there_twice:
        |m| m.caches.push(m.caches[0]) => at!(Caches, 2, NotPaired { field: "part", found: 3, back: "cache" }),
    cache_bones_are_in_range:
        |m| m.caches[1].bone = 3 => at!(Caches, 1, IndexOutOfRange { field: "bone", found: 3, limit: 3 }),
    cache_vertices_hang_on_its_bone:
        |m| m.caches[1].bone = 2 => at!(Vertices, 9, CachedInfluence { bone: 2 }),
    cache_vertices_hang_on_nothing_else:
        |m| {
            m.influences[12].weight = 0.5;
            m.influences.insert(13, InfluenceRow { bone: 2, weight: 0.5 });
            m.vertices[11..].iter_mut().for_each(|vertex| vertex.influence_first += 1);
        }
        => at!(Vertices, 10, CachedInfluence { bone: 1 }),
    position_errors_are_finite:
        |m| m.caches[1].position_error = f32::NAN => at!(Caches, 1, NotFinite { field: "position_error", .. }),
    position_errors_are_not_negative:
        |m| m.caches[1].position_error = -1.0 => at!(Caches, 1, Negative { field: "position_error", .. }),
    a_cache_has_a_key: |m| m.caches[1].key_count = 0 => at!(Caches, 1, EmptyRange { field: "key_count" }),
    a_cache_has_a_segment: |m| m.caches[1].segment_count = 0 => at!(Caches, 1, EmptyRange { field: "segment_count" }),
    cache_reserved_is_zero: |m| m.caches[0].reserved[1] = 1 => at!(Caches, 0, ReservedNotZero { .. }),
    cache_segments_follow_each_other:
        |m| m.caches[1].segment_first = 0
        => at!(Caches, 1, RangeNotContiguous { field: "segment_first", found: 0, expected: 1 }),
    cache_segments_are_in_range:
        |m| m.caches[1].segment_count = 3 => at!(Caches, 1, RangeOutOfBounds { field: "segment_first", .. }),
    caches_cover_all_segments:
        |m| m.segments.push(m.segments[2]) => RowCount { section: Segments, expected: 3, found: 4 },
    no_segment_is_without_a_cache: without_caches => RowCount { section: Segments, expected: 0, found: 3 },

    the_first_segment_begins_at_key_0:
        |m| m.segments[1].key_first = 1
        => at!(Segments, 1, RangeNotContiguous { field: "key_first", found: 1, expected: 0 }),
    segments_share_a_key_with_the_one_before:
        |m| m.segments[2].key_first = 3
        => at!(Segments, 2, RangeNotContiguous { field: "key_first", found: 3, expected: 2 }),
    segments_share_no_more_than_a_key:
        |m| (m.segments[2].key_first, m.segments[2].key_count) = (1, 3)
        => at!(Segments, 2, RangeNotContiguous { field: "key_first", found: 1, expected: 2 }),
    segments_end_by_the_caches_last_key:
        |m| m.segments[2].key_count = 3
        => at!(Segments, 2, RangeOutOfBounds { field: "key_first", first: 2, count: 3, limit: 4 }),
    segments_do_not_wrap:
        |m| m.segments[2].key_count = u32::MAX => at!(Segments, 2, RangeOutOfBounds { field: "key_first", .. }),
    segments_cover_all_keys:
        |m| m.caches[1].key_count = 5 => at!(Caches, 1, Count { field: "key_count", found: 5, expected: 4 }),
    a_segment_has_two_keys:
        |m| m.segments[2].key_count = 1
        => at!(Segments, 2, TooFew { field: "key_count", found: 1, least: 2 }),
    the_segment_of_a_single_key_has_it:
        |m| m.segments[0].key_count = 0
        => at!(Segments, 0, TooFew { field: "key_count", found: 0, least: 1 }),
    a_single_key_has_a_single_segment:
        |m| {
            m.segments.insert(1, m.segments[0]);
            m.caches[0].segment_count = 2;
            m.caches[1].segment_first = 2;
        }
        => at!(Caches, 0, Count { field: "segment_count", found: 2, expected: 1 }),
    key_words_of_segments_follow_each_other:
        |m| m.segments[1].word_first += 1 => at!(Segments, 1, RangeNotContiguous { field: "word_first", found: 10, expected: 9 }),
    key_words_are_in_range:
        |m| m.key_words.truncate(9) => at!(Segments, 0, RangeOutOfBounds { field: "word_first", limit: 5, .. }),
    key_words_do_not_wrap:
        |m| m.segments[1].words_per_key = u32::MAX => at!(Segments, 1, RangeOutOfBounds { field: "word_first", .. }),
    segments_cover_all_words_but_the_closing_ones:
        |m| m.key_words.push(0) => RowCount { section: KeyWords, .. },
    four_words_close_the_section:
        |m| { m.key_words.pop(); } => at!(Segments, 2, RangeOutOfBounds { field: "word_first", .. }),
    the_closing_words_are_zero:
        |m| *m.key_words.last_mut().unwrap() = 1 => Row { section: KeyWords, fault: ReservedNotZero { field: "closing word" }, .. },
    a_key_has_no_more_words_than_its_records_fill:
        |m| { m.segments[2].words_per_key += 1; m.key_words.extend([0; 2]); }
        => at!(Segments, 2, Count { field: "words_per_key", .. }),
    a_key_has_no_fewer_words_than_its_records_fill:
        |m| {
            m.segments[2].words_per_key -= 1;
            m.key_words.drain(23..25);
        }
        => at!(Segments, 2, Count { field: "words_per_key", .. }),
    a_segment_has_a_track:
        |m| m.segments[0].track_count = 0 => at!(Segments, 0, EmptyRange { field: "track_count" }),
    segment_tracks_follow_each_other:
        |m| m.segments[1].track_first = 2 => at!(Segments, 1, RangeNotContiguous { field: "track_first", .. }),
    segment_tracks_are_in_range:
        |m| m.segments[2].track_count = 3 => at!(Segments, 2, RangeOutOfBounds { field: "track_first", .. }),
    segments_cover_all_tracks:
        |m| m.tracks.push(m.tracks[0]) => RowCount { section: Tracks, expected: 5, found: 6 },
    segment_clusters_follow_each_other:
        |m| m.segments[1].cluster_first = 3 => at!(Segments, 1, RangeNotContiguous { field: "cluster_first", .. }),
    segment_clusters_are_in_range:
        |m| m.segments[2].cluster_count = 3 => at!(Segments, 2, RangeOutOfBounds { field: "cluster_first", .. }),
    segments_cover_all_clusters_with_a_track:
        |m| m.segments[2].cluster_count = 1 => RowCount { section: Clusters, expected: 7, found: 8 },
    clusters_without_a_track_stand_first:
        |m| m.clusters[2].track = 0
        => at!(Segments, 0, RangeNotContiguous { field: "cluster_first", found: 3, expected: 2 }),
    clusters_of_segments_have_a_track:
        |m| m.clusters[5].track = NONE => at!(Clusters, 5, IndexOutsideRange { field: "track", first: 1, limit: 3, .. }),
    segment_vertices_follow_each_other:
        |m| m.segments[1].key_vertex_first = 2 => at!(Segments, 1, RangeNotContiguous { field: "key_vertex_first", .. }),
    segment_vertices_are_in_range:
        |m| { m.key_vertices.pop(); }
        => at!(Segments, 2, RangeOutOfBounds { field: "key_vertex_first", first: 8, count: 5, limit: 12 }),
    segments_cover_all_key_vertices:
        |m| m.key_vertices.push(m.key_vertices[0]) => RowCount { section: KeyVertices, expected: 13, found: 14 },

    track_origins_are_finite:
        |m| m.tracks[1].origin[2] = f32::INFINITY => at!(Tracks, 1, NotFinite { field: "origin", .. }),
    track_steps_are_finite:
        |m| m.tracks[1].step = f32::NAN => at!(Tracks, 1, NotFinite { field: "step", .. }),
    track_steps_are_above_zero:
        |m| m.tracks[1].step = 0.0 => at!(Tracks, 1, NotAboveZero { field: "step", .. }),
    track_reserved_is_zero: |m| m.tracks[1].reserved = 1 => at!(Tracks, 1, ReservedNotZero { .. }),
    a_track_without_keys_has_no_origin: |m| m.tracks[4].origin[0] = -0.0 => at!(Tracks, 4, LatticeWithoutKeys),
    a_track_without_keys_has_step_one: |m| m.tracks[4].step = 0.5 => at!(Tracks, 4, LatticeWithoutKeys),
    a_track_without_keys_has_no_boxes_at_keys:
        |m| m.tracks[4].box_interval = 1 => at!(Tracks, 4, ReservedNotZero { field: "box_interval" }),
    a_track_without_keys_names_no_boxes:
        |m| m.tracks[0].box_first = 1 => at!(Tracks, 0, ReservedNotZero { field: "box_first" }),
    kd_trees_have_no_boxes_at_keys:
        |m| m.tracks[2].box_interval = 1
        => at!(Tracks, 2, RangeOutOfBounds { field: "box_first", first: 0, count: 3, limit: 0 }),
    tracks_of_kd_trees_name_no_boxes:
        |m| m.tracks[3].box_first = 1
        => at!(Tracks, 3, RangeNotContiguous { field: "box_first", found: 1, expected: 0 }),
    track_keys_follow_each_other:
        |m| m.tracks[2].key_first = 2
        => at!(Tracks, 2, RangeNotContiguous { field: "key_first", found: 2, expected: 3 }),
    track_keys_are_in_range:
        |m| { m.keys.pop(); } => at!(Tracks, 3, RangeOutOfBounds { field: "key_first", first: 6, count: 2, limit: 7 }),
    tracks_cover_all_keys: |m| m.keys.push(m.keys[7]) => RowCount { section: Keys, expected: 8, found: 9 },

    key_maps_are_finite: |m| m.keys[5].map[11] = f32::NAN => at!(Keys, 5, NotFinite { field: "map", .. }),
    key_bounds_are_finite:
        |m| m.keys[5].bounds.max[0] = f32::INFINITY => at!(Keys, 5, NotFinite { field: "bounds", .. }),
    key_bounds_are_not_empty:
        |m| m.keys[5].bounds = Aabb { min: [0.0, 0.0, 2.0], max: [1.0; 3] } => at!(Keys, 5, EmptyBox { axis: 2, .. }),
    key_flags_are_known:
        |m| m.keys[4].flags = 2 => at!(Keys, 4, UnknownNumber { field: "flags", found: 2, limit: 2 }),
    nothing_is_cut_after_the_last_key: |m| m.keys[2].flags = KeyRow::CUT => at!(Keys, 2, CutAfterLastKey),
    key_reserved_is_zero: |m| m.keys[0].reserved = 1 => at!(Keys, 0, ReservedNotZero { .. }),

    key_vertex_tracks_are_of_their_segment:
        |m| m.key_vertices[3].track = 3
        => at!(KeyVertices, 3, IndexOutsideRange { field: "track", found: 3, first: 1, limit: 3 }),
    key_vertex_tracks_are_not_of_an_earlier_segment:
        |m| m.key_vertices[8].track = 2 => at!(KeyVertices, 8, IndexOutsideRange { field: "track", .. }),
    raw_is_zero_or_one:
        |m| m.key_vertices[3].raw = 2 => at!(KeyVertices, 3, UnknownNumber { field: "raw", found: 2, limit: 2 }),
    raw_positions_have_a_track_without_keys:
        |m| m.key_vertices[9].track = 3 => at!(KeyVertices, 9, RawOnTrackWithKeys { track: 3 }),
    raw_positions_have_no_base:
        |m| m.key_vertices[9].base[1] = 1 => at!(KeyVertices, 9, ReservedNotZero { field: "base" }),
    raw_positions_have_no_widths:
        |m| m.key_vertices[9].widths[1] = 1 => at!(KeyVertices, 9, ReservedNotZero { field: "widths" }),
    widths_are_within_their_limit:
        |m| m.key_vertices[3].widths[1] = 22 => at!(KeyVertices, 3, TooWide { axis: 1, found: 22, limit: 21 }),
    coordinates_are_not_too_low:
        |m| m.key_vertices[12].base[2] = -(1 << 24) - 1
        => at!(KeyVertices, 12, BeyondLattice { axis: 2, found: -16_777_217, limit: 16_777_216 }),
    coordinates_are_not_too_high:
        |m| {
            m.key_vertices[12].widths[0] = 4;
            m.key_vertices[12].base[0] = (1 << 24) - 14;
        }
        => at!(KeyVertices, 12, BeyondLattice { axis: 0, found: 16_777_217, .. }),
    coordinates_do_not_wrap:
        |m| {
            m.key_vertices[12].widths[0] = 21;
            m.key_vertices[12].base[0] = i32::MAX;
        }
        => at!(KeyVertices, 12, BeyondLattice { axis: 0, .. }),
    records_of_a_key_follow_each_other:
        |m| m.key_vertices[4].bit_first += 1 => at!(KeyVertices, 4, RangeNotContiguous { field: "bit_first", .. }),
    records_of_a_key_begin_with_its_first_bit:
        |m| m.key_vertices[3].bit_first = 1 => at!(KeyVertices, 3, RangeNotContiguous { field: "bit_first", expected: 0, .. }),
    there_are_no_words_without_a_cache:
        |m| { without_caches(m); m.segments.clear(); m.tracks.clear(); m.keys.clear(); m.key_vertices.clear(); m.clusters.truncate(3); }
        => RowCount { section: KeyWords, expected: 0, .. },
    raw_positions_are_finite:
        |m| m.key_words[7] = f32::NAN.to_bits() => at!(KeyWords, 6, NotFinite { field: "position", .. }),
    there_are_no_bits_behind_the_last_record:
        |m| {
            let bits: u32 = m.key_vertices[3..8].iter().map(|row| row.record_bits()).sum();
            assert_eq!((bits, m.segments[1].words_per_key), (41, 2));
            // Of its second key.
            m.key_words[9 + 3] |= 1 << 31;
        }
        => at!(KeyWords, 12, ReservedNotZero { field: "bits behind the last record" }),

    cluster_tracks_are_of_their_segment:
        |m| m.clusters[6].track = 2 => at!(Clusters, 6, IndexOutsideRange { field: "track", found: 2, first: 3, limit: 5 }),
    clusters_hang_on_their_caches_bone:
        |m| m.clusters[5].bone = 2 => at!(Clusters, 5, NotTheCachesBone { found: 2, expected: 1 }),
    a_track_with_keys_moves_one_cluster:
        |m| m.clusters[5].track = 1 => at!(Clusters, 5, TrackShared { track: 1, other: 4 }),
    every_track_with_keys_moves_a_cluster:
        |m| {
            m.clusters[6].track = 4;
            m.clusters[6].node_count = 0;
            m.clusters[7].node_first = 7;
            m.kd_nodes.pop();
        }
        => at!(Tracks, 3, TrackUnused),
    free_motion_has_no_tree:
        |m| {
            m.kd_nodes.push(KdNodeRow::pack(KdNode::Leaf { first: 0, count: 1 }));
            m.clusters[7].node_count = 1;
        }
        => at!(Clusters, 7, Count { field: "node_count", found: 1, expected: 0 }),
    a_cluster_with_keys_has_a_tree:
        |m| {
            m.kd_nodes.remove(6);
            m.clusters[5].node_count = 0;
            m.clusters[6..].iter_mut().for_each(|cluster| cluster.node_first -= 1);
        }
        => at!(Clusters, 5, EmptyRange { field: "node_count" }),
    free_motion_lists_each_triangle_once:
        |m| {
            m.references.push(7);
            m.clusters[7].reference_count = 2;
        }
        => at!(Clusters, 7, Count { field: "reference_count", found: 2, expected: 1 }),

    boxes_in_free_motion_are_zero_beside_tracks_with_keys:
        |m| m.reference_boxes[10] = ReferenceBoxRow { min: [0, 0, 1], max: [0, 0, 1] }
        => at!(ReferenceBoxes, 10, ReservedNotZero { field: "box" }),
    boxes_in_free_motion_are_zero:
        |m| m.reference_boxes[6].max[1] = 1 => at!(ReferenceBoxes, 6, ReservedNotZero { field: "box" }),

    triangles_with_a_cache_are_in_no_cluster_without_a_track:
        |m| m.references[0] = 6 => at!(References, 0, TriangleNeedsTrack { triangle: 6 }),
    triangles_without_a_cache_are_in_no_cluster_with_a_track:
        |m| m.references[7] = 0
        => at!(References, 7, IndexOutsideRange { field: "triangle", found: 0, first: 6, limit: 9 }),
    triangles_of_one_cache_are_in_no_cluster_of_another:
        |m| m.references[7] = 9 => at!(References, 7, IndexOutsideRange { found: 9, .. }),
    a_triangle_belongs_to_one_cluster_of_a_segment:
        |m| m.references[8] = 6 => at!(References, 8, TriangleInTwoClusters { triangle: 6, other: 4 }),
    a_triangle_with_area_belongs_to_a_cluster_of_every_segment:
        |m| {
            m.references.pop();
            m.reference_boxes.pop();
            m.clusters[7].reference_count = 0;
            m.clusters[7].triangle_count = 0;
            m.clusters[7].cluster_bone_count = 0;
            m.cluster_bones.truncate(11);
        }
        => at!(Triangles, 7, TriangleNotInSegment { segment: 2 }),
    a_degenerate_triangle_belongs_to_no_cluster_of_a_segment:
        |m| m.references[8] = 8 => at!(References, 8, DegenerateReferenced { triangle: 8 }),

    listed_tracks_are_of_the_segment:
        |m| m.cluster_bones[8].bone = 3
        => at!(ClusterBones, 8, IndexOutsideRange { field: "bone", found: 3, first: 1, limit: 3 }),
    listed_tracks_ascend:
        |m| m.cluster_bones.swap(7, 8) => at!(ClusterBones, 8, NotAscending { field: "bone", found: 1, previous: 2 }),
    every_track_of_a_clusters_vertices_is_listed:
        |m| {
            m.cluster_bones.remove(8);
            m.clusters[5].cluster_bone_count = 1;
            m.clusters[6..].iter_mut().for_each(|cluster| cluster.cluster_bone_first -= 1);
        }
        => at!(Clusters, 5, ClusterTrackMissing { track: 2, vertex: 12 }),
    only_tracks_of_a_clusters_vertices_are_listed:
        |m| {
            m.cluster_bones.insert(7, m.cluster_bones[8]);
            m.clusters[4].cluster_bone_count = 2;
            m.clusters[5..].iter_mut().for_each(|cluster| cluster.cluster_bone_first += 1);
        }
        => at!(ClusterBones, 7, ClusterTrackUnused { track: 2 }),
    boxes_of_tracks_are_finite:
        |m| m.cluster_bones[6].bounds.max[0] = f32::NAN => at!(ClusterBones, 6, NotFinite { field: "bounds", .. }),
    boxes_of_tracks_contain_every_lattice_coordinate:
        |m| m.cluster_bones[6].bounds.max[1] -= 1.0
        => at!(KeyVertices, 3, OutsideBox { field: "stored numbers", axis: 1, box_row: 6, .. }),
    boxes_of_tracks_contain_the_least_lattice_coordinate:
        |m| m.cluster_bones[6].bounds.min[1] += 1.0
        => at!(KeyVertices, 3, OutsideBox { field: "stored numbers", axis: 1, box_row: 6, .. }),
    boxes_of_tracks_contain_raw_positions:
        |m| m.cluster_bones[5].bounds.max[0] = 1.1f32.next_down()
        => at!(KeyVertices, 1, OutsideBox { axis: 0, found: 1.1, box_row: 5, .. }),
    boxes_of_tracks_contain_raw_positions_in_every_key:
        |m| m.cluster_bones[12].bounds.max[1] = 1.75
        => at!(KeyVertices, 11, OutsideBox { axis: 1, found: 2.0, box_row: 12, .. }),
    boxes_of_tracks_hold_for_each_cluster_anew:
        |m| m.cluster_bones[11].bounds.max[0] = m.cluster_bones[11].bounds.min[0]
        => at!(KeyVertices, 10, OutsideBox { axis: 0, box_row: 11, .. }),

    frame_channels_have_a_cache:
        |m| m.channels[4].target = 2 => at!(Channels, 4, IndexOutOfRange { field: "target", found: 2, limit: 2 }),
    frame_width_is_one:
        |m| m.channels[4].width = 3 => at!(Channels, 4, Count { field: "width", found: 3, expected: 1 }),
    a_cache_is_moved_once_per_clip:
        |m| m.channels[3] = m.channels[4] => at!(Channels, 4, RepeatedChannel),
}

fn without_caches(m: &mut Model) {
    m.caches.clear();
    for part in &mut m.parts[2..] {
        part.class = MotionClass::Rigid as u32;
        part.cache = NONE;
    }
}
