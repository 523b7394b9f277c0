//! Vertex caches: files that hold where every point is in every frame, and no faces.

pub(super) mod mdd;
pub(super) mod pc2;

use super::{
    Fault, ImportSettings, MAX_MAGNITUDE, fault_list::FaultList, magnitude, settings::KeptFrames, timeline::Seconds,
};

/// Bytes of a point: three floats.
const POINT_BYTES: usize = 12;

/// A vertex cache of known size, not yet decoded.
#[derive(Debug)]
pub(super) struct Cache<'a> {
    /// Points of a frame, at least one.
    pub point_count: usize,
    /// Frames, at least one.
    pub frame_count: usize,
    times: Times,
    /// All frames and nothing else.
    frames: &'a [u8],
    /// Reads a float in the file's byte order.
    float: fn([u8; 4]) -> f32,
}

/// When the frames are.
#[derive(Debug)]
enum Times {
    /// In frames: the first, and the distance to the next.
    Frames { start: f32, step: f32 },
    /// In seconds, one per frame.
    Seconds(Vec<f32>),
}

impl<'a> Cache<'a> {
    /// Checks the counts of a header against what is behind it, before anything is made of them.
    ///
    /// # Errors
    /// A fault: no points, no frames, or fewer bytes than declared.
    fn new(
        counts: Counts,
        times: Times,
        body: &'a [u8],
        float: fn([u8; 4]) -> f32,
        faults: &mut FaultList,
    ) -> Result<Self, Fault> {
        let Counts { points, frames } = counts;
        let frame_bytes = points.checked_mul(POINT_BYTES);
        let declared = frame_bytes.and_then(|bytes| bytes.checked_mul(frames));
        let Some(exact) = declared.and_then(|bytes| body.get(..bytes)) else {
            let complete = frame_bytes.map_or(0, |bytes| body.len() / bytes.max(1));
            let message = format!(
                "truncated: the header declares {frames} frames of {points} points, the file has {complete} complete \
                 frames; copy or export it again"
            );
            return Err(Fault::error("", message));
        };
        if body.len() > exact.len() {
            let extra = body.len() - exact.len();
            faults.warn(
                "",
                format!("{extra} bytes behind the last frame of the vertex cache are ignored"),
            );
        }
        Ok(Self {
            point_count: points,
            frame_count: frames,
            times,
            frames: exact,
            float,
        })
    }

    /// Decodes the kept frames, frame after frame; numbers that cannot be used are faults at `frame N point M`.
    pub fn positions(&self, kept: KeptFrames, faults: &mut FaultList) -> Vec<[f32; 3]> {
        // Both factors are bounded by the file's length.
        let mut out = Vec::with_capacity(kept.count * self.point_count);
        for number in kept.numbers() {
            let begin = number * self.point_count * POINT_BYTES;
            let bytes = self.frames.get(begin..begin + self.point_count * POINT_BYTES);
            let floats = bytes.unwrap_or_default().as_chunks::<4>().0;
            let points = floats.as_chunks::<3>().0;
            let first = out.len();
            out.extend(points.iter().map(|point| point.map(self.float)));
            let frame = out.get(first..).unwrap_or_default();
            let is_usable = |value: &f32| value.abs() <= MAX_MAGNITUDE;
            if !frame.as_flattened().iter().all(is_usable) {
                list_flaws(number, frame, faults);
            }
        }
        out
    }

    /// When the kept frames are.
    ///
    /// # Errors
    /// A fault: the header's numbers make no times.
    pub fn seconds(&self, kept: KeptFrames, settings: &ImportSettings) -> Result<Seconds, Fault> {
        match (&self.times, settings.frame_rate) {
            (Times::Frames { start, step }, _) => {
                if !(start.is_finite() && step.is_finite() && *step > 0.0) {
                    let message = format!(
                        "the header puts sample 0 at frame {start} and each next one {step} frames later; expected a \
                         finite start and a sample rate above zero, export the cache again"
                    );
                    return Err(Fault::error("header", message));
                }
                let (start, step) = (f64::from(*start), f64::from(*step));
                Ok(Seconds::at_rate(kept, start, step, settings.frame_rate_or_default()))
            }
            (Times::Seconds(_), Some(rate)) => Ok(Seconds::at_rate(kept, 0.0, 1.0, rate)),
            (Times::Seconds(seconds), None) => Ok(Seconds {
                times: kept
                    .numbers()
                    .filter_map(|number| seconds.get(number).copied())
                    .collect(),
                frame_rate: None,
            }),
        }
    }
}

fn list_flaws(number: usize, frame: &[[f32; 3]], faults: &mut FaultList) {
    for (point, position) in frame.iter().enumerate() {
        for (axis, value) in ["x", "y", "z"].into_iter().zip(position) {
            if let Some(flaw) = magnitude::flaw(*value) {
                faults.error(format!("frame {number} point {point}"), format!("{axis} {flaw}"));
            }
        }
    }
}

/// Counts of a header, each at least one.
#[derive(Clone, Copy, Debug)]
struct Counts {
    points: usize,
    frames: usize,
}

impl Counts {
    /// # Errors
    /// A fault: a count is zero or negative.
    fn new(points: i32, frames: i32) -> Result<Self, Fault> {
        let count = |what: &str, found: i32| match usize::try_from(found) {
            Ok(count) if count > 0 => Ok(count),
            _ => {
                let message = format!("the vertex cache declares {found} {what}; expected at least one");
                Err(Fault::error("header", message))
            }
        };
        Ok(Self {
            points: count("points", points)?,
            frames: count("frames", frames)?,
        })
    }
}

/// The header is longer than the file.
fn short_header(expected: usize, found: usize) -> Fault {
    let message = format!("truncated: the header has {expected} bytes, the file {found}; copy or export it again");
    Fault::error("header", message)
}
