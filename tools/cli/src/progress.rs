//! Progress on stderr, and the clock of the stages.

use crate::{args::When, output::note};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::{Serialize, Serializer, ser::SerializeMap};
use std::{
    io::IsTerminal,
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

/// Plain lines about a stage that goes on come no closer together than this.
const LINE_INTERVAL: Duration = Duration::from_secs(5);

/// How progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Bars, drawn again and again in the same line.
    Bars,
    /// A line at the start of each stage, and every five seconds.
    Lines,
    /// Nothing.
    Silent,
}

impl Style {
    /// The style that the options ask for.
    pub fn chosen(when: When, quiet: bool) -> Self {
        match when {
            When::Never => Self::Silent,
            _ if quiet => Self::Silent,
            When::Always => Self::Bars,
            When::Auto if std::io::stderr().is_terminal() => Self::Bars,
            When::Auto => Self::Lines,
        }
    }
}

/// Follows a command through its stages. Shared by all threads.
pub struct Reporter {
    style: Style,
    done: AtomicU64,
    state: Mutex<State>,
}

struct State {
    label: String,
    stage: Option<Stage>,
    seconds: StageSeconds,
}

struct Stage {
    name: &'static str,
    total: u64,
    started: Instant,
    last_line: Instant,
    bar: ProgressBar,
}

impl Reporter {
    /// A reporter that has not begun any stage.
    pub fn new(style: Style) -> Self {
        let state = State {
            label: String::new(),
            stage: None,
            seconds: StageSeconds::default(),
        };
        Self {
            style,
            done: AtomicU64::new(0),
            state: Mutex::new(state),
        }
    }

    /// Puts `label` before every stage's name from here on.
    pub fn set_label(&self, label: &str) {
        self.lock().label = format!("{label}: ");
    }

    /// Begins a stage of `total` steps and ends the one before; a total of 0 means that it is not known.
    pub fn stage(&self, name: &'static str, total: u64) {
        let mut state = self.lock();
        state.end_stage();
        self.done.store(0, Ordering::Relaxed);
        let title = format!("{}{name}", state.label);
        if self.style == Style::Lines {
            note(&title);
        }
        let now = Instant::now();
        state.stage = Some(Stage {
            name,
            total,
            started: now,
            last_line: now,
            bar: self.bar(title, total),
        });
    }

    /// `count` more steps of the stage are done.
    pub fn advance(&self, count: u64) {
        let done = self.done.fetch_add(count, Ordering::Relaxed) + count;
        // Workers do not queue up to draw: whoever finds the lock taken leaves it to the next.
        let Ok(mut state) = self.state.try_lock() else { return };
        let State {
            label,
            stage: Some(stage),
            ..
        } = &mut *state
        else {
            return;
        };
        stage.bar.set_position(done);
        if self.style == Style::Lines && stage.last_line.elapsed() >= LINE_INTERVAL {
            stage.last_line = Instant::now();
            match stage.total {
                0 => note(&format!("{label}{} {done}", stage.name)),
                total => note(&format!("{label}{} {done} of {total}", stage.name)),
            }
        }
    }

    /// Ends the last stage, clears its bar, and gives the seconds spent in each stage since the last call.
    pub fn finish(&self) -> StageSeconds {
        let mut state = self.lock();
        state.end_stage();
        std::mem::take(&mut state.seconds)
    }

    /// A line that is not progress, such as a warning. Hidden by `--quiet` only.
    pub fn message(&self, line: &str, quiet: bool) {
        if !quiet {
            match &self.lock().stage {
                Some(stage) => stage.bar.suspend(|| note(line)),
                None => note(line),
            }
        }
    }

    fn bar(&self, title: String, total: u64) -> ProgressBar {
        if self.style != Style::Bars {
            return ProgressBar::hidden();
        }
        let target = if std::io::stderr().is_terminal() {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::term_like_with_hz(Box::new(console::Term::stderr()), 10)
        };
        let template = if total > 0 {
            "{msg:32!} {wide_bar} {pos}/{len}"
        } else {
            "{msg:32!} {spinner} {elapsed}"
        };
        let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::with_draw_target((total > 0).then_some(total), target)
            .with_style(style)
            .with_message(title);
        bar.tick();
        bar
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // What a panicking thread left behind is still fit to be shown.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl restpose_bake::Progress for Reporter {
    fn stage(&self, name: &'static str, total: u64) {
        Self::stage(self, name, total);
    }

    fn advance(&self, steps: u64) {
        Self::advance(self, steps);
    }
}

impl Drop for Reporter {
    fn drop(&mut self) {
        self.finish();
    }
}

impl State {
    fn end_stage(&mut self) {
        if let Some(stage) = self.stage.take() {
            stage.bar.finish_and_clear();
            self.seconds.add(stage.name, stage.started.elapsed());
        }
    }
}

/// Wall-clock seconds per stage, in the order of the stages.
#[derive(Debug, Default)]
pub struct StageSeconds(Vec<(&'static str, Duration)>);

impl StageSeconds {
    fn add(&mut self, name: &'static str, time: Duration) {
        match self.0.iter_mut().find(|(known, _)| *known == name) {
            Some((_, sum)) => *sum += time,
            None => self.0.push((name, time)),
        }
    }

    /// Over all stages.
    pub fn total(&self) -> Duration {
        self.0.iter().map(|(_, time)| *time).sum()
    }
}

impl Serialize for StageSeconds {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut object = serializer.serialize_map(Some(self.0.len() + 1))?;
        for (name, time) in &self.0 {
            object.serialize_entry(name, &rounded(*time))?;
        }
        object.serialize_entry("total", &rounded(self.total()))?;
        object.end()
    }
}

/// Seconds to the microsecond: a clock reading has no more to say.
fn rounded(time: Duration) -> f64 {
    (time.as_secs_f64() * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_are_timed_in_order_and_repeated_stages_add_up() {
        let reporter = Reporter::new(Style::Silent);
        for name in ["b", "a", "b"] {
            reporter.stage(name, 2);
            reporter.advance(1);
            std::thread::sleep(Duration::from_millis(2));
        }
        let seconds = reporter.finish();
        let json = serde_json::to_string(&seconds).expect("numbers serialise");
        assert!(
            json.starts_with("{\"b\":0.") && json.contains(",\"a\":0.") && json.contains(",\"total\":0."),
            "{json}"
        );
        assert!(seconds.0[0].1 >= Duration::from_millis(4));
        assert_eq!(reporter.finish().total(), Duration::ZERO);
    }

    #[test]
    fn quiet_silences_progress() {
        assert_eq!(Style::chosen(When::Auto, true), Style::Silent);
        assert_eq!(Style::chosen(When::Always, true), Style::Silent);
        assert_eq!(Style::chosen(When::Never, false), Style::Silent);
        assert_eq!(Style::chosen(When::Always, false), Style::Bars);
    }
}
