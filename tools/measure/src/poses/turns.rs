use crate::statistics::median;
use rayon::ThreadPool;
use restpose_runtime::{Frame, Hit, Ray};
use std::time::Instant;

/// Rays of a turn: long enough to warm a cache, about a millisecond, and shorter than the slices of a scheduler, so that
/// most turns are not interrupted on a machine that has other work.
const TURN_RAYS: usize = 1024;

/// Seconds that each frame takes for all rays in a pool: `repeats` rounds in which they take turns, after one that is not
/// timed.
///
/// Of each turn's rays the first frame's time is its median over the rounds; another's is that times the median ratio of
/// the two within a round. So what the machine does between turns falls out.
pub(super) fn trace_seconds(frames: &[Frame], rays: &[Ray], repeats: u32, pool: &ThreadPool) -> Vec<f64> {
    let mut hits: Vec<Option<Hit>> = vec![None; TURN_RAYS];
    let mut turns: Vec<Vec<Vec<f64>>> = vec![Vec::with_capacity(repeats as usize); rays.len().div_ceil(TURN_RAYS)];
    pool.install(|| {
        for round in 0..=repeats {
            for (rays, rounds) in rays.chunks(TURN_RAYS).zip(&mut turns) {
                let hits = &mut hits[..rays.len()];
                let mut times = Vec::with_capacity(frames.len());
                for frame in frames {
                    let start = Instant::now();
                    frame.closest_hits(rays, hits);
                    times.push(start.elapsed().as_secs_f64());
                    std::hint::black_box(&hits);
                }
                if round > 0 {
                    rounds.push(times);
                }
            }
        }
    });
    let mut sums = vec![0.0; frames.len()];
    for rounds in turns {
        for (sum, seconds) in sums.iter_mut().zip(in_turns(&rounds)) {
            *sum += seconds;
        }
    }
    sums
}

/// Per column, the median of the first column times the column's median ratio to it.
fn in_turns(rounds: &[Vec<f64>]) -> Vec<f64> {
    let columns = rounds.first().map_or(0, Vec::len);
    let middle = |of: &dyn Fn(&Vec<f64>) -> f64| median(&mut rounds.iter().map(of).collect::<Vec<f64>>());
    let first = middle(&|round| round[0]);
    (0..columns)
        .map(|column| first * middle(&|round| round[column] / round[0]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_round_changes_no_ratio() {
        let rounds = [vec![1.0, 2.0, 0.5], vec![10.0, 20.0, 5.0], vec![1.0, 2.0, 0.5]];
        assert_eq!(in_turns(&rounds), [1.0, 2.0, 0.5]);
        let rounds = [vec![2.0, 2.0], vec![4.0, 8.0], vec![3.0, 6.0]];
        assert_eq!(in_turns(&rounds), [3.0, 6.0]);
    }
}
