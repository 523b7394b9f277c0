use rayon::ThreadPool;
use restpose_runtime::{Frame, Hit, Ray};
use std::time::Instant;

/// Rays of a turn: a fraction of a millisecond for most files, so that few turns are interrupted on a machine that has
/// other work.
const TURN_RAYS: usize = 256;

/// Seconds that each frame takes for all rays in a pool: `repeats` rounds in which they take turns, after one that is not
/// timed.
///
/// Of each turn its least time counts: all that disturbs makes it longer. No two frames in a row trace the same rays,
/// unless there are few, and every round begins with another frame: branches are predicted well where a like tree was just
/// traced by the same rays, which is worth a tenth of the time.
pub(super) fn trace_seconds(frames: &[Frame], rays: &[Ray], repeats: u32, pool: &ThreadPool) -> Vec<f64> {
    let mut hits: Vec<Option<Hit>> = vec![None; TURN_RAYS];
    let turns: Vec<&[Ray]> = rays.chunks(TURN_RAYS).collect();
    // By frame, then by turn.
    let mut least = vec![vec![f64::INFINITY; turns.len()]; frames.len()];
    pool.install(|| {
        for round in 0..=repeats as usize {
            for step in 0..turns.len() {
                for place in 0..frames.len() {
                    let frame = (place + round) % frames.len();
                    let turn = (step + frame * turns.len() / frames.len()) % turns.len();
                    let hits = &mut hits[..turns[turn].len()];
                    let start = Instant::now();
                    frames[frame].closest_hits(turns[turn], hits);
                    let time = start.elapsed().as_secs_f64();
                    std::hint::black_box(&hits);
                    if round > 0 {
                        least[frame][turn] = least[frame][turn].min(time);
                    }
                }
            }
        }
    });
    least.iter().map(|turns| turns.iter().sum()).collect()
}
