/// What a search along a line found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Minimum {
    pub at: f32,
    pub value: f32,
    /// Evaluations of the function.
    pub steps: u32,
}

/// What golden section keeps of a bracket: (3 − √5) / 2.
pub(super) const GOLDEN: f32 = 0.381_966;

/// The minimum of `f` between `low` and `high`, from `start`, by golden section search combined with parabolic
/// interpolation; the very minimum within `tolerance` where `f` has but one, else a local one.
///
/// Guarantee: evaluates `f` at `start` first and at most `most` times, within the bracket; nothing found costs more than
/// the start.
///
/// Source: Brent, *Algorithms for Minimization without Derivatives*, 1973, chapter 5; the search of Hussain and Grahn.
pub(super) fn minimum(
    mut f: impl FnMut(f32) -> f32,
    [mut low, mut high]: [f32; 2],
    start: f32,
    tolerance: f32,
    most: u32,
) -> Minimum {
    let value = f(start);
    // The best point, the second best, and the one that was second best before.
    let mut points = [(start, value); 3];
    let (mut step, mut before) = (0.0f32, 0.0f32);
    let mut steps = 1;
    while steps < most {
        let [(x, fx), (w, fw), (v, fv)] = points;
        let middle = f32::midpoint(low, high);
        if (x - middle).abs() <= 2.0 * tolerance - 0.5 * (high - low) {
            break;
        }
        let parabola = if before.abs() > tolerance {
            let r = (x - w) * (fx - fv);
            let q = (x - v) * (fx - fw);
            let p = (x - v) * q - (x - w) * r;
            let q = 2.0 * (q - r);
            let (p, q) = if q > 0.0 { (-p, q) } else { (p, -q) };
            let usable = p.abs() < (0.5 * q * before).abs() && p > q * (low - x) && p < q * (high - x);
            usable.then(|| p / q)
        } else {
            None
        };
        if let Some(d) = parabola {
            before = step;
            step = d;
            let u = x + d;
            if u - low < 2.0 * tolerance || high - u < 2.0 * tolerance {
                step = tolerance.copysign(middle - x);
            }
        } else {
            before = if x < middle { high - x } else { low - x };
            step = GOLDEN * before;
        }
        let u = x + if step.abs() >= tolerance {
            step
        } else {
            tolerance.copysign(step)
        };
        let u = u.clamp(low, high);
        let fu = f(u);
        steps += 1;
        if fu <= fx {
            if u < x {
                high = x;
            } else {
                low = x;
            }
            points = [(u, fu), (x, fx), (w, fw)];
        } else {
            if u < x {
                low = u;
            } else {
                high = u;
            }
            if fu <= fw || w == x {
                points = [(x, fx), (u, fu), (w, fw)];
            } else if fu <= fv || v == x || v == w {
                points[2] = (u, fu);
            }
        }
    }
    Minimum {
        at: points[0].0,
        value: points[0].1,
        steps,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_finds_the_minima_of_known_functions() {
        type Case = (fn(f32) -> f32, f32);
        let cases: [Case; 5] = [
            (|x| (x - 0.3) * (x - 0.3), 0.3),
            (|x| (x - 0.7).abs(), 0.7),
            (|x| x * x * x * x - x, 0.629_96),
            (|x| x, 0.0),
            (|x| -x, 1.0),
        ];
        for (case, (f, expected)) in cases.into_iter().enumerate() {
            for start in [GOLDEN, 0.1, 0.9] {
                let found = minimum(f, [0.0, 1.0], start, 1e-3, 60);
                // Brent ends within three tolerances.
                assert!(
                    (found.at - expected).abs() < 3e-3,
                    "case {case} from {start}: {found:?}"
                );
                assert!(found.value <= f(start));
            }
        }
    }

    #[test]
    fn a_parabola_takes_fewer_steps_than_golden_section() {
        let found = minimum(|x| (x - 0.3) * (x - 0.3), [0.0, 1.0], GOLDEN, 1e-3, 60);
        // Golden section alone needs ln(1000) / ln(1.618) = 14 to narrow the bracket so far.
        assert!(found.steps < 12, "{found:?}");
    }

    #[test]
    fn it_ends_on_no_numbers_and_within_its_steps() {
        for f in [|_| f32::NAN, |_| f32::INFINITY, |x: f32| (1e9 * x).sin()] {
            for most in [1, 2, 9] {
                let found = minimum(f, [0.0, 1.0], 0.5, 1e-3, most);
                assert!(found.steps <= most && (0.0..=1.0).contains(&found.at));
            }
        }
    }
}
