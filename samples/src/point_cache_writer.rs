//! Writes vertex caches as PC2 and as MDD.

/// The bytes of a PC2 file: little-endian; a header of 32 bytes, then the points of each frame.
///
/// Shapes: `frames` is `[frame][point]`.
/// `start_frame` is the number of the first frame, `sample_rate` the frames from one sample to the next.
///
/// # Errors
/// [`CacheWriteError`] where frames differ in length or counts exceed 31 bits.
pub fn pc2_bytes(frames: &[Vec<[f32; 3]>], start_frame: f32, sample_rate: f32) -> Result<Vec<u8>, CacheWriteError> {
    let (frame_count, point_count) = counts(frames)?;
    let mut bytes = b"POINTCACHE2\0".to_vec();
    for word in [
        1i32.to_le_bytes(),
        point_count.to_le_bytes(),
        start_frame.to_le_bytes(),
        sample_rate.to_le_bytes(),
        frame_count.to_le_bytes(),
    ] {
        bytes.extend(word);
    }
    bytes.extend(coordinates(frames).flat_map(f32::to_le_bytes));
    Ok(bytes)
}

/// The bytes of an MDD file: big-endian; both counts, the time of each frame, then the points of each frame.
///
/// Shapes: `frames` is `[frame][point]`, `seconds` is `[frame]`.
///
/// # Errors
/// [`CacheWriteError`] where frames differ in length, a frame has no time, or counts exceed 31 bits.
pub fn mdd_bytes(frames: &[Vec<[f32; 3]>], seconds: &[f32]) -> Result<Vec<u8>, CacheWriteError> {
    let (frame_count, point_count) = counts(frames)?;
    if seconds.len() != frames.len() {
        return Err(CacheWriteError::Times {
            expected: frames.len(),
            found: seconds.len(),
        });
    }
    let mut bytes = frame_count.to_be_bytes().to_vec();
    bytes.extend(point_count.to_be_bytes());
    let numbers = seconds.iter().copied().chain(coordinates(frames));
    bytes.extend(numbers.flat_map(f32::to_be_bytes));
    Ok(bytes)
}

fn coordinates(frames: &[Vec<[f32; 3]>]) -> impl Iterator<Item = f32> {
    frames.iter().flatten().flatten().copied()
}

/// Frames, and points of each.
fn counts(frames: &[Vec<[f32; 3]>]) -> Result<(i32, i32), CacheWriteError> {
    let expected = frames.first().map_or(0, Vec::len);
    if let Some(frame) = frames.iter().position(|points| points.len() != expected) {
        return Err(CacheWriteError::UnevenFrames {
            frame,
            expected,
            found: frames[frame].len(),
        });
    }
    let narrow = |count: usize| i32::try_from(count).map_err(|_| CacheWriteError::TooMany { count });
    Ok((narrow(frames.len())?, narrow(expected)?))
}

/// Why a vertex cache could not be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CacheWriteError {
    /// A frame has another number of points than the first.
    #[error("frame {frame} has {found} points, the first has {expected}; a cache holds the same points in each frame")]
    UnevenFrames {
        /// Frame, from 0.
        frame: usize,
        /// Points of the first frame.
        expected: usize,
        /// Points of this frame.
        found: usize,
    },
    /// There is not one time per frame.
    #[error("{found} times for {expected} frames; give one time per frame")]
    Times {
        /// Frames.
        expected: usize,
        /// Times.
        found: usize,
    },
    /// A count does not fit the 31 bits that the formats have for it.
    #[error("{count} frames or points do not fit the formats' 31 bits; split the cache")]
    TooMany {
        /// Frames or points.
        count: usize,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pc2_is_little_endian_after_its_header() {
        let bytes = pc2_bytes(&[vec![[1.0, 2.0, -2.0]], vec![[0.5, 0.0, 4.0]]], 12.0, 0.5).expect("a cache");
        let expected = [
            *b"POIN",
            *b"TCAC",
            *b"HE2\0",
            [1, 0, 0, 0],
            [1, 0, 0, 0],
            [0, 0, 0x40, 0x41],
            [0, 0, 0, 0x3f],
            [2, 0, 0, 0],
            [0, 0, 0x80, 0x3f],
            [0, 0, 0, 0x40],
            [0, 0, 0, 0xc0],
            [0, 0, 0, 0x3f],
            [0, 0, 0, 0],
            [0, 0, 0x80, 0x40],
        ];
        assert_eq!(bytes, expected.as_flattened());
    }

    #[test]
    fn mdd_is_big_endian_with_its_times_first() {
        let bytes = mdd_bytes(&[vec![[1.0, 2.0, -2.0]]], &[0.5]).expect("a cache");
        let expected = [
            [0, 0, 0, 1],
            [0, 0, 0, 1],
            [0x3f, 0, 0, 0],
            [0x3f, 0x80, 0, 0],
            [0x40, 0, 0, 0],
            [0xc0, 0, 0, 0],
        ];
        assert_eq!(bytes, expected.as_flattened());
    }

    #[test]
    fn frames_that_do_not_fit_together_are_refused() {
        let uneven = [vec![[0.0; 3]; 2], vec![[0.0; 3]; 3]];
        let error = CacheWriteError::UnevenFrames {
            frame: 1,
            expected: 2,
            found: 3,
        };
        assert_eq!(pc2_bytes(&uneven, 0.0, 1.0), Err(error));
        let times = CacheWriteError::Times { expected: 1, found: 2 };
        assert_eq!(mdd_bytes(&uneven[..1], &[0.0, 1.0]), Err(times));
    }
}
