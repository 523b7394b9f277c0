use crate::poses::{SampledPose, in_palette};
use glam::{DMat3, DVec3};
use restpose_formats::geom::Affine;

/// How strongly the pivot is held to the middle of the vertices, relative to how strongly motions hold it: a hinge leaves
/// it free along its axis, and small motions about all axes say little.
const HOLD: f64 = 1e-4;

/// 2⁻²⁰: what rounding a palette to `f32` does to the entries of a relative motion. Turns of this size say nothing.
const ROUNDING: f64 = 1.0 / (1u64 << 20) as f64;

/// A pivot further from the vertices than this many times their spread is none: no joint is there.
const FARTHEST: f64 = 8.0;

/// The point about which `mover` turns against `own`: where it displaces least over the poses, by least squares, near
/// `center`, the middle of the vertices that it moves, which are at most `spread` away; all in rest space. For a joint between the two it is the joint.
///
/// Minimises `Σ |(A − 1)·k + b|² + h·|k − center|²` over `R = X_own⁻¹·X_mover = (A | b)`. Any pivot is a right one; a good
/// one makes levers and envelopes small.
pub(super) fn pivot(poses: &[SampledPose], own: usize, mover: usize, center: [f64; 3], spread: f64) -> [f32; 3] {
    let center = DVec3::from(center);
    let (mut square, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for pose in poses {
        let Some(inverse) = &pose.inverses[own] else {
            continue;
        };
        let [own, mover]: [&Affine; 2] = [&pose.palette[own], &pose.palette[mover]];
        let motion = in_palette(inverse, own, mover);
        let turn = DMat3::from_cols_slice(&motion[..9]) - DMat3::IDENTITY;
        let displaced = turn * center + DVec3::from_slice(&motion[9..]);
        square += turn.transpose() * turn + DMat3::from_diagonal(DVec3::splat(ROUNDING * ROUNDING));
        right += turn.transpose() * displaced;
    }
    let trace = square.x_axis.x + square.y_axis.y + square.z_axis.z;
    let held = square + DMat3::from_diagonal(DVec3::splat(HOLD * trace));
    let away = -(held.inverse() * right);
    let found = if away.length() <= FARTHEST * spread {
        center + away
    } else {
        center
    };
    found.to_array().map(|x| x as f32)
}
