//! Line plots as SVG.

use std::fmt::Write;

const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 400.0;
/// Left, top, right, bottom; the names of the series stand on the right.
const MARGIN: [f64; 4] = [64.0, 40.0, 170.0, 52.0];
/// Names of series come no closer together than this.
const NAME_SPACING: f64 = 15.0;
/// More ticks than these run into each other.
const MOST_TICKS: usize = 9;

/// A line with a name at its end.
pub(crate) struct Series {
    pub name: String,
    /// CSS colour.
    pub colour: &'static str,
    pub dashed: bool,
    /// Points that an axis cannot show are left out.
    pub points: Vec<(f64, f64)>,
}

/// A plot.
pub(crate) struct Plot {
    pub title: String,
    pub x_label: &'static str,
    pub y_label: &'static str,
    /// Of x and y.
    pub scales: [Scale; 2],
    pub series: Vec<Series>,
}

/// How values are laid out along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scale {
    /// From zero; shows values that are not negative.
    Linear,
    /// Shows values above zero.
    Logarithmic,
}

impl Scale {
    fn shows(self, value: f64) -> bool {
        value.is_finite() && (value > 0.0 || self == Self::Linear && value == 0.0)
    }
}

/// An axis: values from the first tick to the last run from `from` to `to` on the page.
struct Axis {
    scale: Scale,
    /// At least two, ascending.
    ticks: Vec<f64>,
    from: f64,
    to: f64,
}

impl Axis {
    fn new(scale: Scale, values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        match scale {
            Scale::Linear => Self::from_zero(values, from, to),
            Scale::Logarithmic => Self::around(values, from, to),
        }
    }

    /// From zero to the first tick that is not below `values`: multiples of 1, 2 or 5 times a power of ten, as many as
    /// there is room for.
    fn from_zero(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let greatest = values.fold(0.0, f64::max);
        let greatest = if greatest > 0.0 { greatest } else { 1.0 };
        let mut steps = (-330..=308).flat_map(|e| [1.0, 2.0, 5.0].map(|m| m * 10f64.powi(e)));
        let step = steps
            .find(|step| greatest / step <= (MOST_TICKS - 1) as f64)
            .unwrap_or(greatest);
        let last = (greatest / step).ceil() as usize;
        Self {
            scale: Scale::Linear,
            ticks: (0..=last).map(|count| count as f64 * step).collect(),
            from,
            to,
        }
    }

    /// Logarithmic, from the last tick that is not above `values` to the first that is not below them: 1, 2 and 5 of every decade,
    /// or only 1 where they would be too many.
    fn around(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let (least, greatest) = values.fold((f64::INFINITY, 0.0), |(a, b), x| (x.min(a), x.max(b)));
        let (least, greatest) = if least <= greatest {
            (least, greatest)
        } else {
            (1.0, 1.0)
        };
        let around = |multiples: &[f64]| -> Vec<f64> {
            let decades = (-40..=40).flat_map(|e| multiples.iter().map(move |m| m * 10f64.powi(e)));
            let all: Vec<f64> = decades.collect();
            let first = all.partition_point(|x| *x <= least).saturating_sub(1);
            let last = all.partition_point(|x| *x < greatest).max(first + 1);
            all[first..all.len().min(last + 1)].to_vec()
        };
        let fine = around(&[1.0, 2.0, 5.0]);
        let ticks = if fine.len() <= MOST_TICKS { fine } else { around(&[1.0]) };
        Self {
            scale: Scale::Logarithmic,
            ticks,
            from,
            to,
        }
    }

    fn place(&self, value: f64) -> f64 {
        let [low, .., high] = self.ticks.as_slice() else {
            return self.from;
        };
        let share = match self.scale {
            Scale::Linear => (value - low) / (high - low),
            Scale::Logarithmic => (value / low).ln() / (high / low).ln(),
        };
        self.from + share * (self.to - self.from)
    }
}

impl Plot {
    /// The plot as an `<svg>` element.
    pub(crate) fn svg(&self) -> String {
        let [left, top, right, bottom] = MARGIN;
        let points = || self.series.iter().flat_map(|series| series.shown(self.scales));
        let x = Axis::new(self.scales[0], points().map(|(x, _)| x), left, WIDTH - right);
        let y = Axis::new(self.scales[1], points().map(|(_, y)| y), HEIGHT - bottom, top);
        let mut out = format!(
            "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">\n",
            escape(&self.title)
        );
        let mut add = |line: String| {
            out.push_str(&line);
            out.push('\n');
        };
        add(text(left, top - 18.0, "title", &self.title));
        for tick in &y.ticks {
            let at = y.place(*tick);
            add(line("grid", (x.from, at), (x.to, at)));
            add(text(left - 8.0, at + 4.0, "tick end", &short(*tick)));
        }
        for tick in &x.ticks {
            let at = x.place(*tick);
            add(line("grid", (at, y.from), (at, y.to)));
            add(text(at, y.from + 18.0, "tick middle", &short(*tick)));
        }
        add(text((x.from + x.to) / 2.0, HEIGHT - 12.0, "tick middle", self.x_label));
        add(text(4.0, top - 18.0, "tick", self.y_label));
        for series in &self.series {
            add(series.line(self.scales, &x, &y));
        }
        for (series, at) in self.series.iter().zip(self.name_places(&y)) {
            let style = format!("name\" fill=\"{}", series.colour);
            add(text(x.to + 10.0, at + 4.0, &style, &series.name));
        }
        out.push_str("</svg>\n");
        out
    }

    /// Where each name stands: beside its line's end, moved up where it would cover another one or a tick.
    fn name_places(&self, y: &Axis) -> Vec<f64> {
        let end = |series: &Series| {
            series
                .shown(self.scales)
                .last()
                .map_or(y.from, |(_, value)| y.place(value))
        };
        let mut places: Vec<(usize, f64)> = self.series.iter().map(end).enumerate().collect();
        places.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut free = y.from - NAME_SPACING / 2.0;
        for (_, at) in &mut places {
            *at = at.min(free);
            free = *at - NAME_SPACING;
        }
        places.sort_by_key(|(index, _)| *index);
        places.into_iter().map(|(_, at)| at).collect()
    }
}

impl Series {
    fn shown(&self, [x, y]: [Scale; 2]) -> impl Iterator<Item = (f64, f64)> {
        let points = self.points.iter().copied();
        points.filter(move |(a, b)| x.shows(*a) && y.shows(*b))
    }

    fn line(&self, scales: [Scale; 2], x: &Axis, y: &Axis) -> String {
        let at: Vec<(f64, f64)> = self.shown(scales).map(|(a, b)| (x.place(a), y.place(b))).collect();
        let path: Vec<String> = at.iter().map(|(a, b)| format!("{a:.1},{b:.1}")).collect();
        let dash = if self.dashed { " stroke-dasharray=\"5 4\"" } else { "" };
        let colour = self.colour;
        let mut out = format!("<polyline points=\"{}\" stroke=\"{colour}\"{dash}/>", path.join(" "));
        for (a, b) in at {
            // Writing to a string does not fail.
            let _ = write!(out, "<circle cx=\"{a:.1}\" cy=\"{b:.1}\" r=\"3\" fill=\"{colour}\"/>");
        }
        out
    }
}

fn line(class: &str, from: (f64, f64), to: (f64, f64)) -> String {
    let ((a, b), (c, d)) = (from, to);
    format!("<line class=\"{class}\" x1=\"{a:.1}\" y1=\"{b:.1}\" x2=\"{c:.1}\" y2=\"{d:.1}\"/>")
}

fn text(x: f64, y: f64, class: &str, text: &str) -> String {
    format!(
        "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\">{}</text>",
        escape(text)
    )
}

/// A tick's value: 1, 2 or 5 times a power of ten.
fn short(value: f64) -> String {
    let (value, unit) = match value {
        x if x >= 0.999e6 => (x / 1e6, "M"),
        x if x >= 0.999e3 => (x / 1e3, "k"),
        x => (x, ""),
    };
    // Powers of ten below one are not exact; three digits are.
    let rounded = (value * 1e3).round() / 1e3;
    format!("{}{unit}", if rounded == 0.0 { value } else { rounded })
}

/// Text as it may stand in HTML, between tags and in attributes.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(points: &[(f64, f64)]) -> Series {
        Series {
            name: "a<b".into(),
            colour: "#000",
            dashed: false,
            points: points.to_vec(),
        }
    }

    #[test]
    fn axes_end_on_ticks_around_the_values() {
        let axis = |values: &[f64]| Axis::around(values.iter().copied(), 0.0, 100.0);
        assert_eq!(axis(&[37.0, 480.0]).ticks, [20.0, 50.0, 100.0, 200.0, 500.0]);
        assert_eq!(axis(&[21.0, 3e5]).ticks, [10.0, 100.0, 1e3, 1e4, 1e5, 1e6]);
        assert_eq!(axis(&[20.0, 50.0]).ticks, [20.0, 50.0]);
        assert_eq!(axis(&[3.0]).ticks, [2.0, 5.0]);
        assert_eq!(axis(&[2.0]).ticks, [2.0, 5.0]);
        assert_eq!(axis(&[]).ticks, [1.0, 2.0]);
        assert_eq!(axis(&[37.0, 480.0]).place(20.0), 0.0);
        assert_eq!(axis(&[37.0, 480.0]).place(500.0), 100.0);
        let middle = axis(&[37.0, 480.0]).place(100.0);
        assert!(
            (middle - 50.0).abs() < 1e-9,
            "100 is the middle of 20 and 500 by ratio: {middle}"
        );
        for extreme in [1e-200, 1e200] {
            assert!(axis(&[extreme]).place(extreme).is_finite());
        }
    }

    #[test]
    fn linear_axes_begin_at_zero() {
        let axis = |values: &[f64]| Axis::new(Scale::Linear, values.iter().copied(), 0.0, 100.0);
        assert_eq!(axis(&[3.0, 25.0]).ticks, [0.0, 5.0, 10.0, 15.0, 20.0, 25.0]);
        assert_eq!(axis(&[399.0]).ticks.len(), 9);
        assert_eq!(axis(&[0.0]).ticks.last(), Some(&1.0));
        assert_eq!(axis(&[25.0]).place(10.0), 40.0);
        for extreme in [1e-300, 1e300] {
            assert!(axis(&[extreme]).place(extreme).is_finite());
        }
        assert!(Scale::Linear.shows(0.0) && !Scale::Logarithmic.shows(0.0) && !Scale::Linear.shows(-1.0));
    }

    #[test]
    fn unusable_points_are_left_out() {
        let plot = Plot {
            title: "t".into(),
            x_label: "x",
            y_label: "y",
            scales: [Scale::Logarithmic; 2],
            series: vec![series(&[(1.0, f64::NAN), (0.0, 1.0), (2.0, 3.0), (4.0, f64::INFINITY)])],
        };
        let svg = plot.svg();
        assert_eq!(svg.matches("<circle").count(), 1);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        assert!(svg.contains("a&lt;b") && !svg.contains("a<b"));
    }

    #[test]
    fn names_do_not_cover_each_other() {
        let plot = Plot {
            title: String::new(),
            x_label: "",
            y_label: "",
            scales: [Scale::Logarithmic; 2],
            series: (0..4)
                .map(|i| series(&[(1.0, 1.0), (2.0, 5.0 + f64::from(i) * 0.01)]))
                .collect(),
        };
        let mut places = plot.name_places(&Axis::around([1.0, 5.03].into_iter(), 300.0, 0.0));
        places.sort_by(f64::total_cmp);
        assert!(places.windows(2).all(|pair| pair[1] - pair[0] >= NAME_SPACING));
    }

    #[test]
    fn ticks_are_short() {
        let cases = [(0.2, "0.2"), (5.0, "5"), (2e3, "2k"), (1e6, "1M"), (1e-6, "0.000001")];
        for (value, expected) in cases {
            assert_eq!(short(value), expected);
        }
    }
}
