use std::fmt;

/// How a frame's mesh differs from that of the first frame.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ConnectivityDifference {
    /// It has another number of points.
    PointCount {
        /// Of the first frame.
        expected: usize,
        /// Of this frame.
        found: usize,
    },
    /// It has another number of faces.
    FaceCount {
        /// Of the first frame.
        expected: usize,
        /// Of this frame.
        found: usize,
    },
    /// Counts agree, but this face, the first of those that differ, has other corners.
    Corners {
        /// Number among the faces, counted from 0.
        face: usize,
        /// Line of this frame's file, counted from 1.
        line: usize,
        /// Points of its corners in the first frame, counted from 0.
        expected: Vec<u32>,
        /// Points of its corners in this frame, counted from 0.
        found: Vec<u32>,
    },
}

impl fmt::Display for ConnectivityDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::PointCount { expected, found } => write!(f, "has {found} points, the first frame {expected}"),
            Self::FaceCount { expected, found } => write!(f, "has {found} faces, the first frame {expected}"),
            Self::Corners {
                face,
                line,
                expected,
                found,
            } => write!(
                f,
                "face {} (line {line}) has the corners {}, in the first frame {}",
                *face as u64 + 1,
                Corners(found),
                Corners(expected)
            ),
        }
    }
}

/// Corners as an OBJ file has them, counted from 1.
struct Corners<'a>(&'a [u32]);

impl fmt::Display for Corners<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        /// More tell the reader nothing.
        const MOST_SHOWN: usize = 12;
        for (place, corner) in self.0.iter().take(MOST_SHOWN).enumerate() {
            let space = if place == 0 { "" } else { " " };
            write!(f, "{space}{}", u64::from(*corner) + 1)?;
        }
        if self.0.len() > MOST_SHOWN {
            write!(f, " … ({} in all)", self.0.len())?;
        }
        Ok(())
    }
}
