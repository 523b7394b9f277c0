use crate::{Aabb, Hit, Ray, set_bits::set_bits};
use std::{
    cell::RefCell,
    sync::atomic::{AtomicU64, Ordering::Relaxed},
};

/// Steps along the longest side of a scene, 2¹⁰: so thirty bits tell a cell.
const CELLS: f32 = 1024.0;

/// The rays of a batch that go alone, in an order in which those that begin near each other follow each other: they need the
/// same instances, and what these are is in caches. Memory: keep it.
#[derive(Debug, Default)]
pub(crate) struct RayOrder {
    /// A bit for each ray that goes alone, by place in the batch.
    alone: Vec<AtomicU64>,
    /// Cell and place.
    keys: Vec<u64>,
    /// Of the rays in their order.
    hits: Vec<Option<Hit>>,
}

impl RayOrder {
    /// Begins a batch of so many rays.
    pub(crate) fn begin(&mut self, rays: usize) {
        self.alone
            .resize_with(rays.div_ceil(u64::BITS as usize), AtomicU64::default);
    }

    /// Says which rays go alone, of the 64 from `first` on.
    pub(crate) fn leave(&self, first: usize, alone: u64) {
        self.alone[first / u64::BITS as usize].store(alone, Relaxed);
    }

    /// Sorts those that go alone by where they enter `bounds`.
    pub(crate) fn sort(&mut self, rays: &[Ray], bounds: &Aabb) {
        let longest = (0..3).fold(0.0, |longest: f32, k| longest.max(bounds.max[k] - bounds.min[k]));
        let scale = CELLS / longest;
        self.keys.clear();
        for (word, alone) in self.alone.iter().enumerate() {
            self.keys.extend(set_bits(alone.load(Relaxed)).map(|bit| {
                let place = word * u64::BITS as usize + bit;
                u64::from(cell(&rays[place], bounds, scale)) << 32 | place as u64
            }));
        }
        // Keys are unique, so there is one order.
        #[cfg(feature = "parallel")]
        rayon::slice::ParallelSliceMut::par_sort_unstable(&mut self.keys[..]);
        #[cfg(not(feature = "parallel"))]
        self.keys.sort_unstable();
        self.hits.clear();
        self.hits.resize(self.keys.len(), None);
    }

    /// Keys of the rays in their order, which tell their [`place`]s, and room for the hit of each.
    pub(crate) fn sorted(&mut self) -> (&[u64], &mut [Option<Hit>]) {
        (&self.keys, &mut self.hits)
    }

    /// Runs `batch` with the thread's own.
    pub(crate) fn with<T>(batch: impl FnOnce(&mut Self) -> T) -> T {
        thread_local! {
            static OWN: RefCell<RayOrder> = RefCell::default();
        }
        OWN.with(|own| match own.try_borrow_mut() {
            Ok(mut own) => batch(&mut own),
            // A batch within a task of another that this thread waits for.
            Err(_) => batch(&mut Self::default()),
        })
    }
}

/// The place of a ray in the batch, by its key.
#[inline]
pub(crate) fn place(key: u64) -> usize {
    key as u32 as usize
}

/// Along a curve of Morton's: which cell of the bounds the ray enters first. Any will do where something overflows.
fn cell(ray: &Ray, bounds: &Aabb, scale: f32) -> u32 {
    let mut t = ray.t_min;
    for k in 0..3 {
        let (origin, direction) = (ray.origin[k], ray.direction[k]);
        if direction != 0.0 {
            let plane = if direction > 0.0 { bounds.min[k] } else { bounds.max[k] };
            t = t.max((plane - origin) / direction);
        }
    }
    (0..3).fold(0, |cell, k| {
        let at = ray.origin[k] + t * ray.direction[k];
        cell | spread(((at - bounds.min[k]) * scale).min(CELLS - 1.0) as u32) << k
    })
}

/// Two zeros between the ten lowest bits.
fn spread(mut x: u32) -> u32 {
    x = (x | x << 16) & 0x0300_00ff;
    x = (x | x << 8) & 0x0300_f00f;
    x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Aabb = Aabb {
        min: [-1.0; 3],
        max: [1.0, 1.0, 3.0],
    };

    #[test]
    fn rays_that_go_alone_are_each_there_once() {
        let mut random = fastrand::Rng::with_seed(37);
        let mut order = RayOrder::default();
        for count in [0, 1, 63, 64, 65, 1_000, 130] {
            let mut number = || match random.u8(..12) {
                0 => f32::NAN,
                1 => f32::INFINITY,
                2 => 0.0,
                3 => -1e38,
                _ => random.f32() * 4.0 - 2.0,
            };
            let mut three = || std::array::from_fn(|_| number());
            let rays: Vec<Ray> = (0..count).map(|_| Ray::new(three(), three())).collect();
            order.begin(count);
            let mut expected = Vec::new();
            for first in (0..count).step_by(64) {
                let places = (first..count).take(64).filter(|_| random.bool());
                let alone = places.inspect(|place| expected.push(*place));
                order.leave(first, alone.fold(0, |alone, place| alone | 1 << (place - first)));
            }
            order.sort(&rays, &BOUNDS);
            let (keys, hits) = order.sorted();
            assert_eq!(keys.len(), hits.len());
            let mut found: Vec<usize> = keys.iter().map(|key| place(*key)).collect();
            found.sort_unstable();
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn rays_that_enter_near_each_other_follow_each_other() {
        // From inside, and from outside towards the same corner: the other corner's come between them in the batch.
        let (low, high) = ([-0.9; 3], [0.9, 0.9, 2.9]);
        let towards = |point: [f32; 3]| Ray::between([point[0], point[1], 9.0], point);
        let rays = [
            Ray::new(low, [0.0, 1.0, 0.0]),
            Ray::new(high, [1.0, 0.0, 0.0]),
            Ray::new(low, [0.0, 0.0, -1.0]),
            towards(high),
        ];
        let mut order = RayOrder::default();
        order.begin(rays.len());
        order.leave(0, 0b1111);
        order.sort(&rays, &BOUNDS);
        let places: Vec<usize> = order.sorted().0.iter().map(|key| place(*key)).collect();
        assert_eq!(places, [0, 2, 1, 3]);
    }
}
