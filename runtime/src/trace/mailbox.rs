/// How many primitives a ray remembers as already tested. A miss in this memory costs a repeated test, no more.
const MAILBOX_SIZE: usize = 8;

/// The last few primitives that a ray has tested.
pub(super) struct Mailbox {
    ids: [u32; MAILBOX_SIZE],
    next: usize,
}

impl Mailbox {
    pub(super) const EMPTY: Self = Self {
        ids: [u32::MAX; MAILBOX_SIZE],
        next: 0,
    };

    /// True the first time; `id` must not be `u32::MAX`.
    #[inline]
    pub(super) fn insert(&mut self, id: u32) -> bool {
        let known = self.ids.iter().fold(false, |known, other| known | (*other == id));
        if !known {
            self.ids[self.next] = id;
            self.next = (self.next + 1) % MAILBOX_SIZE;
        }
        !known
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mailbox_remembers_the_last_few() {
        let mut mailbox = Mailbox::EMPTY;
        for id in 0..MAILBOX_SIZE as u32 {
            assert!(mailbox.insert(id) && !mailbox.insert(id));
        }
        assert!(!mailbox.insert(0), "still within the memory");
        assert!(mailbox.insert(99) && mailbox.insert(0), "the oldest is forgotten");
    }
}
