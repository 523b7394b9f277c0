use super::{Crossover, FixedCost, FrameCost, Glance};
use crate::TextRow;

impl TextRow<13> for FrameCost {
    const TITLE: &'static str = "Frames";
    const LEGEND: &'static str = "total µs: from setting poses to the last hit, median; update µs: before the first ray; wrong: hits per million rays \
                                  that are not the runtime's; steps, tests: per ray";
    const COLUMNS: [&'static str; 13] = [
        "scene",
        "triangles",
        "instances",
        "who",
        "strategy",
        "threads",
        "rays",
        "kind",
        "total µs",
        "p99 µs",
        "update µs",
        "wrong",
        "steps, tests",
    ];

    fn cells(&self) -> [String; 13] {
        let per_ray = |count: f64| count / self.rays as f64;
        [
            self.scene.clone(),
            self.triangles.to_string(),
            self.instances.to_string(),
            self.who.to_owned(),
            self.strategy.clone(),
            self.threads.to_string(),
            self.rays.to_string(),
            self.ray_kind.to_owned(),
            microseconds(self.total_us),
            microseconds(self.p99_us),
            microseconds(self.update_us),
            format!("{:.0}", self.wrong_per_million),
            self.counts.map_or("-".to_owned(), |counts| {
                format!("{:.1}, {:.1}", per_ray(counts.steps), per_ray(counts.tests))
            }),
        ]
    }
}

impl TextRow<8> for FixedCost<'_> {
    const TITLE: &'static str = "Before rays";
    const LEGEND: &'static str = "frames without rays and with one: what a frame costs that hardly anybody looks at";
    const COLUMNS: [&'static str; 8] = [
        "scene",
        "triangles",
        "instances",
        "who",
        "strategy",
        "threads",
        "no ray µs",
        "one ray µs",
    ];

    fn cells(&self) -> [String; 8] {
        let row = self.without;
        [
            row.scene.clone(),
            row.triangles.to_string(),
            row.instances.to_string(),
            row.who.to_owned(),
            row.strategy.clone(),
            row.threads.to_string(),
            microseconds(row.total_us),
            self.first_ray_us.map_or("-".to_owned(), microseconds),
        ]
    }
}

impl TextRow<7> for Crossover {
    const TITLE: &'static str = "Crossovers";
    const LEGEND: &'static str = "rays of a frame above which the other strategy is faster, interpolated";
    const COLUMNS: [&'static str; 7] = [
        "scene",
        "instances",
        "threads",
        "kind",
        "faster below",
        "faster above",
        "rays",
    ];

    fn cells(&self) -> [String; 7] {
        [
            self.scene.clone(),
            self.instances.to_string(),
            self.threads.to_string(),
            self.ray_kind.to_owned(),
            self.below.clone(),
            self.above.clone(),
            format!("{:.0}", self.rays),
        ]
    }
}

impl TextRow<9> for Glance {
    const TITLE: &'static str = "At a glance";
    const LEGEND: &'static str = "open: map and check a file whose pages are in memory; pose B: palette, morph weights and frames of an instance; B/instance: \
                                  memory beside these until a ray comes";
    const COLUMNS: [&'static str; 9] = [
        "scene",
        "strategy",
        "triangles",
        "bones",
        "file MB",
        "open µs",
        "open s/GiB",
        "pose B",
        "B/instance",
    ];

    fn cells(&self) -> [String; 9] {
        [
            self.scene.clone(),
            self.strategy.to_owned(),
            self.triangles.to_string(),
            self.bones.to_string(),
            format!("{:.2}", self.file_bytes as f64 / 1e6),
            format!("{:.0}", self.open_us),
            format!("{:.2}", self.open_seconds_per_gib),
            self.pose_bytes.to_string(),
            self.bytes_per_instance
                .map_or("-".to_owned(), |bytes| format!("{bytes:.0}")),
        ]
    }
}

/// Three digits or so.
fn microseconds(us: f64) -> String {
    match us {
        us if us < 10.0 => format!("{us:.2}"),
        us if us < 100.0 => format!("{us:.1}"),
        us => format!("{us:.0}"),
    }
}
