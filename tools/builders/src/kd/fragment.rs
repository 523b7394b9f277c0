use restpose_formats::geom::Aabb;

/// The part of a box that lies in a cell, with the box's index, in 32 bytes: two vectors of four lanes.
///
/// The fourth lane of `min` holds the index, bit for bit. Indices stay below 2³⁰, so it never reads as a NaN.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub(super) struct Fragment {
    pub min: [f32; 4],
    pub max: [f32; 4],
}

/// A plane, and the child that gets what lies in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    pub axis: usize,
    pub position: f32,
    pub planar_left: bool,
}

impl Fragment {
    /// The whole of a box with finite sides. Adding zero turns −0 into +0, so that equal positions have equal bits.
    pub(super) fn of(bounds: &Aabb, id: u32) -> Self {
        let [x, y, z] = bounds.min.map(|side| side + 0.0);
        let [u, v, w] = bounds.max.map(|side| side + 0.0);
        Self {
            min: [x, y, z, f32::from_bits(id)],
            max: [u, v, w, 0.0],
        }
    }

    pub(super) fn id(&self) -> u32 {
        self.min[3].to_bits()
    }
}

/// The smallest box around all fragments; [`Aabb::EMPTY`] for none.
pub(super) fn bounds_of(fragments: &[Fragment]) -> Aabb {
    let (mut min, mut max) = ([f32::INFINITY; 4], [f32::NEG_INFINITY; 4]);
    for fragment in fragments {
        for k in 0..4 {
            min[k] = if fragment.min[k] < min[k] {
                fragment.min[k]
            } else {
                min[k]
            };
            max[k] = if fragment.max[k] > max[k] {
                fragment.max[k]
            } else {
                max[k]
            };
        }
    }
    Aabb {
        min: [min[0], min[1], min[2]],
        max: [max[0], max[1], max[2]],
    }
}

/// Parts `list` at a plane, in order, and clips what straddles it: the left child's fragments come first in `list`, the
/// right child's in `right`, both from the start. The counts of both.
///
/// A fragment goes where it has points strictly on that side; one that lies in the plane goes as the plane says. The
/// very position that the tree stores decides, so the tree and the lists cannot disagree.
///
/// `right` must be as long as `list`.
pub(super) fn sift(list: &mut [Fragment], right: &mut [Fragment], plane: Plane) -> [usize; 2] {
    match plane.axis {
        0 => sift_along::<0>(list, right, plane),
        1 => sift_along::<1>(list, right, plane),
        _ => sift_along::<2>(list, right, plane),
    }
}

fn sift_along<const AXIS: usize>(list: &mut [Fragment], right: &mut [Fragment], plane: Plane) -> [usize; 2] {
    let Plane {
        position, planar_left, ..
    } = plane;
    let right = &mut right[..list.len()];
    let (mut lower, mut upper) = (0, 0);
    // Writing before deciding keeps the loop free of branches that depend on the data.
    for next in 0..list.len() {
        let fragment = list[next];
        let (min, max) = (fragment.min[AXIS], fragment.max[AXIS]);
        let (below, above) = (min < position, max > position);
        let mut part = fragment;
        part.max[AXIS] = if above { position } else { max };
        list[lower] = part;
        lower += usize::from(below | (planar_left & !above));
        let mut part = fragment;
        part.min[AXIS] = if below { position } else { min };
        right[upper] = part;
        upper += usize::from(above | (!planar_left & !below));
    }
    [lower, upper]
}
