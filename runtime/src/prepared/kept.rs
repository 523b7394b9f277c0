use super::pool::Spare;
use std::sync::{
    OnceLock,
    atomic::{AtomicBool, Ordering::Relaxed},
};

/// Something that one thread makes while others do without.
#[derive(Debug, Default)]
pub(super) struct Kept<T> {
    made: OnceLock<Box<T>>,
    is_claimed: AtomicBool,
}

impl<T: Default> Kept<T> {
    #[inline]
    pub(super) fn get(&self) -> Option<&T> {
        self.made.get().map(|made| &**made)
    }

    /// The thing, made by `make` out of a spare one where nobody has begun to; `None` while another thread makes it.
    pub(super) fn get_or_make(&self, spare: &Spare<T>, make: impl FnOnce(&mut T)) -> Option<&T> {
        if self.made.get().is_none() && !self.is_claimed.swap(true, Relaxed) {
            let mut made = spare.take();
            make(&mut made);
            // Nobody else has claimed it.
            let _ = self.made.set(made);
        }
        self.get()
    }

    /// Forgets it.
    pub(super) fn give_back(&mut self, spare: &Spare<T>) {
        if let Some(made) = self.made.take() {
            spare.put(made);
        }
        *self.is_claimed.get_mut() = false;
    }
}
