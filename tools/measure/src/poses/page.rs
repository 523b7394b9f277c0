use super::{AccuracyFigures, BoundsFigures, PosesReport};
use crate::{
    page::{OURS, STATIC, document, section},
    plot::{Plot, Scale, Series, escape},
};

/// The report as one HTML page without scripts: its tables, and plots for each scene.
#[must_use]
pub fn page(report: &PosesReport) -> String {
    let settings = &report.settings;
    let mut scenes: Vec<&str> = report.bounds.iter().map(|row| row.file.scene.as_str()).collect();
    scenes.dedup();
    let mut body = format!(
        "<p>{poses} poses of each kind, {rays} rays of each kind per pose, least of {repeats} times, in turns, one thread. \
         {checked} rays were compared with brute force.</p>\n<div class=\"plots\">\n",
        poses = settings.poses,
        rays = settings.rays,
        repeats = settings.repeats,
        checked = report.brute_force_rays,
    );
    body += &scenes
        .iter()
        .flat_map(|scene| plots(report, scene))
        .map(|plot| plot.svg())
        .collect::<String>();
    body += "</div>\n";
    body += &section(&report.pose_spaces);
    body += &section(&report.thesis_pose_spaces);
    body += &section(&report.bounds);
    body += &section(&report.tessellations);
    body += &section(&report.thesis_tessellations);
    body += &section(&report.accuracy);
    document(&format!("Poses and bounds: {}", escape(&scenes.join(", "))), &body)
}

fn plots(report: &PosesReport, scene: &str) -> Vec<Plot> {
    let title = |what: &str| format!("{scene}: {what}");
    let mut out = Vec::new();
    for (poses, what) in [
        ("clip", "random rays, between samples"),
        ("blend", "random rays, blends of clips"),
        ("ragdoll", "random rays, ragdoll"),
    ] {
        out.push(Plot {
            title: title(what),
            x_label: "triangles",
            y_label: "speed relative to sampled bounds",
            scales: [Scale::Logarithmic, Scale::Linear],
            series: by_bounds(report, scene, poses, "random", &|row| row.rays.relative_speed),
        });
    }
    out.push(Plot {
        title: title("check of a blend"),
        x_label: "triangles",
        y_label: "µs per frame",
        scales: [Scale::Logarithmic, Scale::Linear],
        series: by_bounds(report, scene, "blend", "random", &|row| row.commits.check_us),
    });
    out.push(preprocessing(report, scene, title("preprocessing")));
    out.push(Plot {
        title: title("speed against accuracy, random rays"),
        x_label: "speed relative to sampled bounds",
        y_label: "missed or wrong rays per million",
        scales: [Scale::Linear; 2],
        series: accuracy(report, scene),
    });
    // Scenes without joints have no ragdolls.
    out.retain(|plot| plot.series.iter().any(|series| !series.points.is_empty()));
    out
}

fn by_bounds(
    report: &PosesReport,
    scene: &str,
    poses: &str,
    rays: &str,
    value: &dyn Fn(&BoundsFigures) -> f64,
) -> Vec<Series> {
    let rows = || {
        let rows = report.bounds.iter();
        rows.filter(|row| row.file.scene == scene && row.poses == poses && row.rays.rays == rays)
    };
    let mut names: Vec<String> = Vec::new();
    for name in rows().map(|row| row.file.bounds_label()) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let series = |name: String| Series {
        colour: if name == "sampled" { STATIC } else { OURS },
        dashed: false,
        points: rows()
            .filter(|row| row.file.bounds_label() == name)
            .map(|row| (row.file.triangles as f64, value(row)))
            .collect(),
        name,
    };
    names.into_iter().map(series).collect()
}

fn preprocessing(report: &PosesReport, scene: &str, title: String) -> Plot {
    let ours = |name: &str, dashed, trees: bool| Series {
        name: format!("{name}, {}", if trees { "trees" } else { "sampling" }),
        colour: OURS,
        dashed,
        points: report
            .tessellations
            .iter()
            .filter(|row| row.file.scene == scene && row.file.bounds_label() == name)
            .map(|row| {
                let seconds = if trees { row.tree_seconds } else { row.sampling_seconds };
                (row.file.triangles as f64, seconds)
            })
            .collect(),
    };
    let thesis = |name: &str, trees: bool| Series {
        name: format!("UT2003, {name}"),
        colour: STATIC,
        dashed: trees,
        points: report
            .thesis_tessellations
            .iter()
            .filter(|row| row.scene == "UT2003")
            .map(|row| {
                let seconds = if trees { row.tree_seconds } else { row.sampling_seconds };
                (f64::from(row.triangles), seconds)
            })
            .collect(),
    };
    Plot {
        title,
        x_label: "triangles",
        y_label: "s",
        scales: [Scale::Logarithmic; 2],
        series: vec![
            ours("sampled", false, false),
            ours("envelope 16", false, false),
            ours("envelope 16", true, true),
            thesis("sampling", false),
            thesis("trees", true),
        ],
    }
}

fn accuracy(report: &PosesReport, scene: &str) -> Vec<Series> {
    let points = |sampled: bool| -> Vec<(f64, f64)> {
        let rows = report.accuracy.iter();
        rows.filter(|row| row.file.scene == scene && row.rays.rays == "random")
            .filter(|row| row.sample_step_seconds.is_some() == sampled)
            .map(|AccuracyFigures { rays, .. }| (rays.relative_speed, rays.missed_per_million + rays.wrong_per_million))
            .collect()
    };
    vec![
        Series {
            name: "sampled".to_owned(),
            colour: STATIC,
            dashed: false,
            points: points(true),
        },
        Series {
            name: "envelopes".to_owned(),
            colour: OURS,
            dashed: false,
            points: points(false),
        },
    ]
}
