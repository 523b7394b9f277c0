/// What kernels need of a set of instructions. A value is the proof that this machine has them.
///
/// Of numbers that do not compare, `max` and `min` return the second.
pub(crate) trait Lanes: Copy {
    /// Eight numbers.
    type F8: Copy;
    /// Four numbers.
    type F4: Copy;
    /// Four `f64`.
    type D4: Copy;

    fn load8(self, from: &[f32; 8]) -> Self::F8;
    fn store8(self, from: Self::F8, to: &mut [f32; 8]);
    fn max8(self, a: Self::F8, b: Self::F8) -> Self::F8;
    fn splat8(self, x: f32) -> Self::F8;
    /// Eight whole numbers, exactly.
    fn widen8(self, from: &[u16; 8]) -> Self::F8;
    fn widen8_bytes(self, from: &[u8; 8]) -> Self::F8;
    fn add8(self, a: Self::F8, b: Self::F8) -> Self::F8;
    fn sub8(self, a: Self::F8, b: Self::F8) -> Self::F8;
    fn abs8(self, a: Self::F8) -> Self::F8;
    fn mul8(self, a: Self::F8, b: Self::F8) -> Self::F8;
    fn div8(self, a: Self::F8, b: Self::F8) -> Self::F8;
    /// Of lanes that do not compare, the second.
    fn min8(self, a: Self::F8, b: Self::F8) -> Self::F8;
    /// Lane `i` of output `k` is lane `k` of input `i`.
    fn transpose8(self, from: [Self::F8; 8]) -> [Self::F8; 8];
    /// As `le8`, where `a < b`.
    fn lt8(self, a: Self::F8, b: Self::F8) -> u32;
    /// A bit per lane, lane 0 lowest: set where `a ≤ b`, and so not for numbers that do not compare.
    fn le8(self, a: Self::F8, b: Self::F8) -> u32;
    /// Of lanes with `a ≤ b`, writes `a` and the tag, falling, behind each other; how many. What is written behind these means
    /// nothing.
    ///
    /// The lowest three bits of `a` do not count: of lanes that are equal but for them, later ones are written first.
    fn sort8(self, a: Self::F8, b: Self::F8, tags: &[u32; 8], to: (&mut [f32; 8], &mut [u32; 8])) -> usize;
    /// The indices of the lanes, as bits and not as numbers, the lane with the greatest number first. Its lowest three bits do not
    /// count: of lanes that are equal but for them, later ones come first. A NaN is beyond the infinity of its sign.
    fn order8(self, a: Self::F8) -> Self::F8;
    /// Lane `i` is lane `order[i]` of `a`: of the bits, the lowest three count.
    fn permute8(self, a: Self::F8, order: Self::F8) -> Self::F8;
    /// Lane `i` is lane `i − BY` where there is one, else its own. `BY` is 1, 2 or 4.
    fn later8<const BY: usize>(self, a: Self::F8) -> Self::F8;
    /// Lane `i` is lane `i + BY` where there is one, else its own. `BY` is 1, 2 or 4.
    fn sooner8<const BY: usize>(self, a: Self::F8) -> Self::F8;
    /// As `max8`, where lane 7 counts: its bits are those of `b`'s, plus one.
    fn max8_counting(self, a: Self::F8, b: Self::F8) -> Self::F8;
    /// Lanes 0 to 3 from the first, 4 to 7 from the second.
    fn join(self, low: Self::F4, high: Self::F4) -> Self::F8;
    /// Lanes 0 to 3 and 4 to 7.
    fn halves(self, from: Self::F8) -> [Self::F4; 2];

    fn load4(self, from: &[f32; 4]) -> Self::F4;
    fn store4(self, from: Self::F4) -> [f32; 4];
    fn splat4(self, x: f32) -> Self::F4;
    /// Lanes 1, 2, 3, 0.
    fn rotate4(self, a: Self::F4) -> Self::F4;
    fn add4(self, a: Self::F4, b: Self::F4) -> Self::F4;
    fn sub4(self, a: Self::F4, b: Self::F4) -> Self::F4;
    fn mul4(self, a: Self::F4, b: Self::F4) -> Self::F4;
    fn min4(self, a: Self::F4, b: Self::F4) -> Self::F4;
    fn max4(self, a: Self::F4, b: Self::F4) -> Self::F4;
    /// Towards zero. Lanes must lie between ±2³¹, or mean nothing.
    fn truncate4(self, a: Self::F4) -> [i32; 4];
    /// `a₀a₁ + a₁a₂ + a₂a₀`, added from the left.
    fn pair_products(self, a: Self::F4) -> f32;

    fn load4_f64(self, from: &[f64; 4]) -> Self::D4;
    fn store4_f64(self, from: Self::D4) -> [f64; 4];
    /// Four `f64`, exactly.
    fn to_f64(self, a: Self::F4) -> Self::D4;
    /// Four `f32`, rounded to nearest.
    fn to_f32(self, a: Self::D4) -> Self::F4;
    fn splat4_f64(self, x: f64) -> Self::D4;
    fn add4_f64(self, a: Self::D4, b: Self::D4) -> Self::D4;
    fn sub4_f64(self, a: Self::D4, b: Self::D4) -> Self::D4;
    fn mul4_f64(self, a: Self::D4, b: Self::D4) -> Self::D4;
    fn div4_f64(self, a: Self::D4, b: Self::D4) -> Self::D4;
    fn abs4_f64(self, a: Self::D4) -> Self::D4;
    fn max4_f64(self, a: Self::D4, b: Self::D4) -> Self::D4;
    /// As `lt8`.
    fn lt4_f64(self, a: Self::D4, b: Self::D4) -> u32;
}
