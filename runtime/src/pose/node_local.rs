use super::curve::normalized;
use crate::{affine64::Affine64, simd::Portable};
use restpose_formats::rows::Local;

/// A node's local map in a pose: parent from node, in `f64`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NodeLocal {
    /// Scale first, then rotation, then translation.
    Trs {
        /// Translation.
        translation: [f64; 3],
        /// Quaternion x, y, z, w of unit length.
        rotation: [f64; 4],
        /// Scale per axis.
        scale: [f64; 3],
    },
    /// Any affine map, four columns of three.
    Matrix([[f64; 3]; 4]),
}

impl NodeLocal {
    /// With the rotation's length as it is, so to be [normalized](Self::normalize) unless another is set.
    #[inline(always)]
    pub(super) fn as_stored(local: Local) -> Self {
        match local {
            Local::Trs {
                translation,
                rotation,
                scale,
            } => Self::Trs {
                translation: translation.map(f64::from),
                rotation: rotation.map(f64::from),
                scale: scale.map(f64::from),
            },
            Local::Matrix(columns) => Self::Matrix(columns.map(|column| column.map(f64::from))),
        }
    }

    /// Gives the rotation unit length.
    #[inline(always)]
    pub(super) fn normalize(&mut self) {
        if let Self::Trs { rotation, .. } = self {
            *rotation = normalized(*rotation);
        }
    }

    /// Turns the node in its own axes: `rotation`, a quaternion x, y, z, w of any length but zero, comes before the
    /// rotation that the node has; before the whole map where that is a matrix.
    pub fn turn(&mut self, rotation: [f64; 4]) {
        let turn = normalized(rotation);
        match self {
            Self::Trs { rotation, .. } => *rotation = normalized(after(*rotation, turn)),
            Self::Matrix(columns) => {
                let [x, y, z] = axes(turn);
                let turn = Affine64::new(&[x, y, z, [0.0; 3]]);
                *columns = Affine64::new(columns).after(Portable, &turn).numbers();
            }
        }
    }

    /// Takes a channel's value; a matrix has none that a channel could move.
    pub(super) fn set_translation(&mut self, value: [f64; 3]) {
        if let Self::Trs { translation, .. } = self {
            *translation = value;
        }
    }

    /// As [`Self::set_translation`]; a unit quaternion.
    pub(super) fn set_rotation(&mut self, value: [f64; 4]) {
        if let Self::Trs { rotation, .. } = self {
            *rotation = value;
        }
    }

    /// As [`Self::set_translation`].
    pub(super) fn set_scale(&mut self, value: [f64; 3]) {
        if let Self::Trs { scale, .. } = self {
            *scale = value;
        }
    }

    /// Translation · rotation · scale (glTF 2.0 §3.5.3).
    #[inline(always)]
    pub(super) fn map(&self) -> Affine64 {
        match self {
            Self::Matrix(columns) => Affine64::new(columns),
            Self::Trs {
                translation,
                rotation,
                scale,
            } => {
                let axes = axes(*rotation);
                let scaled = |k: usize| [axes[k][0] * scale[k], axes[k][1] * scale[k], axes[k][2] * scale[k]];
                Affine64::new(&[scaled(0), scaled(1), scaled(2), *translation])
            }
        }
    }
}

/// Where a rotation takes the three axes.
#[inline(always)]
fn axes([x, y, z, w]: [f64; 4]) -> [[f64; 3]; 3] {
    [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y + z * w),
            2.0 * (x * z - y * w),
        ],
        [
            2.0 * (x * y - z * w),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z + x * w),
        ],
        [
            2.0 * (x * z + y * w),
            2.0 * (y * z - x * w),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ]
}

/// Quaternion product: rotation `a` after rotation `b`.
fn after([ax, ay, az, aw]: [f64; 4], [bx, by, bz, bw]: [f64; 4]) -> [f64; 4] {
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A turn by 120° that takes x to y, y to z and z to x, of twice the unit length: every product below is exact.
    const CYCLE: [f64; 4] = [1.0, 1.0, 1.0, 1.0];

    #[test]
    fn a_turn_comes_before_what_the_node_does() {
        let translation = [1.0, 2.0, 3.0];
        let mut node = NodeLocal::Trs {
            translation,
            // Half a turn about z.
            rotation: [0.0, 0.0, 1.0, 0.0],
            scale: [1.0; 3],
        };
        let mut matrix = NodeLocal::Matrix(node.map().numbers());
        node.turn(CYCLE);
        matrix.turn(CYCLE);
        // x goes to y by the turn, then to −y by the node; y to z and stays; z to x, then to −x.
        let expected = [[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], translation];
        assert_eq!(node.map().numbers(), expected);
        assert_eq!(matrix, NodeLocal::Matrix(expected));
    }

    #[test]
    fn a_turn_without_length_changes_nothing() {
        let mut node = NodeLocal::Matrix([[2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 4.0], [5.0; 3]]);
        let before = node;
        node.turn([0.0; 4]);
        assert_eq!(node, before);
    }
}
