//! The poses of a clip, span by span, with bounds of everything that happens in between.
//!
//! A clip's channels are smooth between their keys. So the poses between two times that no key separates form a span:
//! translations and scales are lines or cubics there, whose derivatives are known, and rotations move on arcs of known
//! speed or are cubics brought to length one. What a span says of a bone's motion against another follows by the product
//! rule along the skeleton ([`SpanMap::after`]), so it holds at all times, at overshoots of cubic splines and in the middle
//! of arcs as well.
//!
//! Nothing bounds a span in which a scale may pass through zero, or a cubic of quaternions does. Such spans are in no
//! envelope of the clusters that they concern: the runtime finds their poses outside and widens the boxes.

use super::{
    span_map::{SpanMap, SpanNumber},
    world_span::spectral_bound,
};
use glam::{DMat3, DQuat, DVec4};
use restpose_formats::{
    Model,
    rows::{ChannelRow, Interpolation, Local, NONE, NodeRow, Path},
};

/// A stretch of a clip.
pub(crate) struct Span {
    /// Per node row.
    pub nodes: Vec<NodeSpan>,
    /// Per morph target row.
    pub morph_weights: Vec<SpanNumber>,
}

/// A node's local map over a span.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NodeSpan {
    pub(super) translation: [SpanNumber; 3],
    pub(super) rotation: RotationSpan,
    pub(super) scale: [SpanNumber; 3],
    /// What takes the place of rotation and scale in a node with a matrix.
    pub(super) matrix: Option<[[f64; 3]; 3]>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct RotationSpan {
    begin: DQuat,
    end: DQuat,
    /// Radians per span.
    pub(super) speed: f64,
    /// Radians per span, squared; infinite where nothing is known.
    pub(super) acceleration: f64,
    /// Bounds by how much the matrices that the evaluator computes in `f64`, and those of `begin` and `end`, differ from
    /// exact ones, in the spectral norm, together; infinite where nothing is known.
    pub(super) error: f64,
}

/// [`RotationSpan::error`] of a key or an arc, and of a cubic per unit of what enters it relative to its length. Quaternions
/// of keys and arcs are off by 2⁻⁴⁵ at most: by 2⁻⁴⁷ in the evaluator, which does not bring arcs to length one again, and
/// by some sixty roundings here; those of cubics by 2⁻⁴⁴ of what enters. A matrix is off by twice the turn that is off and
/// by four times the length, so by less than eight times that, roundings of its own included.
const ROTATION_ERROR: f64 = 1.0 / (1u64 << 40) as f64;

/// Part of what enters a cubic of quaternions that must be left of its length for the evaluator to be near to it.
const LEAST_LENGTH: f64 = 1.0 / (1u64 << 20) as f64;

impl RotationSpan {
    fn constant(rotation: DQuat) -> Self {
        Self {
            begin: rotation,
            end: rotation,
            speed: 0.0,
            acceleration: 0.0,
            error: ROTATION_ERROR,
        }
    }
}

impl NodeSpan {
    fn at_rest(row: &NodeRow) -> Self {
        match row.local() {
            Local::Matrix(columns) => {
                let columns = columns.map(|column| column.map(f64::from));
                Self {
                    translation: columns[3].map(SpanNumber::constant),
                    rotation: RotationSpan::constant(DQuat::IDENTITY),
                    scale: [SpanNumber::constant(1.0); 3],
                    matrix: Some([columns[0], columns[1], columns[2]]),
                }
            }
            Local::Trs {
                translation,
                rotation,
                scale,
            } => Self {
                translation: translation.map(|x| SpanNumber::constant(x.into())),
                rotation: RotationSpan::constant(unit(DVec4::from(rotation.map(f64::from)))),
                scale: scale.map(|x| SpanNumber::constant(x.into())),
                matrix: None,
            },
        }
    }

    /// Parent from node.
    pub(crate) fn forward(&self) -> [SpanMap; 2] {
        let [begin, end] = [self.rotation.begin, self.rotation.end].map(|q| DMat3::from_quat(q).to_cols_array_2d());
        let linear = match self.matrix {
            Some([x, y, z]) => SpanMap::constant([x, y, z, [0.0; 3]]),
            None => SpanMap::rotation(begin, end, self.rotation.speed, self.rotation.acceleration)
                .after(&SpanMap::scale(self.scale)),
        };
        [SpanMap::translation(self.translation), linear]
    }

    /// Bounds the spectral norm of the linear part of [`Self::backward`]; `None` where nothing does.
    pub(super) fn inverse_norm(&self) -> Option<f64> {
        if let Some(columns) = self.matrix {
            let inverse = DMat3::from_cols_array_2d(&columns).inverse();
            return inverse.is_finite().then(|| spectral_bound(&inverse.to_cols_array_2d()));
        }
        let mut greatest = 0.0f64;
        for scale in self.scale {
            let (low, high) = scale.inverted()?.range();
            greatest = greatest.max(low.abs()).max(high.abs());
        }
        Some(greatest)
    }

    /// Node from parent; `None` where a scale may be zero.
    pub(crate) fn backward(&self) -> Option<[SpanMap; 2]> {
        let linear = if let Some(columns) = self.matrix {
            let inverse = DMat3::from_cols_array_2d(&columns).inverse();
            let [x, y, z] = inverse.to_cols_array_2d();
            inverse.is_finite().then(|| SpanMap::constant([x, y, z, [0.0; 3]]))?
        } else {
            let [x, y, z] = self.scale;
            let scale = SpanMap::scale([x.inverted()?, y.inverted()?, z.inverted()?]);
            let [begin, end] =
                [self.rotation.begin, self.rotation.end].map(|q| DMat3::from_quat(q).transpose().to_cols_array_2d());
            let rotation = SpanMap::rotation(begin, end, self.rotation.speed, self.rotation.acceleration);
            scale.after(&rotation)
        };
        Some([linear, SpanMap::translation(self.translation.map(SpanNumber::negated))])
    }
}

impl Span {
    /// The pose without any clip.
    pub(crate) fn at_rest(model: &Model) -> Self {
        Self {
            nodes: model.nodes.iter().map(NodeSpan::at_rest).collect(),
            morph_weights: model
                .morph_targets
                .iter()
                .map(|target| SpanNumber::constant(target.default_weight.into()))
                .collect(),
        }
    }

    /// Clip `clip` from `begin` to `end` seconds, which do not lie on different sides of any key. At `end` it is where the
    /// clip comes from before, whether or not it jumps there.
    pub(crate) fn of_clip(model: &Model, clip: usize, begin: f64, end: f64) -> Self {
        let mut out = Self::at_rest(model);
        let row = &model.clips[clip];
        for channel in &model.channels[row.channel_first as usize..][..row.channel_count as usize] {
            let piece = Piece::new(model, channel, begin, end);
            match Path::from_number(channel.path) {
                Some(Path::Translation) => {
                    out.nodes[channel.target as usize].translation = std::array::from_fn(|k| piece.number(k));
                }
                Some(Path::Scale) => {
                    out.nodes[channel.target as usize].scale = std::array::from_fn(|k| piece.number(k));
                }
                Some(Path::Rotation) => out.nodes[channel.target as usize].rotation = piece.rotation(),
                Some(Path::Weights) => {
                    let set = &model.morph_sets[channel.target as usize];
                    for k in 0..set.target_count as usize {
                        out.morph_weights[set.target_first as usize + k] = piece.number(k);
                    }
                }
                Some(Path::Frame) | None => {}
            }
        }
        out
    }

    /// The greatest angle by which a node turns against its parent, radians.
    pub(crate) fn greatest_turn(&self) -> f64 {
        let turn = |rotation: &RotationSpan| rotation.speed + rotation.acceleration.sqrt();
        self.nodes.iter().map(|node| turn(&node.rotation)).fold(0.0, f64::max)
    }
}

/// A channel over a span: the key that it comes from, and what part of the way to the next one the span takes.
struct Piece<'a> {
    values: &'a [f32],
    width: usize,
    interpolation: Interpolation,
    key: usize,
    /// Parts of the way at the span's ends, equal where nothing moves.
    from: f64,
    to: f64,
    /// From the key to the next, seconds.
    step_seconds: f64,
}

impl<'a> Piece<'a> {
    fn new(model: &'a Model, channel: &ChannelRow, begin: f64, end: f64) -> Self {
        let interpolation = Interpolation::from_number(channel.interpolation).unwrap_or(Interpolation::Step);
        let (width, keys) = (channel.width as usize, channel.key_count as usize);
        let times = &model.key_times[channel.time_first as usize..][..keys];
        let count = keys * width * interpolation.values_per_key() as usize;
        let key = times
            .partition_point(|time| f64::from(*time) <= begin)
            .saturating_sub(1);
        let mut piece = Self {
            values: &model.key_values[channel.value_first as usize..][..count],
            width,
            interpolation,
            key,
            from: 0.0,
            to: 0.0,
            step_seconds: 0.0,
        };
        let start = f64::from(times[key]);
        if begin >= start && key + 1 < keys && interpolation != Interpolation::Step {
            piece.step_seconds = f64::from(times[key + 1]) - start;
            piece.from = (begin - start) / piece.step_seconds;
            piece.to = ((end - start) / piece.step_seconds).min(1.0);
        }
        piece
    }

    fn is_still(&self) -> bool {
        self.step_seconds == 0.0
    }

    /// Component `k` of key `key`: `part` 0 is the in-tangent, 1 the value, 2 the out-tangent of a cubic spline.
    fn component(&self, key: usize, part: usize, k: usize) -> f64 {
        let row = match self.interpolation {
            Interpolation::CubicSpline => key * 3 + part,
            _ => key,
        };
        f64::from(self.values[row * self.width + k])
    }

    fn number(&self, k: usize) -> SpanNumber {
        let a = self.component(self.key, 1, k);
        if self.is_still() {
            return SpanNumber::constant(a);
        }
        let b = self.component(self.key + 1, 1, k);
        let way = self.to - self.from;
        if self.interpolation == Interpolation::Linear {
            let at = |s: f64| (1.0 - s) * a + s * b;
            return SpanNumber {
                begin: at(self.from),
                end: at(self.to),
                rate: (b - a).abs() * way,
                curvature: 0.0,
                terms: a.abs() + b.abs(),
            };
        }
        let out = self.step_seconds * self.component(self.key, 2, k);
        let into = self.step_seconds * self.component(self.key + 1, 0, k);
        // Hermite's cubic as a + s·(out + s·(square + s·cube)).
        let (square, cube) = (3.0 * (b - a) - 2.0 * out - into, 2.0 * (a - b) + out + into);
        let at = |s: f64| a + s * (out + s * (square + s * cube));
        let slope = |s: f64| (out + s * (2.0 * square + s * 3.0 * cube)).abs();
        // The second derivative is a line: its ends bound it.
        let bend = |s: f64| (2.0 * square + s * 6.0 * cube).abs();
        let curvature = bend(self.from).max(bend(self.to)) * way * way;
        SpanNumber {
            begin: at(self.from),
            end: at(self.to),
            rate: slope(self.from).max(slope(self.to)) * way + curvature,
            curvature,
            terms: a.abs() + b.abs() + out.abs() + into.abs(),
        }
    }

    fn rotation(&self) -> RotationSpan {
        let key = |key: usize| DVec4::from_array(std::array::from_fn(|k| self.component(key, 1, k)));
        if self.is_still() {
            return RotationSpan::constant(unit(key(self.key)));
        }
        if self.interpolation == Interpolation::Linear {
            return arc(key(self.key), key(self.key + 1), self.from, self.to);
        }
        let numbers: [SpanNumber; 4] = std::array::from_fn(|k| self.number(k));
        let length = |of: fn(&SpanNumber) -> f64| numbers.iter().map(|n| of(n) * of(n)).sum::<f64>().sqrt();
        let (rate, curvature) = (length(|n| n.rate), length(|n| n.curvature));
        let [begin, end] =
            [|n: &SpanNumber| n.begin, |n: &SpanNumber| n.end].map(|of| DVec4::from_array(numbers.each_ref().map(of)));
        // The cubic keeps at least this far from zero: the nearest point of the straight way, less what it bends.
        let nearest = nearest_to_zero(begin, end) - 0.125 * curvature;
        // n = q/|q| moves at |n′| ≤ |q′|/|q| and bends by |n″| ≤ |q″|/|q| + 2|q′|²/|q|²; a rotation turns twice as fast.
        let (speed, acceleration) = if nearest > 0.0 {
            let (moved, bent) = (rate / nearest, curvature / nearest);
            (2.0 * moved, 2.0 * (bent + 2.0 * moved * moved))
        } else {
            (f64::INFINITY, f64::INFINITY)
        };
        let terms = length(|n| n.terms);
        let error = if nearest > LEAST_LENGTH * terms {
            ROTATION_ERROR * (terms / nearest)
        } else {
            f64::INFINITY
        };
        RotationSpan {
            begin: unit(begin),
            end: unit(end),
            speed,
            acceleration,
            error,
        }
    }
}

/// The quaternion at length one; the identity where it has no length, as the runtime has it.
fn unit(q: DVec4) -> DQuat {
    let length = q.length();
    if length > 0.0 && length.is_finite() {
        DQuat::from_vec4(q / length)
    } else {
        DQuat::IDENTITY
    }
}

/// Distance of the segment between two points from the origin.
fn nearest_to_zero(a: DVec4, b: DVec4) -> f64 {
    let way = b - a;
    let place = -a.dot(way) / way.length_squared();
    if place.is_nan() {
        return a.length();
    }
    (a + way * place.clamp(0.0, 1.0)).length()
}

/// The shorter arc between two keys as stored, from one part of the way to another. Of half turns, the one that the
/// evaluator takes: it goes by the sign of this sum, in this order, before the keys are brought to length one.
fn arc(a: DVec4, b: DVec4, from: f64, to: f64) -> RotationSpan {
    let [a, b] = [a, b].map(|key| if key == DVec4::ZERO { DVec4::W } else { key });
    let is_opposite = a.dot(b) < 0.0;
    let (a, b) = (unit(a), unit(b));
    let b = if is_opposite { -b } else { b };
    let angle = 2.0 * (a - b).length().atan2((a + b).length());
    let at = |s: f64| {
        let sine = angle.sin();
        if sine > 0.0 {
            let (p, q) = (((1.0 - s) * angle).sin() / sine, (s * angle).sin() / sine);
            unit(DVec4::from(a * p + b * q))
        } else {
            a
        }
    };
    RotationSpan {
        begin: at(from),
        end: at(to),
        speed: 2.0 * angle * (to - from),
        acceleration: 0.0,
        error: ROTATION_ERROR,
    }
}

/// Spans that a pose space is cut into at most, beyond what its samples ask for. More would only make its envelopes
/// thinner by the last few percent.
const MOST_SPANS: usize = 16_384;

/// Spans are cut so that no node turns by more than this within one, radians: four degrees bend a path by 0.06 % of its
/// lever.
const GREATEST_TURN: f64 = 4.0 * std::f64::consts::PI / 180.0;

/// Cuts of one span at most.
const MOST_CUTS: f64 = 64.0;

/// All spans of the clips that `model.samples` names, between their consecutive times, and the pose without clips.
pub(crate) fn spans(model: &Model) -> Vec<Span> {
    spans_with_times(model).into_iter().map(|(span, ..)| span).collect()
}

/// As [`spans`], each with its clip, if any, and the times at its ends.
pub(crate) fn spans_with_times(model: &Model) -> Vec<(Span, Option<usize>, [f64; 2])> {
    let mut stretches = Vec::new();
    for pair in model.samples.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        if a.clip != NONE && a.clip == b.clip {
            stretches.push((a.clip as usize, f64::from(a.seconds), f64::from(b.seconds)));
        }
    }
    // Samples that stand alone, and the last of each clip: where a channel jumps, it jumps there.
    for (place, sample) in model.samples.iter().enumerate() {
        let next = model.samples.get(place + 1);
        if sample.clip != NONE && next.is_none_or(|next| next.clip != sample.clip) {
            stretches.push((
                sample.clip as usize,
                f64::from(sample.seconds),
                f64::from(sample.seconds),
            ));
        }
    }
    let turns: Vec<f64> = stretches
        .iter()
        // A turn of which nothing is known is cut as often as any.
        .map(|(clip, begin, end)| {
            let turn = Span::of_clip(model, *clip, *begin, *end).greatest_turn();
            turn.min(GREATEST_TURN * MOST_CUTS)
        })
        .collect();
    let cuts = |turn: f64, step: f64| (turn / step).ceil().clamp(1.0, MOST_CUTS) as usize;
    let mut step = GREATEST_TURN;
    while stretches.len() < MOST_SPANS && turns.iter().map(|turn| cuts(*turn, step)).sum::<usize>() > MOST_SPANS {
        step *= 2.0;
    }
    let mut out = vec![(Span::at_rest(model), None, [0.0; 2])];
    for ((clip, begin, end), turn) in stretches.into_iter().zip(turns) {
        let count = if out.len() < MOST_SPANS { cuts(turn, step) } else { 1 };
        let time = |cut: usize| {
            if cut == count {
                end
            } else {
                begin + (end - begin) * cut as f64 / count as f64
            }
        };
        out.extend((0..count).map(|cut| {
            let ends = [time(cut), time(cut + 1)];
            (Span::of_clip(model, clip, ends[0], ends[1]), Some(clip), ends)
        }));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use restpose_formats::rows::{ClipRow, SampleRow};

    /// Splines between opposite quaternions pass through zero, where nothing bounds how they turn. However many there are,
    /// none of their spans is left out: other joints move in them, too.
    #[test]
    fn spans_that_nothing_bounds_are_all_there() {
        const KEYS: usize = 300;
        let mut model = Model {
            nodes: vec![NodeRow::new(
                NONE,
                0,
                Local::Trs {
                    translation: [0.0; 3],
                    rotation: [0.0, 0.0, 0.0, 1.0],
                    scale: [1.0; 3],
                },
            )],
            key_times: (0..KEYS).map(|key| key as f32 / 60.0).collect(),
            ..Model::default()
        };
        for key in 0..KEYS {
            let sign = if key % 2 == 0 { 1.0 } else { -1.0 };
            model.key_values.extend([0.0; 4]);
            model.key_values.extend([0.0, 0.6 * sign, 0.0, 0.8 * sign]);
            model.key_values.extend([0.0; 4]);
        }
        model.channels.push(ChannelRow {
            target: 0,
            path: Path::Rotation as u32,
            interpolation: Interpolation::CubicSpline as u32,
            width: 4,
            time_first: 0,
            key_count: KEYS as u32,
            value_first: 0,
            reserved: 0,
        });
        model.clips.push(ClipRow {
            start_seconds: 0.0,
            end_seconds: model.key_times[KEYS - 1],
            channel_first: 0,
            channel_count: 1,
        });
        let sample = |seconds: &f32| SampleRow {
            clip: 0,
            seconds: *seconds,
        };
        model.samples = model.key_times.iter().map(sample).collect();
        let spans = spans_with_times(&model);
        for pair in model.key_times.windows(2) {
            let inside = |(_, _, [begin, end]): &&(Span, Option<usize>, [f64; 2])| {
                *begin >= f64::from(pair[0]) && *end <= f64::from(pair[1]) && begin < end
            };
            let covered: f64 = spans.iter().filter(inside).map(|(.., [begin, end])| end - begin).sum();
            let whole = f64::from(pair[1]) - f64::from(pair[0]);
            // Times are added up in f64.
            assert!(
                (covered - whole).abs() < 1e-9 * whole,
                "{pair:?}: {covered} of {whole} s"
            );
        }
    }
}
