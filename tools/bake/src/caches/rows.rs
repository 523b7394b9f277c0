use super::{
    segment::{Segment, SegmentCluster},
    stored_positions::{Home, StoredPositions},
};
use crate::{BakeError, assemble::row_count};
use restpose_formats::{
    Model, TreeKind,
    geom::Aabb,
    rows::{
        CacheRow, ClusterBoneRow, ClusterRow, KeyRow, KeyVertexRow, NONE, PartRow, ReferenceBoxRow, SegmentRow,
        TrackRow,
    },
};

/// The track without keys: local space is the cache's own.
const OWN_SPACE: TrackRow = TrackRow {
    key_first: NONE,
    origin: [0.0; 3],
    step: 1.0,
    box_first: 0,
    box_interval: 0,
    reserved: 0,
};

/// A cache whose part is in coherent motion. `triangles` are the triangle rows that the segments' numbers stand for.
pub(super) fn add_coherent(
    model: &mut Model,
    cache: usize,
    segments: &[Segment],
    triangles: &[u32],
) -> Result<(), BakeError> {
    model.caches[cache].segment_first = row_count("segments", model.segments.len())?;
    model.caches[cache].segment_count = row_count("segments", segments.len())?;
    for segment in segments {
        add_segment(model, cache, segment, triangles)?;
    }
    Ok(())
}

fn add_segment(model: &mut Model, cache: usize, segment: &Segment, triangles: &[u32]) -> Result<(), BakeError> {
    let own_space = u32::from(segment.stored.has_raw());
    let cluster_count = row_count("clusters", segment.clusters.len())?;
    let track_first = row_count("tracks", model.tracks.len())?;
    let key_count = row_count("keys", segment.keys.end() - segment.keys.start() + 1)?;
    model.segments.push(SegmentRow {
        key_first: row_count("keys", *segment.keys.start())?,
        key_count,
        track_first,
        track_count: cluster_count + own_space,
        cluster_first: row_count("clusters", model.clusters.len())?,
        cluster_count,
        key_vertex_first: row_count("key vertices", model.key_vertices.len())?,
        word_first: row_count("key words", model.key_words.len())?,
        words_per_key: segment.stored.words_per_key,
    });
    add_positions(model, &segment.stored, track_first)?;
    let keys = || (0..key_count as usize).map(|key| segment.stored.key_words(key));
    let rows = segment.stored.rows.iter();
    let stored: Vec<Aabb> = rows.map(|row| row.bounds(keys())).collect();
    for (index, cluster) in (0u32..).zip(&segment.clusters) {
        model.tracks.push(TrackRow {
            key_first: row_count("keys", model.keys.len())?,
            origin: [0.0; 3],
            step: Some(segment.stored.steps[index as usize])
                .filter(|step| *step > 0.0)
                .unwrap_or(1.0),
            box_first: row_count("boxes at keys", model.key_boxes.len())?,
            box_interval: cluster.key_boxes.interval,
            reserved: 0,
        });
        model.key_boxes.extend_from_slice(&cluster.key_boxes.rows);
        for (key, (map, bounds)) in cluster.track.maps().iter().zip(&cluster.key_bounds).enumerate() {
            model.keys.push(KeyRow {
                map: bytemuck::cast(map.columns),
                bounds: *bounds,
                flags: u32::from(cluster.track.is_cut(key)) * KeyRow::CUT,
                reserved: 0,
            });
        }
        let bones = cluster_bones(segment, cluster, track_first, &stored);
        let mut row = ClusterRow {
            bone: model.caches[cache].bone,
            node_first: 0,
            node_count: 0,
            reference_first: 0,
            reference_count: 0,
            cluster_bone_first: row_count("cluster bones", model.cluster_bones.len())?,
            cluster_bone_count: row_count("cluster bones", bones.len())?,
            triangle_count: row_count("triangles", cluster.triangles.len())?,
            bounds_local: Aabb::EMPTY,
            track: track_first + index,
            reserved: 0,
        };
        let triangle = |place: u32| triangles[cluster.triangles[place as usize] as usize];
        cluster.tree.add_rows(model, &cluster.boxes, triangle, &mut row)?;
        model.clusters.push(row);
        model.cluster_bones.extend(bones);
    }
    if own_space > 0 {
        model.tracks.push(OWN_SPACE);
    }
    Ok(())
}

/// Adds a segment's key vertices and words.
fn add_positions(model: &mut Model, stored: &StoredPositions, track_first: u32) -> Result<(), BakeError> {
    let rows = stored.rows.iter().map(|row| KeyVertexRow {
        track: track_first + row.track,
        ..*row
    });
    row_count("key vertices", model.key_vertices.len() + rows.len())?;
    row_count("key words", model.key_words.len() + stored.words().len())?;
    model.key_vertices.extend(rows);
    model.key_words.extend_from_slice(stored.words());
    Ok(())
}

/// The tracks that move the cluster's vertices, ascending, with the box of what they move.
fn cluster_bones(
    segment: &Segment,
    cluster: &SegmentCluster,
    track_first: u32,
    stored: &[Aabb],
) -> Vec<ClusterBoneRow> {
    let mut boxes = vec![Aabb::EMPTY; segment.clusters.len() + 1];
    for vertex in &cluster.vertices {
        let track = segment.stored.rows[*vertex as usize].track;
        let bounds = &mut boxes[track as usize];
        *bounds = bounds.union(stored[*vertex as usize]);
    }
    let moved = (0u32..).zip(boxes).filter(|(_, bounds)| !bounds.is_empty());
    let row = |(track, bounds)| ClusterBoneRow {
        bone: track_first + track,
        bounds,
        reserved: 0,
    };
    moved.map(row).collect()
}

/// A cache whose part is in free motion: positions as they are, and one list of triangles.
pub(super) fn add_free<F: AsRef<[[f32; 3]]> + Sync>(
    model: &mut Model,
    cache: usize,
    frames: &[F],
    triangles: &[u32],
    tree: TreeKind,
) -> Result<(), BakeError> {
    let CacheRow {
        bone, key_count, part, ..
    } = model.caches[cache];
    let PartRow {
        vertex_first,
        vertex_count,
        ..
    } = model.parts[part as usize];
    let stored = StoredPositions::new(frames, &[], &vec![Home::Raw; vertex_count as usize], 0.0)?;
    let track = row_count("tracks", model.tracks.len())?;
    model.caches[cache].segment_first = row_count("segments", model.segments.len())?;
    model.caches[cache].segment_count = 1;
    model.segments.push(SegmentRow {
        key_first: 0,
        key_count,
        track_first: track,
        track_count: 1,
        cluster_first: row_count("clusters", model.clusters.len())?,
        cluster_count: u32::from(!triangles.is_empty()),
        key_vertex_first: row_count("key vertices", model.key_vertices.len())?,
        word_first: row_count("key words", model.key_words.len())?,
        words_per_key: stored.words_per_key,
    });
    model.tracks.push(OWN_SPACE);
    add_positions(model, &stored, track)?;
    let corners = triangles
        .iter()
        .flat_map(|triangle| model.triangles[*triangle as usize].corners);
    let positions = corners.flat_map(|corner| {
        let vertex = (corner - vertex_first) as usize;
        frames.iter().map(move |frame| frame.as_ref()[vertex])
    });
    let bounds = Aabb::around(positions);
    if triangles.is_empty() {
        return Ok(());
    }
    let count = row_count("triangle references", triangles.len())?;
    model.clusters.push(ClusterRow {
        bone,
        node_first: row_count("tree nodes", model.kd_nodes.len() + model.wide_nodes.len())?,
        node_count: 0,
        reference_first: row_count("triangle references", model.references.len())?,
        reference_count: count,
        cluster_bone_first: row_count("cluster bones", model.cluster_bones.len())?,
        cluster_bone_count: 1,
        triangle_count: count,
        bounds_local: bounds,
        track,
        reserved: 0,
    });
    model.references.extend_from_slice(triangles);
    if tree == TreeKind::Kd {
        model
            .reference_boxes
            .resize(model.references.len(), ReferenceBoxRow::default());
    }
    model.cluster_bones.push(ClusterBoneRow {
        bone: track,
        bounds,
        reserved: 0,
    });
    row_count("triangle references", model.references.len())?;
    Ok(())
}

/// Closes the section of positions, once all caches are in.
pub(super) fn close_words(model: &mut Model) -> Result<(), BakeError> {
    if !model.caches.is_empty() {
        model.key_words.extend([0; KeyVertexRow::CLOSING_WORDS]);
    }
    row_count("key words", model.key_words.len())?;
    Ok(())
}
