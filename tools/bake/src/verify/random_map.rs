use super::pose_source::{PoseFamily, SMALL_TURN_DEG};
use fastrand::Rng;
use glam::{DAffine3, DMat3, DQuat, DVec3, DVec4};
use restpose_runtime::Affine;

/// A number from −`magnitude` to `magnitude`.
fn signed(random: &mut Rng, magnitude: f64) -> f64 {
    (random.f64() * 2.0 - 1.0) * magnitude
}

/// A rotation, all alike.
///
/// Points of a ball are drawn from the cube around it; their directions are spread evenly, and unit quaternions that are
/// spread evenly are rotations that are (Shoemake 1992).
pub(super) fn rotation(random: &mut Rng) -> DQuat {
    loop {
        let q = DVec4::from_array(std::array::from_fn(|_| signed(random, 1.0)));
        // Short ones would lose digits when they are made longer.
        if (0.01..=1.0).contains(&q.length_squared()) {
            return DQuat::from_vec4(q.normalize());
        }
    }
}

/// A direction, all alike.
pub(super) fn direction(random: &mut Rng) -> DVec3 {
    rotation(random) * DVec3::X
}

/// A turn by up to [`SMALL_TURN_DEG`] about any axis.
pub(super) fn small_turn(random: &mut Rng) -> DQuat {
    DQuat::from_axis_angle(direction(random), random.f64() * SMALL_TURN_DEG.to_radians())
}

/// What a family does to a bone in the space of its joint; nothing where it does that elsewhere.
pub(super) fn distortion(family: PoseFamily, random: &mut Rng) -> DAffine3 {
    let linear = match family {
        PoseFamily::Scaled => DMat3::from_diagonal(DVec3::from_array(std::array::from_fn(|_| {
            2f64.powf(signed(random, 6.0))
        }))),
        PoseFamily::Sheared => {
            let mut shear = DMat3::IDENTITY;
            let column = random.usize(..3);
            for row in (0..3).filter(|row| *row != column) {
                shear.col_mut(column)[row] = signed(random, 3.0);
            }
            shear
        }
        PoseFamily::Mirrored => {
            let n = direction(random);
            DMat3::from_cols_array_2d(&std::array::from_fn(|j| {
                std::array::from_fn(|k| f64::from(u8::from(j == k)) - 2.0 * n[j] * n[k])
            }))
        }
        PoseFamily::Vanished => {
            let scales = [[0.0; 3], [1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1e-30; 3]];
            DMat3::from_diagonal(scales[random.usize(..scales.len())].into())
        }
        PoseFamily::NearSingular => {
            let flat = 10f64.powf(-4.0 - 3.0 * random.f64());
            let middle = if random.bool() { 1.0 } else { flat };
            let [a, b] = [0; 2].map(|_| DMat3::from_quat(rotation(random)));
            a * DMat3::from_diagonal(DVec3::new(1.0, middle, flat)) * b
        }
        PoseFamily::Ragdoll
        | PoseFamily::SmallTurns
        | PoseFamily::Blend
        | PoseFamily::Mix
        | PoseFamily::Far
        | PoseFamily::Morphs => DMat3::IDENTITY,
    };
    DAffine3::from_mat3(linear)
}

/// A rotation, mirrored at times, with uneven scale and a translation of a few units.
pub(super) fn instance_transform(random: &mut Rng) -> Affine {
    let rotation = rotation(random);
    let translation = DVec3::from_array(std::array::from_fn(|_| signed(random, 8.0)));
    let mut scale = DVec3::from_array(std::array::from_fn(|_| 1.0 + signed(random, 0.6)));
    if random.bool() {
        scale.z = -scale.z;
    }
    rounded(&DAffine3::from_scale_rotation_translation(scale, rotation, translation))
}

/// The map in `f32`; numbers beyond its range stand at its ends, so that every map is finite.
pub(super) fn rounded(map: &DAffine3) -> Affine {
    Affine {
        columns: map.to_cols_array_2d().map(|column| column.map(rounded_number)),
    }
}

/// As [`rounded`]; NaN, which only numbers beyond `f64` make, is zero.
pub(super) fn rounded_number(x: f64) -> f32 {
    if x.is_nan() {
        0.0
    } else {
        (x as f32).clamp(f32::MIN, f32::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use restpose_runtime::invert_frame;

    fn drawn(family: PoseFamily) -> Vec<DAffine3> {
        let mut random = Rng::with_seed(3);
        (0..200).map(|_| distortion(family, &mut random)).collect()
    }

    /// The mean of 10,000 unit vectors spread evenly is shorter than 0.05 but for odds of 1e-10 (five times its standard
    /// deviation, 1/√10,000); the mean square of each entry of an even rotation is 1/3.
    #[test]
    fn rotations_are_spread_evenly() {
        let mut random = Rng::with_seed(1);
        let (mut sum, mut squares) = ([DVec3::ZERO; 3], DVec3::ZERO);
        let count = 10_000;
        for _ in 0..count {
            let q = rotation(&mut random);
            assert!((q.length() - 1.0).abs() < 1e-12);
            for (k, axis) in DVec3::AXES.into_iter().enumerate() {
                sum[k] += q * axis;
            }
            squares += (q * DVec3::X) * (q * DVec3::X);
        }
        for mean in sum.map(|sum| sum / f64::from(count)) {
            assert!(mean.length() < 0.05, "{mean}");
        }
        let squares = squares / f64::from(count);
        assert!(
            (squares - DVec3::splat(1.0 / 3.0)).abs().max_element() < 0.02,
            "{squares}"
        );
    }

    #[test]
    fn small_turns_are_small_and_reach_their_limit() {
        let mut random = Rng::with_seed(2);
        let angles: Vec<f64> = (0..1_000)
            .map(|_| small_turn(&mut random).to_axis_angle().1.to_degrees())
            .collect();
        let largest = angles.iter().copied().fold(0.0, f64::max);
        assert!(
            (0.95 * SMALL_TURN_DEG..=SMALL_TURN_DEG * (1.0 + 1e-12)).contains(&largest),
            "{largest}"
        );
    }

    #[test]
    fn distortions_are_what_their_families_say() {
        for map in drawn(PoseFamily::Mirrored) {
            assert!((map.matrix3.determinant() + 1.0).abs() < 1e-12);
        }
        for map in drawn(PoseFamily::Sheared) {
            assert!((map.matrix3.determinant() - 1.0).abs() < 1e-12 && map.matrix3 != DMat3::IDENTITY);
        }
        for map in drawn(PoseFamily::Scaled) {
            let factors = [map.matrix3.x_axis.x, map.matrix3.y_axis.y, map.matrix3.z_axis.z];
            assert!(
                factors.iter().all(|factor| (1.0 / 64.0..=64.0).contains(factor)),
                "{factors:?}"
            );
        }
        let vanished = drawn(PoseFamily::Vanished);
        assert!(vanished.iter().all(|map| invert_frame(&rounded(map)).is_none()));
        let near: Vec<bool> = drawn(PoseFamily::NearSingular)
            .iter()
            .map(|map| invert_frame(&rounded(map)).is_some())
            .collect();
        // The runtime takes frames up to a condition of 2¹⁶, so both its ways are met.
        assert!(near.contains(&true) && near.contains(&false));
    }

    #[test]
    fn maps_are_finite_whatever_overflows() {
        let beyond =
            DAffine3::from_cols_array(&[1e300, -1e300, f64::NAN, 1e-300, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        let map = rounded(&beyond);
        assert!(map.is_finite());
        assert_eq!(map.columns[0], [f32::MAX, f32::MIN, 0.0]);
    }
}
