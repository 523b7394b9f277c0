use std::sync::{
    Mutex, OnceLock, PoisonError,
    atomic::{AtomicBool, Ordering::Relaxed},
};

/// Something that one thread makes while others do without, and whose memory is kept for the next pose.
#[derive(Debug, Default)]
pub(super) struct Kept<T> {
    made: OnceLock<Box<T>>,
    is_claimed: AtomicBool,
    spare: Mutex<Option<Box<T>>>,
}

impl<T: Default> Kept<T> {
    #[inline]
    pub(super) fn get(&self) -> Option<&T> {
        self.made.get().map(|made| &**made)
    }

    /// The thing, made by `make` out of an old one where nobody has begun to; `None` while another thread makes it.
    pub(super) fn get_or_make(&self, make: impl FnOnce(&mut T)) -> Option<&T> {
        if self.made.get().is_none() && !self.is_claimed.swap(true, Relaxed) {
            let spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner).take();
            let mut made = spare.unwrap_or_default();
            make(&mut made);
            // Nobody else has claimed it.
            let _ = self.made.set(made);
        }
        self.get()
    }

    /// Begins a pose.
    pub(super) fn forget(&mut self) {
        if let Some(made) = self.made.take() {
            *self.spare.get_mut().unwrap_or_else(PoisonError::into_inner) = Some(made);
        }
        *self.is_claimed.get_mut() = false;
    }
}
