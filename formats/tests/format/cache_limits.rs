//! Vertex caches that keep every rule but barely, or at great length.

use crate::fixture::model;
use restpose_formats::{
    rows::{ClipRow, ClusterRow, KeyVertexRow, MotionClass, ReferenceBoxRow, SegmentRow, TriangleRow},
    write,
};

#[test]
fn lattice_coordinates_and_widths_at_their_limits_are_accepted() {
    let mut m = model();
    // The last vertex, which belongs to no triangle with area: its records have no bits, so that any base fits.
    m.key_vertices[12].base = [-(1 << 24), 1 << 24, 0];
    assert!(write(&m).is_ok());
    m.key_vertices[12].base[2] = (1 << 24) - (1 << 21) + 1;
    m.key_vertices[12].widths[2] = 21;
    // Its record is the last of each of two keys, and begins with bit 14 of the last of seven words.
    assert_eq!(
        (m.key_vertices[12].bit_first, m.segments[2].words_per_key),
        (6 * 32 + 14, 7)
    );
    m.segments[2].words_per_key = 8;
    let first = m.segments[2].word_first as usize;
    for end in [first + 14, first + 7] {
        m.key_words[end - 1] |= u32::MAX << 14;
        m.key_words.insert(end, 0b111);
    }
    assert!(write(&m).is_ok());
    m.key_vertices[12].base[2] += 1;
    assert!(write(&m).is_err());
}

#[test]
fn a_rigid_part_may_have_a_cache() {
    let mut m = model();
    m.parts[2].class = MotionClass::Rigid as u32;
    assert!(write(&m).is_ok());
}

#[test]
fn a_morph_set_and_a_cache_of_the_same_number_move_in_one_clip() {
    let mut m = model();
    m.channels[4].target = m.channels[2].target;
    m.clips[0].channel_count = 5;
    let none = ClipRow {
        start_seconds: 0.0,
        end_seconds: 0.0,
        channel_first: 5,
        channel_count: 0,
    };
    m.clips[1] = none;
    assert!(write(&m).is_ok());
}

#[test]
fn segments_without_clusters_do_not_cost_as_much_as_their_part_has_triangles() {
    // Looking at each triangle in each segment would take 2^36 steps.
    const COUNT: u32 = 1 << 18;
    let mut m = model();
    m.triangles.truncate(6);
    m.triangles.extend((0..COUNT).map(|_| TriangleRow { corners: [9; 3] }));
    m.triangles.push(TriangleRow { corners: [14; 3] });
    m.meta.degenerate_triangle_count = COUNT + 2;
    for (row, count) in [(2, COUNT), (3, 1)] {
        m.parts[row].triangle_count = count;
        m.primitives[row + 1].triangle_count = count;
    }
    m.parts[3].triangle_first = 6 + COUNT;
    m.primitives[4].triangle_first = 6 + COUNT;
    m.clusters.truncate(3);
    m.cluster_bones.truncate(5);
    m.kd_nodes.truncate(5);
    m.references.truncate(6);
    m.reference_boxes.truncate(6);
    m.keys.clear();
    m.tracks.truncate(1);
    m.segments.truncate(1);
    (m.segments[0].cluster_count, m.segments[0].words_per_key) = (0, 0);
    m.key_vertices.truncate(3);
    m.key_words = vec![0; 4];
    m.caches[1].key_count = COUNT + 1;
    m.caches[1].segment_count = COUNT;
    for key in 0..COUNT {
        let (track, vertex) = (m.tracks.len() as u32, m.key_vertices.len() as u32);
        m.segments.push(SegmentRow {
            key_first: key,
            key_count: 2,
            track_first: track,
            cluster_first: 3,
            key_vertex_first: vertex,
            ..m.segments[0]
        });
        m.tracks.push(m.tracks[0]);
        m.key_vertices.extend(
            [KeyVertexRow {
                track,
                ..m.key_vertices[0]
            }; 5],
        );
    }
    for row in &mut m.key_vertices {
        (row.raw, row.bit_first) = (0, 0);
    }
    assert_eq!(write(&m).err(), None);
}

#[test]
fn keys_without_words_cost_nothing_however_many_there_are() {
    // All vertices stay at one place, in so many keys that looking at each would take seconds.
    let mut m = model();
    m.caches[0].key_count = u32::MAX;
    let segment = &mut m.segments[0];
    (segment.key_count, segment.words_per_key) = (u32::MAX, 0);
    for vertex in &mut m.key_vertices[..3] {
        (vertex.raw, vertex.bit_first) = (0, 0);
    }
    m.key_words.drain(..9);
    for segment in &mut m.segments[1..] {
        segment.word_first -= 9;
    }
    (m.cluster_bones[5].bounds.min, m.cluster_bones[5].bounds.max) = ([0.0; 3], [0.0; 3]);
    assert_eq!(write(&m).err(), None);
}

#[test]
fn a_long_vertex_in_many_clusters_is_looked_at_once() {
    // Its words once per cluster would take 2^34 steps.
    const COUNT: u32 = 1 << 17;
    let mut m = model();
    m.caches[0].key_count = COUNT;
    m.segments[0].key_count = COUNT;
    m.key_words.splice(0..9, vec![2.0f32.to_bits(); 9 * COUNT as usize]);
    for segment in &mut m.segments[1..] {
        segment.word_first += 9 * (COUNT - 1);
    }
    m.triangles.splice(9.., vec![m.triangles[9]; COUNT as usize]);
    m.parts[3].triangle_count = COUNT;
    m.primitives[4].triangle_count = COUNT;
    m.cluster_bones[5].bounds.min = [2.0; 3];
    m.cluster_bones[5].bounds.max = [2.0; 3];
    let more = COUNT - 1;
    m.segments[0].cluster_count = COUNT;
    for segment in &mut m.segments[1..] {
        segment.cluster_first += more;
    }
    for cluster in &mut m.clusters[4..] {
        cluster.reference_first += more;
        cluster.cluster_bone_first += more;
    }
    let first = m.clusters[3];
    let clusters = (0..COUNT).map(|at| ClusterRow {
        reference_first: first.reference_first + at,
        cluster_bone_first: first.cluster_bone_first + at,
        ..first
    });
    m.clusters.splice(3..4, clusters);
    m.cluster_bones.splice(5..6, vec![m.cluster_bones[5]; COUNT as usize]);
    m.references.splice(6..7, 9..9 + COUNT);
    m.reference_boxes
        .splice(6..7, vec![ReferenceBoxRow::default(); COUNT as usize]);
    assert_eq!(write(&m).err(), None);
}
