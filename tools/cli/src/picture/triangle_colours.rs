use super::colour::{Colour, decode, distinct};
use restpose_formats::ModelView;
use restpose_runtime::Frame;

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

/// A colour per triangle, by the cluster that holds it in this frame. `of_clusters` as [`of_clusters`] gives it.
pub fn by_cluster(model: &ModelView<'_>, of_clusters: &[Colour], frame: &Frame<'_>) -> Vec<Colour> {
    let mut colours = vec![NO_CLUSTER; model.triangles.len()];
    for active in frame.clusters() {
        let number = active.cluster as usize;
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
