use super::{AnimationFigures, BuildFigures, BuildersReport, TheirFigures};
use crate::TextRow;

impl TextRow<21> for BuildFigures {
    const TITLE: &'static str = "Builds";
    const LEGEND: &'static str = "s: of a builder that keeps its memory, first s: of a new one; speedup, SAH, speed: relative to the first builder of \
                                  the same tree on the first number of threads, above 1 is better; threads ×: relative to one thread; refs: leaf \
                                  entries per triangle; B/tri: peak of a build beside the boxes; steps, tests: per ray; speed: of tracing";
    const COLUMNS: [&'static str; 21] = [
        "scene",
        "triangles",
        "order",
        "tree",
        "builder",
        "threads",
        "s",
        "first s",
        "Mtris/s",
        "speedup",
        "threads ×",
        "SAH cost",
        "SAH",
        "refs",
        "depth",
        "B/tri",
        "camera steps",
        "tests",
        "speed",
        "random steps",
        "speed",
    ];

    fn cells(&self) -> [String; 21] {
        [
            self.scene.clone(),
            self.triangles.to_string(),
            order(self.shuffled),
            self.tree.to_owned(),
            self.builder.to_owned(),
            self.threads.to_string(),
            seconds(self.seconds),
            seconds(self.first_seconds),
            format!("{:.2}", self.mtris_per_s),
            format!("{:.2}", self.speedup),
            format!("{:.2}", self.scaling),
            format!("{:.1}", self.sah_cost),
            format!("{:.3}", self.sah_relative),
            format!("{:.2}", self.references as f64 / self.triangles as f64),
            self.depth.to_string(),
            self.peak_bytes_per_triangle
                .map_or("-".to_owned(), |bytes| format!("{bytes:.0}")),
            format!("{:.1}", self.primary_steps),
            format!("{:.2}", self.primary_tests),
            format!("{:.3}", self.render_relative),
            format!("{:.1}", self.random_steps),
            format!("{:.3}", self.random_render_relative),
        ]
    }
}

/// A row of Günther's Tables 4.1 and 4.2: a builder beside the exact one, with triangles in the scene's order and in random
/// order.
#[derive(Clone, Debug, PartialEq)]
pub struct OrderFigures<'a> {
    /// In the scene's order.
    own: &'a BuildFigures,
    reference: &'a BuildFigures,
    /// In random order: of the reference, of the builder; NaN where that was not measured.
    shuffled: [f64; 2],
}

impl BuildersReport {
    /// Every builder on its first number of threads beside its reference.
    #[must_use]
    pub fn orders(&self) -> Vec<OrderFigures<'_>> {
        let first = |of: &BuildFigures, builder: &str, shuffled: bool| {
            let mut rows = self.builds.iter();
            rows.find(|row| {
                (row.scene.as_str(), row.tree, row.builder, row.shuffled)
                    == (of.scene.as_str(), of.tree, builder, shuffled)
            })
        };
        let mut out = Vec::new();
        for own in &self.builds {
            let is_first = first(own, own.builder, false).is_some_and(|row| std::ptr::eq(row, own));
            let Some(reference) = first(own, own.reference, false) else {
                continue;
            };
            if is_first && own.builder != own.reference {
                let seconds = |builder| first(own, builder, true).map_or(f64::NAN, |row| row.seconds);
                out.push(OrderFigures {
                    own,
                    reference,
                    shuffled: [seconds(own.reference), seconds(own.builder)],
                });
            }
        }
        out
    }
}

impl TextRow<11> for OrderFigures<'_> {
    const TITLE: &'static str = "Exact and fast builders, as in Günther's Tables 4.1 and 4.2";
    const LEGEND: &'static str = "one thread; exact s: the reference; shuffled: triangles in random order; quality: SAH cost of the exact tree over this one's";
    const COLUMNS: [&'static str; 11] = [
        "scene",
        "triangles",
        "tree",
        "builder",
        "exact s",
        "shuffled",
        "s",
        "shuffled",
        "speedup",
        "shuffled",
        "quality %",
    ];

    fn cells(&self) -> [String; 11] {
        let Self {
            own,
            reference,
            shuffled: [reference_shuffled, own_shuffled],
        } = self;
        [
            own.scene.clone(),
            own.triangles.to_string(),
            own.tree.to_owned(),
            own.builder.to_owned(),
            seconds(reference.seconds),
            seconds(*reference_shuffled),
            seconds(own.seconds),
            seconds(*own_shuffled),
            ratio(reference.seconds / own.seconds),
            ratio(reference_shuffled / own_shuffled),
            format!("{:.1}", 100.0 * own.sah_relative),
        ]
    }
}

impl TextRow<14> for AnimationFigures {
    const TITLE: &'static str = "From frame to frame, as in Hussain and Grahn's Table I";
    const LEGEND: &'static str = "one thread; exact ms: the reference, median over the frames; initial: the first frame; saved: of the exact builder's time; \
                                  SAH: cost of the exact tree over this one's, mean and least; tracked: share of nodes whose plane was foreseen; error: of \
                                  foreseen planes, in lengths of the box around a node's boxes; steps: of a search for a plane, where it was foreseen and where not";
    const COLUMNS: [&'static str; 14] = [
        "scene",
        "triangles",
        "frames",
        "builder",
        "exact",
        "exact ms",
        "initial ms",
        "running ms",
        "saved %",
        "SAH",
        "least",
        "tracked %",
        "error",
        "steps",
    ];

    fn cells(&self) -> [String; 14] {
        let milliseconds = |seconds: f64| format!("{:.2}", 1e3 * seconds);
        let dash = || "-".to_owned();
        [
            self.scene.clone(),
            self.triangles.to_string(),
            self.frames.to_string(),
            self.builder.to_owned(),
            self.reference.to_owned(),
            milliseconds(self.exact_seconds),
            milliseconds(self.initial_seconds),
            milliseconds(self.running_seconds),
            format!("{:.1}", 100.0 * self.reduction),
            format!("{:.3}", self.sah_relative),
            format!("{:.3}", self.sah_relative_least),
            self.tracked_fraction
                .map_or_else(dash, |share| format!("{:.1}", 100.0 * share)),
            self.prediction_error.map_or_else(dash, |error| format!("{error:.4}")),
            match (self.tracked_steps, self.untracked_steps) {
                (Some(tracked), Some(untracked)) => format!("{tracked:.1}, {untracked:.1}"),
                _ => dash(),
            },
        ]
    }
}

impl TextRow<9> for TheirFigures {
    const TITLE: &'static str = "What the papers report";
    const LEGEND: &'static str = "on their machines; exact s: their exact builder; quality: SAH cost of the exact tree over this one's (Günther) or speed of tracing \
                                  relative to it (Wald)";
    const COLUMNS: [&'static str; 9] = [
        "table",
        "scene",
        "triangles",
        "builder",
        "threads",
        "exact s",
        "s",
        "speedup",
        "quality %",
    ];

    fn cells(&self) -> [String; 9] {
        [
            self.table.to_owned(),
            self.scene.to_owned(),
            self.triangles.to_string(),
            self.builder.to_owned(),
            self.threads.to_string(),
            seconds(self.exact_seconds),
            seconds(self.seconds),
            format!("{:.2}", self.exact_seconds / self.seconds),
            self.quality
                .map_or("-".to_owned(), |quality| format!("{:.1}", 100.0 * quality)),
        ]
    }
}

fn order(shuffled: bool) -> String {
    if shuffled { "random" } else { "scene's" }.to_owned()
}

fn ratio(ratio: f64) -> String {
    if ratio.is_nan() {
        "-".to_owned()
    } else {
        format!("{ratio:.2}")
    }
}

/// Three digits or so.
fn seconds(seconds: f64) -> String {
    match seconds {
        s if s.is_nan() => "-".to_owned(),
        s if s < 0.1 => format!("{s:.5}"),
        s if s < 10.0 => format!("{s:.3}"),
        s => format!("{s:.1}"),
    }
}
