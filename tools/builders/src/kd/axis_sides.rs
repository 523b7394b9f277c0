use super::fragment::Fragment;

/// The sides of a node's fragments along one axis, as two plain lists: what the cost at a position takes to count.
#[derive(Debug, Default)]
pub(super) struct AxisSides {
    lower: Vec<f32>,
    upper: Vec<f32>,
}

/// What lies around a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Beside {
    /// The nearest side of a fragment below the position; −∞ if there is none.
    pub below: f32,
    /// The nearest side at or above it; ∞ if there is none.
    pub above: f32,
}

/// Numbers worked on at once.
const LANES: usize = 8;

impl AxisSides {
    pub(super) fn fill(&mut self, fragments: &[Fragment], axis: usize) {
        self.lower.clear();
        self.upper.clear();
        match axis {
            0 => self.fill_from::<0>(fragments),
            1 => self.fill_from::<1>(fragments),
            _ => self.fill_from::<2>(fragments),
        }
    }

    fn fill_from<const AXIS: usize>(&mut self, fragments: &[Fragment]) {
        self.lower.extend(fragments.iter().map(|fragment| fragment.min[AXIS]));
        self.upper.extend(fragments.iter().map(|fragment| fragment.max[AXIS]));
    }

    /// Fragments that begin below `position`, and that end at or above it.
    pub(super) fn counts(&self, position: f32) -> [u32; 2] {
        let mut counts = [0, 0];
        for (lower, upper) in self.lower.iter().zip(&self.upper) {
            counts[0] += u32::from(*lower < position);
            counts[1] += u32::from(*upper >= position);
        }
        counts
    }

    pub(super) fn beside(&self, position: f32) -> Beside {
        let (mut below, mut above) = ([f32::NEG_INFINITY; LANES], [f32::INFINITY; LANES]);
        for list in [&self.lower, &self.upper] {
            let (chunks, rest) = list.as_chunks::<LANES>();
            let mut last = [f32::NAN; LANES];
            last[..rest.len()].copy_from_slice(rest);
            for chunk in chunks.iter().chain([&last]) {
                for k in 0..LANES {
                    let side = chunk[k];
                    let low = if side < position { side } else { f32::NEG_INFINITY };
                    let high = if side >= position { side } else { f32::INFINITY };
                    below[k] = if low > below[k] { low } else { below[k] };
                    above[k] = if high < above[k] { high } else { above[k] };
                }
            }
        }
        Beside {
            below: below.into_iter().fold(f32::NEG_INFINITY, f32::max),
            above: above.into_iter().fold(f32::INFINITY, f32::min),
        }
    }
}
