/// A scalar Kalman filter of a random walk: what is tracked stays where it is but for noise.
///
/// Source: Hussain and Grahn, Eqs. 9 and 10, with A = H = 1 and no control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Kalman {
    /// Estimated state x.
    state: f32,
    /// Its error covariance P.
    covariance: f32,
}

/// Covariance Q of the process: how far a plane moves in a frame, squared, in lengths of the box around its node's boxes.
/// A plane in the test animations moves by about a hundredth.
const PROCESS: f32 = 1e-4;

/// Covariance R of the measurement: how far the search may end beside the optimum, squared, in the same lengths. The
/// search ends within a five-hundredth.
const MEASUREMENT: f32 = 4e-6;

impl Kalman {
    /// A filter whose first measurement was `measured`.
    pub(super) fn new(measured: f32) -> Self {
        Self {
            state: measured,
            covariance: MEASUREMENT,
        }
    }

    /// The state expected in the next frame.
    pub(super) fn predicted(&self) -> f32 {
        self.state
    }

    /// Moves on by a frame and corrects by what was measured in it.
    pub(super) fn advance(&mut self, measured: f32) {
        let covariance = self.covariance + PROCESS;
        let gain = covariance / (covariance + MEASUREMENT);
        self.state += gain * (measured - self.state);
        self.covariance = (1.0 - gain) * covariance;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The gain that the covariance settles to: P⁻ = (Q + √(Q² + 4QR)) / 2, K = P⁻ / (P⁻ + R).
    fn steady_gain() -> f32 {
        let prior = f32::midpoint(PROCESS, (PROCESS * PROCESS + 4.0 * PROCESS * MEASUREMENT).sqrt());
        prior / (prior + MEASUREMENT)
    }

    #[test]
    fn at_constant_speed_it_lags_by_the_speed_over_the_steady_gain() {
        let speed = 0.01;
        let mut filter = Kalman::new(0.0);
        let mut error = 0.0;
        for frame in 1..=100 {
            let measured = frame as f32 * speed;
            error = measured - filter.predicted();
            filter.advance(measured);
        }
        // Positions up to 1 are rounded to 6e-8.
        assert!((error - speed / steady_gain()).abs() < 1e-5, "{error}");
    }

    #[test]
    fn what_rests_is_predicted_exactly() {
        let mut filter = Kalman::new(0.25);
        for _ in 0..5 {
            filter.advance(0.25);
        }
        assert_eq!(filter.predicted(), 0.25);
    }
}
