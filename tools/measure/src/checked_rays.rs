use crate::{Place, WrongHit};
use rayon::prelude::*;
use restpose_bake::verify::Oracle;
use restpose_runtime::{Frame, Hit, Ray, TraceCounters};

/// Triangle tests that comparing one set of rays with brute force takes: a fraction of a second.
const BRUTE_FORCE_TESTS: usize = 20_000_000;

/// Rays that are compared with brute force however many triangles there are.
const FEWEST_BRUTE_FORCE_RAYS: usize = 16;

/// Rays whose hits are known to be right, with what they cost.
pub(crate) struct CheckedRays {
    pub rays: Vec<Ray>,
    pub hits: Vec<Option<Hit>>,
    /// Fuzzy trees, static tree.
    pub counters: [TraceCounters; 2],
    pub brute_force_rays: u64,
    place: Place,
}

impl CheckedRays {
    /// Traces `rays` by fuzzy trees and by the static twin's, counting, and compares: all rays with each other, a
    /// subset spread over them with brute force. Bit for bit: triangle, `t` and barycentric coordinates.
    pub(crate) fn new(
        [ours, twin]: [Frame; 2],
        oracle: &Oracle,
        rays: Vec<Ray>,
        place: Place,
    ) -> Result<Self, Box<WrongHit>> {
        let (hits, our_counters) = counted(ours, &rays);
        let (twin_hits, twin_counters) = counted(twin, &rays);
        let mut out = Self {
            rays,
            hits,
            counters: [our_counters, twin_counters],
            brute_force_rays: 0,
            place,
        };
        out.compare("the static tree", &twin_hits)?;

        let subset = brute_force_subset(out.rays.len(), oracle);
        let expected: Vec<Option<Hit>> = subset
            .par_iter()
            .map(|index| oracle.closest_hit(&out.rays[*index]))
            .collect();
        out.brute_force_rays = subset.len() as u64;
        for (index, expected) in subset.into_iter().zip(expected) {
            if out.hits[index] != expected {
                return Err(out.wrong(index, "fuzzy trees", out.hits[index], "brute force", expected));
            }
        }
        Ok(out)
    }

    /// Compares the hits of all rays with the known ones.
    pub(crate) fn compare(&self, traced: &'static str, found: &[Option<Hit>]) -> Result<(), Box<WrongHit>> {
        match self.hits.iter().zip(found).position(|(known, found)| known != found) {
            Some(index) => Err(self.wrong(index, traced, found[index], "fuzzy trees", self.hits[index])),
            None => Ok(()),
        }
    }

    fn wrong(
        &self,
        index: usize,
        traced: &'static str,
        found: Option<Hit>,
        reference: &'static str,
        expected: Option<Hit>,
    ) -> Box<WrongHit> {
        Box::new(WrongHit {
            place: self.place,
            ray: self.rays[index],
            traced,
            found,
            reference,
            expected,
        })
    }
}

/// Which of `count` rays are compared with brute force: as many as there is time for, spread evenly.
pub(crate) fn brute_force_subset(count: usize, oracle: &Oracle) -> Vec<usize> {
    let most = (BRUTE_FORCE_TESTS / oracle.triangle_count().max(1)).max(FEWEST_BRUTE_FORCE_RAYS);
    (0..count).step_by(count.div_ceil(most).max(1)).collect()
}

/// The hits of all rays, on all threads, and the sum of what they cost.
pub(crate) fn counted(frame: Frame, rays: &[Ray]) -> (Vec<Option<Hit>>, TraceCounters) {
    let one = |ray: &Ray| {
        let mut counters = TraceCounters::default();
        (frame.closest_hit_counted(ray, &mut counters), counters)
    };
    let (hits, counters): (Vec<_>, Vec<_>) = rays.par_iter().map(one).unzip();
    let sum = counters
        .into_iter()
        .fold(TraceCounters::default(), |mut sum, counters| {
            sum += counters;
            sum
        });
    (hits, sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use restpose_bake::{BakeSettings, NoProgress, bake, import::import, verify::Rays};
    use restpose_runtime::{Asset, InstanceId, Posing, Scene};
    use std::{path::Path, sync::Arc};

    const PLACE: Place = Place::Sample {
        subdivisions: 2,
        sample: 7,
    };

    fn walker_at(seconds: f32) -> (Scene, InstanceId) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples/scenes/walker.glb");
        let source = import(&path).unwrap().animation;
        let baked = bake(&source, &BakeSettings::default(), &NoProgress).unwrap();
        let bytes = restpose_formats::write(&baked.model).unwrap();
        let mut scene = Scene::new();
        let instance = scene.add(&Arc::new(Asset::from_bytes(&bytes).unwrap()));
        // Counters then do not depend on the rays that came before.
        scene.set_posing(instance, Posing::Recomputed).unwrap();
        scene.play(instance, 0, seconds).unwrap();
        (scene, instance)
    }

    #[test]
    fn another_pose_is_noticed_wherever_it_stands() {
        let ((mut here, instance), (mut elsewhere, _)) = (walker_at(0.0), walker_at(0.4));
        let (here, elsewhere) = (here.commit(), elsewhere.commit());
        let (oracle, other_oracle) = (Oracle::new(&here, &[instance]), Oracle::new(&elsewhere, &[instance]));
        let rays: Vec<Ray> = Rays::new(&oracle, 1).take(500).collect();
        let check = |frames, oracle| CheckedRays::new(frames, oracle, rays.clone(), PLACE);

        let right = check([here, here], &oracle).ok().unwrap();
        assert_eq!(right.brute_force_rays, 500);
        assert_eq!(right.counters[0], right.counters[1]);
        assert!(
            right.hits.iter().flatten().count() > 100,
            "rays that hit nothing prove nothing"
        );

        let wrong = check([here, elsewhere], &oracle).err().unwrap();
        assert_eq!((wrong.traced, wrong.place), ("the static tree", PLACE));
        let wrong = check([here, here], &other_oracle).err().unwrap();
        assert_eq!((wrong.traced, wrong.reference), ("fuzzy trees", "brute force"));
    }

    #[test]
    fn one_bit_of_one_hit_is_noticed() {
        let (mut scene, instance) = walker_at(0.1);
        let frame = scene.commit();
        let oracle = Oracle::new(&frame, &[instance]);
        let rays: Vec<Ray> = Rays::new(&oracle, 2).take(100).collect();
        let checked = CheckedRays::new([frame; 2], &oracle, rays, PLACE).ok().unwrap();
        let mut hits = checked.hits.clone();
        assert!(checked.compare("copy", &hits).is_ok());
        let changed = hits.iter().rposition(Option::is_some).unwrap();
        if let Some(hit) = &mut hits[changed] {
            hit.u = hit.u.next_up();
        }
        let wrong = checked.compare("copy", &hits).err().unwrap();
        assert_eq!(wrong.ray, checked.rays[changed]);
    }
}
