use super::report::{CachedPart, ClusteringSeconds, Growth, MotionSegment};
use restpose_bake::{BakeReport, DecomposeReport, PartReport, SegmentReport};
use std::ops::AddAssign;

/// The parts with a vertex cache.
pub(super) fn cached_parts(report: &BakeReport) -> Vec<CachedPart> {
    let part = |part: &PartReport| {
        let cache = part.cache.as_ref()?;
        Some(CachedPart {
            name: part.name.clone(),
            class: part.class.name(),
            reason: part.reason.clone(),
            keys: cache.keys,
            position_error: cache.position_error,
            bytes_per_vertex_key: cache.bytes_per_vertex_key,
            bytes: cache.bytes,
            bytes_one_segment: cache.bytes_one_segment,
            expected_cost: cache.expected_cost,
            expected_cost_one_segment: cache.expected_cost_one_segment,
            expected_cost_rebuilt: cache.expected_cost_rebuilt,
            segments: cache.segments.iter().map(segment).collect(),
        })
    };
    report.parts.iter().filter_map(part).collect()
}

/// Seconds of the stages of clustering over all segments. Segments that share clusters were clustered once: their
/// reports are the same, times included.
pub(super) fn clustering_seconds(report: &BakeReport) -> ClusteringSeconds {
    let caches = report.parts.iter().filter_map(|part| part.cache.as_ref());
    let mut sum = ClusteringSeconds::default();
    for cache in caches {
        let mut counted: Vec<&DecomposeReport> = Vec::new();
        for found in cache.segments.iter().map(|segment| &segment.decomposition) {
            if !counted.contains(&found) {
                counted.push(found);
                sum += stages(found);
            }
        }
    }
    sum
}

fn stages(found: &DecomposeReport) -> ClusteringSeconds {
    let seconds = &found.seconds;
    ClusteringSeconds {
        components: seconds.components,
        rest: seconds.rest,
        relax: seconds.relax,
        refine: seconds.refine,
        axes: seconds.axes,
    }
}

fn segment(segment: &SegmentReport) -> MotionSegment {
    let steps = segment.decomposition.steps.iter();
    MotionSegment {
        key_first: segment.key_first,
        key_last: segment.key_last,
        clusters: segment.clusters,
        rest_frame: segment.rest_key,
        expected_cost: segment.expected_cost,
        fuzzy_box_area: segment.fuzzy_box_area,
        clustering_seconds: stages(&segment.decomposition)
            .entries()
            .iter()
            .map(|(_, seconds)| seconds)
            .sum(),
        growth: steps
            .map(|step| Growth {
                clusters: step.clusters,
                residual: step.residual,
                fuzzy_box_area: step.fuzzy_box_area,
                cost: step.cost,
            })
            .collect(),
    }
}

/// The mean over some clusterings. One that stopped early counts as it was in the end.
pub(super) fn mean_growth<'a>(all: impl Iterator<Item = &'a [Growth]>) -> Vec<Growth> {
    let all: Vec<&[Growth]> = all.filter(|steps| !steps.is_empty()).collect();
    let longest = all.iter().map(|steps| steps.len()).max().unwrap_or(0);
    let mean = |place: usize| {
        let here = || all.iter().map(|steps| &steps[place.min(steps.len() - 1)]);
        let mean = |of: fn(&Growth) -> f64| here().map(of).sum::<f64>() / all.len() as f64;
        Growth {
            clusters: here().map(|step| step.clusters).max().unwrap_or(0),
            residual: mean(|step| step.residual),
            fuzzy_box_area: mean(|step| step.fuzzy_box_area),
            cost: mean(|step| step.cost),
        }
    };
    (0..longest).map(mean).collect()
}

impl AddAssign for ClusteringSeconds {
    fn add_assign(&mut self, other: Self) {
        self.components += other.components;
        self.rest += other.rest;
        self.relax += other.relax;
        self.refine += other.refine;
        self.axes += other.axes;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(areas: &[f64]) -> Vec<Growth> {
        let step = |(place, area): (usize, &f64)| Growth {
            clusters: place + 1,
            residual: area / 8.0,
            fuzzy_box_area: *area,
            cost: area * 2.0,
        };
        areas.iter().enumerate().map(step).collect()
    }

    #[test]
    fn clusterings_that_stop_early_count_as_they_ended() {
        let (long, short) = (steps(&[8.0, 4.0, 2.0]), steps(&[6.0, 2.0]));
        let mean = mean_growth([long.as_slice(), &short, &[]].into_iter());
        assert_eq!(mean, steps(&[7.0, 3.0, 2.0]));
        assert_eq!(mean_growth(std::iter::empty()), []);
    }
}
