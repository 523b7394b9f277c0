//! The figures by which fuzzy trees and a hierarchy built in every frame are compared.

use super::segment::{PartKeys, Segment};
use crate::cost::FuzzyTrees;
use restpose_formats::geom::Aabb;
use restpose_runtime::build::{Bvh, BvhSettings, CheckedBoxes, StreamedBvh};

/// Keys for which a hierarchy over posed triangles is built, to compare with.
const COMPARED_KEYS: usize = 5;

/// What tracing the part's segments takes, mean over the key intervals.
pub(super) fn fuzzy_trees(segments: &[Segment]) -> FuzzyTrees {
    let mut out = FuzzyTrees {
        cost: 0.0,
        clusters: 0.0,
        rebuilt_triangles: 0.0,
    };
    let mut all = 0.0;
    for segment in segments {
        let intervals = segment.keys.end() - segment.keys.start();
        let weight = intervals.max(1) as f64;
        all += weight;
        out.cost += segment.cost * weight;
        out.clusters += segment.clusters.len() as f64 * weight;
        for cluster in &segment.clusters {
            let cut = (0..intervals).filter(|key| cluster.track.is_cut(*key)).count();
            out.rebuilt_triangles += (cut * cluster.triangles.len()) as f64;
        }
    }
    FuzzyTrees {
        cost: out.cost / all,
        clusters: out.clusters / all,
        rebuilt_triangles: out.rebuilt_triangles / all,
    }
}

/// Expected cost through the hierarchy that the runtime would build over the posed triangles, mean over a few keys.
pub(super) fn rebuilt_cost(keys: &PartKeys) -> f64 {
    let count = keys.frames.len().min(COMPARED_KEYS);
    let mut builder = StreamedBvh::default();
    let mut tree = Bvh::default();
    let mut cost = |place: usize| {
        let frame = &keys.frames[place * keys.frames.len() / count];
        let boxes: Vec<Aabb> = keys
            .triangles
            .iter()
            .map(|triangle| Aabb::around(triangle.map(|corner| frame[corner as usize])))
            .collect();
        match CheckedBoxes::new(&boxes) {
            Ok(boxes) => builder.build(boxes, &BvhSettings::default(), &mut tree),
            // Positions are finite, and rows of 32 bits count the triangles: there are none.
            Err(_) => tree.clear(),
        }
        tree.sah_cost(&BvhSettings::default())
    };
    (0..count).map(&mut cost).sum::<f64>() / count as f64
}
