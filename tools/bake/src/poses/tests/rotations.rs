use crate::poses::rotation::{between, from_vector, uniform, vector_of};
use std::f64::consts::PI;

const ROTATIONS: usize = 20_000;

fn matrix(rotation: [f64; 4]) -> glam::DMat3 {
    glam::DMat3::from_quat(glam::DQuat::from_array(rotation))
}

#[test]
fn random_rotations_are_uniform_on_the_sphere_of_rotations() {
    let mut random = fastrand::Rng::with_seed(5);
    let matrices: Vec<_> = (0..ROTATIONS).map(|_| matrix(uniform(&mut random))).collect();
    let mean = |value: &dyn Fn(&glam::DMat3) -> f64| matrices.iter().map(value).sum::<f64>() / ROTATIONS as f64;
    // Every entry has mean 0 and variance 1/3, the trace mean 0 and variance 1; five standard deviations of the mean of so
    // many. Rotations whose angle is uniform have a trace of mean 1.
    let deviation = (1.0 / ROTATIONS as f64).sqrt();
    for (column, row) in (0..9).map(|k| (k / 3, k % 3)) {
        let entry = mean(&|matrix| matrix.col(column)[row]);
        assert!(entry.abs() < 5.0 * deviation / 3f64.sqrt(), "{column} {row}: {entry}");
    }
    let trace = |matrix: &glam::DMat3| matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z;
    assert!(mean(&trace).abs() < 5.0 * deviation);
    // The squared trace has mean 1 and variance 2.
    let squared = mean(&|matrix| trace(matrix).powi(2));
    assert!((squared - 1.0).abs() < 5.0 * deviation * 2f64.sqrt(), "{squared}");
}

#[test]
fn rotation_vectors_and_rotations_go_both_ways() {
    let mut random = fastrand::Rng::with_seed(6);
    for angle in [0.0, 1e-9, 0.1, 1.0, 0.5 * PI, 3.0, PI] {
        let axis = matrix(uniform(&mut random)).x_axis;
        let vector = (axis * angle).to_array();
        let found = vector_of(from_vector(vector));
        for k in 0..3 {
            // A dozen roundings, and at half a turn the sign is not known.
            let near = |x: f64| (found[k] - x).abs() <= 1e-14 * angle;
            assert!(near(vector[k]) || angle == PI && near(-vector[k]), "{angle}: {found:?}");
        }
    }
}

#[test]
fn a_rotation_between_two_is_in_the_axes_of_the_first() {
    let (quarter_x, third_y) = (from_vector([0.5 * PI, 0.0, 0.0]), from_vector([0.0, 1.0, 0.0]));
    let both = (glam::DQuat::from_array(quarter_x) * glam::DQuat::from_array(third_y)).to_array();
    let found = vector_of(between(quarter_x, both));
    // A few roundings of numbers up to 1.
    assert!(
        found[0].abs() < 1e-15 && (found[1] - 1.0).abs() < 1e-15 && found[2].abs() < 1e-15,
        "{found:?}"
    );
}
