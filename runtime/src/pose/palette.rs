use super::NodeLocal;
#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Affine,
    affine64::Affine64,
    simd::{Lanes, Portable, SimdLevel},
};
use restpose_formats::rows::{BoneRow, NONE, NodeRow};

/// Writes asset space from the space of each node, and the palette that this makes: of a pose, whose `locals` are those of the
/// nodes. The same bits at every level: nothing is fused.
///
/// With AVX2 a pose of the fox (21 arcs, 25 bones) takes three quarters of the time.
pub(super) fn write_palette(
    level: SimdLevel,
    skeleton: (&[NodeRow], &[BoneRow]),
    locals: &[NodeLocal],
    worlds: &mut Vec<Affine64>,
    palette: &mut Vec<Affine>,
) {
    #[cfg(target_arch = "x86_64")]
    if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
        #[target_feature(enable = "avx2,popcnt")]
        fn compiled(
            simd: Avx2,
            skeleton: (&[NodeRow], &[BoneRow]),
            locals: &[NodeLocal],
            worlds: &mut Vec<Affine64>,
            palette: &mut Vec<Affine>,
        ) {
            write(simd, skeleton, locals, worlds, palette);
        }
        #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
        // SAFETY: an `Avx2` exists only on machines that have both features.
        return unsafe { compiled(simd, skeleton, locals, worlds, palette) };
    }
    write(Portable, skeleton, locals, worlds, palette);
}

#[inline(always)]
fn write<S: Lanes>(
    simd: S,
    (nodes, bones): (&[NodeRow], &[BoneRow]),
    locals: &[NodeLocal],
    worlds: &mut Vec<Affine64>,
    palette: &mut Vec<Affine>,
) {
    worlds.clear();
    worlds.reserve(locals.len());
    for (row, local) in nodes.iter().zip(locals) {
        let map = local.map();
        let world = if row.parent == NONE {
            map
        } else {
            worlds[row.parent as usize].after(simd, &map)
        };
        worlds.push(world);
    }
    palette.clear();
    palette.reserve(bones.len());
    for bone in bones {
        palette.push(if bone.node == NONE {
            Affine::IDENTITY
        } else {
            worlds[bone.node as usize].rounded_after(simd, &bone.inverse_bind())
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn levels_agree_on_every_bit() {
        let mut random = fastrand::Rng::with_seed(61);
        for round in 0..500 {
            let scale = 10f32.powi(random.i32(-12..12));
            let count = random.u32(1..20);
            let mut numbers = || -> [f32; 12] { std::array::from_fn(|_| (random.f32() - 0.5) * scale) };
            let nodes: Vec<NodeRow> = (0..count)
                .map(|node| NodeRow {
                    parent: if node % 7 == 0 { NONE } else { node / 2 },
                    local_kind: u32::from(node % 3 == 0),
                    local: numbers(),
                    ..NodeRow::zeroed()
                })
                .collect();
            let bones: Vec<BoneRow> = (0..count)
                .map(|bone| BoneRow {
                    node: if bone == 3 { NONE } else { count - 1 - bone },
                    inverse_bind: numbers(),
                    ..BoneRow::zeroed()
                })
                .collect();
            let locals: Vec<NodeLocal> = nodes.iter().map(|row| NodeLocal::as_stored(row.local())).collect();
            let bits = |level| -> Vec<[u32; 12]> {
                let (mut worlds, mut palette) = (Vec::new(), vec![Affine::IDENTITY; 2]);
                write_palette(level, (&nodes, &bones), &locals, &mut worlds, &mut palette);
                palette.iter().map(|map| bytemuck::cast(*map)).collect()
            };
            let expected = bits(SimdLevel::Portable);
            assert_eq!(expected.len(), bones.len());
            assert_eq!(bits(SimdLevel::detect()), expected, "round {round}");
        }
    }
}
