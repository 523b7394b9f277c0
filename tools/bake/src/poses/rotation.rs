//! Rotations as unit quaternions x, y, z, w and as rotation vectors: axis times angle, radians. With `libm`, so that every
//! platform computes the same bits.

use std::f64::consts::TAU;

/// A rotation, uniform on the sphere of rotations.
///
/// Source: Shoemake 1992, *Uniform Random Rotations* (Graphics Gems III).
pub(crate) fn uniform(random: &mut fastrand::Rng) -> [f64; 4] {
    let [share, a, b] = std::array::from_fn(|_| random.f64());
    let (first, second) = ((1.0 - share).sqrt(), share.sqrt());
    let (a, b) = (TAU * a, TAU * b);
    [
        first * libm::sin(a),
        first * libm::cos(a),
        second * libm::sin(b),
        second * libm::cos(b),
    ]
}

/// The rotation of a rotation vector.
pub(crate) fn from_vector(vector: [f64; 3]) -> [f64; 4] {
    let angle = length(vector);
    if angle == 0.0 {
        return [0.0, 0.0, 0.0, 1.0];
    }
    let sine = libm::sin(0.5 * angle) / angle;
    let [x, y, z] = vector.map(|v| v * sine);
    [x, y, z, libm::cos(0.5 * angle)]
}

/// The rotation vector of a unit quaternion, at most half a turn long.
pub(crate) fn vector_of([x, y, z, w]: [f64; 4]) -> [f64; 3] {
    let (axis, w) = if w < 0.0 { ([-x, -y, -z], -w) } else { ([x, y, z], w) };
    let sine = length(axis);
    if sine == 0.0 {
        return [0.0; 3];
    }
    let scale = 2.0 * libm::atan2(sine, w) / sine;
    axis.map(|v| v * scale)
}

/// What takes `from` to `to` in the axes of `from`: `to` is `from` after it. All are unit quaternions.
pub(crate) fn between(from: [f64; 4], to: [f64; 4]) -> [f64; 4] {
    (glam::DQuat::from_array(from).conjugate() * glam::DQuat::from_array(to)).to_array()
}

fn length([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}
