/// Places of the samples in a pixel, from 0 to 1: `side` × `side`, each row and column of the finest grid met once, so
/// that edges close to upright or level are smooth too.
pub fn places(side: u32) -> Vec<[f64; 2]> {
    let n = f64::from(side);
    (0..side)
        .flat_map(|j| (0..side).map(move |i| (f64::from(i), f64::from(j))))
        .map(|(i, j)| [(i + (j + 0.5) / n) / n, (j + (n - 0.5 - i) / n) / n])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fine_row_and_column_is_met_once() {
        for side in [1, 2, 4] {
            let count = side * side;
            for axis in 0..2 {
                let cells: Vec<u32> = places(side)
                    .iter()
                    .map(|p| (p[axis] * f64::from(count)) as u32)
                    .collect();
                let mut sorted = cells.clone();
                sorted.sort_unstable();
                assert_eq!(sorted, (0..count).collect::<Vec<_>>(), "{side} {axis}");
            }
        }
        assert_eq!(places(1), [[0.5, 0.5]]);
    }
}
