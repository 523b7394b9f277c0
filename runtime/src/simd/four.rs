/// Four numbers that are computed alike, or three and one that means nothing: in functions that are compiled for AVX2, compilers
/// make one vector of them where they are stored at once; elsewhere [`Doubles`](super::Doubles) does.
pub(crate) type Four = [f64; 4];

/// As `std::array::from_fn`, which is not always inlined.
#[inline(always)]
pub(crate) fn four(of: impl Fn(usize) -> f64) -> Four {
    [of(0), of(1), of(2), of(3)]
}
