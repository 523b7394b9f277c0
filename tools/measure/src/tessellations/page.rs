use super::{COLUMNS, LEGEND, TessellationRow, TessellationsReport};
use crate::{
    page::{OURS, STATIC, document, table},
    plot::{Plot, Scale, Series, escape},
};

/// The report as one HTML page without scripts: its rows, and plots against the number of triangles.
#[must_use]
pub fn page(report: &TessellationsReport) -> String {
    let settings = &report.settings;
    let mut body = format!(
        "<p>{LEGEND}.</p>\n<p>{frames} frames, {side} × {side} camera rays and {random} random rays each, medians of \
         {repeats}; {updates} updates.</p>\n",
        frames = settings.frames,
        side = settings.picture_side,
        random = settings.random_rays,
        repeats = settings.repeats,
        updates = settings.updates,
    );
    body += &table(&COLUMNS, report.rows.iter().map(|row| row.cells().to_vec()));
    let plots: String = plots(report).iter().map(Plot::svg).collect();
    body += &format!("<div class=\"plots\">\n{plots}</div>\n");
    document(&format!("Cost of a frame: {}", escape(&report.source)), &body)
}

fn plots(report: &TessellationsReport) -> Vec<Plot> {
    let mut threads: Vec<usize> = report.rows.iter().map(|row| row.threads).collect();
    threads.sort_unstable();
    threads.dedup();
    let series = |threads: usize, name: &str, colour, dashed, value: &dyn Fn(&TessellationRow) -> f64| Series {
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
        scales: [Scale::Logarithmic; 2],
        series: vec![
            series(least, "update", OURS, false, &|row| row.update_us),
            series(least, "update, 99th percentile", OURS, true, &|row| row.update_p99_us),
            series(least, "static tree built anew", STATIC, false, &|row| {
                row.static_build_ms * 1e3
            }),
        ],
    });
    let rays = threads.iter().map(|&threads| Plot {
        title: format!("Rays, {threads} thread{}", if threads == 1 { "" } else { "s" }),
        x_label: "triangles",
        y_label: "Mrays/s",
        scales: [Scale::Logarithmic; 2],
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
