use super::{ClusterBoneRow, WideNodeRow};
use crate::geom::{Aabb, round::f32_above};
use bytemuck::{Pod, Zeroable};

/// Bones beside the cluster's own that boxes of its nodes can follow: those of the first so many of its cluster-bone rows,
/// its own bone's left out.
pub const MAX_MOVERS: usize = 8;

/// A weight of one, as a [`NodeMoverRow`] counts weights.
pub const MOVER_WEIGHTS: f32 = 65536.0;

/// By which weights a bone moves what is in the eight boxes of a [`WideNodeRow`].
///
/// With the weight w by which the bone moves a vertex below a place, zero where it does not,
/// `|w·`[`MOVER_WEIGHTS`]` − weight| ≤ spread` in exact arithmetic. Bones for which a node has no row, but for the
/// cluster's own, move nothing below it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct NodeMoverRow {
    /// Per place; zero in empty ones, here and in `spread`.
    pub weight: [u16; 8],
    /// Per place.
    pub spread: [u16; 8],
    /// The bone, counted among the cluster's cluster-bone rows but for its own bone's; below [`MAX_MOVERS`]. Those of a
    /// node ascend.
    pub mover: u32,
}

/// The lattice of the boxes of nodes with movers, in a cluster's local space: a coordinate q stands for `origin + q·step` in
/// exact arithmetic, the same step on all axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestLattice {
    /// Least corner of the box around the boxes of the cluster's bones, and so around its rest positions.
    pub origin: [f32; 3],
    /// 1/65533 of the longest side of that box, rounded upwards.
    pub step: f32,
}

impl RestLattice {
    /// That of a cluster with these cluster-bone rows, whose boxes are finite.
    #[must_use]
    pub fn new(cluster_bones: &[ClusterBoneRow]) -> Self {
        let bounds = cluster_bones
            .iter()
            .fold(Aabb::EMPTY, |bounds, row| bounds.union(row.bounds));
        let sides = (0..3).map(|k| f64::from(bounds.max[k]) - f64::from(bounds.min[k]));
        let side = sides.fold(0.0, f64::max);
        Self {
            origin: bounds.min,
            // Two steps to spare: the greatest coordinate that `around` needs is 65534.
            step: f32_above(side / f64::from(u16::MAX - 2)),
        }
    }

    /// Whether there is a lattice. There is none over a single point, nor where the step would not be a normal number.
    #[must_use]
    pub fn is_usable(&self) -> bool {
        self.step.is_normal() && self.step > 0.0 && self.origin.iter().all(|x| x.is_finite())
    }

    /// Least and greatest corner of a box on the lattice, which is usable, that contains `rest`: the smallest, or one step more
    /// on a side where rounding might matter. `rest` lies inside the box of the bones.
    #[must_use]
    pub fn around(&self, rest: &Aabb) -> [[u16; 3]; 2] {
        // Two roundings in `f64` are off by 2⁻⁵² of a place: far less.
        let slack = f64::from(u16::MAX) / (1u64 << 40) as f64;
        let place = |x: f32, k: usize| (f64::from(x) - f64::from(self.origin[k])) / f64::from(self.step);
        // The casts saturate: a least place, which is not below zero, may be for the slack alone. No greatest place is above
        // 65533·(1 + 2⁻⁵¹), so none is cut off.
        [
            std::array::from_fn(|k| (place(rest.min[k], k) - slack).floor() as u16),
            std::array::from_fn(|k| (place(rest.max[k], k) + slack).ceil() as u16),
        ]
    }
}

impl WideNodeRow {
    /// Its movers among those of a file.
    #[inline]
    #[must_use]
    pub fn movers<'a>(&self, all: &'a [NodeMoverRow]) -> &'a [NodeMoverRow] {
        &all[self.mover_first as usize..][..self.mover_count as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cmp::Ordering;

    fn rows<const N: usize>(boxes: [Aabb; N]) -> [ClusterBoneRow; N] {
        boxes.map(|bounds| ClusterBoneRow {
            bone: 0,
            bounds,
            reserved: 0,
        })
    }

    fn cube(min: f32, max: f32) -> Aabb {
        Aabb {
            min: [min; 3],
            max: [max; 3],
        }
    }

    /// Where a plane of the lattice lies, seen from `x`, in exact arithmetic.
    fn plane_from(x: f32, lattice: &RestLattice, k: usize, q: u16) -> Ordering {
        // The product is exact, and so is the sum together with its error (Knuth, The Art of Computer Programming, 4.2.2).
        let (a, b) = (f64::from(lattice.origin[k]), f64::from(q) * f64::from(lattice.step));
        let sum = a + b;
        let rest = sum - a;
        let error = (a - (sum - rest)) + (b - rest);
        sum.total_cmp(&f64::from(x)).then(error.total_cmp(&0.0))
    }

    /// `around` contains its box exactly, and is larger by a step or less.
    fn check_around(lattice: &RestLattice, rest: &Aabb) {
        let [min, max] = lattice.around(rest);
        let step = f64::from(lattice.step);
        for k in 0..3 {
            let (low, high) = (rest.min[k], rest.max[k]);
            let said = format!("{min:?}..{max:?} on axis {k} around {low:e}..{high:e} on {lattice:?}");
            assert_ne!(plane_from(low, lattice, k, min[k]), Ordering::Greater, "{said}");
            assert_ne!(plane_from(high, lattice, k, max[k]), Ordering::Less, "{said}");
            // What is beyond a step is the slack, and what `f64` rounds here.
            let plane = |q: u16| f64::from(lattice.origin[k]) + f64::from(q) * step;
            let width = 1.001 * step;
            assert!(f64::from(low) - plane(min[k]) <= width, "{said}");
            assert!(plane(max[k]) - f64::from(high) <= width, "{said}");
        }
    }

    #[test]
    fn lattice_boxes_contain_their_box_and_are_hardly_larger() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            f64::from((state >> 40) as u32) / f64::from(1u32 << 24)
        };
        let mut usable = 0;
        for round in 0..20_000 {
            let (scale, offset) = ([1e-30, 1.0, 1e30][round % 3], [0.0, 1e3, -1e7][round / 3 % 3]);
            let mut interval = |low: f64, high: f64| {
                let (a, b) = (low + random() * (high - low), low + random() * (high - low));
                (a.min(b) as f32, a.max(b) as f32)
            };
            let (mut boxes, mut rest) = ([Aabb::EMPTY; 2], Aabb::EMPTY);
            for k in 0..3 {
                for bounds in &mut boxes {
                    (bounds.min[k], bounds.max[k]) = interval(offset * scale, (offset + 1.0) * scale);
                }
                let whole = boxes[0].union(boxes[1]);
                let (low, high) = (whole.min[k], whole.max[k]);
                (rest.min[k], rest.max[k]) = interval(f64::from(low), f64::from(high));
                // Ends of the lattice, and boxes without thickness, are as likely as anything else.
                rest.min[k] = if round % 5 == 0 { low } else { rest.min[k].max(low) };
                rest.max[k] = match round % 7 {
                    0 => high,
                    1 => rest.min[k],
                    _ => rest.max[k].clamp(rest.min[k], high),
                };
            }
            let lattice = RestLattice::new(&rows(boxes));
            if !lattice.is_usable() {
                continue;
            }
            usable += 1;
            check_around(&lattice, &rest);
        }
        assert!(usable > 15_000, "{usable} of 20000");
    }

    #[test]
    fn what_rounds_to_a_plane_is_contained_all_the_same() {
        // A step is 2⁻¹⁶, and what the origin is beside zero is lost in every difference.
        let step = 1.0 / 65536.0;
        for origin in [-1e-30, 1e-30] {
            let lattice = RestLattice::new(&rows([cube(origin, 65533.0 * step)]));
            assert_eq!(lattice.step, step);
            check_around(&lattice, &cube(100.0 * step, 200.0 * step));
        }
    }

    #[test]
    fn lattices_of_any_finite_size_hold_the_whole_box() {
        let least = 65533.0 * f32::MIN_POSITIVE;
        let sides = [
            least,
            3e-30,
            1.0,
            3.0,
            65533.0,
            65533.0f32.next_up(),
            1e7,
            1e30,
            f32::MAX,
        ];
        for (side, min) in sides
            .iter()
            .flat_map(|side| [0.0, -0.3, -1.0].map(|part| (*side, part * side)))
        {
            let whole = cube(min, min + side);
            let lattice = RestLattice::new(&rows([whole]));
            assert!(lattice.is_usable(), "{side:e}");
            check_around(&lattice, &whole);
            // One axis may be much shorter than the others, or have no length.
            for short in [0.0, 1e-6 * side] {
                let mut flat = whole;
                flat.max[1] = flat.min[1] + short;
                let lattice = RestLattice::new(&rows([flat]));
                check_around(&lattice, &flat);
            }
        }
        let everything = cube(-f32::MAX, f32::MAX);
        let lattice = RestLattice::new(&rows([cube(-f32::MAX, 0.0), cube(0.0, f32::MAX)]));
        assert!(lattice.is_usable());
        check_around(&lattice, &everything);
    }

    #[test]
    fn there_is_no_lattice_over_a_point_or_what_is_not_finite() {
        let too_small = 65533.0 * f32::MIN_POSITIVE.next_down();
        let boxes = [
            cube(1.0, 1.0),
            cube(0.0, too_small),
            cube(0.0, f32::INFINITY),
            cube(f32::NEG_INFINITY, 0.0),
            cube(f32::NAN, f32::NAN),
            Aabb {
                min: [f32::INFINITY, 0.0, 0.0],
                max: [f32::INFINITY, 1.0, 1.0],
            },
            Aabb::EMPTY,
            Aabb::EVERYTHING,
        ];
        for bounds in boxes {
            assert!(!RestLattice::new(&rows([bounds])).is_usable(), "{bounds:?}");
        }
        assert!(!RestLattice::new(&[]).is_usable());
    }
}
