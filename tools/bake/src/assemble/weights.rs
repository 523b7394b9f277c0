use crate::import::Influence;
use restpose_formats::rows::WEIGHT_STEP;

/// Steps that the weights of one vertex sum to.
const WHOLE: u32 = 1 << 24;

/// Normalises weights to multiples of [`WEIGHT_STEP`] that sum to exactly one, and drops those that round to nothing.
///
/// Largest remainders get the steps that rounding down leaves over, so no weight moves by a full step. Order is kept.
/// `influences` have positive finite weights and at least one entry.
pub(super) fn exact_weights(influences: &[Influence]) -> Vec<(usize, f32)> {
    let sum: f64 = influences.iter().map(|influence| f64::from(influence.weight)).sum();
    let shares = influences
        .iter()
        .map(|influence| f64::from(influence.weight) / sum * f64::from(WHOLE));
    let mut steps: Vec<(u32, f64)> = shares
        .map(|share| (share.floor() as u32, share - share.floor()))
        .collect();
    let mut order: Vec<usize> = (0..steps.len()).collect();
    order.sort_by(|a, b| steps[*b].1.total_cmp(&steps[*a].1).then(a.cmp(b)));
    let given: u32 = steps.iter().map(|(steps, _)| steps).sum();
    if given > WHOLE {
        // Only rounding of the shares can do this, and only by a step or two.
        steps[order[0]].0 -= given - WHOLE;
    } else {
        for place in order.iter().cycle().take((WHOLE - given) as usize) {
            steps[*place].0 += 1;
        }
    }
    let weight = |steps: u32| steps as f32 * WEIGHT_STEP;
    influences
        .iter()
        .zip(&steps)
        .filter(|(_, s)| s.0 > 0)
        .map(|(i, s)| (i.joint, weight(s.0)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exact(weights: &[f32]) -> Vec<f32> {
        let influences: Vec<Influence> = weights
            .iter()
            .enumerate()
            .map(|(joint, weight)| Influence { joint, weight: *weight })
            .collect();
        exact_weights(&influences)
            .into_iter()
            .map(|(_, weight)| weight)
            .collect()
    }

    #[test]
    fn weights_sum_to_exactly_one_in_steps() {
        for weights in [
            vec![1.0f32],
            vec![0.3, 0.7],
            vec![0.1; 7],
            vec![1e-3, 5.0, 1e9],
            vec![1.0 / 3.0; 3],
            vec![85.0, 85.0, 84.0],
        ] {
            let steps: Vec<f64> = exact(&weights)
                .iter()
                .map(|w| f64::from(*w) * f64::from(WHOLE))
                .collect();
            assert!(
                steps.iter().all(|s| s.fract() == 0.0 && *s > 0.0),
                "{weights:?}: {steps:?}"
            );
            assert_eq!(steps.iter().sum::<f64>(), f64::from(WHOLE), "{weights:?}");
        }
    }

    #[test]
    fn weights_stay_within_a_step_and_vanishing_ones_go() {
        assert_eq!(exact(&[0.25, 0.75]), [0.25, 0.75]);
        assert_eq!(exact(&[1.0, 1e-12]), [1.0]);
        let thirds = exact(&[1.0, 1.0, 1.0]);
        assert!(
            thirds
                .iter()
                .all(|w| (f64::from(*w) - 1.0 / 3.0).abs() <= f64::from(WEIGHT_STEP))
        );
    }
}
