/// Up to `count` of the indices below `length`, in the middles of equal shares.
pub(crate) fn spread(count: usize, length: usize) -> Vec<usize> {
    let count = count.min(length);
    (0..count).map(|i| (2 * i + 1) * length / (2 * count)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_spread_over_all_samples() {
        assert_eq!(spread(4, 100), [12, 37, 62, 87]);
        assert_eq!(spread(1, 1), [0]);
        assert_eq!(spread(5, 2), [0, 1]);
        assert_eq!(spread(3, 0), [0usize; 0]);
    }
}
