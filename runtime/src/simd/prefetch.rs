#![cfg_attr(
    target_arch = "x86_64",
    expect(unsafe_code, reason = "an instruction that takes an address")
)]

/// Bytes of a cache line.
#[cfg(target_arch = "x86_64")]
const LINE: usize = 64;

/// Asks for what will be read or written soon, without waiting for it. Elsewhere than on x86-64 does nothing.
#[inline]
pub(crate) fn prefetch<T>(things: &[T]) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let first = things.as_ptr().cast::<i8>();
        for offset in (0..size_of_val(things)).step_by(LINE) {
            // SAFETY: the instruction changes nothing that a program sees and faults at no address; this one is inside of
            // `things`.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(first.add(offset)) }
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = things;
}
