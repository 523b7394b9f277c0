use crate::{
    asset_instance::AssetInstance,
    prepared::{Prepared, PreparedPool},
};
use std::{
    collections::{HashMap, hash_map::Entry},
    sync::{Arc, Weak},
};

/// Moving instances, each at the time of the last ray of this thread that met it: rays of one time that follow each other
/// share what was prepared.
#[derive(Default)]
pub(super) struct Moments {
    /// The commit that they belong to.
    commit: u64,
    /// By index of the instance.
    all: HashMap<u32, Moment>,
}

struct Moment {
    time: f32,
    /// A thread that traces no more keeps no asset.
    pool: Weak<PreparedPool>,
    prepared: Box<Prepared>,
}

impl Moments {
    /// An instance at a time, where it moves in the interval of the commit.
    pub(super) fn at(&mut self, commit: u64, index: u32, instance: &AssetInstance, time: f32) -> &Prepared {
        if std::mem::replace(&mut self.commit, commit) != commit {
            for (_, moment) in self.all.drain() {
                if let Some(pool) = moment.pool.upgrade() {
                    pool.put(moment.prepared);
                }
            }
        }
        let moment = match self.all.entry(index) {
            Entry::Occupied(entry) => {
                let moment = entry.into_mut();
                if moment.time == time {
                    return &moment.prepared;
                }
                moment
            }
            Entry::Vacant(entry) => entry.insert(Moment {
                time,
                pool: Arc::downgrade(instance.pool()),
                prepared: instance.pool().take(),
            }),
        };
        moment.time = time;
        instance.prepare_at(time, &mut moment.prepared);
        &moment.prepared
    }
}
