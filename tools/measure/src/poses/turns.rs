use rayon::ThreadPool;
use restpose_runtime::{Frame, Hit, Ray};
use std::time::Instant;

/// Rays of a turn: a fraction of a millisecond for most files, so that few turns are interrupted on a machine that has
/// other work.
const TURN_RAYS: usize = 256;

/// Seconds that each frame takes for all rays in a pool: `repeats` rounds in which they take turns, after one that is not
/// timed.
///
/// Of each turn its least time counts: all that disturbs makes it longer. Every round begins with another frame, because
/// who comes first finds neither the rays in the cache nor their branches predicted.
pub(super) fn trace_seconds(frames: &[Frame], rays: &[Ray], repeats: u32, pool: &ThreadPool) -> Vec<f64> {
    let mut hits: Vec<Option<Hit>> = vec![None; TURN_RAYS];
    // By turn, then by frame.
    let mut least = vec![vec![f64::INFINITY; frames.len()]; rays.len().div_ceil(TURN_RAYS)];
    pool.install(|| {
        for round in 0..=repeats {
            for (rays, least) in rays.chunks(TURN_RAYS).zip(&mut least) {
                let hits = &mut hits[..rays.len()];
                for place in 0..frames.len() {
                    let frame = (place + round as usize) % frames.len();
                    let start = Instant::now();
                    frames[frame].closest_hits(rays, hits);
                    let time = start.elapsed().as_secs_f64();
                    std::hint::black_box(&hits);
                    if round > 0 {
                        least[frame] = least[frame].min(time);
                    }
                }
            }
        }
    });
    (0..frames.len())
        .map(|frame| least.iter().map(|turn| turn[frame]).sum())
        .collect()
}
