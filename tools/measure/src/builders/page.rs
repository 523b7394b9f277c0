use super::{BuildFigures, BuildersReport};
use crate::{
    page::{COLOURS, document, section},
    plot::{Plot, Scale, Series},
};

/// The report as one HTML page without scripts: its tables, and plots.
#[must_use]
pub fn page(report: &BuildersReport) -> String {
    let settings = &report.settings;
    let mut body = format!(
        "<p>Median of up to {repeats} builds, in turns, no more after {seconds} s. Trees of all builders are traced by one \
         traversal per kind, one thread. All of their hits are equal; {checked} rays were compared with brute force.</p>\n\
         <div class=\"plots\">\n",
        repeats = settings.repeats,
        seconds = settings.seconds,
        checked = report.brute_force_rays,
    );
    body += &plots(report).iter().map(Plot::svg).collect::<String>();
    body += "</div>\n";
    body += &section(&report.orders());
    body += &section(&report.animations);
    body += &section(&report.builds);
    body += &section(&report.theirs);
    document("Tree builders", &body)
}

fn plots(report: &BuildersReport) -> Vec<Plot> {
    let rows = || report.builds.iter().filter(|row| !row.shuffled);
    let first_threads = |row: &&BuildFigures| row.threads == least_threads(report, row);
    let mut out = vec![Plot {
        title: "build rate, fewest threads".to_owned(),
        x_label: "triangles",
        y_label: "Mtris/s",
        scales: [Scale::Logarithmic; 2],
        series: by_builder(rows().filter(first_threads), |row| {
            (row.triangles as f64, row.mtris_per_s)
        }),
    }];
    for scene in names(rows().map(|row| row.scene.as_str())) {
        let own = || rows().filter(|row| row.scene == scene);
        for tree in names(own().map(|row| row.tree)) {
            out.push(Plot {
                title: format!("{scene}: quality against speed, {tree}"),
                x_label: "Mtris/s",
                y_label: "SAH cost, reference's over this",
                scales: [Scale::Logarithmic, Scale::Linear],
                series: by_builder(own().filter(first_threads).filter(|row| row.tree == tree), |row| {
                    (row.mtris_per_s, row.sah_relative)
                }),
            });
        }
        out.push(Plot {
            title: format!("{scene}: threads"),
            x_label: "threads",
            y_label: "build rate, relative to fewest threads",
            scales: [Scale::Linear; 2],
            series: by_builder(own(), |row| (row.threads as f64, row.scaling)),
        });
    }
    // A line of one point says nothing about threads.
    out.retain(|plot| plot.x_label != "threads" || plot.series.iter().any(|series| series.points.len() > 1));
    out
}

fn least_threads(report: &BuildersReport, of: &BuildFigures) -> usize {
    let same = report
        .builds
        .iter()
        .filter(|row| row.scene == of.scene && row.builder == of.builder);
    same.map(|row| row.threads).min().unwrap_or(of.threads)
}

fn names<'a>(all: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut out = Vec::new();
    for name in all {
        if !out.contains(&name) {
            out.push(name);
        }
    }
    out
}

/// A line per builder; those of peers are dashed. Points ascend.
fn by_builder<'a>(
    rows: impl Iterator<Item = &'a BuildFigures>,
    point: impl Fn(&BuildFigures) -> (f64, f64),
) -> Vec<Series> {
    let mut out: Vec<Series> = Vec::new();
    for row in rows {
        let place = out.iter().position(|series| series.name == row.builder);
        let place = place.unwrap_or_else(|| {
            out.push(Series {
                name: row.builder.to_owned(),
                colour: COLOURS[out.len() % COLOURS.len()],
                dashed: row.peer,
                points: Vec::new(),
            });
            out.len() - 1
        });
        out[place].points.push(point(row));
    }
    for series in &mut out {
        series.points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    out
}
