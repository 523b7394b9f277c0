use super::{
    RayKind,
    crowd::{Crowd, posed_bounds},
    ray_sets::RaySet,
    settings::FrameSettings,
};
use crate::{MeasureError, Place, WrongHit, checked_rays::brute_force_subset};
use rayon::prelude::*;
use restpose_bake::verify::Oracle;
use restpose_runtime::{Aabb, Hit};

/// Rays per kind and pose whose hits are compared.
const CHECKED_RAYS: u32 = 1 << 14;

/// The part of the scene's diagonal by which a peer's hit may be off, 2⁻¹²: its rounding is a few 2⁻²⁴ of the largest
/// coordinate over the cosine of the angle at which the ray meets the triangle, so rays that graze by less than a degree count as
/// wrong, too, and there are few.
const PEER_ERROR: f64 = 1.0 / 4096.0;

/// What is known to be right: the room that a crowd takes, and hits that brute force found.
pub(super) struct Reference {
    /// Over all poses.
    pub bounds: Aabb,
    pub sets: Vec<CheckedSet>,
    pub brute_force_rays: u64,
}

/// Rays that are compared before any are timed.
pub(super) struct CheckedSet {
    pub rays: RaySet,
    /// Of the first pose: places among the rays, and their hits.
    expected: Vec<(usize, Option<Hit>)>,
}

impl Reference {
    pub(super) fn new(crowd: &Crowd, settings: &FrameSettings) -> Result<Self, MeasureError> {
        let (mut scene, instances) = crowd.scene(&crowd.asset)?;
        let mut bounds = Aabb::EMPTY;
        // The first pose comes last and stays.
        for pose in (0..crowd.poses.len()).rev() {
            crowd.pose(&mut scene, &instances, pose)?;
            bounds = bounds.union(posed_bounds(&scene.commit(), &instances, &crowd.asset));
        }
        let frame = scene.commit();
        let oracle = Oracle::new(&frame, &instances);
        let most = settings.rays.iter().copied().max().unwrap_or(0).min(CHECKED_RAYS);
        let set = |kind: &RayKind| {
            let rays = RaySet::new(*kind, most, most, &bounds, settings.seed);
            let expected = brute_force_subset(rays.count, &oracle)
                .into_par_iter()
                .map(|index| (index, oracle.closest_hit(&rays.of_frame(0)[index])))
                .collect();
            CheckedSet { rays, expected }
        };
        let sets: Vec<CheckedSet> = settings.ray_kinds.iter().map(set).collect();
        Ok(Self {
            bounds,
            brute_force_rays: sets.iter().map(|set| set.expected.len() as u64).sum(),
            sets,
        })
    }

    /// The greatest distance between equal hits of peers.
    pub(super) fn peer_error(&self) -> f64 {
        let side = |k: usize| f64::from(self.bounds.max[k]) - f64::from(self.bounds.min[k]);
        PEER_ERROR * (0..3).map(|k| side(k).powi(2)).sum::<f64>().sqrt()
    }
}

impl CheckedSet {
    /// Compares hits of the first pose with brute force's, bit for bit.
    pub(super) fn compare(&self, traced: &'static str, hits: &[Option<Hit>]) -> Result<(), Box<WrongHit>> {
        match self.expected.iter().find(|(index, hit)| hits[*index] != *hit) {
            None => Ok(()),
            Some((index, hit)) => Err(self.wrong(traced, 0, *index, hits[*index], "brute force", *hit)),
        }
    }

    /// Compares two strategies' hits, bit for bit.
    pub(super) fn compare_all(
        &self,
        (traced, hits): (&'static str, &[Option<Hit>]),
        (reference, expected): (&'static str, &[Option<Hit>]),
        pose: usize,
    ) -> Result<(), Box<WrongHit>> {
        match hits.iter().zip(expected).position(|(a, b)| a != b) {
            None => Ok(()),
            Some(index) => Err(self.wrong(traced, pose, index, hits[index], reference, expected[index])),
        }
    }

    fn wrong(
        &self,
        traced: &'static str,
        pose: usize,
        index: usize,
        found: Option<Hit>,
        reference: &'static str,
        expected: Option<Hit>,
    ) -> Box<WrongHit> {
        Box::new(WrongHit {
            place: Place::Crowd {
                pose,
                rays: self.rays.kind.name(),
            },
            ray: self.rays.of_frame(pose)[index],
            traced,
            found,
            reference,
            expected,
        })
    }
}
