use crate::import::{Channel, ChannelTarget};
use glam::DVec4;
use restpose_formats::rows::Interpolation;

/// A channel's value at a time.
pub(super) fn value(channel: &Channel, seconds: f64) -> Vec<f64> {
    let per_key = channel.values.len() / channel.times.len();
    let width = per_key / channel.interpolation.values_per_key() as usize;
    let key = |key: usize, part: usize| -> Vec<f64> {
        let begin = key * per_key
            + if channel.interpolation == Interpolation::CubicSpline {
                part * width
            } else {
                0
            };
        channel.values[begin..begin + width]
            .iter()
            .map(|x| f64::from(*x))
            .collect()
    };
    let last = channel.times.len() - 1;
    let next = channel
        .times
        .iter()
        .position(|time| f64::from(*time) > seconds)
        .unwrap_or(last + 1);
    if next == 0 {
        return key(0, 1);
    }
    if next > last || channel.interpolation == Interpolation::Step {
        return key(next - 1, 1);
    }
    let (begin, end) = (f64::from(channel.times[next - 1]), f64::from(channel.times[next]));
    let (step, s) = (end - begin, (seconds - begin) / (end - begin));
    let (a, b) = (key(next - 1, 1), key(next, 1));
    if channel.interpolation == Interpolation::Linear {
        if channel.target == ChannelTarget::Rotation {
            return slerp(&a, &b, s).to_vec();
        }
        return a.iter().zip(&b).map(|(a, b)| a + (b - a) * s).collect();
    }
    let (out, into) = (key(next - 1, 2), key(next, 0));
    let hermite = |k: usize| {
        (2.0 * s.powi(3) - 3.0 * s.powi(2) + 1.0) * a[k]
            + step * (s.powi(3) - 2.0 * s.powi(2) + s) * out[k]
            + (3.0 * s.powi(2) - 2.0 * s.powi(3)) * b[k]
            + step * (s.powi(3) - s.powi(2)) * into[k]
    };
    (0..width).map(hermite).collect()
}

fn slerp(a: &[f64], b: &[f64], s: f64) -> [f64; 4] {
    let (a, mut b) = (DVec4::from_slice(a).normalize(), DVec4::from_slice(b).normalize());
    if a.dot(b) < 0.0 {
        b = -b;
    }
    // Exponential of a fraction of the logarithm, another way than the runtime's.
    let across = b - a * a.dot(b);
    let (sine, cosine) = (across.length(), a.dot(b));
    if sine == 0.0 {
        return a.to_array();
    }
    let angle = s * sine.atan2(cosine);
    (a * angle.cos() + across / sine * angle.sin()).to_array()
}
