use super::{COLUMNS, LEGEND, MotionFrame, MotionReport};
use crate::{
    page::{OURS, STATIC, document, table},
    plot::{Plot, Scale, Series, escape},
};

/// The report as one HTML page without scripts: its numbers, and plots against the number of clusters and over time.
#[must_use]
pub fn page(report: &MotionReport) -> String {
    let title = format!("Motion decomposition: {}", escape(&report.source));
    let mut body = format!("<p>{}.</p>\n", escape(LEGEND));
    body += &table(
        &COLUMNS,
        [
            report.primary.cells("camera").to_vec(),
            report.wide.cells("wide camera").to_vec(),
            report.random.cells("random").to_vec(),
        ],
    );
    body += &format!("<p>{}</p>\n", escape(&report.facts().join("; ")));
    body += "<div class=\"plots\">\n";
    for plot in plots(report) {
        body += &plot.svg();
    }
    body += "</div>\n";
    let mut titles = vec!["frame", "segment", "clusters", "rest frame"];
    titles.extend(&COLUMNS[1..]);
    titles.push("update µs");
    body += &table(&titles, report.frames.iter().map(row));
    document(&title, &body)
}

fn row(frame: &MotionFrame) -> Vec<String> {
    let number = |number: Option<String>| number.unwrap_or_else(|| "–".to_owned());
    let mut cells = vec![
        place(frame).to_string(),
        number(frame.segment.map(|x| x.to_string())),
        frame.clusters.to_string(),
        number(frame.rest_frame.map(|x| x.to_string())),
    ];
    cells.extend(frame.primary.cells("").into_iter().skip(1));
    cells.push(format!("{:.1}", frame.update_us));
    cells
}

/// Where a frame stands on the axis of time: its number, or seconds where the source has no frames.
fn place(frame: &MotionFrame) -> f64 {
    frame.cache_frame.unwrap_or(f64::from(frame.seconds))
}

fn plots(report: &MotionReport) -> Vec<Plot> {
    let numbered = report.frames.iter().any(|frame| frame.cache_frame.is_some());
    let x_label = if numbered { "frame" } else { "seconds" };
    let over_time = |name: &str, colour, dashed, value: &dyn Fn(&MotionFrame) -> f64| Series {
        name: name.to_owned(),
        colour,
        dashed,
        points: report.frames.iter().map(|frame| (place(frame), value(frame))).collect(),
    };
    let plot = |title: &str, y_label, series| Plot {
        title: title.to_owned(),
        x_label,
        y_label,
        scales: [Scale::Linear; 2],
        series,
    };
    let mut out = growth(report);
    out.push(plot(
        "Fuzzy over static, camera rays",
        "ratio",
        vec![
            over_time("intersections", OURS, true, &|frame| frame.intersections_ratio),
            over_time("steps", OURS, false, &|frame| frame.steps_ratio),
            over_time("time", STATIC, false, &|frame| frame.time_ratio),
        ],
    ));
    out.push(plot(
        "Fuzzy over static, random rays",
        "ratio",
        vec![
            over_time("intersections", OURS, true, &|frame| frame.random.intersections_ratio),
            over_time("steps", OURS, false, &|frame| frame.random.steps_ratio),
            over_time("time", STATIC, false, &|frame| frame.random.time_ratio),
        ],
    ));
    for (place, rate) in report.frame_rates.iter().enumerate() {
        let threads = rate.threads;
        let side = report.settings.picture_side;
        let title = format!(
            "{side} × {side} pictures, {threads} thread{}",
            if threads == 1 { "" } else { "s" }
        );
        out.push(plot(
            &title,
            "frames/s",
            vec![
                over_time("static, prebuilt", STATIC, true, &|frame| {
                    frame.frame_rates[place].static_traced
                }),
                over_time("fuzzy, with update", OURS, false, &|frame| {
                    frame.frame_rates[place].fuzzy
                }),
                over_time("static, built anew", STATIC, false, &|frame| {
                    frame.frame_rates[place].static_built
                }),
            ],
        ));
    }
    out
}

/// Figure 3.7: both costs against the number of clusters, and what the baker minimises, relative to one cluster.
fn growth(report: &MotionReport) -> Vec<Plot> {
    let Some(first) = report.growth.first() else {
        return Vec::new();
    };
    let series = |name: &str, colour, dashed, of: fn(&super::Growth) -> f64| Series {
        name: name.to_owned(),
        colour,
        dashed,
        points: report
            .growth
            .iter()
            .map(|step| (step.clusters as f64, of(step) / of(first)))
            .collect(),
    };
    vec![Plot {
        title: "Relative to one cluster".to_owned(),
        x_label: "clusters",
        y_label: "part",
        scales: [Scale::Linear; 2],
        series: vec![
            series("residual motion", STATIC, false, |step| step.residual),
            series("fuzzy box area", OURS, false, |step| step.fuzzy_box_area),
            series("expected cost", OURS, true, |step| step.cost),
        ],
    }]
}
