use super::{
    key_track::KeyTrack,
    segment::{PartKeys, Segment, SegmentOutput},
};
use crate::{BakeError, Progress, bounds::FuzzyBox, motion::keyframed::DecomposeSettings};
use rayon::prelude::*;

/// Places at which a segment is tried to be split, evenly spaced: enough to find where the motion changes.
const TRIED_PLACES: usize = 31;

/// Splits `whole` in time while that pays: each step takes the segment that costs most over its keys, splits it where the
/// boxes of both sides are smallest together, and keeps the split if the part of the cost that it saves is at least
/// [`SegmentOutput::size_worth`] times the part of bytes that it adds. Until then all segments have the clusters of `whole`;
/// at last each gets clusters of its own, which is where most is gained (CHICKEN in 8 segments, primary rays: 5.8
/// triangle tests per ray with the clusters of the whole, 1.7 with its own), but takes as long as decomposing the whole.
///
/// Where nodes have boxes at keys, to split saves next to nothing: none of COW, HORSE and CHICKEN is split even where bytes are
/// worth nothing.
///
/// Günther wished for clustering in time as well as in space for animations like his CHICKEN (§3.6 of the dissertation);
/// this is ours.
pub(super) fn split_in_time(
    part: &PartKeys,
    whole: Segment,
    most: usize,
    decompose: &DecomposeSettings,
    output: SegmentOutput,
    progress: &dyn Progress,
) -> Result<Vec<Segment>, BakeError> {
    let intervals = |segment: &Segment| (segment.keys.end() - segment.keys.start()) as f64;
    let weighted_cost = |segment: &Segment| segment.cost * intervals(segment);
    let mut open = vec![(whole, true)];
    while open.len() < most {
        let candidates = open.iter().enumerate().filter(|(_, (_, may_split))| *may_split);
        let worst = candidates.max_by(|(_, (a, _)), (_, (b, _))| weighted_cost(a).total_cmp(&weighted_cost(b)));
        let Some((place, (segment, _))) = worst else {
            break;
        };
        let Some(key) = best_place(segment, part) else {
            open[place].1 = false;
            continue;
        };
        let (first, last) = (*segment.keys.start(), *segment.keys.end());
        let left = segment.over(part, first..=key, output)?;
        let right = segment.over(part, key..=last, output)?;
        let all_cost: f64 = open.iter().map(|(segment, _)| weighted_cost(segment)).sum();
        let all_bytes: u64 = open.iter().map(|(segment, _)| segment.byte_count()).sum();
        let saved = weighted_cost(segment) - weighted_cost(&left) - weighted_cost(&right);
        let added = (left.byte_count() + right.byte_count()) as f64 - segment.byte_count() as f64;
        if saved / all_cost > 0.0 && saved / all_cost >= output.size_worth * added / all_bytes as f64 {
            open[place] = (left, true);
            open.insert(place + 1, (right, true));
        } else {
            open[place].1 = false;
        }
    }
    let mut out = Vec::with_capacity(open.len());
    let several = open.len() > 1;
    for (segment, _) in open {
        if several {
            let own = Segment::new(part, segment.keys.clone(), decompose, output, progress)?;
            out.push(if own.cost < segment.cost { own } else { segment });
        } else {
            out.push(segment);
        }
    }
    Ok(out)
}

/// The key at which the boxes before and after, each times its intervals, have the least surface together.
fn best_place(segment: &Segment, part: &PartKeys) -> Option<usize> {
    let (first, last) = (*segment.keys.start(), *segment.keys.end());
    let intervals = last - first;
    if intervals < 2 {
        return None;
    }
    let mut places: Vec<usize> = (1..=TRIED_PLACES)
        .map(|place| (place * intervals / (TRIED_PLACES + 1)).clamp(1, intervals - 1))
        .collect();
    places.dedup();
    let tracks: Vec<&KeyTrack> = segment.clusters.iter().map(|cluster| &cluster.track).collect();
    let corners: Vec<(usize, [u32; 3])> = segment
        .clusters
        .iter()
        .enumerate()
        .flat_map(|(index, cluster)| {
            let corners = |triangle: &u32| part.triangles[*triangle as usize];
            cluster.triangles.iter().map(move |triangle| (index, corners(triangle)))
        })
        .collect();
    let areas: Vec<Vec<f64>> = corners
        .par_iter()
        .map(|(cluster, triangle)| {
            let at_key = |key: usize| {
                let mut bounds = FuzzyBox::EMPTY;
                for corner in triangle {
                    let position = part.frames[first + key].as_ref()[*corner as usize].map(f64::from);
                    bounds.add(tracks[*cluster].local(key, position));
                }
                bounds
            };
            let at_keys: Vec<FuzzyBox> = (0..=intervals).map(at_key).collect();
            let sum = |places: &mut dyn Iterator<Item = usize>| -> Vec<f64> {
                let mut bounds = FuzzyBox::EMPTY;
                places
                    .map(|key| {
                        bounds = bounds.union(at_keys[key]);
                        bounds.surface_area()
                    })
                    .collect()
            };
            let before = sum(&mut (0..=intervals));
            let after = sum(&mut (0..=intervals).rev());
            places
                .iter()
                .map(|place| before[*place] * *place as f64 + after[intervals - place] * (intervals - place) as f64)
                .collect()
        })
        .collect();
    let total = |place: usize| areas.iter().map(|areas| areas[place]).sum::<f64>();
    let best = (0..places.len()).min_by(|a, b| total(*a).total_cmp(&total(*b)))?;
    Some(first + places[best])
}
