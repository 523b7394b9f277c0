//! A channel's value at a time.
//!
//! Source: glTF 2.0, appendix C (animation sampler interpolation modes). Everything in `f64`, with `libm`, so that every
//! platform computes the same bits.

use restpose_formats::{
    ModelView,
    rows::{ChannelRow, Interpolation, Path},
};

/// A channel of an open file.
pub(crate) struct Curve<'a> {
    times: &'a [f32],
    values: &'a [f32],
    width: usize,
    path: Path,
    interpolation: Interpolation,
}

/// Where a time falls among the keys.
enum Place {
    /// At a key, or before the first or behind the last one.
    Key(usize),
    /// Between this key and the next, at this fraction of the way.
    Between {
        key: usize,
        fraction: f64,
        step_seconds: f64,
    },
}

impl<'a> Curve<'a> {
    /// The channel in `row`, whose ranges and numbers were checked when the file was opened.
    pub(crate) fn new(model: &ModelView<'a>, row: &ChannelRow) -> Self {
        let interpolation = Interpolation::from_number(row.interpolation).unwrap_or(Interpolation::Step);
        let (width, keys) = (row.width as usize, row.key_count as usize);
        Self {
            times: &model.key_times[row.time_first as usize..][..keys],
            values: &model.key_values[row.value_first as usize..]
                [..keys * width * interpolation.values_per_key() as usize],
            width,
            path: Path::from_number(row.path).unwrap_or(Path::Translation),
            interpolation,
        }
    }

    fn place(&self, seconds: f32) -> Place {
        let later = self.times.partition_point(|time| *time <= seconds);
        if later == 0 {
            return Place::Key(0);
        }
        let key = later - 1;
        if later == self.times.len() || self.interpolation == Interpolation::Step || self.times[key] == seconds {
            return Place::Key(key);
        }
        let (begin, end) = (f64::from(self.times[key]), f64::from(self.times[later]));
        Place::Between {
            key,
            fraction: (f64::from(seconds) - begin) / (end - begin),
            step_seconds: end - begin,
        }
    }

    /// Component `k` of a key: `part` 0 is the in-tangent, 1 the value, 2 the out-tangent of a cubic spline.
    fn component(&self, key: usize, part: usize, k: usize) -> f64 {
        let index = match self.interpolation {
            Interpolation::CubicSpline => (key * 3 + part) * self.width + k,
            _ => key * self.width + k,
        };
        f64::from(self.values[index])
    }

    /// Component `k` of a channel whose components do not depend on each other.
    pub(crate) fn scalar(&self, seconds: f32, k: usize) -> f64 {
        match self.place(seconds) {
            Place::Key(key) => self.component(key, 1, k),
            Place::Between {
                key,
                fraction,
                step_seconds,
            } => self.between(key, fraction, step_seconds, k),
        }
    }

    fn between(&self, key: usize, s: f64, step_seconds: f64, k: usize) -> f64 {
        let (begin, end) = (self.component(key, 1, k), self.component(key + 1, 1, k));
        if self.interpolation == Interpolation::Linear {
            return (1.0 - s) * begin + s * end;
        }
        let (out, into) = (
            step_seconds * self.component(key, 2, k),
            step_seconds * self.component(key + 1, 0, k),
        );
        let (s2, s3) = (s * s, s * s * s);
        (2.0 * s3 - 3.0 * s2 + 1.0) * begin + (s3 - 2.0 * s2 + s) * out + (3.0 * s2 - 2.0 * s3) * end + (s3 - s2) * into
    }

    /// A rotation as a unit quaternion.
    pub(crate) fn rotation(&self, seconds: f32) -> [f64; 4] {
        let at = |key| std::array::from_fn(|k| self.component(key, 1, k));
        match self.place(seconds) {
            Place::Key(key) => normalized(at(key)),
            Place::Between { key, fraction, .. } if self.interpolation == Interpolation::Linear => {
                slerp(normalized(at(key)), normalized(at(key + 1)), fraction)
            }
            Place::Between {
                key,
                fraction,
                step_seconds,
            } => normalized(std::array::from_fn(|k| self.between(key, fraction, step_seconds, k))),
        }
    }

    /// What it moves.
    pub(crate) fn path(&self) -> Path {
        self.path
    }
}

/// The quaternion at length one; the identity where it has no length.
pub(crate) fn normalized(q: [f64; 4]) -> [f64; 4] {
    let length = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    if length > 0.0 && length.is_finite() {
        q.map(|x| x / length)
    } else {
        [0.0, 0.0, 0.0, 1.0]
    }
}

/// Spherical interpolation along the shorter arc between unit quaternions.
fn slerp(a: [f64; 4], b: [f64; 4], s: f64) -> [f64; 4] {
    let dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    let sign = if dot < 0.0 { -1.0 } else { 1.0 };
    // atan2 of the half-chords is accurate at any angle, where acos(dot) loses half the digits near zero.
    let chord = |sign: f64| {
        (0..4)
            .map(|k| (a[k] - sign * b[k]) * (a[k] - sign * b[k]))
            .sum::<f64>()
            .sqrt()
    };
    let angle = 2.0 * libm::atan2(chord(sign), chord(-sign));
    let sine = libm::sin(angle);
    let (from, to) = if sine > 0.0 {
        (libm::sin((1.0 - s) * angle) / sine, libm::sin(s * angle) / sine)
    } else {
        (1.0 - s, s)
    };
    normalized(std::array::from_fn(|k| from * a[k] + sign * to * b[k]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve<'a>(path: Path, interpolation: Interpolation, times: &'a [f32], values: &'a [f32]) -> Curve<'a> {
        let width = if path == Path::Rotation { 4 } else { 1 };
        Curve {
            times,
            values,
            width,
            path,
            interpolation,
        }
    }

    #[test]
    fn times_outside_the_keys_are_clamped_and_step_holds() {
        let step = curve(
            Path::Translation,
            Interpolation::Step,
            &[1.0, 2.0, 4.0],
            &[10.0, 20.0, 40.0],
        );
        for (seconds, value) in [
            (0.0, 10.0),
            (1.0, 10.0),
            (1.9, 10.0),
            (2.0, 20.0),
            (3.9, 20.0),
            (4.0, 40.0),
            (9.0, 40.0),
        ] {
            assert_eq!(step.scalar(seconds, 0), value, "at {seconds}");
        }
    }

    #[test]
    fn linear_is_linear() {
        let linear = curve(Path::Translation, Interpolation::Linear, &[1.0, 3.0], &[10.0, 20.0]);
        assert_eq!(linear.scalar(1.5, 0), 12.5);
        assert_eq!(linear.scalar(3.5, 0), 20.0);
    }

    #[test]
    fn cubic_spline_follows_hermite() {
        // p0 = 0 with out-tangent 2 per second, p1 = 4 with in-tangent 0, two seconds apart: at the middle
        // 0.5·p0 + 0.125·2·2 + 0.5·p1 − 0.125·2·0 = 2.5.
        let cubic = curve(
            Path::Translation,
            Interpolation::CubicSpline,
            &[0.0, 2.0],
            &[9.0, 0.0, 2.0, 0.0, 4.0, 9.0],
        );
        assert_eq!(cubic.scalar(1.0, 0), 2.5);
        assert_eq!(cubic.scalar(2.0, 0), 4.0);
    }

    #[test]
    fn rotations_take_the_shorter_arc_at_even_speed() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        // From none to a quarter turn about z, given with the opposite sign.
        let keys = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -half, -half];
        let turn = curve(Path::Rotation, Interpolation::Linear, &[0.0, 1.0], &keys);
        for (seconds, degrees) in [(0.25f32, 22.5f64), (0.5, 45.0), (0.75, 67.5)] {
            let [_, _, z, w] = turn.rotation(seconds);
            let found = 2.0 * libm::atan2(z, w).to_degrees();
            assert!((found - degrees).abs() < 1e-5, "{found} is not {degrees}");
        }
    }

    #[test]
    fn nearly_equal_rotations_interpolate_between_them() {
        let tiny = 1e-9;
        let b = normalized([tiny, 0.0, 0.0, 1.0]);
        let middle = slerp([0.0, 0.0, 0.0, 1.0], b, 0.5);
        assert!((middle[0] - 0.5 * tiny).abs() < 1e-18);
    }
}
