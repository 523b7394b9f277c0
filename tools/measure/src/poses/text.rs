use super::{
    AccuracyFigures, BoundsFigures, FileFigures, PoseSpaceFigures, RayFigures, TessellationFigures, ThesisPoseSpace,
    ThesisTessellation,
};
use crate::TextRow;

impl TextRow<16> for PoseSpaceFigures {
    const TITLE: &'static str = "Pose spaces";
    const LEGEND: &'static str =
        "at times of one clip; area, speed: relative to that clip's own file with sampled bounds";
    const COLUMNS: [&'static str; 16] = [
        "scene",
        "pose space",
        "bounds",
        "samples",
        "area",
        "per leaf",
        "MB",
        "bake s",
        "rays",
        "steps",
        "boxes",
        "tests",
        "Mrays/s",
        "speed",
        "missed/M",
        "wrong/M",
    ];

    fn cells(&self) -> [String; 16] {
        let file = &self.file;
        let [rays, steps, boxes, tests, mrays, speed, missed, wrong] = self.rays.cells();
        [
            file.scene.clone(),
            file.pose_space.to_owned(),
            file.bounds_label(),
            file.samples.to_string(),
            format!("{:.2}", file.area_ratio),
            format!("{:.2}", file.triangles_per_leaf),
            file.megabytes(),
            format!("{:.2}", file.bake_seconds),
            rays,
            steps,
            boxes,
            tests,
            mrays,
            speed,
            missed,
            wrong,
        ]
    }
}

impl TextRow<6> for ThesisPoseSpace {
    const TITLE: &'static str = "Pose spaces in the thesis, Table 3.1";
    const LEGEND: &'static str = "UT2003, sampled bounds";
    const COLUMNS: [&'static str; 6] = ["pose space", "samples", "area", "per leaf", "frames/s", "speed"];

    fn cells(&self) -> [String; 6] {
        [
            self.pose_space.to_owned(),
            self.samples.to_string(),
            format!("{:.2}", self.area_ratio),
            format!("{:.2}", self.triangles_per_leaf),
            format!("{:.1}", self.frames_per_s),
            format!("{:.2}", self.relative_speed),
        ]
    }
}

impl TextRow<20> for BoundsFigures {
    const TITLE: &'static str = "Bounds";
    const LEGEND: &'static str = "area, speed: relative to sampled bounds; outside: share of clusters outside their pose \
                                  space; excess: largest, scene units; check: what commit takes more than with sampled \
                                  bounds, again: in the pose of the frame before";
    const COLUMNS: [&'static str; 20] = [
        "scene",
        "triangles",
        "bounds",
        "area",
        "MB",
        "poses",
        "outside",
        "excess",
        "commit µs",
        "check µs",
        "again µs",
        "ns/pair",
        "rays",
        "steps",
        "boxes",
        "tests",
        "Mrays/s",
        "speed",
        "missed/M",
        "wrong/M",
    ];

    fn cells(&self) -> [String; 20] {
        let (file, commits) = (&self.file, &self.commits);
        let [rays, steps, boxes, tests, mrays, speed, missed, wrong] = self.rays.cells();
        [
            file.scene.clone(),
            file.triangles.to_string(),
            file.bounds_label(),
            format!("{:.2}", file.area_ratio),
            file.megabytes(),
            self.poses.to_owned(),
            format!(
                "{:.2}",
                commits.clusters_outside as f64 / commits.clusters.max(1) as f64
            ),
            format!("{:.1e}", commits.largest_excess),
            format!("{:.1}", commits.commit_us),
            format!("{:.1}", commits.check_us),
            format!("{:.1}", commits.check_again_us),
            if commits.bone_pairs > 0 {
                format!("{:.0}", commits.check_ns_per_pair)
            } else {
                "–".to_owned()
            },
            rays,
            steps,
            boxes,
            tests,
            mrays,
            speed,
            missed,
            wrong,
        ]
    }
}

impl TextRow<9> for TessellationFigures {
    const TITLE: &'static str = "Tessellations";
    const LEGEND: &'static str = "sampling: poses, choice of bones, bounds; frames: camera rays of 1024 × 1024 pixels after \
                                  a commit, one thread, no shading";
    const COLUMNS: [&'static str; 9] = [
        "scene",
        "triangles",
        "bounds",
        "sampling s",
        "trees s",
        "bake s",
        "commit µs",
        "Mrays/s",
        "frames/s",
    ];

    fn cells(&self) -> [String; 9] {
        [
            self.file.scene.clone(),
            self.file.triangles.to_string(),
            self.file.bounds_label(),
            format!("{:.2}", self.sampling_seconds),
            format!("{:.2}", self.tree_seconds),
            format!("{:.2}", self.file.bake_seconds),
            format!("{:.1}", self.commit_us),
            format!("{:.3}", self.rays.mrays_per_s),
            format!("{:.2}", self.frames_per_s),
        ]
    }
}

impl TextRow<5> for ThesisTessellation {
    const TITLE: &'static str = "Tessellations in the thesis, Table 3.3";
    const LEGEND: &'static str = "one core; pictures with shading";
    const COLUMNS: [&'static str; 5] = ["scene", "triangles", "sampling s", "trees s", "frames/s"];

    fn cells(&self) -> [String; 5] {
        [
            self.scene.to_owned(),
            self.triangles.to_string(),
            format!("{:.2}", self.sampling_seconds),
            format!("{:.2}", self.tree_seconds),
            format!("{:.1}", self.frames_per_s),
        ]
    }
}

impl TextRow<15> for AccuracyFigures {
    const TITLE: &'static str = "Accuracy";
    const LEGEND: &'static str =
        "at times of clips between all samples; area, speed: relative to sampled bounds as bake makes them";
    const COLUMNS: [&'static str; 15] = [
        "scene", "bounds", "step s", "keys", "samples", "area", "MB", "rays", "steps", "boxes", "tests", "Mrays/s",
        "speed", "missed/M", "wrong/M",
    ];

    fn cells(&self) -> [String; 15] {
        let file = &self.file;
        let [rays, steps, boxes, tests, mrays, speed, missed, wrong] = self.rays.cells();
        [
            file.scene.clone(),
            file.bounds_label(),
            self.sample_step_seconds
                .map_or("–".to_owned(), |step| format!("{step:.4}")),
            if self.keys_sampled { "yes" } else { "no" }.to_owned(),
            file.samples.to_string(),
            format!("{:.2}", file.area_ratio),
            file.megabytes(),
            rays,
            steps,
            boxes,
            tests,
            mrays,
            speed,
            missed,
            wrong,
        ]
    }
}

impl RayFigures {
    fn cells(&self) -> [String; 8] {
        [
            self.rays.to_owned(),
            format!("{:.1}", self.steps),
            format!("{:.2}", self.box_tests),
            format!("{:.2}", self.triangle_tests),
            format!("{:.3}", self.mrays_per_s),
            format!("{:.3}", self.relative_speed),
            format!("{:.1}", self.missed_per_million),
            format!("{:.1}", self.wrong_per_million),
        ]
    }
}

impl FileFigures {
    /// How its boxes are bounded, with the number of envelopes.
    #[must_use]
    pub fn bounds_label(&self) -> String {
        match self.envelopes {
            None => self.bounds.to_owned(),
            Some(envelopes) => format!("{} {envelopes}", self.bounds),
        }
    }

    fn megabytes(&self) -> String {
        format!("{:.2}", self.bytes as f64 / 1e6)
    }
}
