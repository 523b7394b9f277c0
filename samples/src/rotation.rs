//! Rotations whose bytes are the same on every platform: sines come from `libm`, never from the platform.

use glam::{DQuat, DVec3};

/// Rotation by `degrees` about a unit axis, right-handed.
pub fn about(axis: DVec3, degrees: f64) -> DQuat {
    let half = degrees.to_radians() * 0.5;
    let sine = libm::sin(half);
    DQuat::from_xyzw(axis.x * sine, axis.y * sine, axis.z * sine, libm::cos(half))
}

/// Rotation by `degrees` about x: takes +y towards +z.
pub fn about_x(degrees: f64) -> DQuat {
    about(DVec3::X, degrees)
}

/// Rotation by `degrees` about y: takes +z towards +x.
pub fn about_y(degrees: f64) -> DQuat {
    about(DVec3::Y, degrees)
}

/// Rotation by `degrees` about z: takes +x towards +y.
pub fn about_z(degrees: f64) -> DQuat {
    about(DVec3::Z, degrees)
}

/// Sine of an angle given in turns.
pub fn sin_turn(turns: f64) -> f64 {
    libm::sin(turns * core::f64::consts::TAU)
}

/// Cosine of an angle given in turns.
pub fn cos_turn(turns: f64) -> f64 {
    libm::cos(turns * core::f64::consts::TAU)
}

/// Flips signs so that each rotation lies in the half-space of the one before it.
///
/// A cubic spline through quaternions needs this: unlike slerp it does not choose the shorter way by itself.
pub fn with_continuous_signs(mut rotations: Vec<DQuat>) -> Vec<DQuat> {
    for index in 1..rotations.len() {
        if rotations[index].dot(rotations[index - 1]) < 0.0 {
            rotations[index] = -rotations[index];
        }
    }
    rotations
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turns_take_each_axis_to_the_next() {
        // 1e-15: a handful of roundings of values near one.
        assert!((about_x(90.0) * DVec3::Y).distance(DVec3::Z) < 1e-15);
        assert!((about_y(90.0) * DVec3::Z).distance(DVec3::X) < 1e-15);
        assert!((about_z(90.0) * DVec3::X).distance(DVec3::Y) < 1e-15);
    }

    #[test]
    fn signs_become_continuous() {
        let q = about_x(20.0);
        assert_eq!(with_continuous_signs(vec![q, -q, q]), vec![q, q, q]);
    }
}
