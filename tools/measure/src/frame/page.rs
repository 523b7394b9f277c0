use super::{FrameCost, FrameReport};
use crate::{
    page::{COLOURS, document, section},
    plot::{Plot, Scale, Series},
};

/// The report as one HTML page without scripts: plots, then its tables.
#[must_use]
pub fn page(report: &FrameReport) -> String {
    let mut body = format!(
        "<p>A frame is set pose, update and trace. {poses} poses, at least a frame of each, no more after {seconds} s. All \
         contestants get the same rays; their hits were compared, and {checked} rays with brute force.</p>\n\
         <div class=\"plots\">\n",
        poses = report.settings.poses,
        seconds = report.settings.seconds,
        checked = report.brute_force_rays,
    );
    body += &plots(report).iter().map(Plot::svg).collect::<String>();
    body += "</div>\n";
    body += &section(&report.fixed_costs());
    body += &section(&report.glances);
    body += &section(&report.crossovers);
    body += &section(&report.frames);
    document("Cost of a frame", &body)
}

/// A plot per scene, kind of rays and number of threads.
fn plots(report: &FrameReport) -> Vec<Plot> {
    let mut out: Vec<(&FrameCost, Plot)> = Vec::new();
    for row in report.frames.iter().filter(|row| row.rays > 0) {
        let own = |(first, _): &(&FrameCost, Plot)| first.ray_kind == row.ray_kind && first.is_same_contest(row);
        let place = out.iter().position(own).unwrap_or_else(|| {
            out.push((row, plot(row)));
            out.len() - 1
        });
        let series = &mut out[place].1.series;
        let name = format!("{} {}", row.who, row.strategy);
        let line = series.iter().position(|line| line.name == name).unwrap_or_else(|| {
            series.push(Series {
                name,
                colour: COLOURS[series.len() % COLOURS.len()],
                dashed: row.who != "restpose",
                points: Vec::new(),
            });
            series.len() - 1
        });
        series[line].points.push((row.rays as f64, row.total_us));
    }
    out.into_iter().map(|(_, plot)| plot).collect()
}

fn plot(row: &FrameCost) -> Plot {
    let threads = if row.threads == 1 { "thread" } else { "threads" };
    let crowd = if row.instances == 1 {
        String::new()
    } else {
        format!("{} × ", row.instances)
    };
    Plot {
        title: format!("{crowd}{}: {} rays, {} {threads}", row.scene, row.ray_kind, row.threads),
        x_label: "rays per frame",
        y_label: "µs per frame",
        scales: [Scale::Logarithmic; 2],
        series: Vec::new(),
    }
}
