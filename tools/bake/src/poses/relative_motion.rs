//! How bones move against each other.
//!
//! `R = X_c⁻¹·X_i` is followed along the skeleton from one bone to the other. What both hang on is in neither `X_c⁻¹·X_i`
//! nor here, so a walk through the scene adds nothing; and about a joint as pivot a neighbour only turns.

use super::{
    span::Span,
    span_map::{Numbers, SpanMap, less_identity},
    world_span::{WorldSpan, spectral_bound},
};
use glam::{DAffine3, DMat3};
use restpose_formats::{
    Model,
    geom::{Affine, round::UNIT_ROUNDOFF},
    rows::{BoneRow, NONE},
};

/// Relative motions of some bones over a stretch of poses: the straight way from `begin` to `end`, and how far from it
/// they can be, that of palettes rounded to `f32` included. The twelve numbers of a bone, then those of the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chord {
    pub begin: Vec<f64>,
    pub end: Vec<f64>,
    pub stray: Vec<f64>,
}

/// The bones of a palette over a span, for what their rounding does to relative motions.
pub(crate) struct BoneSpans {
    bones: Vec<BoneSpan>,
}

#[derive(Clone, Copy)]
struct BoneSpan {
    /// Bounds the Frobenius norm of the linear part.
    linear: f64,
    translation: f64,
    /// Bounds the spectral norm of the inverse; `None` where nothing does.
    inverse: Option<f64>,
}

/// A second-order term where first-order ones are bounded: u times the greatest condition number of a cluster frame is
/// 2⁻⁸. Rounding in `f64` hides in it.
const SECOND_ORDER: f64 = 1.0 + 1.0 / 64.0;

impl BoneSpans {
    /// By norms, which do not grow along a chain of joints ([`WorldSpan`]): of a tail of 50 joints, entries bounded one by one
    /// made boxes of 10²⁶ times its size.
    pub(crate) fn new(model: &Model, span: &Span) -> Self {
        let worlds = WorldSpan::all(model, span);
        let mut inverses: Vec<Option<f64>> = Vec::with_capacity(span.nodes.len());
        for (row, node) in model.nodes.iter().zip(&span.nodes) {
            let own = node.inverse_norm();
            inverses.push(match row.parent {
                NONE => own,
                parent => own
                    .zip(inverses[parent as usize])
                    .map(|(own, from_world)| own * from_world),
            });
        }
        let bone = |bone: &BoneRow| {
            let [x, y, z, offset] = bind_columns(&bone.inverse_bind());
            let linear = [x, y, z];
            let unbind = DMat3::from_cols_array_2d(&linear).inverse();
            let unbind = unbind.is_finite().then(|| spectral_bound(&unbind.to_cols_array_2d()));
            let (world, from_world) = match bone.node {
                NONE => (&WorldSpan::IDENTITY, Some(1.0)),
                node => (&worlds[node as usize], inverses[node as usize]),
            };
            let size = world.linear.size + world.linear.error;
            BoneSpan {
                linear: 3f64.sqrt() * size * spectral_bound(&linear),
                translation: size * norm(&offset) + world.offset.size + world.offset.error,
                inverse: unbind.zip(from_world).map(|(unbind, from_world)| unbind * from_world),
            }
        };
        Self {
            bones: model.bones.iter().map(bone).collect(),
        }
    }
}

/// The way along the skeleton from a cluster's bone to another that moves its vertices.
pub(crate) struct Way {
    bones: [usize; 2],
    /// Rest space of the cluster from its bone's node.
    leave: [[f64; 3]; 4],
    /// The other bone's node from rest space.
    enter: [[f64; 3]; 4],
    /// Nodes from the other bone's up to below what both hang on.
    up: Vec<usize>,
    /// Nodes from below that down to the cluster's bone's, inverted.
    down: Vec<usize>,
}

impl Way {
    /// `None` where the cluster's bone has an inverse bind map without inverse: its frame never has one either.
    pub(crate) fn new(model: &Model, cluster_bone: usize, bone: usize) -> Option<Self> {
        let chain = |bone: usize| {
            let mut nodes = Vec::new();
            let mut node = model.bones[bone].node;
            while node != NONE {
                nodes.push(node as usize);
                node = model.nodes[node as usize].parent;
            }
            nodes
        };
        let (mut down, mut up) = (chain(cluster_bone), chain(bone));
        while let (Some(a), Some(b)) = (down.last(), up.last()) {
            if a != b {
                break;
            }
            down.pop();
            up.pop();
        }
        down.reverse();
        let bind = bind_columns(&model.bones[cluster_bone].inverse_bind());
        let leave = DAffine3::from_cols_array_2d(&bind).inverse();
        leave.is_finite().then(|| Self {
            bones: [cluster_bone, bone],
            leave: leave.to_cols_array_2d(),
            enter: bind_columns(&model.bones[bone].inverse_bind()),
            up,
            down,
        })
    }

    /// Appends the motion about `pivot` over a span; false where nothing bounds it.
    pub(crate) fn follow(&self, span: &Span, bones: &BoneSpans, pivot: [f32; 3], chord: &mut Chord) -> bool {
        let pivot = pivot.map(f64::from);
        let shift = |by: [f64; 3]| SpanMap::constant([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], by]);
        let mut map = SpanMap::constant(self.enter).after(&shift(pivot));
        for node in &self.up {
            let [outer, inner] = span.nodes[*node].forward();
            map = outer.after(&inner.after(&map));
        }
        for node in &self.down {
            let Some([outer, inner]) = span.nodes[*node].backward() else {
                return false;
            };
            map = outer.after(&inner.after(&map));
        }
        map = shift(pivot.map(|x| -x))
            .after(&SpanMap::constant(self.leave))
            .after(&map);
        let Some(rounding) = self.rounding(bones, pivot) else {
            return false;
        };
        let stray: Numbers = std::array::from_fn(|n| 0.125 * map.curvature[n] + rounding[usize::from(n >= 9)]);
        if !map.begin.iter().chain(&map.end).chain(&stray).all(|x| x.is_finite()) {
            return false;
        }
        chord.begin.extend(less_identity(&map.begin));
        chord.end.extend(less_identity(&map.end));
        chord.stray.extend(stray);
        true
    }

    /// Bounds what rounding the palette to `f32` does to each entry of A − 1 and of d: with errors δ of at most u times
    /// the maps, `R̂ − R = X_c⁻¹(δ_i − δ_c·R)` to first order.
    fn rounding(&self, bones: &BoneSpans, pivot: [f64; 3]) -> Option<[f64; 2]> {
        let [own, other] = self.bones.map(|bone| bones.bones[bone]);
        let inverse = own.inverse?;
        let unit = SECOND_ORDER * UNIT_ROUNDOFF * inverse;
        let linear = unit * (other.linear + own.linear * inverse * other.linear);
        let apart = inverse * (other.translation + own.translation);
        let offset = unit * (other.translation + own.translation + own.linear * apart);
        let pivot: f64 = pivot.iter().map(|x| x.abs()).sum();
        Some([linear, linear * pivot + offset])
    }
}

/// The motion of a bone against a cluster's in one pose of a palette: A and b of R, columns first.
pub(crate) fn in_palette(inverse: &[[f64; 3]; 3], own: &Affine, other: &Affine) -> Numbers {
    let turned = |v: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|k| inverse[k][0] * v[0] + inverse[k][1] * v[1] + inverse[k][2] * v[2])
    };
    let mut out = [0.0; 12];
    for j in 0..4 {
        let column = std::array::from_fn(|k| {
            let from = if j == 3 { f64::from(own.columns[3][k]) } else { 0.0 };
            f64::from(other.columns[j][k]) - from
        });
        out[3 * j..][..3].copy_from_slice(&turned(column));
    }
    out
}

/// The relative motion about a pivot: `A − 1` and `(A − 1)·k + b`.
pub(crate) fn about(motion: &Numbers, pivot: [f32; 3]) -> Numbers {
    let mut out = less_identity(motion);
    for j in 0..3 {
        for k in 0..3 {
            out[9 + k] += out[3 * j + k] * f64::from(pivot[j]);
        }
    }
    out
}

fn bind_columns(map: &Affine) -> [[f64; 3]; 4] {
    map.columns.map(|column| column.map(f64::from))
}

fn norm(numbers: &[f64]) -> f64 {
    numbers.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BakeSettings, NoProgress, bake, import::import, poses::spans_with_times};
    use restpose_runtime::{Pose, PoseEvaluator, invert_frame};
    use std::path::Path;

    /// What the runtime's own evaluation, rounded palette and all, makes of any time in a span is near the span's chord, on
    /// every pair of bones of the bundled scenes that moves a vertex together.
    #[test]
    fn motions_between_samples_stay_near_their_chords() {
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples/scenes");
        for name in ["walker.glb", "mixed.glb", "machine.gltf", "tentacle.gltf"] {
            let animation = import(&scenes.join(name)).unwrap().animation;
            let settings = BakeSettings {
                sample_step_seconds: 0.1,
                ..BakeSettings::default()
            };
            let model = bake(&animation, &settings, &NoProgress).unwrap().model;
            let view = model.view();
            let mut pairs: Vec<(u32, u32)> = Vec::new();
            for cluster in model.clusters.iter().filter(|cluster| cluster.track == NONE) {
                let rows =
                    &model.cluster_bones[cluster.cluster_bone_first as usize..][..cluster.cluster_bone_count as usize];
                pairs.extend(
                    rows.iter()
                        .filter(|row| row.bone != cluster.bone)
                        .map(|row| (cluster.bone, row.bone)),
                );
            }
            let ways: Vec<Way> = pairs
                .iter()
                .map(|(own, other)| Way::new(&model, *own as usize, *other as usize).unwrap())
                .collect();
            let mut random = fastrand::Rng::with_seed(6);
            let (mut evaluator, mut pose) = (PoseEvaluator::default(), Pose::default());
            for (span, clip, [begin, end]) in spans_with_times(&model) {
                let bones = BoneSpans::new(&model, &span);
                for _ in 0..3 {
                    let s = random.f64();
                    let seconds = (begin + s * (end - begin)) as f32;
                    if f64::from(seconds) < begin || f64::from(seconds) > end {
                        continue;
                    }
                    let s = if end > begin {
                        (f64::from(seconds) - begin) / (end - begin)
                    } else {
                        0.0
                    };
                    evaluator.evaluate(&view, clip, seconds, &mut pose);
                    for ((own, other), way) in pairs.iter().zip(&ways) {
                        let [own, other] = [own, other].map(|bone| &pose.palette[*bone as usize]);
                        let pivot = [0.1, 0.2, -0.3];
                        let found = about(&in_palette(&invert_frame(own).unwrap(), own, other), pivot);
                        let mut chord = Chord::default();
                        assert!(way.follow(&span, &bones, pivot, &mut chord));
                        for n in 0..12 {
                            let on_chord = (1.0 - s) * chord.begin[n] + s * chord.end[n];
                            assert!(
                                (found[n] - on_chord).abs() <= chord.stray[n],
                                "{name}: bones {:?}, number {n} at {seconds} s of {begin} to {end}: {} is not {on_chord} ± {}",
                                way.bones,
                                found[n],
                                chord.stray[n]
                            );
                        }
                    }
                }
            }
        }
    }
}
