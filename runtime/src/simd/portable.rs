use super::Lanes;

/// Arrays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

impl Lanes for Portable {
    type F8 = [f32; 8];
    type F4 = [f32; 4];
    type D4 = [f64; 4];

    #[inline(always)]
    fn load8(self, from: &[f32; 8]) -> [f32; 8] {
        *from
    }

    #[inline(always)]
    fn store8(self, from: [f32; 8], to: &mut [f32; 8]) {
        *to = from;
    }

    #[inline(always)]
    fn max8(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        std::array::from_fn(|k| if a[k] > b[k] { a[k] } else { b[k] })
    }

    #[inline(always)]
    fn splat8(self, x: f32) -> [f32; 8] {
        [x; 8]
    }

    #[inline(always)]
    fn widen8(self, from: &[u16; 8]) -> [f32; 8] {
        from.map(f32::from)
    }

    #[inline(always)]
    fn widen8_bytes(self, from: &[u8; 8]) -> [f32; 8] {
        from.map(f32::from)
    }

    #[inline(always)]
    fn add8(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        std::array::from_fn(|k| a[k] + b[k])
    }

    #[inline(always)]
    fn sub8(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        std::array::from_fn(|k| a[k] - b[k])
    }

    #[inline(always)]
    fn abs8(self, a: [f32; 8]) -> [f32; 8] {
        a.map(f32::abs)
    }

    #[inline(always)]
    fn mul8(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        std::array::from_fn(|k| a[k] * b[k])
    }

    #[inline(always)]
    fn div8(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        std::array::from_fn(|k| a[k] / b[k])
    }

    #[inline(always)]
    fn min8(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        std::array::from_fn(|k| if a[k] < b[k] { a[k] } else { b[k] })
    }

    #[inline(always)]
    fn transpose8(self, from: [[f32; 8]; 8]) -> [[f32; 8]; 8] {
        std::array::from_fn(|k| std::array::from_fn(|i| from[i][k]))
    }

    #[inline(always)]
    fn lt8(self, a: [f32; 8], b: [f32; 8]) -> u32 {
        (0..8).fold(0, |bits, k| bits | u32::from(a[k] < b[k]) << k)
    }

    #[inline(always)]
    fn le8(self, a: [f32; 8], b: [f32; 8]) -> u32 {
        (0..8).fold(0, |bits, k| bits | u32::from(a[k] <= b[k]) << k)
    }

    #[inline(always)]
    fn sort8(self, a: [f32; 8], b: [f32; 8], tags: &[u32; 8], to: (&mut [f32; 8], &mut [u32; 8])) -> usize {
        let mut keys = [0; 8];
        let mut count = 0;
        for k in 0..8 {
            if a[k] <= b[k] {
                let key = falling_key(a[k], k);
                let mut at = count;
                while at > 0 && keys[at - 1] < key {
                    keys[at] = keys[at - 1];
                    at -= 1;
                }
                keys[at] = key;
                count += 1;
            }
        }
        for (at, key) in keys[..count].iter().enumerate() {
            let lane = *key as usize & 7;
            (to.0[at], to.1[at]) = (a[lane], tags[lane]);
        }
        count
    }

    #[inline(always)]
    fn order8(self, a: [f32; 8]) -> [f32; 8] {
        let mut keys: [i32; 8] = std::array::from_fn(|k| falling_key(a[k], k));
        keys.sort_unstable_by(|a, b| b.cmp(a));
        keys.map(|key| f32::from_bits(key as u32 & 7))
    }

    #[inline(always)]
    fn permute8(self, a: [f32; 8], order: [f32; 8]) -> [f32; 8] {
        order.map(|lane| a[lane.to_bits() as usize & 7])
    }

    #[inline(always)]
    fn later8<const BY: usize>(self, a: [f32; 8]) -> [f32; 8] {
        std::array::from_fn(|k| a[if k < BY { k } else { k - BY }])
    }

    #[inline(always)]
    fn sooner8<const BY: usize>(self, a: [f32; 8]) -> [f32; 8] {
        std::array::from_fn(|k| a[if k + BY > 7 { k } else { k + BY }])
    }

    #[inline(always)]
    fn max8_counting(self, a: [f32; 8], b: [f32; 8]) -> [f32; 8] {
        let mut out = self.max8(a, b);
        out[7] = f32::from_bits(b[7].to_bits().wrapping_add(1));
        out
    }

    #[inline(always)]
    fn join(self, low: [f32; 4], high: [f32; 4]) -> [f32; 8] {
        std::array::from_fn(|k| if k < 4 { low[k] } else { high[k - 4] })
    }

    #[inline(always)]
    fn halves(self, from: [f32; 8]) -> [[f32; 4]; 2] {
        [0, 4].map(|first| std::array::from_fn(|k| from[first + k]))
    }

    #[inline(always)]
    fn load4(self, from: &[f32; 4]) -> [f32; 4] {
        *from
    }

    #[inline(always)]
    fn store4(self, from: [f32; 4]) -> [f32; 4] {
        from
    }

    #[inline(always)]
    fn splat4(self, x: f32) -> [f32; 4] {
        [x; 4]
    }

    #[inline(always)]
    fn rotate4(self, [a, b, c, d]: [f32; 4]) -> [f32; 4] {
        [b, c, d, a]
    }

    #[inline(always)]
    fn add4(self, a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
        std::array::from_fn(|k| a[k] + b[k])
    }

    #[inline(always)]
    fn sub4(self, a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
        std::array::from_fn(|k| a[k] - b[k])
    }

    #[inline(always)]
    fn mul4(self, a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
        std::array::from_fn(|k| a[k] * b[k])
    }

    #[inline(always)]
    fn min4(self, a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
        std::array::from_fn(|k| if a[k] < b[k] { a[k] } else { b[k] })
    }

    #[inline(always)]
    fn max4(self, a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
        std::array::from_fn(|k| if a[k] > b[k] { a[k] } else { b[k] })
    }

    #[inline(always)]
    fn truncate4(self, a: [f32; 4]) -> [i32; 4] {
        a.map(|x| x as i32)
    }

    #[inline(always)]
    fn pair_products(self, [x, y, z, _]: [f32; 4]) -> f32 {
        x * y + y * z + z * x
    }

    #[inline(always)]
    fn load4_f64(self, from: &[f64; 4]) -> [f64; 4] {
        *from
    }

    #[inline(always)]
    fn store4_f64(self, from: [f64; 4]) -> [f64; 4] {
        from
    }

    #[inline(always)]
    fn to_f64(self, a: [f32; 4]) -> [f64; 4] {
        a.map(f64::from)
    }

    #[inline(always)]
    fn to_f32(self, a: [f64; 4]) -> [f32; 4] {
        a.map(|x| x as f32)
    }

    #[inline(always)]
    fn splat4_f64(self, x: f64) -> [f64; 4] {
        [x; 4]
    }

    #[inline(always)]
    fn add4_f64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|k| a[k] + b[k])
    }

    #[inline(always)]
    fn sub4_f64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|k| a[k] - b[k])
    }

    #[inline(always)]
    fn mul4_f64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|k| a[k] * b[k])
    }

    #[inline(always)]
    fn div4_f64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|k| a[k] / b[k])
    }

    #[inline(always)]
    fn abs4_f64(self, a: [f64; 4]) -> [f64; 4] {
        a.map(f64::abs)
    }

    #[inline(always)]
    fn max4_f64(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|k| if a[k] > b[k] { a[k] } else { b[k] })
    }

    #[inline(always)]
    fn lt4_f64(self, a: [f64; 4], b: [f64; 4]) -> u32 {
        (0..4).fold(0, |bits, k| bits | u32::from(a[k] < b[k]) << k)
    }
}

/// Orders numbers as integers, by lanes where only the lowest three bits differ.
#[inline(always)]
fn falling_key(a: f32, lane: usize) -> i32 {
    let bits = a.to_bits() as i32;
    (bits ^ ((bits >> 31) as u32 >> 1) as i32) & !7 | lane as i32
}
