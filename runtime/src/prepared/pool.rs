use super::{Prepared, Scratch, Whole};
use crate::{Asset, vertex_memo::VertexMemo};
use std::{
    cmp::Ordering,
    collections::BinaryHeap,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicU32, Ordering::Relaxed},
    },
};

/// An asset, and what was made for its instances and is needed no longer: memory for the next.
///
/// What only instances with many rays need is kept apart, so that there is no more of it than such instances at once.
#[derive(Debug)]
pub(crate) struct PreparedPool {
    asset: Arc<Asset>,
    prepared: Mutex<BinaryHeap<Numbered>>,
    /// How many were made.
    count: AtomicU32,
    pub wholes: Spare<Whole>,
    pub memos: Spare<VertexMemo>,
    pub scratch: Spare<Scratch>,
}

/// The lowest number comes first: the same few are used again, whichever was put back last, so that they are in caches, and
/// have grown to what is asked of them.
#[derive(Debug)]
struct Numbered {
    /// Beside the thing: to find the lowest touches none of the others.
    number: u32,
    prepared: Box<Prepared>,
}

impl PartialEq for Numbered {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Numbered {}

impl PartialOrd for Numbered {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Numbered {
    fn cmp(&self, other: &Self) -> Ordering {
        other.number.cmp(&self.number)
    }
}

impl PreparedPool {
    pub(crate) fn new(asset: &Arc<Asset>) -> Self {
        Self {
            asset: Arc::clone(asset),
            prepared: Mutex::default(),
            count: AtomicU32::new(0),
            wholes: Spare::default(),
            memos: Spare::default(),
            scratch: Spare::default(),
        }
    }

    pub(crate) fn asset(&self) -> &Arc<Asset> {
        &self.asset
    }

    pub(crate) fn take(&self) -> Box<Prepared> {
        let spare = self.prepared.lock().unwrap_or_else(PoisonError::into_inner).pop();
        spare.map_or_else(
            || {
                Box::new(Prepared {
                    number: self.count.fetch_add(1, Relaxed),
                    ..Prepared::default()
                })
            },
            |numbered| numbered.prepared,
        )
    }

    pub(crate) fn put(&self, mut prepared: Box<Prepared>) {
        prepared.give_back(self);
        self.prepared
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push(Numbered {
                number: prepared.number,
                prepared,
            });
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
