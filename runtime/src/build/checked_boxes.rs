use restpose_formats::geom::Aabb;
use thiserror::Error;

/// Boxes that every builder ends on: at least one, finite, none inverted, countable. What [`BuildError`] refuses is
/// refused here, before any work.
#[derive(Clone, Copy, Debug)]
pub struct CheckedBoxes<'a>(&'a [Aabb]);

/// Why no tree can be built over a list of boxes.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum BuildError {
    /// There is nothing to build over.
    #[error("no boxes; expected at least one; leave out what is empty")]
    NoBoxes,
    /// Indices would not fit.
    #[error("{count} boxes; expected at most {}; split the geometry", CheckedBoxes::MAX_COUNT)]
    TooManyBoxes {
        /// Boxes given.
        count: usize,
    },
    /// A side is NaN or infinite.
    #[error(
        "box {index}: {side} {value} on axis {axis}; expected a finite number; leave the box out or mend its vertices"
    )]
    NotFinite {
        /// The box.
        index: usize,
        /// `"min"` or `"max"`.
        side: &'static str,
        /// 0, 1 or 2.
        axis: usize,
        /// What was found.
        value: f32,
    },
    /// A box contains nothing.
    #[error("box {index}: min {min} above max {max} on axis {axis}; expected min <= max; leave out what is empty")]
    Inverted {
        /// The box.
        index: usize,
        /// 0, 1 or 2.
        axis: usize,
        /// Lower side.
        min: f32,
        /// Upper side.
        max: f32,
    },
}

impl<'a> CheckedBoxes<'a> {
    /// Most boxes that a tree can count: node indices reach twice as far and are kept in 32 bits.
    pub const MAX_COUNT: usize = 1 << 31;

    /// Checks all boxes.
    ///
    /// # Errors
    /// [`BuildError`], for the first box at fault.
    pub fn new(boxes: &'a [Aabb]) -> Result<Self, BuildError> {
        check_count(boxes.len())?;
        match boxes.iter().position(|bounds| !is_usable(bounds)) {
            None => Ok(Self(boxes)),
            Some(index) => Err(fault(index, &boxes[index])),
        }
    }

    /// The boxes.
    #[must_use]
    pub fn get(self) -> &'a [Aabb] {
        self.0
    }
}

fn check_count(count: usize) -> Result<(), BuildError> {
    match count {
        0 => Err(BuildError::NoBoxes),
        1..=CheckedBoxes::MAX_COUNT => Ok(()),
        _ => Err(BuildError::TooManyBoxes { count }),
    }
}

/// False for NaN, whichever way it is compared.
fn is_usable(bounds: &Aabb) -> bool {
    (0..3).fold(true, |usable, k| {
        usable & (f32::MIN <= bounds.min[k]) & (bounds.min[k] <= bounds.max[k]) & (bounds.max[k] <= f32::MAX)
    })
}

fn fault(index: usize, bounds: &Aabb) -> BuildError {
    for (side, corner) in [("min", bounds.min), ("max", bounds.max)] {
        if let Some(axis) = corner.iter().position(|x| !x.is_finite()) {
            return BuildError::NotFinite {
                index,
                side,
                axis,
                value: corner[axis],
            };
        }
    }
    let axis = (0..3).find(|k| bounds.min[*k] > bounds.max[*k]).unwrap_or(0);
    BuildError::Inverted {
        index,
        axis,
        min: bounds.min[axis],
        max: bounds.max[axis],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Aabb = Aabb {
        min: [0.0; 3],
        max: [1.0; 3],
    };

    fn with(change: impl Fn(&mut Aabb)) -> Vec<Aabb> {
        let mut boxes = vec![UNIT; 3];
        change(&mut boxes[1]);
        boxes
    }

    #[test]
    fn unusable_boxes_are_named() {
        assert_eq!(CheckedBoxes::new(&[]).unwrap_err(), BuildError::NoBoxes);
        for value in [f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
            for axis in 0..3 {
                for side in ["min", "max"] {
                    let boxes = with(|b| {
                        let corner = if side == "min" { &mut b.min } else { &mut b.max };
                        corner[axis] = value;
                    });
                    let text = CheckedBoxes::new(&boxes).unwrap_err().to_string();
                    assert!(
                        text.contains(&format!("box 1: {side} {value} on axis {axis}")),
                        "{text}"
                    );
                }
            }
        }
        let boxes = with(|b| b.min[2] = 2.0);
        let expected = BuildError::Inverted {
            index: 1,
            axis: 2,
            min: 2.0,
            max: 1.0,
        };
        assert_eq!(CheckedBoxes::new(&boxes).unwrap_err(), expected);
    }

    #[test]
    fn counts_beyond_32_bit_indices_are_refused() {
        assert_eq!(check_count(CheckedBoxes::MAX_COUNT), Ok(()));
        let count = CheckedBoxes::MAX_COUNT + 1;
        assert_eq!(check_count(count), Err(BuildError::TooManyBoxes { count }));
    }

    #[test]
    fn points_and_the_largest_boxes_pass() {
        let everything = Aabb {
            min: [f32::MIN; 3],
            max: [f32::MAX; 3],
        };
        let point = Aabb {
            min: [-0.0; 3],
            max: [0.0; 3],
        };
        assert_eq!(CheckedBoxes::new(&[everything, point]).unwrap().get().len(), 2);
    }
}
