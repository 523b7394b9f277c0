use super::report::FrameCost;
use serde::Serialize;

/// Where one strategy overtakes another.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Crossover {
    /// File name of the source.
    pub scene: String,
    /// Instances.
    pub instances: u64,
    /// Threads.
    pub threads: usize,
    /// Kind of the rays.
    pub ray_kind: &'static str,
    /// Faster with fewer rays: `who-strategy`.
    pub below: String,
    /// Faster with more.
    pub above: String,
    /// Rays of a frame at which both take as long, by interpolation between the two measured numbers around, on logarithmic
    /// scales.
    pub rays: f64,
}

/// All crossings between two strategies of which at least one is the runtime's.
pub(super) fn crossovers(rows: &[FrameCost]) -> Vec<Crossover> {
    let lines = lines(rows);
    let mut out = Vec::new();
    for (index, first) in lines.iter().enumerate() {
        for second in &lines[index + 1..] {
            let [a, b] = [first[0], second[0]];
            let ours = a.who == "restpose" || b.who == "restpose";
            if ours && a.is_same_contest(b) && a.ray_kind == b.ray_kind {
                crossings(first, second, &mut out);
            }
        }
    }
    out
}

/// Rows of one strategy and kind of rays, by their number.
fn lines(rows: &[FrameCost]) -> Vec<Vec<&FrameCost>> {
    let mut lines: Vec<Vec<&FrameCost>> = Vec::new();
    for row in rows.iter().filter(|row| row.rays > 0) {
        let own = |line: &&mut Vec<&FrameCost>| line[0].ray_kind == row.ray_kind && line[0].is_same_strategy(row);
        match lines.iter_mut().find(own) {
            Some(line) => line.push(row),
            None => lines.push(vec![row]),
        }
    }
    for line in &mut lines {
        line.sort_by_key(|row| row.rays);
    }
    lines
}

fn crossings(first: &[&FrameCost], second: &[&FrameCost], out: &mut Vec<Crossover>) {
    // Above zero where the second is faster.
    let lead = |place: usize| (first[place].total_us / second[place].total_us).ln();
    for place in 1..first.len().min(second.len()) {
        let (before, after) = (lead(place - 1), lead(place));
        if before * after >= 0.0 || first[place].rays != second[place].rays {
            continue;
        }
        let share = before / (before - after);
        let [from, to] = [place - 1, place].map(|place| (first[place].rays as f64).ln());
        let (below, above) = if before < 0.0 { (first, second) } else { (second, first) };
        let name = |row: &FrameCost| format!("{}-{}", row.who, row.strategy);
        out.push(Crossover {
            scene: first[0].scene.clone(),
            instances: first[0].instances,
            threads: first[0].threads,
            ray_kind: first[0].ray_kind,
            below: name(below[0]),
            above: name(above[0]),
            rays: (from + share * (to - from)).exp(),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(who: &'static str, totals: &[f64]) -> Vec<FrameCost> {
        let row = |(place, total): (usize, &f64)| FrameCost {
            scene: "s".to_owned(),
            triangles: 1,
            instances: 1,
            who,
            strategy: "x".to_owned(),
            threads: 1,
            ray_kind: "random",
            rays: 10u64.pow(place as u32),
            frames: 1,
            total_us: *total,
            p99_us: *total,
            least_us: *total,
            update_us: 0.0,
            wrong_per_million: 0.0,
            counts: None,
        };
        totals.iter().enumerate().map(row).collect()
    }

    #[test]
    fn lines_cross_between_the_numbers_that_were_measured() {
        // Ratios 1/4 and 4 lie as far below one as above it: the middle of 10 and 100 by ratio.
        let rows = [line("restpose", &[1.0, 1.0, 16.0]), line("peer", &[4.0, 4.0, 4.0])].concat();
        let found = crossovers(&rows);
        assert_eq!(found.len(), 1);
        assert_eq!(
            (found[0].below.as_str(), found[0].above.as_str()),
            ("restpose-x", "peer-x")
        );
        assert!((found[0].rays - 1000f64.sqrt()).abs() < 1e-9, "{}", found[0].rays);
        let swapped = [line("peer", &[4.0, 4.0, 4.0]), line("restpose", &[1.0, 1.0, 16.0])].concat();
        assert_eq!(crossovers(&swapped), found);
    }

    #[test]
    fn others_do_not_concern_us() {
        let rows = [line("one", &[1.0, 9.0]), line("other", &[4.0, 4.0])].concat();
        assert!(crossovers(&rows).is_empty());
        assert!(crossovers(&line("restpose", &[1.0, 2.0])).is_empty());
    }
}
