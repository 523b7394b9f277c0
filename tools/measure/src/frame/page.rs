use super::{COLUMNS, FrameReport, FrameRow, LEGEND};
use crate::plot::{Plot, Series, escape};

/// Colours that remain apart for colour-blind eyes (Okabe and Ito).
const OURS: &str = "#0072b2";
const STATIC: &str = "#d55e00";

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;max-width:72rem;margin:2rem auto;padding:0 1rem;color:#222}\
h1{font-size:1.4rem}table{border-collapse:collapse;font-variant-numeric:tabular-nums}\
th,td{padding:.2rem .6rem;text-align:right;border-bottom:1px solid #ddd}th{font-weight:600}\
.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(26rem,1fr));gap:1.5rem;margin-top:2rem}\
.wide{overflow-x:auto}svg{width:100%;font-size:13px}.title{font-weight:600}.title,.tick{fill:#444}\
.end{text-anchor:end}.middle{text-anchor:middle}.grid{stroke:#e4e4e4}polyline{fill:none;stroke-width:2}";

/// The report as one HTML page without scripts: its rows, and plots against the number of triangles.
#[must_use]
pub fn page(report: &FrameReport) -> String {
    let source = escape(&report.source);
    let settings = &report.settings;
    let head: String = COLUMNS.map(|title| format!("<th>{title}</th>")).concat();
    let row = |row: &FrameRow| {
        format!(
            "<tr>{}</tr>\n",
            row.cells().map(|cell| format!("<td>{cell}</td>")).concat()
        )
    };
    let rows: String = report.rows.iter().map(row).collect();
    let plots: String = plots(report).iter().map(Plot::svg).collect();
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>Cost of a frame: {source}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n\
         <h1>Cost of a frame: {source}</h1>\n<p>{LEGEND}.</p>\n\
         <p>{frames} frames, {side} × {side} camera rays and {random} random rays each, medians of {repeats}; \
         {updates} updates.</p>\n\
         <div class=\"wide\"><table>\n<tr>{head}</tr>\n{rows}</table></div>\n\
         <div class=\"plots\">\n{plots}</div>\n</body>\n</html>\n",
        frames = settings.frames,
        side = settings.picture_side,
        random = settings.random_rays,
        repeats = settings.repeats,
        updates = settings.updates,
    )
}

fn plots(report: &FrameReport) -> Vec<Plot> {
    let mut threads: Vec<usize> = report.rows.iter().map(|row| row.threads).collect();
    threads.sort_unstable();
    threads.dedup();
    let series = |threads: usize, name: &str, colour, dashed, value: &dyn Fn(&FrameRow) -> f64| Series {
        name: name.to_owned(),
        colour,
        dashed,
        points: report
            .rows
            .iter()
            .filter(|row| row.threads == threads)
            .map(|row| (row.triangles as f64, value(row)))
            .collect(),
    };
    let update = threads.first().map(|&least| Plot {
        title: "Before the first ray of a frame".to_owned(),
        x_label: "triangles",
        y_label: "µs",
        series: vec![
            series(least, "update", OURS, false, &|row| row.update_us),
            series(least, "update, 99th percentile", OURS, true, &|row| row.update_p99_us),
            series(least, "static kd-tree built anew", STATIC, false, &|row| {
                row.static_build_ms * 1e3
            }),
        ],
    });
    let rays = threads.iter().map(|&threads| Plot {
        title: format!("Rays, {threads} thread{}", if threads == 1 { "" } else { "s" }),
        x_label: "triangles",
        y_label: "Mrays/s",
        series: vec![
            series(threads, "primary, static tree", STATIC, false, &|row| {
                row.primary.twin.mrays
            }),
            series(threads, "primary, fuzzy trees", OURS, false, &|row| {
                row.primary.ours.mrays
            }),
            series(threads, "random, static tree", STATIC, true, &|row| {
                row.random.twin.mrays
            }),
            series(threads, "random, fuzzy trees", OURS, true, &|row| row.random.ours.mrays),
        ],
    });
    update.into_iter().chain(rays).collect()
}
