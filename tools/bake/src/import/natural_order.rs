use std::cmp::Ordering;

/// Order of names in which `frame2` comes before `frame10`: runs of digits compare as numbers of any length, all
/// else byte by byte. Names that differ only in leading zeros compare byte by byte.
pub(super) fn compare(a: &[u8], b: &[u8]) -> Ordering {
    let mut pairs = runs(a).zip(runs(b)).map(|(a, b)| compare_runs(a, b));
    let first_difference = pairs.find(|order| order.is_ne());
    first_difference
        .unwrap_or_else(|| runs(a).count().cmp(&runs(b).count()))
        .then_with(|| a.cmp(b))
}

/// Maximal runs of digits and of other bytes.
fn runs(name: &[u8]) -> impl Iterator<Item = &[u8]> {
    name.chunk_by(|a, b| a.is_ascii_digit() == b.is_ascii_digit())
}

fn compare_runs(a: &[u8], b: &[u8]) -> Ordering {
    let is_number = |run: &[u8]| run.first().is_some_and(u8::is_ascii_digit);
    if is_number(a) && is_number(b) {
        let (a, b) = (without_zeros(a), without_zeros(b));
        return a.len().cmp(&b.len()).then_with(|| a.cmp(b));
    }
    a.cmp(b)
}

fn without_zeros(digits: &[u8]) -> &[u8] {
    let zeros = digits.iter().take_while(|digit| **digit == b'0').count();
    digits.get(zeros..).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_compare_as_numbers() {
        let sorted = [
            "1",
            "a",
            "a1b010",
            "a1b10",
            "a2b9",
            "a10b1",
            "b",
            "frame",
            "frame0002",
            "frame10",
            "frame10_b",
            "frame18446744073709551616",
            "frame18446744073709551617",
        ];
        for (i, a) in sorted.iter().enumerate() {
            for (j, b) in sorted.iter().enumerate() {
                assert_eq!(compare(a.as_bytes(), b.as_bytes()), i.cmp(&j), "{a} {b}");
            }
        }
    }
}
