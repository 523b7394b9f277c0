//! Where nodes are over a span: their maps at its ends, and norms of what happens in between and of what rounding adds.
//!
//! [`SpanMap`](super::span_map::SpanMap) bounds every number of a map by itself. From the scene down to a fingertip that
//! overestimates turns by up to √3 per joint; norms do not, for a rotation's is one.

use super::{
    span::{NodeSpan, Span},
    span_map::{Numbers, SpanNumber, product},
};
use glam::DMat3;
use restpose_formats::{
    Model,
    rows::{NONE, NodeRow},
};

/// Bounds of a map's linear part, by its spectral norm, or of its translation, by its length, at all times of a span.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Norms {
    pub size: f64,
    /// First derivative by the span's time, which counts from 0 to 1.
    pub rate: f64,
    /// Second derivative.
    pub curvature: f64,
    /// By how much what the evaluator computes in `f64`, and what this module computes at the span's ends, differ from
    /// the exact map: the sum of both.
    pub error: f64,
}

/// A channel's number, times the magnitudes that enter it. A cubic takes some forty roundings, the way's fraction
/// included, in the evaluator and as many here: less than 2⁻⁴⁴ in all.
const NUMBER_ERROR: f64 = 1.0 / (1u64 << 44) as f64;

/// Sums and products of maps: six roundings per entry, times three for the norm of the magnitudes, twice.
const PRODUCT_ERROR: f64 = 1.0 / (1u64 << 47) as f64;

/// Rates of rotations are quotients by the length of a quaternion, of which at least the 2⁻²⁰ᵗʰ part of what enters is
/// left: they are exact to 2⁻²², or off by less than the error.
const RATE_SLACK: f64 = 1.0 + 1.0 / (1u64 << 16) as f64;

impl Norms {
    const ZERO: Self = Self {
        size: 0.0,
        rate: 0.0,
        curvature: 0.0,
        error: 0.0,
    };

    fn constant(size: f64) -> Self {
        Self { size, ..Self::ZERO }
    }

    fn of_number(number: &SpanNumber) -> Self {
        let (least, greatest) = number.range();
        let error = number_error(number);
        Self {
            size: least.abs().max(greatest.abs()) + error,
            rate: number.rate + error,
            curvature: number.curvature + error,
            error,
        }
    }

    /// Combines bounds of three numbers, field by field.
    fn of_numbers(numbers: &[SpanNumber; 3], combine: fn([f64; 3]) -> f64) -> Self {
        let each = numbers.each_ref().map(Self::of_number);
        let all = |field: fn(&Self) -> f64| combine(each.each_ref().map(field));
        Self {
            size: all(|norms| norms.size),
            rate: all(|norms| norms.rate),
            curvature: all(|norms| norms.curvature),
            error: all(|norms| norms.error),
        }
    }

    /// Of a linear part after another, or after a translation: the product rule.
    fn product(&self, inner: &Self) -> Self {
        let (size, inner_size) = (self.size + self.error, inner.size + inner.error);
        Self {
            size: self.size * inner.size,
            rate: self.rate * inner.size + self.size * inner.rate,
            curvature: self.curvature * inner.size + 2.0 * self.rate * inner.rate + self.size * inner.curvature,
            error: self.error * inner_size + self.size * inner.error + PRODUCT_ERROR * size * inner_size,
        }
    }

    fn sum(&self, other: &Self) -> Self {
        let size = self.size + other.size;
        let error = self.error + other.error;
        Self {
            size,
            rate: self.rate + other.rate,
            curvature: self.curvature + other.curvature,
            error: error + PRODUCT_ERROR * (size + error),
        }
    }
}

/// Bounds how far what the evaluator and [`Span`] compute of a number is from it.
pub(crate) fn number_error(number: &SpanNumber) -> f64 {
    NUMBER_ERROR * number.terms
}

/// A node's map, world from node, over a span.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WorldSpan {
    pub begin: Numbers,
    pub end: Numbers,
    pub linear: Norms,
    pub offset: Norms,
}

impl WorldSpan {
    /// The map that changes nothing.
    pub(crate) const IDENTITY: Self = Self {
        begin: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        end: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        linear: Norms {
            size: 1.0,
            ..Norms::ZERO
        },
        offset: Norms::ZERO,
    };

    fn local(node: &NodeSpan) -> Self {
        let [translation, linear] = node.forward();
        let with = |mut linear: Numbers, translation: Numbers| {
            linear[9..].copy_from_slice(&translation[9..]);
            linear
        };
        Self {
            begin: with(linear.begin, translation.begin),
            end: with(linear.end, translation.end),
            linear: linear_norms(node),
            offset: Norms::of_numbers(&node.translation, |x| x.iter().map(|x| x * x).sum::<f64>().sqrt()),
        }
    }

    fn after(&self, inner: &Self) -> Self {
        Self {
            begin: product(&self.begin, &inner.begin, &self.begin),
            end: product(&self.end, &inner.end, &self.end),
            linear: self.linear.product(&inner.linear),
            offset: self.linear.product(&inner.offset).sum(&self.offset),
        }
    }

    /// All nodes over a span, per node row.
    pub(crate) fn all(model: &Model, span: &Span) -> Vec<Self> {
        let mut worlds: Vec<Self> = Vec::with_capacity(model.nodes.len());
        for (NodeRow { parent, .. }, node) in model.nodes.iter().zip(&span.nodes) {
            let local = Self::local(node);
            worlds.push(match *parent {
                NONE => local,
                parent => worlds[parent as usize].after(&local),
            });
        }
        worlds
    }
}

/// Rotation after scale, or a matrix, which is as stored.
fn linear_norms(node: &NodeSpan) -> Norms {
    if let Some(columns) = node.matrix {
        return Norms::constant(spectral_bound(&columns));
    }
    let rotation = &node.rotation;
    let rotation = Norms {
        size: 1.0,
        rate: rotation.speed * RATE_SLACK + rotation.error,
        curvature: (rotation.speed * rotation.speed + rotation.acceleration) * RATE_SLACK + rotation.error,
        error: rotation.error,
    };
    let greatest = |x: [f64; 3]| x.iter().copied().fold(0.0, f64::max);
    rotation.product(&Norms::of_numbers(&node.scale, greatest))
}

/// Bounds the spectral norm of a matrix by the greatest sum of a row of `|MᵀM|`: exact where its columns are orthogonal.
pub(super) fn spectral_bound(columns: &[[f64; 3]; 3]) -> f64 {
    let square = DMat3::from_cols_array_2d(columns);
    let square = (square.transpose() * square).to_cols_array_2d();
    let row = |k: usize| square.iter().map(|column| column[k].abs()).sum::<f64>();
    row(0).max(row(1)).max(row(2)).sqrt()
}
