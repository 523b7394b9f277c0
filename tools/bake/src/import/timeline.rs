use super::{Fault, fault_list::FaultList, magnitude, settings::KeptFrames};

/// When the kept frames are, and the options that say so.
#[derive(Debug)]
pub(super) struct Timeline {
    /// Seconds per kept frame, strictly increasing; none for a single frame, which is no motion.
    pub times: Vec<f32>,
    /// Settings that changed it, in a fixed order.
    pub options: Vec<(String, String)>,
}

/// When frames are, as a source has it.
#[derive(Debug)]
pub(super) struct Seconds {
    /// Seconds per kept frame, not yet checked.
    pub times: Vec<f32>,
    /// The frame rate that they were made with, if any.
    pub frame_rate: Option<f64>,
}

impl Seconds {
    /// Frames at `start`, `start + step` and so on, counted in frames of which `rate` make a second.
    pub fn at_rate(kept: KeptFrames, start: f64, step: f64, rate: f64) -> Self {
        let time = |number: usize| ((start + step * number as f64) / rate) as f32;
        Self {
            times: kept.numbers().map(time).collect(),
            frame_rate: Some(rate),
        }
    }
}

impl Timeline {
    /// Of more than one frame, asks for the times and checks them.
    ///
    /// # Errors
    /// That of `seconds`, or a fault at `frame N`: not a number, too large, or not after the frame before.
    pub fn new(
        kept: KeptFrames,
        seconds: impl FnOnce() -> Result<Seconds, Fault>,
        faults: &mut FaultList,
    ) -> Result<Self, Fault> {
        let mut options = Vec::new();
        let mut times = Vec::new();
        if kept.count > 1 {
            let seconds = seconds()?;
            check(&seconds, kept, faults)?;
            times = seconds.times;
            options.extend(
                seconds
                    .frame_rate
                    .map(|rate| ("frame_rate".to_owned(), rate.to_string())),
            );
        }
        options.extend(kept.listed());
        Ok(Self { times, options })
    }
}

fn check(seconds: &Seconds, kept: KeptFrames, faults: &mut FaultList) -> Result<(), Fault> {
    let remedy = match seconds.frame_rate {
        Some(_) => "take another frame rate",
        None => "name a frame rate, which replaces the times of the file",
    };
    let mut previous: Option<(usize, f32)> = None;
    for (number, time) in kept.numbers().zip(&seconds.times) {
        let at = || format!("frame {number}");
        if let Some(flaw) = magnitude::flaw(*time) {
            return Err(Fault::error(at(), format!("its time in seconds {flaw}; {remedy}")));
        }
        match previous {
            None if *time < 0.0 => faults.warn(at(), format!("is at {time} s; expected none before zero")),
            Some((before, earlier)) if earlier >= *time => {
                let message =
                    format!("is at {time} s, frame {before} at {earlier} s; expected increasing times, {remedy}");
                return Err(Fault::error(at(), message));
            }
            _ => {}
        }
        previous = Some((number, *time));
    }
    Ok(())
}
