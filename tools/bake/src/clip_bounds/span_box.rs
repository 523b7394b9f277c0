use super::moved_bones::{LEAST_STEP, Moved, MovedBone};
use crate::poses::{Span, WorldSpan};
use restpose_formats::{Model, geom::round::UNIT_ROUNDOFF};

/// An axis-aligned box in asset space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Box3 {
    pub min: [f64; 3],
    pub max: [f64; 3],
}

impl Box3 {
    pub(super) const EMPTY: Self = Self {
        min: [f64::INFINITY; 3],
        max: [f64::NEG_INFINITY; 3],
    };

    pub(super) fn union(&self, other: &Self) -> Self {
        Self {
            min: std::array::from_fn(|k| self.min[k].min(other.min[k])),
            max: std::array::from_fn(|k| self.max[k].max(other.max[k])),
        }
    }

    pub(super) fn contains(&self, other: &Self) -> bool {
        (0..3).all(|k| self.min[k] <= other.min[k] && other.max[k] <= self.max[k])
    }

    /// Widened by a part of its sides, on each of them.
    pub(super) fn widened(&self, part: f64) -> Self {
        let by = |k: usize| part * (self.max[k] - self.min[k]);
        Self {
            min: std::array::from_fn(|k| self.min[k] - by(k)),
            max: std::array::from_fn(|k| self.max[k] + by(k)),
        }
    }
}

/// Where a span's poses have the asset.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpanBox {
    /// At its ends.
    pub ends: Box3,
    /// At all of its times.
    pub bounds: Box3,
    /// Bounds `|X|·|p| + |t|`.
    pub reach: [f64; 3],
    /// Bounds the sum of the coordinates of `|p|`.
    pub rest_reach: f64,
}

/// Sizes up to this cannot have overflowed where the runtime rounds them to `f32`.
const LARGEST: f64 = f32::MAX as f64 / 8.0;

/// Relative slack of the bounds themselves, for theirs are sums of fewer than 2⁴⁰ roundings in `f64`.
const BOUND_SLACK: f64 = 1.0 + 1.0 / 1024.0;

/// Point 3 of the module: twice six roundings of a product of maps, and sixteen of a box's image; of magnitudes which the
/// norms bound up to a factor of three.
const IMAGE_ERROR: f64 = 1.0 / (1u64 << 46) as f64;

/// Below it a rounding to `f32` is no longer relative to its number.
const SMALLEST_NORMAL: f64 = f32::MIN_POSITIVE as f64;

impl SpanBox {
    /// `None` where nothing bounds the span, or its numbers are too large.
    pub(super) fn new(model: &Model, bones: &[MovedBone], span: &Span) -> Option<Self> {
        let worlds = WorldSpan::all(model, span);
        let mut out = Self {
            ends: Box3::EMPTY,
            bounds: Box3::EMPTY,
            reach: [0.0; 3],
            rest_reach: 0.0,
        };
        for bone in bones {
            let world = bone.node.map_or(WorldSpan::IDENTITY, |node| worlds[node]);
            let own = bone_box(&world, &bone.bind, &bone.moved(span))?;
            out = Self {
                ends: out.ends.union(&own.ends),
                bounds: out.bounds.union(&own.bounds),
                reach: std::array::from_fn(|k| out.reach[k].max(own.reach[k])),
                rest_reach: out.rest_reach.max(own.rest_reach),
            };
        }
        Some(out)
    }
}

fn bone_box(world: &WorldSpan, bind: &[[f64; 3]; 4], moved: &Moved) -> Option<SpanBox> {
    let WorldSpan { linear, offset, .. } = world;
    let (min, max) = (moved.bounds.min, moved.bounds.max);
    let size = moved.size.map(|x| x + SMALLEST_NORMAL);

    // In the node's space: how far what moves is from its origin, and the same without what cancels out.
    let lever = (0..8)
        .map(|corner| {
            let p: [f64; 3] = std::array::from_fn(|k| if corner >> k & 1 == 0 { min[k] } else { max[k] });
            length(std::array::from_fn(|k| {
                bind[0][k] * p[0] + bind[1][k] * p[1] + bind[2][k] * p[2] + bind[3][k]
            }))
        })
        .fold(0.0, f64::max);
    let axes = [bind[0], bind[1], bind[2]].map(length);
    let entering = axes[0] * size[0] + axes[1] * size[1] + axes[2] * size[2] + length(bind[3]);

    let bend = 0.125 * (linear.curvature * lever + offset.curvature) * BOUND_SLACK;
    let bend_entering = 0.125 * (linear.curvature * entering + offset.curvature) * BOUND_SLACK;
    let (turned, carried) = (linear.size + linear.error, offset.size + offset.error);
    let error = (linear.error * entering + offset.error + IMAGE_ERROR * (turned * entering + carried)) * BOUND_SLACK;
    let rest_reach = (size[0] + size[1] + size[2]) * BOUND_SLACK;

    let mut out = SpanBox {
        ends: Box3::EMPTY,
        bounds: Box3::EMPTY,
        reach: [0.0; 3],
        rest_reach,
    };
    for world in [&world.begin, &world.end] {
        for k in 0..3 {
            let entry = |column: [f64; 3]| world[k] * column[0] + world[3 + k] * column[1] + world[6 + k] * column[2];
            let (mut middle, mut spread) = (entry(bind[3]) + world[9 + k], 0.0);
            let mut reach = middle.abs();
            for j in 0..3 {
                let x = entry(bind[j]);
                middle += x * (0.5 * (min[j] + max[j]));
                spread += x.abs() * (0.5 * (max[j] - min[j]));
                reach += x.abs() * size[j];
            }
            let reach = reach * BOUND_SLACK + bend_entering + error;
            let rounding = (UNIT_ROUNDOFF * reach + LEAST_STEP * (1.0 + rest_reach)) * BOUND_SLACK + error;
            let end = spread + rounding;
            out.ends.min[k] = out.ends.min[k].min(middle - end);
            out.ends.max[k] = out.ends.max[k].max(middle + end);
            out.bounds.min[k] = out.bounds.min[k].min(middle - (end + bend));
            out.bounds.max[k] = out.bounds.max[k].max(middle + (end + bend));
            out.reach[k] = out.reach[k].max(reach);
            // Not a NaN that is lost.
            if !(reach <= LARGEST && end + bend <= LARGEST) {
                return None;
            }
        }
    }
    // Every entry of the palette, also of what moves nothing but zeros.
    let entries = turned * (1.0 + axes[0].max(axes[1]).max(axes[2]) + length(bind[3])) + carried;
    (entries <= LARGEST && rest_reach <= LARGEST).then_some(out)
}

fn length([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}
