use super::colour::{Colour, decode, distinct};
use restpose_formats::ModelView;

/// Colours of parts in a shaded picture; parts beyond the last begin again.
const PART_COLOURS: [[u8; 3]; 6] = [
    [222, 190, 152],
    [158, 182, 190],
    [196, 150, 134],
    [176, 186, 142],
    [188, 168, 190],
    [204, 196, 176],
];

/// What no cluster holds: triangles without area, which no ray meets.
const NO_CLUSTER: Colour = Colour::splat(0.5);

/// A colour per triangle, by the part that it belongs to.
pub fn by_part(model: &ModelView<'_>) -> Vec<Colour> {
    let mut colours = vec![NO_CLUSTER; model.triangles.len()];
    for (part, srgb) in model.parts.iter().zip(PART_COLOURS.iter().cycle()) {
        let end = part.triangle_first.saturating_add(part.triangle_count);
        if let Some(own) = colours.get_mut(part.triangle_first as usize..end as usize) {
            own.fill(decode(*srgb));
        }
    }
    colours
}

/// A colour per cluster row: by its bone, or by its place among the clusters that share a vertex cache with it in time.
///
/// Clusters that count in the same frame differ, and those of one cache have the same colours in every time segment.
pub fn of_clusters(model: &ModelView<'_>) -> Vec<Colour> {
    let mut colours: Vec<Colour> = model.clusters.iter().map(|cluster| distinct(cluster.bone)).collect();
    let mut taken = model.bones.len() as u32;
    for cache in model.caches {
        let segments = rows(model.segments, cache.segment_first, cache.segment_count);
        for segment in segments {
            let first = segment.cluster_first as usize;
            let own = colours.iter_mut().skip(first).take(segment.cluster_count as usize);
            own.zip(taken..).for_each(|(colour, number)| *colour = distinct(number));
        }
        let most = segments.iter().map(|segment| segment.cluster_count).max();
        taken = taken.saturating_add(most.unwrap_or(0));
    }
    colours
}

/// A colour per triangle, by the cluster that holds it in a frame.
///
/// `of_clusters` is as [`of_clusters`] gives it, `active` the rows of the frame's clusters.
pub fn by_cluster(model: &ModelView<'_>, of_clusters: &[Colour], active: impl Iterator<Item = u32>) -> Vec<Colour> {
    let mut colours = vec![NO_CLUSTER; model.triangles.len()];
    for number in active.map(|row| row as usize) {
        let (Some(cluster), Some(colour)) = (model.clusters.get(number), of_clusters.get(number)) else {
            continue;
        };
        for triangle in rows(model.references, cluster.reference_first, cluster.reference_count) {
            if let Some(own) = colours.get_mut(*triangle as usize) {
                *own = *colour;
            }
        }
    }
    colours
}

fn rows<T>(section: &[T], first: u32, count: u32) -> &[T] {
    section
        .get(first as usize..first.saturating_add(count) as usize)
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use restpose_formats::{
        Model,
        geom::Aabb,
        rows::{BoneRow, CacheRow, ClusterRow, NONE, SegmentRow, TriangleRow},
    };

    /// A cluster of one triangle.
    fn cluster(triangle: u32, track: u32) -> ClusterRow {
        ClusterRow {
            bone: 0,
            node_first: 0,
            node_count: 1,
            reference_first: triangle,
            reference_count: 1,
            cluster_bone_first: 0,
            cluster_bone_count: 0,
            triangle_count: 1,
            bounds_local: Aabb::EMPTY,
            track,
            reserved: 0,
        }
    }

    fn segment(cluster_first: u32, cluster_count: u32) -> SegmentRow {
        SegmentRow {
            key_first: 0,
            key_count: 2,
            track_first: 0,
            track_count: 1,
            cluster_first,
            cluster_count,
            key_vertex_first: 0,
            word_first: 0,
            words_per_key: 0,
        }
    }

    fn cache(segment_first: u32, segment_count: u32) -> CacheRow {
        CacheRow {
            part: 0,
            bone: 0,
            key_count: 3,
            segment_first,
            segment_count,
            position_error: 0.0,
            reserved: [0; 2],
        }
    }

    /// Five triangles: one that no cache moves, two of a cache with two segments in which they change places, one of
    /// another cache, one without area.
    fn model() -> Model {
        let root = BoneRow {
            node: NONE,
            source_skin: NONE,
            source_joint: NONE,
            reserved: 0,
            inverse_bind: [0.0; 12],
        };
        Model {
            bones: vec![root],
            triangles: vec![TriangleRow { corners: [0; 3] }; 5],
            references: (0..4).collect(),
            clusters: vec![
                cluster(0, NONE),
                cluster(1, 0),
                cluster(2, 1),
                cluster(2, 2),
                cluster(1, 3),
                cluster(3, 4),
            ],
            segments: vec![segment(1, 2), segment(3, 2), segment(5, 1)],
            caches: vec![cache(0, 2), cache(2, 1)],
            ..Model::default()
        }
    }

    #[test]
    fn each_time_segment_shows_its_own_clusters_by_the_same_colours() {
        let model = model();
        let view = model.view();
        let of_clusters = of_clusters(&view);
        let early = by_cluster(&view, &of_clusters, [0, 1, 2, 5].into_iter());
        let late = by_cluster(&view, &of_clusters, [0, 3, 4, 5].into_iter());
        let [a, b, c, d] = [0, 1, 2, 3].map(|triangle: usize| early[triangle]);
        assert_eq!(early, [a, b, c, d, NO_CLUSTER]);
        assert_eq!(late, [a, c, b, d, NO_CLUSTER], "the two have changed places");
    }

    #[test]
    fn clusters_of_one_moment_differ() {
        let model = model();
        let view = model.view();
        let shown = by_cluster(&view, &of_clusters(&view), [0, 1, 2, 5].into_iter());
        for (place, colour) in shown.iter().enumerate() {
            assert!(!shown[..place].contains(colour), "{shown:?}");
        }
    }
}
