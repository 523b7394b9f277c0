use crate::{
    Place, WrongHit,
    checked_rays::{brute_force_subset, counted},
};
use rayon::prelude::*;
use restpose_bake::verify::Oracle;
use restpose_runtime::{Frame, Hit, Ray, TraceCounters};

/// Rays in frames that show the same pose, with what each frame finds.
pub(super) struct SettledRays {
    /// By frame.
    pub found: Vec<Found>,
    /// Rays that hit.
    pub hits: u64,
    pub brute_force_rays: u64,
}

/// What one frame finds.
pub(super) struct Found {
    pub hits: Vec<Option<Hit>>,
    pub counters: TraceCounters,
    /// Rays that hit and are found to miss.
    pub missed: u64,
    /// Rays that find another hit than the first, or one where there is none.
    pub wrong: u64,
}

impl SettledRays {
    /// Traces `rays` in each frame, counting, and compares bit for bit: all rays with each other, and those on which any
    /// two frames disagree, beside a subset spread over all, with brute force.
    ///
    /// # Errors
    /// Where a frame that is `guaranteed` to miss nothing finds another hit than brute force. Others are counted.
    pub fn new(frames: &[(Frame, bool)], oracle: &Oracle, rays: &[Ray], place: Place) -> Result<Self, Box<WrongHit>> {
        let mut found: Vec<Found> = frames
            .iter()
            .map(|(frame, _)| {
                let (hits, counters) = counted(*frame, rays);
                Found {
                    hits,
                    counters,
                    missed: 0,
                    wrong: 0,
                }
            })
            .collect();
        let mut to_check = brute_force_subset(rays.len(), oracle);
        to_check
            .extend((0..rays.len()).filter(|ray| found.iter().any(|other| other.hits[*ray] != found[0].hits[*ray])));
        to_check.sort_unstable();
        to_check.dedup();
        let expected: Vec<Option<Hit>> = to_check.par_iter().map(|ray| oracle.closest_hit(&rays[*ray])).collect();
        let mut hits = found[0].hits.clone();
        for (ray, expected) in to_check.iter().zip(expected) {
            hits[*ray] = expected;
            for (found, (_, guaranteed)) in found.iter_mut().zip(frames) {
                let own = found.hits[*ray];
                if own == expected {
                    continue;
                }
                if *guaranteed {
                    return Err(Box::new(WrongHit {
                        place,
                        ray: rays[*ray],
                        traced: "a file with envelopes",
                        found: own,
                        reference: "brute force",
                        expected,
                    }));
                }
                match own {
                    None => found.missed += 1,
                    Some(_) => found.wrong += 1,
                }
            }
        }
        Ok(Self {
            found,
            hits: hits.iter().flatten().count() as u64,
            brute_force_rays: to_check.len() as u64,
        })
    }
}
