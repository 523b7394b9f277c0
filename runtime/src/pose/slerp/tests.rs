use super::*;

/// Half a unit in the last place of one: what a rounding is off by, relative to its result.
const U: f64 = f64::EPSILON / 2.0;

/// Everything that [`slerp`]'s documentation adds up, 2⁻⁴⁷, and what [`by_sines`] is off by: some thirty roundings.
const BOUND: f64 = 128.0 * U;

fn length(q: [f64; 4]) -> f64 {
    q.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn distance(a: [f64; 4], b: [f64; 4]) -> f64 {
    length(std::array::from_fn(|k| a[k] - b[k]))
}

fn unit(q: [f64; 4]) -> [f64; 4] {
    q.map(|x| x / length(q))
}

/// The lanes that hold `q` alone.
fn splat(q: [f64; 4]) -> [Four; 4] {
    q.map(|x| [x; LANES])
}

fn one(a: [f64; 4], b: [f64; 4], s: f64) -> [f64; 4] {
    slerp(SimdLevel::Portable, &splat(a), &splat(b), &[s; LANES]).map(|component| component[0])
}

/// As glTF 2.0, appendix C, has it, the angle from half the chords: `acos` of the product has lost it where it is small.
fn by_sines(a: [f64; 4], b: [f64; 4], s: f64) -> [f64; 4] {
    let (a, b) = (unit(a), unit(b));
    let dot: f64 = (0..4).map(|k| a[k] * b[k]).sum();
    let b = if dot < 0.0 { b.map(|x| -x) } else { b };
    let angle = 2.0 * libm::atan2(distance(a, b), distance(a, b.map(|x| -x)));
    let part = |s: f64| {
        if angle > 0.0 {
            libm::sin(s * angle) / libm::sin(angle)
        } else {
            s
        }
    };
    std::array::from_fn(|k| part(1.0 - s) * a[k] + part(s) * b[k])
}

/// A unit quaternion and one at a right angle to it.
fn right_angle(random: &mut fastrand::Rng) -> [[f64; 4]; 2] {
    let mut any = || unit(std::array::from_fn(|_| random.f64() - 0.5));
    let (a, c) = (any(), any());
    let dot: f64 = (0..4).map(|k| a[k] * c[k]).sum();
    [a, unit(std::array::from_fn(|k| c[k] - dot * a[k]))]
}

/// The bounds of the polynomials, and a dozen roundings here and there.
#[test]
fn polynomials_are_as_near_as_they_say() {
    for step in 1..=4000 {
        let angle = std::f64::consts::FRAC_PI_2 * f64::from(step) / 4000.0;
        let half = libm::sin(0.5 * angle);
        let y = 2.0 * half * half;
        let [square, ..] = polynomial(&SQUARE, [y; LANES]);
        assert!((y * square / (angle * angle) - 1.0).abs() < 12.0 * U, "{angle}");
        let [sine, ..] = polynomial(&SINE, [angle * angle; LANES]);
        assert!((angle * sine / libm::sin(angle) - 1.0).abs() < 16.0 * U, "{angle}");
    }
}

#[test]
fn arcs_agree_with_sines() {
    let mut random = fastrand::Rng::with_seed(1);
    for step in 0..=400 {
        // Half the angles between the rotations: from 10⁻¹² radians to a right angle evenly by their digits, then up to
        // the whole turn that is none.
        let angle = if step <= 200 {
            1e-12 * (std::f64::consts::FRAC_PI_2 / 1e-12).powf(f64::from(step) / 200.0)
        } else {
            std::f64::consts::FRAC_PI_2 * f64::from(step) / 200.0
        };
        for _ in 0..20 {
            let [a, c] = right_angle(&mut random);
            let b: [f64; 4] = std::array::from_fn(|k| libm::cos(angle) * a[k] + libm::sin(angle) * c[k]);
            let lengths = [random.f64() + 0.01, random.f64() * 100.0 + 0.01];
            let (long_a, long_b) = (a.map(|x| x * lengths[0]), b.map(|x| x * lengths[1]));
            for s in [0.0, 1e-9, 0.25, 0.5, random.f64(), 1.0] {
                let (found, expected) = (one(long_a, long_b, s), by_sines(long_a, long_b, s));
                // Where the signs of the products differ by rounding, either arc is right.
                let is_half_turn = (angle - std::f64::consts::FRAC_PI_2).abs() < 1e-15;
                if !is_half_turn {
                    assert!(
                        distance(found, expected) <= BOUND,
                        "{angle} {s}: {found:?} {expected:?}"
                    );
                }
                assert!((length(found) - 1.0).abs() <= BOUND, "{angle} {s}");
            }
        }
    }
}

/// Tiny angles keep their digits, for the weights do.
#[test]
fn nearly_equal_rotations_interpolate_between_them() {
    for angle in [1e-9, 1e-20, 1e-40] {
        let [x, y, z, w] = one([0.0, 0.0, 0.0, 1.0], [angle, 0.0, 0.0, 1.0], 0.5);
        assert!((x / angle - 0.5).abs() < 8.0 * U, "{angle}: {x}");
        assert_eq!([y, z], [0.0; 2]);
        assert!((w - 1.0).abs() < 8.0 * U);
    }
}

/// Two roundings per key are in its length, one more in each weight.
#[test]
fn ends_and_equal_keys_are_met() {
    let mut random = fastrand::Rng::with_seed(2);
    for _ in 0..1000 {
        let [a, c] = right_angle(&mut random).map(|q| q.map(|x| 3.0 * x));
        let b: [f64; 4] = std::array::from_fn(|k| a[k] + random.f64() * c[k]);
        let s = random.f64();
        let minus = |q: [f64; 4]| q.map(|x| -x);
        for (found, expected) in [
            (one(a, b, 0.0), a),
            (one(a, b, 1.0), b),
            (one(a, minus(b), 1.0), b),
            (one(a, a, s), a),
            (one(a, minus(a), s), a),
        ] {
            assert!(distance(found, unit(expected)) < 16.0 * U, "{found:?} {expected:?}");
        }
    }
}

#[test]
fn half_turns_have_the_arc_of_their_sign() {
    let none = [0.0, 0.0, 0.0, 1.0];
    let half = std::f64::consts::FRAC_1_SQRT_2;
    for (w, x) in [
        (0.0, half),
        (-0.0, half),
        (1e-17, half),
        (-1e-17, -half),
        (-1e-300, -half),
    ] {
        let found = one(none, [1.0, 0.0, 0.0, w], 0.5);
        assert!(distance(found, [x, 0.0, 0.0, half]) < 16.0 * U, "{w}: {found:?}");
    }
}

#[test]
fn keys_without_length_count_as_the_identity() {
    let [none, zero, turn] = [[0.0, 0.0, 0.0, 1.0], [0.0; 4], [0.0, 0.6, 0.0, 0.8]];
    assert_eq!(one(zero, turn, 0.3), one(none, turn, 0.3));
    assert_eq!(one(turn, zero, 0.3), one(turn, none, 0.3));
    assert_eq!(one(zero, zero, 0.3), none);
    // The least and the greatest lengths that f32 has.
    let (least, greatest) = (f64::from(f32::from_bits(1)), f64::from(f32::MAX));
    let found = one([0.0, 0.0, 0.0, least], [greatest; 4], 1.0);
    assert!(distance(found, [0.5; 4]) < 16.0 * U, "{found:?}");
}

#[test]
fn lanes_do_not_touch_each_other_at_any_level() {
    let mut random = fastrand::Rng::with_seed(3);
    for _ in 0..1000 {
        let mut any = || -> [Four; 4] { std::array::from_fn(|_| std::array::from_fn(|_| random.f64() - 0.5)) };
        let (a, b) = (any(), any());
        let s = std::array::from_fn(|_| random.f64());
        let together = slerp(SimdLevel::detect(), &a, &b, &s);
        for lane in 0..LANES {
            let of = |lanes: &[Four; 4]| lanes.map(|component| component[lane]);
            assert_eq!(
                one(of(&a), of(&b), s[lane]).map(f64::to_bits),
                of(&together).map(f64::to_bits)
            );
        }
    }
}
