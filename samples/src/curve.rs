//! Numbers that change with time along keys.

/// A smooth curve through `(time, value)` keys that ascend in time: level at each key, constant outside.
pub fn eased(keys: &[(f64, f64)], time: f64) -> f64 {
    for pair in keys.windows(2) {
        let ((start, from), (end, to)) = (pair[0], pair[1]);
        if time <= end {
            let along = ((time - start) / (end - start)).clamp(0.0, 1.0);
            return from + (to - from) * along * along * (3.0 - 2.0 * along);
        }
    }
    keys.last().map_or(0.0, |&(_, value)| value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_meets_its_keys_and_stays_at_its_ends() {
        let keys = [(1.0, 2.0), (3.0, 6.0), (4.0, 0.0)];
        let found = [-9.0, 1.0, 1.5, 2.0, 3.0, 4.0, 9.0].map(|time| eased(&keys, time));
        assert_eq!(found, [2.0, 2.0, 2.625, 4.0, 6.0, 0.0, 0.0]);
        assert_eq!(eased(&[], 1.0), 0.0);
    }
}
