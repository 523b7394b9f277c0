//! World space from rest space of all bones at once: what vertices are posed by. The maps of
//! [`PosedMap::product`](crate::cluster_frame::PosedMap::product), bit by bit.

#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Affine,
    affine64::Affine64,
    simd::{Lanes, Portable, SimdLevel},
};

/// Writes the map that vertices are posed by, per bone.
pub(crate) fn posed_maps(level: SimdLevel, transform: &Affine, palette: &[Affine], out: &mut Vec<Affine>) {
    if *transform == Affine::IDENTITY {
        out.clear();
        out.extend_from_slice(palette);
        return;
    }
    out.resize(palette.len(), Affine::IDENTITY);
    #[cfg(target_arch = "x86_64")]
    if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
        #[target_feature(enable = "avx2,popcnt")]
        fn compiled(simd: Avx2, transform: &Affine, palette: &[Affine], out: &mut [Affine]) {
            products(simd, transform, palette, out);
        }
        #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
        // SAFETY: an `Avx2` exists only on machines that have both features.
        return unsafe { compiled(simd, transform, palette, out) };
    }
    products(Portable, transform, palette, out);
}

#[inline(always)]
fn products<S: Lanes>(simd: S, transform: &Affine, palette: &[Affine], out: &mut [Affine]) {
    let wide = Affine64::from_affine(transform);
    for (x, out) in palette.iter().zip(out) {
        // Identities are left out, which keeps the signs of zeros.
        *out = if *x == Affine::IDENTITY {
            *transform
        } else {
            wide.rounded_after(simd, x)
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cluster_frame::{Map64, PosedMap};

    #[test]
    fn maps_are_those_of_products() {
        let mut random = fastrand::Rng::with_seed(23);
        for round in 0..2000 {
            let mut map = |identity: bool| {
                if identity {
                    return Affine::IDENTITY;
                }
                let scale = 10f32.powi(random.i32(-36..36));
                let mut entry = || match random.u8(..16) {
                    0 => -0.0,
                    1 => f32::MAX,
                    _ => (random.f32() - 0.5) * scale,
                };
                Affine {
                    columns: std::array::from_fn(|_| std::array::from_fn(|_| entry())),
                }
            };
            let transform = map(round % 5 == 0);
            let palette: Vec<Affine> = (0..round % 7).map(|bone| map(bone == 2)).collect();
            let bits = |maps: &[Affine]| -> Vec<[u32; 12]> { maps.iter().map(|map| bytemuck::cast(*map)).collect() };
            let expected: Vec<Affine> = palette
                .iter()
                .map(|x| PosedMap::product(Portable, &[&Map64::new(&transform), &Map64::new(x)]).map)
                .collect();
            for level in [SimdLevel::Portable, SimdLevel::detect()] {
                let mut found = vec![Affine::IDENTITY; 3];
                posed_maps(level, &transform, &palette, &mut found);
                assert_eq!(bits(&found), bits(&expected), "round {round}");
            }
        }
    }
}
