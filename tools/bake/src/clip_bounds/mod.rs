//! Where an asset is during clips: one box per stretch of a clip that holds at every time of it, so that an instance that
//! plays it is bounded without a palette, and nearly as tightly as by one.
//!
//! # Why it holds
//!
//! Notation: X = W·B takes a bone's rest space to asset space, W being the map of the bone's node and B its inverse bind
//! map; bars are entry-wise absolute values; u = 2⁻²⁴; spectral norms of linear parts, lengths of vectors. A pose's box
//! holds every mix of the images `X·p` if it holds each, for weights are not negative and sum to exactly one. So it is
//! enough to bound `X·p` for each bone, each p that it moves, and each time of a span, which no key separates.
//!
//! 1. *Rest positions.* p lies in the box of the rest positions that the bone moves, widened by each morph target's weight
//!    times its displacements, both as intervals. Weights are bounded over the span, by a cubic's ends and its curvature.
//! 2. *In between.* For a p that stays, `f(s) = X(s)·p` is twice differentiable and stays within `sup|f″|/8` of the
//!    straight way between its ends, which the box of both images of 1 holds. With q = B·p, `f″ = W″q + t″`, and its length
//!    is at most `‖W″‖·|q| + |t″|`, by norms that follow from the product rule along the skeleton ([`WorldSpan`]).
//! 3. *`f64`.* The evaluator computes W in `f64`, this module does at the ends of the span; both are off by no more than
//!    the norms' errors, which the same chain adds up. With `L = Σ|Bⱼ||pⱼ| + |b|` they move the image by at most
//!    `error·L + |error of t|`, and the products with B and with p by some roundings of `‖W‖·L + |t|`.
//! 4. *Rounding to `f32`.* A palette's entry is off by u relative to it, or by 2⁻¹⁵⁰: the image by `u·(|X||p| + |t|)` and
//!    `2⁻¹⁵⁰·(1 + Σ|pⱼ|)`.
//! 5. *Times.* The spans of a stretch, with what happens at their begins and ends, hold every time that is in it
//!    ([`mod@spans`]).
//!
//! Spans whose bounds reach out of the box around the ends of all of a stretch are halved, so what the box has beyond the
//! stretch's own motion is at most [`SLACK_PART`] of its sides; or more where a stretch has too many spans. No inverse is
//! taken: scales may pass through zero.

mod moved_bones;
mod span_box;
mod spans;

#[cfg(doc)]
use crate::poses::WorldSpan;
use crate::{Progress, poses::Span};
use moved_bones::{MovedBone, moved_bones};
use rayon::prelude::*;
use restpose_formats::{
    Model,
    geom::{
        Aabb,
        round::{f32_above, f32_below},
    },
    rows::{ClipBoundsRow, STRETCHES},
};
use span_box::{Box3, SpanBox};
use spans::{key_times, spans};

/// Part of a box's sides that the bounds of what is between the ends of spans may add on each of them.
const SLACK_PART: f64 = 1.0 / 256.0;

/// How often a span is halved at most.
const MOST_HALVINGS: u32 = 12;

/// Spans that are halved no further than they are, for a stretch has too many that would have to be.
const MOST_SPANS: usize = 512;

/// A row per stretch of each clip and one for the pose without any; none for an asset with vertex caches, which are
/// bounded by their keys.
///
/// Guarantee: the same rows on any number of threads.
///
/// Complexity: per clip, its stretches, its keys and what they are halved into, times nodes and bones; independent of the
/// triangles but for one pass over their corners.
pub(crate) fn clip_bounds(model: &Model, progress: &dyn Progress) -> Vec<ClipBoundsRow> {
    if !model.caches.is_empty() {
        return Vec::new();
    }
    let bones = moved_bones(model);
    let clip = |clip| {
        let keys = key_times(model, clip);
        let stretch = |stretch| {
            let spans = spans(&model.clips[clip], &keys, stretch);
            of_spans(model, &bones, clip, spans).unwrap_or(ClipBoundsRow::UNKNOWN)
        };
        let rows: Vec<_> = (0..STRETCHES).into_par_iter().map(stretch).collect();
        progress.advance(1);
        rows
    };
    let clips: Vec<_> = (0..model.clips.len()).into_par_iter().map(clip).collect();
    let at_rest = SpanBox::new(model, &bones, &Span::at_rest(model)).and_then(|at_rest| row(&at_rest));
    clips
        .into_iter()
        .flatten()
        .chain([at_rest.unwrap_or(ClipBoundsRow::UNKNOWN)])
        .collect()
}

/// Of a clip during some spans, at least one; `None` where nothing bounds one of them.
fn of_spans(model: &Model, bones: &[MovedBone], clip: usize, mut spans: Vec<[f64; 2]>) -> Option<ClipBoundsRow> {
    let (mut ends, mut whole) = (Box3::EMPTY, None);
    for halving in 0..=MOST_HALVINGS {
        let boxes: Vec<Option<SpanBox>> = spans
            .iter()
            .map(|[begin, end]| SpanBox::new(model, bones, &Span::of_clip(model, clip, *begin, *end)))
            .collect();
        ends = boxes.iter().flatten().fold(ends, |ends, own| ends.union(&own.ends));
        let enough = ends.widened(SLACK_PART);
        let is_last = halving == MOST_HALVINGS || spans.len() > MOST_SPANS;
        let mut halves = Vec::new();
        for ([begin, end], own) in spans.into_iter().zip(boxes) {
            let middle = 0.5 * (begin + end);
            let is_done = |own: &SpanBox| is_last || enough.contains(&own.bounds);
            match own.filter(is_done) {
                Some(own) => whole = Some(whole.map_or(own, |whole| both(&whole, &own))),
                None if is_last || middle <= begin || middle >= end => return None,
                None => halves.extend([[begin, middle], [middle, end]]),
            }
        }
        if halves.is_empty() {
            break;
        }
        spans = halves;
    }
    row(&whole?)
}

fn both(a: &SpanBox, b: &SpanBox) -> SpanBox {
    SpanBox {
        ends: a.ends.union(&b.ends),
        bounds: a.bounds.union(&b.bounds),
        reach: std::array::from_fn(|k| a.reach[k].max(b.reach[k])),
        rest_reach: a.rest_reach.max(b.rest_reach),
    }
}

/// Rounded outwards; `None` where that is beyond all numbers.
fn row(of: &SpanBox) -> Option<ClipBoundsRow> {
    let bounds = Aabb {
        min: of.bounds.min.map(f32_below),
        max: of.bounds.max.map(f32_above),
    };
    let is_finite = bounds.min.iter().chain(&bounds.max).all(|x| x.is_finite());
    is_finite.then(|| ClipBoundsRow::within(bounds, of.reach.map(f32_above), f32_above(of.rest_reach)))
}
