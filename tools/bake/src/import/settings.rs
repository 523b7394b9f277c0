use super::ImportError;
use std::path::Path;

/// How vertex caches and OBJ sequences are read. A glTF file or a single OBJ mesh needs none of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImportSettings {
    /// Frames per second, finite and above zero. Default: 24 where the source counts in frames (PC2, OBJ sequences), the
    /// source's own times where it has them (MDD), which a rate replaces.
    pub frame_rate: Option<f64>,
    /// Which frames are kept. Default: all.
    pub frames: FrameRange,
}

/// Frames of a source to keep: `first`, `first + step` and so on up to `last`. Numbers count from 0 in the source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    /// First frame kept; there must be such a frame. Default 0.
    pub first: usize,
    /// No frame behind it is kept; there must be such a frame, `first` or later. Default: the last of the source.
    pub last: Option<usize>,
    /// Distance of the kept frames, at least 1. Default 1.
    pub step: usize,
}

impl Default for FrameRange {
    fn default() -> Self {
        Self {
            first: 0,
            last: None,
            step: 1,
        }
    }
}

impl std::fmt::Display for FrameRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.last {
            Some(last) => write!(f, "frames {} to {last}", self.first)?,
            None => write!(f, "frames from {}", self.first)?,
        }
        write!(f, ", every {}", self.step)
    }
}

/// Frames per second where neither source nor settings name a rate: that of film, and of the programs that write caches.
const DEFAULT_FRAME_RATE: f64 = 24.0;

/// A cache's channel holds frame numbers as `f32`, which counts exactly up to here.
const MAX_FRAMES: usize = 1 << 24;

impl ImportSettings {
    /// Refuses settings that no source can follow.
    pub(super) fn check(&self) -> Result<(), ImportError> {
        match self.frame_rate {
            Some(found) if !(found.is_finite() && found > 0.0) => Err(ImportError::FrameRate { found }),
            _ => Ok(()),
        }
    }

    /// The frame rate of a source that counts in frames.
    pub(super) fn frame_rate_or_default(&self) -> f64 {
        self.frame_rate.unwrap_or(DEFAULT_FRAME_RATE)
    }

    /// The frames to keep of `frame_count` that the source at `path` has.
    ///
    /// # Errors
    /// [`ImportError::FrameRange`], [`ImportError::TooManyFrames`].
    pub(super) fn kept_frames(&self, path: &Path, frame_count: usize) -> Result<KeptFrames, ImportError> {
        let FrameRange { first, last, step } = self.frames;
        let last = last.unwrap_or(frame_count.saturating_sub(1));
        if step == 0 || first > last || last >= frame_count {
            return Err(ImportError::FrameRange {
                path: path.to_owned(),
                range: self.frames,
                frame_count,
            });
        }
        let count = (last - first) / step + 1;
        if count > MAX_FRAMES {
            return Err(ImportError::TooManyFrames {
                path: path.to_owned(),
                found: count,
                limit: MAX_FRAMES,
            });
        }
        Ok(KeptFrames {
            first,
            last,
            step,
            count,
        })
    }
}

/// A [`FrameRange`] that the source can give: all frames exist, at least one is kept.
#[derive(Clone, Copy, Debug)]
pub(super) struct KeptFrames {
    first: usize,
    last: usize,
    step: usize,
    /// Frames kept.
    pub count: usize,
}

impl KeptFrames {
    /// Their numbers in the source.
    pub fn numbers(self) -> impl Iterator<Item = usize> {
        (self.first..=self.last).step_by(self.step)
    }

    /// As import options, in a fixed order.
    pub fn listed(self) -> [(String, String); 3] {
        [
            ("first_frame", self.first),
            ("last_frame", self.last),
            ("frame_step", self.step),
        ]
        .map(|(name, value)| (name.to_owned(), value.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(first: usize, last: Option<usize>, step: usize, frame_count: usize) -> Option<Vec<usize>> {
        let settings = ImportSettings {
            frame_rate: None,
            frames: FrameRange { first, last, step },
        };
        let kept = settings.kept_frames(Path::new("x"), frame_count).ok()?;
        let numbers: Vec<usize> = kept.numbers().collect();
        assert_eq!(numbers.len(), kept.count);
        Some(numbers)
    }

    #[test]
    fn a_range_keeps_its_frames() {
        assert_eq!(kept(0, None, 1, 3), Some(vec![0, 1, 2]));
        assert_eq!(kept(1, Some(6), 2, 8), Some(vec![1, 3, 5]));
        assert_eq!(kept(2, Some(2), 9, 3), Some(vec![2]));
    }

    #[test]
    fn a_range_that_the_source_does_not_have_is_refused() {
        for (first, last, step, frame_count) in [
            (0, None, 0, 3),
            (3, None, 1, 3),
            (2, Some(1), 1, 3),
            (0, Some(3), 1, 3),
            (0, None, 1, 0),
            (usize::MAX, Some(usize::MAX), usize::MAX, 3),
        ] {
            assert_eq!(
                kept(first, last, step, frame_count),
                None,
                "{first} {last:?} {step} {frame_count}"
            );
        }
    }

    #[test]
    fn no_more_frames_are_kept_than_a_channel_counts() {
        let settings = ImportSettings::default();
        assert_eq!(
            settings.kept_frames(Path::new("x"), MAX_FRAMES).unwrap().count,
            MAX_FRAMES
        );
        assert_eq!((MAX_FRAMES - 1) as f32 as usize, MAX_FRAMES - 1);
        let error = settings.kept_frames(Path::new("x"), MAX_FRAMES + 1).unwrap_err();
        assert!(matches!(error, ImportError::TooManyFrames { found, .. } if found == MAX_FRAMES + 1));
    }
}
