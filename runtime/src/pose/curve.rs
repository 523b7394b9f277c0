//! A channel's value at a time.
//!
//! Source: glTF 2.0, appendix C (animation sampler interpolation modes). Everything in `f64`, with no operation that IEEE
//! 754 does not round, so that every platform computes the same bits.

use super::arcs::Arc;
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

/// A rotation at a time.
pub(super) enum Rotation {
    /// A unit quaternion.
    Here([f64; 4]),
    /// To be interpolated.
    On(Arc),
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

    /// `later` is a guess of how many keys are not after `seconds`, and becomes their number: most channels of a clip
    /// have the same times, though not in the same rows.
    #[inline(always)]
    fn place(&self, seconds: f32, later: &mut usize) -> Place {
        let is_before = |key: usize| self.times.get(key).is_some_and(|time| *time <= seconds);
        let is_right = *later <= self.times.len() && (*later == 0 || is_before(*later - 1)) && !is_before(*later);
        if !is_right {
            *later = self.times.partition_point(|time| *time <= seconds);
        }
        let later = *later;
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

    /// Component `k` of a channel whose components do not depend on each other. `later` as in [`Self::place`].
    pub(crate) fn scalar(&self, seconds: f32, later: &mut usize, k: usize) -> f64 {
        match self.place(seconds, later) {
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

    /// A rotation. `later` as in [`Self::place`].
    #[inline(always)]
    pub(super) fn rotation(&self, seconds: f32, later: &mut usize) -> Rotation {
        match self.place(seconds, later) {
            Place::Key(key) => Rotation::Here(normalized(self.quaternion(key).map(f64::from))),
            Place::Between { key, fraction, .. } if self.interpolation == Interpolation::Linear => Rotation::On(Arc {
                keys: [self.quaternion(key), self.quaternion(key + 1)],
                fraction,
            }),
            Place::Between {
                key,
                fraction,
                step_seconds,
            } => Rotation::Here(normalized(std::array::from_fn(|k| {
                self.between(key, fraction, step_seconds, k)
            }))),
        }
    }

    /// A key's value.
    #[inline(always)]
    fn quaternion(&self, key: usize) -> [f32; 4] {
        let row = match self.interpolation {
            Interpolation::CubicSpline => key * 3 + 1,
            _ => key,
        };
        let (quaternions, _) = self.values.as_chunks();
        quaternions[row]
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
            assert_eq!(step.scalar(seconds, &mut 0, 0), value, "at {seconds}");
        }
    }

    #[test]
    fn linear_is_linear() {
        let linear = curve(Path::Translation, Interpolation::Linear, &[1.0, 3.0], &[10.0, 20.0]);
        assert_eq!(linear.scalar(1.5, &mut 0, 0), 12.5);
        assert_eq!(linear.scalar(3.5, &mut 0, 0), 20.0);
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
        assert_eq!(cubic.scalar(1.0, &mut 0, 0), 2.5);
        assert_eq!(cubic.scalar(2.0, &mut 0, 0), 4.0);
    }

    #[test]
    fn a_guess_changes_nothing() {
        let times = [1.0, 2.0, 4.0];
        for interpolation in [Interpolation::Step, Interpolation::Linear] {
            let curve = curve(Path::Translation, interpolation, &times, &[10.0, 20.0, 40.0]);
            for seconds in [0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 9.0] {
                let expected = curve.scalar(seconds, &mut 0, 0);
                for guess in [1, 2, 3, 4, usize::MAX] {
                    let mut later = guess;
                    assert_eq!(
                        curve.scalar(seconds, &mut later, 0),
                        expected,
                        "at {seconds} from {guess}"
                    );
                    assert_eq!(later, times.iter().filter(|time| **time <= seconds).count());
                }
            }
        }
    }
}
