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

#[cfg(test)]
mod tests {
    use super::*;
    use restpose_bake::{
        BakeSettings, DecomposeSettings, NoProgress, SegmentSettings, bake,
        import::{ImportSettings, import_obj_bytes},
    };
    use restpose_runtime::{Asset, Scene};
    use std::sync::Arc;

    const FRAMES: u8 = 9;
    /// Columns of two points; between neighbours there are two triangles.
    const COLUMNS: u8 = 7;

    /// A strip that bends beside another one that bends the other way, in two time segments.
    fn two_strips() -> Arc<Asset> {
        let mut obj = String::new();
        let mut cache = b"POINTCACHE2\0".to_vec();
        cache.extend([1, 4 * i32::from(COLUMNS)].map(i32::to_le_bytes).concat());
        cache.extend([0.0, 1.0].map(f32::to_le_bytes).concat());
        cache.extend(i32::from(FRAMES).to_le_bytes());
        for frame in 0..FRAMES {
            for (x, y, side) in points() {
                let point = [x, y, side * x * x * (f32::from(frame) - 4.0) * 0.1];
                cache.extend(point.map(f32::to_le_bytes).concat());
            }
        }
        for (x, y, _) in points() {
            obj += &format!("v {x} {y} 0\n");
        }
        for (strip, first) in [("left", 1), ("right", 1 + 2 * COLUMNS)] {
            obj += &format!("o {strip}\n");
            for corner in (0..COLUMNS - 1).map(|column| first + 2 * column) {
                obj += &format!("f {corner} {} {} {}\n", corner + 2, corner + 3, corner + 1);
            }
        }
        let (mesh, cache) = (("strips.obj", obj.as_bytes()), Some(("strips.pc2", cache.as_slice())));
        let imported = import_obj_bytes(mesh, cache, &ImportSettings::default()).expect("a sound source");
        let settings = BakeSettings {
            motion: DecomposeSettings {
                max_clusters: 2,
                ..DecomposeSettings::default()
            },
            segments: SegmentSettings { most: 2, worth: 0.0 },
            rays_per_frame: 0.0,
            ..BakeSettings::default()
        };
        let baked = bake(&imported.animation, &settings, &NoProgress).expect("a sound scene");
        let bytes = restpose_formats::write(&baked.model).expect("a sound model");
        Arc::new(Asset::from_bytes(&bytes).expect("a sound file"))
    }

    fn points() -> impl Iterator<Item = (f32, f32, f32)> {
        [(0.0, 1.0), (4.0, -1.0)].into_iter().flat_map(|(place, side)| {
            (0..2 * COLUMNS).map(move |point| (f32::from(point / 2), place + f32::from(point % 2), side))
        })
    }

    #[test]
    fn each_time_segment_shows_its_own_clusters_in_the_same_colours() {
        let asset = two_strips();
        let model = asset.model();
        assert!(
            model.caches.iter().all(|cache| cache.segment_count == 2),
            "{:?}",
            model.caches
        );
        let of_clusters = of_clusters(model);
        let mut scene = Scene::new();
        let strips = scene.add(&asset);
        let mut seen = Vec::new();
        for frame in [0.0, f64::from(FRAMES) - 1.0] {
            scene.set_cache_frames(strips, &[frame; 2]).expect("two caches");
            let colours = by_cluster(model, &of_clusters, &scene.commit());
            assert_eq!(colours.len(), model.triangles.len());
            assert!(
                !colours.contains(&NO_CLUSTER),
                "every triangle is in a cluster of every segment"
            );
            let mut shown = Vec::new();
            colours.iter().for_each(|colour| {
                if !shown.contains(colour) {
                    shown.push(*colour);
                }
            });
            shown.sort_by(|a, b| a.to_array().partial_cmp(&b.to_array()).expect("colours are finite"));
            assert_eq!(shown.len(), 4, "two clusters of each strip");
            seen.push(shown);
        }
        assert_eq!(seen[0], seen[1]);
    }
}
