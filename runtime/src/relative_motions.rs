//! How the bones of a cluster move against its own in a pose, in `f64`: what is measured against envelopes, and what boxes
//! follow.

use crate::{
    affine64::wide,
    simd::{Doubles, Four, Lanes, weighted_sum},
};
use restpose_formats::{geom::Affine, rows::ClusterBoneRow};

/// 2⁻⁴⁸: bounds the `f64` roundings of a relative motion, under 32 of 2⁻⁵³, relative to the magnitudes that enter it.
pub(crate) const ROUNDING: f64 = 1.0 / (1u64 << 48) as f64;

/// `R = X⁻¹·Xᵢ` for a bone i beside the cluster's own, X: with `E = A − 1` and b, a point p is displaced by `E·p + b`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RelativeMotion {
    /// Columns of E, of three numbers each.
    pub columns: [Four; 3],
    pub offset: Four,
    /// Bounds the error of each entry of E.
    pub entry_error: f64,
    /// Bounds the error of each entry of b.
    pub offset_error: f64,
}

/// Those of a cluster, in the order of its bones. Scratch: keep one and reuse it.
#[derive(Debug, Default)]
pub(crate) struct RelativeMotions {
    pub motions: Vec<RelativeMotion>,
    /// Of the bones' maps, the cluster's own among them.
    pub largest: LargestEntries,
}

/// What bounds the entries of some maps.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LargestEntries {
    /// Greatest length of each row of a linear part.
    pub linear: [f64; 3],
    /// Greatest magnitude of each number of a translation.
    pub offset: [f64; 3],
}

impl RelativeMotions {
    /// `inverse` is what [`invert_frame`](crate::invert_frame) made of the map of bone row `own`; `palette` has no instance
    /// transform in it.
    ///
    /// # Why the errors bound what is left out
    ///
    /// With the computed inverse L, `X⁻¹ = L + (1 − L·X)·X⁻¹`, so `‖1 − L·X‖` bounds the relative error of everything that L
    /// maps ([`inverse_error`]); twice that covers its square. The products have a few roundings of the norms that enter.
    #[inline(always)]
    pub(crate) fn update<S: Lanes>(
        &mut self,
        simd: S,
        cluster_bones: &[ClusterBoneRow],
        own: u32,
        inverse: &[[f64; 3]; 3],
        palette: &[Affine],
    ) {
        self.motions.clear();
        self.motions.reserve(cluster_bones.len());
        let own_map = &palette[own as usize];
        let [u, v, w] = inverse;
        let turn = [
            [u[0], v[0], w[0], 0.0],
            [u[1], v[1], w[1], 0.0],
            [u[2], v[2], w[2], 0.0],
        ];
        let turn = Doubles::three(simd, &turn);
        let [a, b, c, d] = own_map.columns;
        let own_offset = Doubles::from_point(simd, d);
        let (mut linear, mut moved) = (squares(linear_of(simd, [a, b, c])), own_offset.abs());
        let slack = 2.0 * inverse_error(simd, turn, own_map) + ROUNDING;
        let (inverse_norm, own_length) = (root_of_sum(squares(turn)), root_of_sum(own_offset * own_offset));
        let axes = Doubles::axes(simd);
        for row in cluster_bones {
            if row.bone == own {
                continue;
            }
            let [a, b, c, d] = palette[row.bone as usize].columns;
            let (rows, translation) = (squares(linear_of(simd, [a, b, c])), Doubles::from_point(simd, d));
            let [offset_x, offset_y, offset_z, _] = (translation - own_offset).numbers();
            // What is not a number moves no vertex to any place, and takes nothing from the others.
            linear = rows.max(linear);
            moved = translation.abs().max(moved);
            self.motions.push(RelativeMotion {
                columns: [
                    (weighted_sum(turn, wide(a)) - axes[0]).numbers(),
                    (weighted_sum(turn, wide(b)) - axes[1]).numbers(),
                    (weighted_sum(turn, wide(c)) - axes[2]).numbers(),
                ],
                offset: weighted_sum(turn, [offset_x, offset_y, offset_z]).numbers(),
                entry_error: slack * (inverse_norm * root_of_sum(rows) + 1.0),
                offset_error: slack * (inverse_norm * (root_of_sum(translation * translation) + own_length)),
            });
        }
        let ([u, v, w, _], [x, y, z, _]) = (linear.numbers(), moved.numbers());
        self.largest = LargestEntries {
            linear: [u.sqrt(), v.sqrt(), w.sqrt()],
            offset: [x, y, z],
        };
    }
}

/// The squared lengths of a linear part's rows.
#[inline(always)]
fn squares<S: Lanes>([x, y, z]: [Doubles<S>; 3]) -> Doubles<S> {
    x * x + y * y + z * z
}

/// Of squares, a length.
#[inline(always)]
fn root_of_sum<S: Lanes>(squares: Doubles<S>) -> f64 {
    let [x, y, z, _] = squares.numbers();
    (x + y + z).sqrt()
}

#[inline(always)]
fn linear_of<S: Lanes>(simd: S, [x, y, z]: [[f32; 3]; 3]) -> [Doubles<S>; 3] {
    [
        Doubles::from_point(simd, x),
        Doubles::from_point(simd, y),
        Doubles::from_point(simd, z),
    ]
}

#[inline(always)]
fn greatest<S: Lanes>(numbers: Doubles<S>) -> f64 {
    let [x, y, z, _] = numbers.numbers();
    x.max(y).max(z)
}

/// `‖L·X − I‖∞` for a computed inverse L, by its columns, its own rounding included: `X⁻¹ − L = −(L·X − I)·X⁻¹`, so it
/// bounds the relative error of everything that L maps.
#[inline(always)]
fn inverse_error<S: Lanes>(simd: S, turn: [Doubles<S>; 3], own: &Affine) -> f64 {
    let magnitudes = [turn[0].abs(), turn[1].abs(), turn[2].abs()];
    let axes = Doubles::axes(simd);
    let mut sum = Doubles::splat(simd, 0.0);
    for j in 0..3 {
        let [x, y, z] = wide(own.columns[j]);
        let entering = weighted_sum(magnitudes, [x.abs(), y.abs(), z.abs()]) + axes[j];
        sum = sum + (weighted_sum(turn, [x, y, z]) - axes[j]).abs() + entering * ROUNDING;
    }
    greatest(sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{invert_frame, simd::Portable};
    use bytemuck::Zeroable;

    /// The largest entries of all bones but those that are no numbers, wherever they stand.
    #[test]
    fn a_bone_that_is_not_a_number_hides_no_other() {
        let map = |scale: f32, offset: f32| {
            let mut map = Affine::from_translation([0.0, offset, 0.0]);
            map.columns[2][1] = scale;
            map
        };
        let (far, unknown, near) = (map(-5.0, 1e6), map(f32::NAN, f32::NAN), map(1.0, 1.0));
        for others in [[far, unknown, near], [unknown, far, near], [near, far, unknown]] {
            let palette = [&[Affine::IDENTITY][..], &others].concat();
            let rows: Vec<ClusterBoneRow> = (0..4)
                .map(|bone| ClusterBoneRow {
                    bone,
                    ..ClusterBoneRow::zeroed()
                })
                .collect();
            let mut motions = RelativeMotions::default();
            let inverse = invert_frame(&palette[0]).unwrap();
            motions.update(Portable, &rows, 0, &inverse, &palette);
            assert_eq!(motions.motions.len(), 3);
            let LargestEntries { linear, offset } = motions.largest;
            // The second row of the far one, and those of the identity.
            assert_eq!((linear, offset), ([1.0, 26f64.sqrt(), 1.0], [0.0, 1e6, 0.0]));
        }
    }
}
