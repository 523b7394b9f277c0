use crate::{
    asset_instance::AssetInstance,
    prepared::{Prepared, PreparedPool},
    scene::Scene,
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
    /// What rays need of an instance at a time of the scene's interval.
    #[inline]
    pub(super) fn prepared_at<'a>(
        &'a mut self,
        scene: &Scene,
        index: u32,
        instance: &'a AssetInstance,
        time: f32,
    ) -> &'a Prepared {
        if time > 0.0 && instance.is_moving() {
            self.at(scene.commit, index, instance, time)
        } else {
            instance.prepared()
        }
    }

    fn give_back(&mut self) {
        for (_, moment) in self.all.drain() {
            if let Some(pool) = moment.pool.upgrade() {
                pool.put(moment.prepared);
            }
        }
    }

    /// An instance at a time, where it moves in the interval of the commit.
    fn at(&mut self, commit: u64, index: u32, instance: &AssetInstance, time: f32) -> &Prepared {
        if std::mem::replace(&mut self.commit, commit) != commit {
            self.give_back();
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

impl Drop for Moments {
    fn drop(&mut self) {
        self.give_back();
    }
}
