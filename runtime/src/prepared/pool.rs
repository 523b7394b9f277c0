use super::{Prepared, Scratch, Whole};
use crate::{Asset, vertex_memo::VertexMemo};
use std::sync::{
    Arc, Mutex, PoisonError,
    atomic::{AtomicU32, Ordering::Relaxed},
};

/// An asset, and what was made for its instances and is needed no longer: memory for the next.
///
/// What only instances with many rays need is kept apart, so that there is no more of it than such instances at once.
#[derive(Debug)]
pub(crate) struct PreparedPool {
    asset: Arc<Asset>,
    prepared: Mutex<Numbered>,
    pub wholes: Spare<Whole>,
    pub memos: Spare<VertexMemo>,
    pub scratch: Spare<Scratch>,
}

impl PreparedPool {
    pub(crate) fn new(asset: &Arc<Asset>) -> Self {
        Self {
            asset: Arc::clone(asset),
            prepared: Mutex::default(),
            wholes: Spare::default(),
            memos: Spare::default(),
            scratch: Spare::default(),
        }
    }

    pub(crate) fn asset(&self) -> &Arc<Asset> {
        &self.asset
    }

    pub(crate) fn take(&self) -> Box<Prepared> {
        self.prepared.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    pub(crate) fn put(&self, mut prepared: Box<Prepared>) {
        prepared.give_back(self);
        self.prepared
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .put(prepared);
    }
}

/// Instances in their poses, by number. The lowest that is spare comes first: the same few are used again, whichever was put
/// back last, so that they are in caches, and have grown to what is asked of them.
#[derive(Debug, Default)]
struct Numbered {
    /// `None` where it is in use.
    spare: Vec<Option<Box<Prepared>>>,
    /// A bit for each that is spare: to find the lowest touches none of them.
    bits: Vec<u64>,
    /// No word of `bits` before this one has any.
    first: usize,
}

impl Numbered {
    fn take(&mut self) -> Box<Prepared> {
        while let Some(word) = self.bits.get_mut(self.first) {
            if *word == 0 {
                self.first += 1;
                continue;
            }
            let number = self.first * u64::BITS as usize + word.trailing_zeros() as usize;
            *word &= *word - 1;
            if let Some(prepared) = self.spare[number].take() {
                return prepared;
            }
        }
        let number = self.spare.len();
        self.spare.push(None);
        self.bits.resize(self.spare.len().div_ceil(u64::BITS as usize), 0);
        Box::new(Prepared {
            number,
            ..Prepared::default()
        })
    }

    fn put(&mut self, prepared: Box<Prepared>) {
        let number = prepared.number;
        let word = number / u64::BITS as usize;
        self.bits[word] |= 1 << (number % u64::BITS as usize);
        self.first = self.first.min(word);
        self.spare[number] = Some(prepared);
    }
}

/// Things of one kind that are not in use.
#[derive(Debug)]
pub(crate) struct Spare<T> {
    things: Mutex<Vec<Box<T>>>,
    /// How many are in use.
    in_use: AtomicU32,
}

impl<T> Default for Spare<T> {
    fn default() -> Self {
        Self {
            things: Mutex::default(),
            in_use: AtomicU32::new(0),
        }
    }
}

impl<T: Default> Spare<T> {
    /// One that is spare, or a new one.
    pub(super) fn take(&self) -> Box<T> {
        self.in_use.fetch_add(1, Relaxed);
        let spare = self.things.lock().unwrap_or_else(PoisonError::into_inner).pop();
        spare.unwrap_or_default()
    }

    pub(super) fn put(&self, thing: Box<T>) {
        self.in_use.fetch_sub(1, Relaxed);
        self.things.lock().unwrap_or_else(PoisonError::into_inner).push(thing);
    }

    pub(crate) fn in_use(&self) -> u32 {
        self.in_use.load(Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Taken and put back at random: always the lowest number that is not in use, and a new one only where all are.
    #[test]
    fn the_lowest_number_comes_first() {
        let mut random = fastrand::Rng::with_seed(12);
        for _ in 0..20 {
            let (mut pool, mut used, mut made) = (Numbered::default(), Vec::<Box<Prepared>>::new(), 0);
            let most = random.usize(1..300);
            for _ in 0..2_000 {
                if used.len() < most && random.bool() {
                    let taken = pool.take();
                    let lowest = (0..).find(|number| used.iter().all(|other| other.number != *number));
                    assert_eq!(Some(taken.number), lowest);
                    made = made.max(taken.number + 1);
                    used.push(taken);
                } else if !used.is_empty() {
                    pool.put(used.swap_remove(random.usize(..used.len())));
                }
            }
            assert_eq!(pool.spare.len(), made);
        }
    }
}
