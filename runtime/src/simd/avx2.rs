#![expect(unsafe_code, reason = "instructions that not every machine has")]

use super::Lanes;
use std::arch::x86_64::*;

/// AVX2 and POPCNT. A value exists only where [`Avx2::new`] found them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2(());

impl Avx2 {
    /// `None` on machines without them.
    #[inline]
    pub(crate) fn new() -> Option<Self> {
        (is_x86_feature_detected!("avx2") && is_x86_feature_detected!("popcnt")).then_some(Self(()))
    }
}

// SAFETY, for every block below: `self` proves that the machine has AVX2 (and with it SSE to AVX) and POPCNT, which is all
// that these instructions need. References to arrays are valid for the bytes that are read or written, and no alignment is assumed.
impl Lanes for Avx2 {
    type F8 = __m256;
    type F4 = __m128;
    type D4 = __m256d;

    #[inline(always)]
    fn load8(self, from: &[f32; 8]) -> __m256 {
        // SAFETY: see above; 32 bytes.
        unsafe { _mm256_loadu_ps(from.as_ptr()) }
    }

    #[inline(always)]
    fn store8(self, from: __m256, to: &mut [f32; 8]) {
        // SAFETY: see above; 32 bytes.
        unsafe { _mm256_storeu_ps(to.as_mut_ptr(), from) }
    }

    #[inline(always)]
    fn max8(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: see above.
        unsafe { _mm256_max_ps(a, b) }
    }

    #[inline(always)]
    fn splat8(self, x: f32) -> __m256 {
        // SAFETY: see above.
        unsafe { _mm256_set1_ps(x) }
    }

    #[inline(always)]
    fn widen8(self, from: &[u16; 8]) -> __m256 {
        // SAFETY: see above; 16 bytes.
        unsafe { _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(_mm_loadu_si128(from.as_ptr().cast()))) }
    }

    #[inline(always)]
    fn widen8_bytes(self, from: &[u8; 8]) -> __m256 {
        // SAFETY: see above; 8 bytes.
        unsafe { _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_loadl_epi64(from.as_ptr().cast()))) }
    }

    #[inline(always)]
    fn add8(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: see above.
        unsafe { _mm256_add_ps(a, b) }
    }

    #[inline(always)]
    fn sub8(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: see above.
        unsafe { _mm256_sub_ps(a, b) }
    }

    #[inline(always)]
    fn abs8(self, a: __m256) -> __m256 {
        // SAFETY: see above.
        unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), a) }
    }

    #[inline(always)]
    fn mul8(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: see above.
        unsafe { _mm256_mul_ps(a, b) }
    }

    #[inline(always)]
    fn div8(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: see above.
        unsafe { _mm256_div_ps(a, b) }
    }

    #[inline(always)]
    fn min8(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: see above.
        unsafe { _mm256_min_ps(a, b) }
    }

    #[inline(always)]
    fn transpose8(self, r: [__m256; 8]) -> [__m256; 8] {
        // SAFETY: see above.
        unsafe {
            // Within each half: pairs of rows, then fours of them; then the halves.
            let t = [
                _mm256_unpacklo_ps(r[0], r[1]),
                _mm256_unpackhi_ps(r[0], r[1]),
                _mm256_unpacklo_ps(r[2], r[3]),
                _mm256_unpackhi_ps(r[2], r[3]),
                _mm256_unpacklo_ps(r[4], r[5]),
                _mm256_unpackhi_ps(r[4], r[5]),
                _mm256_unpacklo_ps(r[6], r[7]),
                _mm256_unpackhi_ps(r[6], r[7]),
            ];
            let f = [
                _mm256_shuffle_ps::<0x44>(t[0], t[2]),
                _mm256_shuffle_ps::<0xee>(t[0], t[2]),
                _mm256_shuffle_ps::<0x44>(t[1], t[3]),
                _mm256_shuffle_ps::<0xee>(t[1], t[3]),
                _mm256_shuffle_ps::<0x44>(t[4], t[6]),
                _mm256_shuffle_ps::<0xee>(t[4], t[6]),
                _mm256_shuffle_ps::<0x44>(t[5], t[7]),
                _mm256_shuffle_ps::<0xee>(t[5], t[7]),
            ];
            [
                _mm256_permute2f128_ps::<0x20>(f[0], f[4]),
                _mm256_permute2f128_ps::<0x20>(f[1], f[5]),
                _mm256_permute2f128_ps::<0x20>(f[2], f[6]),
                _mm256_permute2f128_ps::<0x20>(f[3], f[7]),
                _mm256_permute2f128_ps::<0x31>(f[0], f[4]),
                _mm256_permute2f128_ps::<0x31>(f[1], f[5]),
                _mm256_permute2f128_ps::<0x31>(f[2], f[6]),
                _mm256_permute2f128_ps::<0x31>(f[3], f[7]),
            ]
        }
    }

    #[inline(always)]
    fn lt8(self, a: __m256, b: __m256) -> u32 {
        // SAFETY: see above.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b)) as u32 }
    }

    #[inline(always)]
    fn le8(self, a: __m256, b: __m256) -> u32 {
        // SAFETY: see above.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)) as u32 }
    }

    #[inline(always)]
    fn sort8(self, a: __m256, b: __m256, tags: &[u32; 8], to: (&mut [f32; 8], &mut [u32; 8])) -> usize {
        // SAFETY: see above; 32 bytes each.
        unsafe {
            let counts = _mm256_cmp_ps::<_CMP_LE_OQ>(a, b);
            let keys = falling_keys(a);
            let least = _mm256_castsi256_ps(_mm256_set1_epi32(i32::MIN));
            let keys = _mm256_castps_si256(_mm256_blendv_ps(least, _mm256_castsi256_ps(keys), counts));
            let keys = sorted(keys);
            // Of an index, three bits count.
            let tags = _mm256_permutevar8x32_epi32(_mm256_loadu_si256(tags.as_ptr().cast()), keys);
            _mm256_storeu_si256(to.1.as_mut_ptr().cast(), tags);
            _mm256_storeu_ps(to.0.as_mut_ptr(), _mm256_permutevar8x32_ps(a, keys));
            _popcnt32(_mm256_movemask_ps(counts)) as usize
        }
    }

    #[inline(always)]
    fn order8(self, a: __m256) -> __m256 {
        // SAFETY: see above.
        unsafe { _mm256_castsi256_ps(_mm256_and_si256(sorted(falling_keys(a)), _mm256_set1_epi32(7))) }
    }

    #[inline(always)]
    fn permute8(self, a: __m256, order: __m256) -> __m256 {
        // SAFETY: see above.
        unsafe { _mm256_permutevar8x32_ps(a, _mm256_castps_si256(order)) }
    }

    #[inline(always)]
    fn later8<const BY: usize>(self, a: __m256) -> __m256 {
        let lane = |k: i32| if k < BY as i32 { k } else { k - BY as i32 };
        // SAFETY: see above.
        unsafe {
            let order = _mm256_setr_epi32(lane(0), lane(1), lane(2), lane(3), lane(4), lane(5), lane(6), lane(7));
            _mm256_permutevar8x32_ps(a, order)
        }
    }

    #[inline(always)]
    fn sooner8<const BY: usize>(self, a: __m256) -> __m256 {
        let lane = |k: i32| if k + BY as i32 > 7 { k } else { k + BY as i32 };
        // SAFETY: see above.
        unsafe {
            let order = _mm256_setr_epi32(lane(0), lane(1), lane(2), lane(3), lane(4), lane(5), lane(6), lane(7));
            _mm256_permutevar8x32_ps(a, order)
        }
    }

    #[inline(always)]
    fn max8_counting(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: see above.
        unsafe {
            let one = _mm256_setr_epi32(0, 0, 0, 0, 0, 0, 0, 1);
            let counted = _mm256_add_epi32(_mm256_castps_si256(b), one);
            _mm256_blend_ps::<0b1000_0000>(_mm256_max_ps(a, b), _mm256_castsi256_ps(counted))
        }
    }

    #[inline(always)]
    fn join(self, low: __m128, high: __m128) -> __m256 {
        // SAFETY: see above.
        unsafe { _mm256_set_m128(high, low) }
    }

    #[inline(always)]
    fn halves(self, from: __m256) -> [__m128; 2] {
        // SAFETY: see above.
        unsafe { [_mm256_castps256_ps128(from), _mm256_extractf128_ps::<1>(from)] }
    }

    #[inline(always)]
    fn load4(self, from: &[f32; 4]) -> __m128 {
        // SAFETY: see above; 16 bytes.
        unsafe { _mm_loadu_ps(from.as_ptr()) }
    }

    #[inline(always)]
    fn store4(self, from: __m128) -> [f32; 4] {
        let mut to = [0.0; 4];
        // SAFETY: see above; 16 bytes.
        unsafe { _mm_storeu_ps(to.as_mut_ptr(), from) };
        to
    }

    #[inline(always)]
    fn splat4(self, x: f32) -> __m128 {
        // SAFETY: see above.
        unsafe { _mm_set1_ps(x) }
    }

    #[inline(always)]
    fn rotate4(self, a: __m128) -> __m128 {
        // SAFETY: see above.
        unsafe { _mm_shuffle_ps::<0b00_11_10_01>(a, a) }
    }

    #[inline(always)]
    fn add4(self, a: __m128, b: __m128) -> __m128 {
        // SAFETY: see above.
        unsafe { _mm_add_ps(a, b) }
    }

    #[inline(always)]
    fn sub4(self, a: __m128, b: __m128) -> __m128 {
        // SAFETY: see above.
        unsafe { _mm_sub_ps(a, b) }
    }

    #[inline(always)]
    fn mul4(self, a: __m128, b: __m128) -> __m128 {
        // SAFETY: see above.
        unsafe { _mm_mul_ps(a, b) }
    }

    #[inline(always)]
    fn min4(self, a: __m128, b: __m128) -> __m128 {
        // SAFETY: see above.
        unsafe { _mm_min_ps(a, b) }
    }

    #[inline(always)]
    fn max4(self, a: __m128, b: __m128) -> __m128 {
        // SAFETY: see above.
        unsafe { _mm_max_ps(a, b) }
    }

    #[inline(always)]
    fn truncate4(self, a: __m128) -> [i32; 4] {
        let mut to = [0; 4];
        // SAFETY: see above; 16 bytes.
        unsafe { _mm_storeu_si128(to.as_mut_ptr().cast(), _mm_cvttps_epi32(a)) };
        to
    }

    #[inline(always)]
    fn pair_products(self, a: __m128) -> f32 {
        // SAFETY: see above.
        unsafe {
            let products = _mm_mul_ps(a, _mm_shuffle_ps::<0b00_00_10_01>(a, a));
            let second = _mm_movehdup_ps(products);
            let third = _mm_movehl_ps(products, products);
            _mm_cvtss_f32(_mm_add_ss(_mm_add_ss(products, second), third))
        }
    }

    #[inline(always)]
    fn load4_f64(self, from: &[f64; 4]) -> __m256d {
        // SAFETY: see above; 32 bytes.
        unsafe { _mm256_loadu_pd(from.as_ptr()) }
    }

    #[inline(always)]
    fn store4_f64(self, from: __m256d) -> [f64; 4] {
        let mut to = [0.0; 4];
        // SAFETY: see above; 32 bytes.
        unsafe { _mm256_storeu_pd(to.as_mut_ptr(), from) };
        to
    }

    #[inline(always)]
    fn to_f64(self, a: __m128) -> __m256d {
        // SAFETY: see above.
        unsafe { _mm256_cvtps_pd(a) }
    }

    #[inline(always)]
    fn to_f32(self, a: __m256d) -> __m128 {
        // SAFETY: see above.
        unsafe { _mm256_cvtpd_ps(a) }
    }

    #[inline(always)]
    fn splat4_f64(self, x: f64) -> __m256d {
        // SAFETY: see above.
        unsafe { _mm256_set1_pd(x) }
    }

    #[inline(always)]
    fn add4_f64(self, a: __m256d, b: __m256d) -> __m256d {
        // SAFETY: see above.
        unsafe { _mm256_add_pd(a, b) }
    }

    #[inline(always)]
    fn sub4_f64(self, a: __m256d, b: __m256d) -> __m256d {
        // SAFETY: see above.
        unsafe { _mm256_sub_pd(a, b) }
    }

    #[inline(always)]
    fn mul4_f64(self, a: __m256d, b: __m256d) -> __m256d {
        // SAFETY: see above.
        unsafe { _mm256_mul_pd(a, b) }
    }

    #[inline(always)]
    fn div4_f64(self, a: __m256d, b: __m256d) -> __m256d {
        // SAFETY: see above.
        unsafe { _mm256_div_pd(a, b) }
    }

    #[inline(always)]
    fn abs4_f64(self, a: __m256d) -> __m256d {
        // SAFETY: see above.
        unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), a) }
    }

    #[inline(always)]
    fn max4_f64(self, a: __m256d, b: __m256d) -> __m256d {
        // SAFETY: see above.
        unsafe { _mm256_max_pd(a, b) }
    }

    #[inline(always)]
    fn lt4_f64(self, a: __m256d, b: __m256d) -> u32 {
        // SAFETY: see above.
        unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(a, b)) as u32 }
    }
}

/// Lanes of `UPPER` from the lesser of two, the others from the greater.
///
/// # Safety
///
/// The machine has AVX2.
#[inline(always)]
unsafe fn exchange<const UPPER: i32>(a: __m256i, b: __m256i) -> __m256i {
    // SAFETY: as the caller's.
    unsafe {
        let (least, greatest) = (_mm256_min_epi32(a, b), _mm256_max_epi32(a, b));
        _mm256_blend_epi32::<UPPER>(greatest, least)
    }
}

/// Orders numbers as integers, by lanes where only the lowest three bits differ.
///
/// # Safety
///
/// The machine has AVX2.
#[inline(always)]
unsafe fn falling_keys(a: __m256) -> __m256i {
    // SAFETY: as the caller's.
    unsafe {
        let bits = _mm256_castps_si256(a);
        let flipped = _mm256_srli_epi32::<1>(_mm256_srai_epi32::<31>(bits));
        let lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
        let keys = _mm256_andnot_si256(_mm256_set1_epi32(7), _mm256_xor_si256(bits, flipped));
        _mm256_or_si256(keys, lanes)
    }
}

/// The lanes, falling.
///
/// # Safety
///
/// The machine has AVX2.
#[inline(always)]
unsafe fn sorted(keys: __m256i) -> __m256i {
    // SAFETY: as the caller's.
    unsafe {
        // Batcher's bitonic network: in each step, the greater of two goes to the lower lane.
        let keys = exchange::<0b10_10_10_10>(keys, _mm256_shuffle_epi32::<0b10_11_00_01>(keys));
        let keys = exchange::<0b11_00_11_00>(keys, _mm256_shuffle_epi32::<0b00_01_10_11>(keys));
        let keys = exchange::<0b10_10_10_10>(keys, _mm256_shuffle_epi32::<0b10_11_00_01>(keys));
        let reversed = _mm256_permutevar8x32_epi32(keys, _mm256_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0));
        let keys = exchange::<0b11_11_00_00>(keys, reversed);
        let keys = exchange::<0b11_00_11_00>(keys, _mm256_shuffle_epi32::<0b01_00_11_10>(keys));
        exchange::<0b10_10_10_10>(keys, _mm256_shuffle_epi32::<0b10_11_00_01>(keys))
    }
}
