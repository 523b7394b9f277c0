//! Boxes at keys hold at every time between them, and most would not two steps further in.

use restpose_bake::{
    BakeSettings, DecomposeSettings, NoProgress, bake,
    import::{Animation, ImportSettings, import_files},
};
use restpose_formats::{
    Model, ModelView,
    rows::{CacheRow, ClusterRow, SegmentRow},
};
use restpose_tests::{
    CacheRecipe, Motion,
    key_box_escapes::{PassedSide, SegmentTime, passed_sides},
    random_cache,
};
use std::collections::BTreeSet;

fn baked(animation: &Animation, size_worth: f64) -> Model {
    let settings = BakeSettings {
        size_worth,
        segments: 3,
        rays_per_frame: 0.0,
        motion: DecomposeSettings {
            max_clusters: 3,
            ..DecomposeSettings::default()
        },
        ..BakeSettings::default()
    };
    bake(animation, &settings, &NoProgress).expect("a scene").model
}

fn animation(seed: u64, frames: usize, motions: &'static [Motion]) -> Animation {
    random_cache(&CacheRecipe {
        seed,
        frames,
        parts: 1,
        pieces: 2,
        points: 12,
        bridges: 6,
        motions,
        residual: 0.05,
        offset: 0.0,
        moving_nodes: false,
        scale: 1.0,
    })
}

fn goose() -> Animation {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../samples/scenes");
    let inputs = ["goose.obj", "goose.pc2"].map(|name| folder.join(name));
    let imported = import_files(&inputs, &ImportSettings::default());
    imported.expect("a sample").animation
}

/// Clusters that have boxes at keys.
fn keyed<'a>(model: &ModelView<'a>) -> Vec<(&'a CacheRow, &'a SegmentRow, &'a ClusterRow)> {
    let mut out = Vec::new();
    for cache in model.caches {
        for segment in &model.segments[cache.segment_first as usize..][..cache.segment_count as usize] {
            let clusters = &model.clusters[segment.cluster_first as usize..][..segment.cluster_count as usize];
            let has_boxes = |cluster: &&ClusterRow| model.tracks[cluster.track as usize].box_interval > 0;
            out.extend(
                clusters
                    .iter()
                    .filter(has_boxes)
                    .map(|cluster| (cache, segment, cluster)),
            );
        }
    }
    out
}

/// Sides that are passed at any of the times between every so many keys, but for those in cut intervals, and how many clusters
/// were looked at: that have boxes at every key, and at fewer.
fn passed(model: &ModelView, keys: usize, times: &[f32]) -> (BTreeSet<(u32, PassedSide)>, [usize; 2]) {
    let (mut out, mut looked) = (BTreeSet::new(), [0; 2]);
    for (cache, segment, cluster) in keyed(model) {
        let track = &model.tracks[cluster.track as usize];
        looked[usize::from(track.box_interval > 1)] += 1;
        for key in (0..segment.key_count - 1).step_by(keys) {
            if model.keys[(track.key_first + key) as usize].is_cut() {
                continue;
            }
            for weight in times {
                let time = SegmentTime { key, weight: *weight };
                let sides = passed_sides(model, (cache, segment), cluster, time);
                out.extend(sides.into_iter().map(|side| (key, side)));
            }
        }
    }
    (out, looked)
}

#[test]
fn what_is_below_a_box_is_in_it_at_every_time() {
    let (mut looked, mut in_segments) = (0, 0);
    for seed in 0..14 {
        for (motion, frames) in Motion::ALL.chunks(1).zip([7, 10, 5, 12].iter().cycle()) {
            for size_worth in [0.0, 0.3, 1.0] {
                let model = baked(&animation(seed, *frames, motion), size_worth);
                let (sides, found) = passed(&model.view(), 1, &[0.0, 1.0 / 3.0, 0.5, 0.875, 1.0]);
                assert!(
                    sides.is_empty(),
                    "seed {seed}, {motion:?}, worth {size_worth}: {sides:?}"
                );
                looked += found[0];
                if model.segments.len() > 1 {
                    in_segments += found[0];
                }
            }
        }
    }
    assert!(
        looked > 300 && in_segments > 30,
        "{looked}, {in_segments} of them in one of several segments"
    );
}

/// Smooth motion, where the way between two of these boxes passes keys.
#[test]
fn what_is_below_boxes_at_fewer_keys_is_in_them() {
    let mut looked = 0;
    for size_worth in [0.5, 1.0] {
        let model = baked(&goose(), size_worth);
        let (sides, found) = passed(&model.view(), 5, &[0.4]);
        assert!(sides.is_empty(), "worth {size_worth}: {sides:?}");
        looked += found[1];
    }
    assert!(looked >= 4, "{looked}");
}

/// Of motion that bends little between keys, most sides are no more than two steps further out than they need be.
#[test]
fn sides_further_in_are_passed() {
    const KEYS: usize = 20;
    let mut model = baked(&goose(), 0.0);
    for row in &mut model.key_boxes {
        row.min
            .as_flattened_mut()
            .iter_mut()
            .for_each(|q| *q = q.saturating_add(2));
        row.max
            .as_flattened_mut()
            .iter_mut()
            .for_each(|q| *q = q.saturating_sub(2));
    }
    let view = model.view();
    let (found, _) = passed(&view, KEYS, &[0.0]);
    let mut all = 0;
    for (_, segment, cluster) in keyed(&view) {
        let nodes = &view.wide_nodes[cluster.node_first as usize..][..cluster.node_count as usize];
        let places: usize = nodes.iter().map(|node| node.children().count()).sum();
        all += 6 * places * (segment.key_count as usize - 1).div_ceil(KEYS);
    }
    assert!(all > 10_000 && 2 * found.len() > all, "{} of {all}", found.len());
}
