//! The two cache formats.
//!
//! PC2, little-endian: the 12 bytes `POINTCACHE2\0`, i32 version 1, i32 points, f32 start frame, f32 frames from one
//! sample to the next, i32 samples; then samples × points × 3 f32.
//!
//! MDD, big-endian: i32 frames, i32 points, one f32 per frame with its time in seconds; then frames × points × 3 f32.

pub(super) const PC2_MAGIC: &[u8; 12] = b"POINTCACHE2\0";

/// Seconds of each frame, and its points.
type Frames = (Vec<f64>, Vec<Vec<[f32; 3]>>);

struct Words<'a> {
    bytes: &'a [u8],
    big_endian: bool,
}

impl Words<'_> {
    fn word(&mut self) -> [u8; 4] {
        let (word, rest) = self.bytes.split_first_chunk().expect("the cache ends too early");
        self.bytes = rest;
        *word
    }

    fn count(&mut self) -> usize {
        let word = self.word();
        let count = if self.big_endian {
            i32::from_be_bytes(word)
        } else {
            i32::from_le_bytes(word)
        };
        usize::try_from(count).expect("a count below zero")
    }

    fn number(&mut self) -> f32 {
        let word = self.word();
        if self.big_endian {
            f32::from_be_bytes(word)
        } else {
            f32::from_le_bytes(word)
        }
    }

    /// All that is left.
    fn frames(mut self, frames: usize, points: usize) -> Vec<Vec<[f32; 3]>> {
        assert_eq!(
            self.bytes.len(),
            frames * points * 12,
            "bytes of {frames} frames of {points} points"
        );
        let mut point = || std::array::from_fn(|_| self.number());
        (0..frames).map(|_| (0..points).map(|_| point()).collect()).collect()
    }
}

pub(super) fn pc2(bytes: &[u8], frames_per_second: f64) -> Frames {
    let bytes = bytes.strip_prefix(PC2_MAGIC).expect("the magic word of PC2");
    let mut words = Words {
        bytes,
        big_endian: false,
    };
    assert_eq!(words.count(), 1, "version");
    let points = words.count();
    let (start, rate) = (f64::from(words.number()), f64::from(words.number()));
    let samples = words.count();
    let seconds = |sample| (start + sample as f64 * rate) / frames_per_second;
    ((0..samples).map(seconds).collect(), words.frames(samples, points))
}

/// A frame rate replaces the file's own times.
pub(super) fn mdd(bytes: &[u8], frames_per_second: Option<f64>) -> Frames {
    let mut words = Words {
        bytes,
        big_endian: true,
    };
    let (frames, points) = (words.count(), words.count());
    let own: Vec<f64> = (0..frames).map(|_| f64::from(words.number())).collect();
    let seconds = match frames_per_second {
        Some(rate) => (0..frames).map(|frame| frame as f64 / rate).collect(),
        None => own,
    };
    (seconds, words.frames(frames, points))
}
