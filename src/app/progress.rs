//! Progress on standard error: a bar on a terminal, a line now and then elsewhere, nothing when asked to be quiet.

use super::report::Stage;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::fmt::{self, Display};
use std::io::{self, IsTerminal, Write};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How much to say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Voice {
    Normal,
    Quiet,
}

/// Shows the stages of a run and remembers how long each took.
pub struct Progress {
    channel: Channel,
    /// Between two lines.
    interval: Duration,
    current: Option<Current>,
    stages: Vec<Stage>,
    watch: Option<Watch>,
}

/// What was shown last, for another thread to look at: the stage, how many iterations are done, and of how many.
pub type Watch = Arc<Mutex<Option<(&'static str, u64, u64)>>>;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Channel {
    Terminal,
    Lines,
    None,
}

struct Current {
    name: &'static str,
    /// Iterations that were done before this run.
    cached: u64,
    /// Iterations that are done.
    iterations: u64,
    start: Instant,
    last_line: Instant,
    bar: Option<ProgressBar>,
    /// What moves within an iteration.
    detail: String,
}

/// Time between two lines where there is no terminal; `TERRANE_PROGRESS` says another, in seconds.
const LINE_INTERVAL: Duration = Duration::from_secs(10);

/// The variable that says it.
pub const INTERVAL: &str = "TERRANE_PROGRESS";

impl Progress {
    pub fn new(voice: Voice) -> Self {
        let channel = match voice {
            Voice::Quiet => Channel::None,
            Voice::Normal if io::stderr().is_terminal() => Channel::Terminal,
            Voice::Normal => Channel::Lines,
        };
        let asked = std::env::var(INTERVAL).ok().and_then(|seconds| seconds.parse().ok());
        let interval = asked.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
        let interval = interval.unwrap_or(LINE_INTERVAL);
        Progress { channel, interval, current: None, stages: Vec::new(), watch: None }
    }

    /// Tells nobody.
    #[cfg(feature = "viewer")]
    pub fn silent() -> Self {
        Progress::new(Voice::Quiet)
    }

    /// Tells those who look at it.
    #[cfg(feature = "viewer")]
    pub fn watched(watch: Watch) -> Self {
        Progress { watch: Some(watch), ..Progress::silent() }
    }

    /// Says that `iteration` of `of` iterations of a stage are done. The first call of another stage ends the one before;
    /// what is done by then comes from the cache.
    pub fn show(&mut self, stage: &'static str, iteration: u64, of: u64) {
        if self.current.as_ref().is_some_and(|current| current.name != stage) {
            self.end();
        }
        if let Some(watch) = &self.watch {
            *watch.lock().unwrap_or_else(PoisonError::into_inner) = Some((stage, iteration, of));
        }
        let channel = self.channel;
        if self.current.is_none() && iteration > 0 && iteration < of {
            self.say(&format!("{stage}: continuing at iteration {iteration} of {of}"));
        }
        let current = self.current.get_or_insert_with(|| Current::new(stage, iteration, of, channel));
        current.iterations = iteration;
        if let Some(bar) = &current.bar {
            bar.set_length(of);
            bar.set_position(iteration);
        } else if channel == Channel::Lines && current.last_line.elapsed() >= self.interval {
            current.last_line = Instant::now();
            let rate = (iteration - current.cached) as f64 / current.start.elapsed().as_secs_f64();
            let left = of.saturating_sub(iteration) as f64 / rate;
            let detail = &current.detail;
            if iteration == current.cached {
                line(&format!("{stage}: {iteration} of {of}{detail}"));
            } else {
                line(&format!("{stage}: {iteration} of {of}, {rate:.1}/s, {left:.0} s left{detail}"));
            }
        }
    }

    /// What is to be told of the stage under way beside its iterations, from now on.
    pub fn detail(&mut self, detail: impl Display) {
        let Some(current) = &mut self.current else { return };
        current.detail = format!("; {detail}");
        if let Some(bar) = &current.bar {
            bar.set_prefix(detail.to_string());
        }
    }

    /// Ends the stage under way.
    pub fn end(&mut self) {
        let Some(current) = self.current.take() else { return };
        if let Some(bar) = &current.bar {
            bar.finish_and_clear();
        }
        let Current { name, cached, .. } = current;
        let (iterations, seconds) = (current.iterations - cached, current.start.elapsed().as_secs_f64());
        if cached > 0 && iterations == 0 {
            self.say(&format!("{name}: from the cache"));
        } else {
            self.say(&format!("{name}: {iterations} in {seconds:.1} s"));
        }
        self.stages.push(Stage { name, seconds, iterations, cached });
    }

    /// A line for the user.
    pub fn say(&self, message: &dyn Display) {
        match self.current.as_ref().and_then(|current| current.bar.as_ref()) {
            Some(bar) => bar.suspend(|| line(message)),
            None if self.channel == Channel::None => {}
            None => line(message),
        }
    }

    pub fn into_stages(self) -> Vec<Stage> {
        self.stages
    }
}

impl Current {
    fn new(name: &'static str, cached: u64, of: u64, channel: Channel) -> Self {
        let now = Instant::now();
        let bar = (channel == Channel::Terminal).then(|| {
            let bar = ProgressBar::with_draw_target(Some(of), ProgressDrawTarget::stderr());
            bar.set_style(style());
            bar.set_message(name);
            bar.set_position(cached);
            bar.reset_eta();
            bar
        });
        Current { name, cached, iterations: cached, start: now, last_line: now, bar, detail: String::new() }
    }
}

fn style() -> ProgressStyle {
    let template = "{msg:<16} {bar:32} {pos}/{len}  {rate}  {eta} left  {prefix}";
    // A template that can't be read leaves the plain bar.
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    style.with_key("rate", |state: &ProgressState, out: &mut dyn fmt::Write| {
        let _ = write!(out, "{:.1}/s", state.per_sec());
    })
}

/// The share of a stage that is done, if a line tells that.
#[cfg(feature = "viewer")]
pub fn share(line: &str) -> Option<f32> {
    let (_, told) = line.split_once(": ")?;
    let (done, told) = told.split_once(" of ")?;
    let of = told.split([',', ';']).next()?;
    let [done, of] = [done, of].map(|number| number.parse::<f32>().ok());
    Some((done? / of.filter(|of| *of > 0.0)?).clamp(0.0, 1.0))
}

/// Nobody may be reading: whether it can be written is not asked.
fn line(message: &dyn Display) {
    let _ = writeln!(io::stderr().lock(), "{message}");
}

#[cfg(all(test, feature = "viewer"))]
mod tests {
    use super::share;

    #[test]
    fn lines_tell_the_share_that_is_done() {
        assert_eq!(share("erosion: 120 of 480"), Some(0.25));
        assert_eq!(share("erosion: 240 of 480, 12.1/s, 20 s left; 8 tiles"), Some(0.5));
        for other in [
            "erosion: 480 in 40.1 s",
            "erosion: continuing at iteration 3 of 480",
            "erosion: from the cache",
            "error: layers: 2 of these are unknown",
            "wrote height.exr",
        ] {
            assert_eq!(share(other), None, "{other}");
        }
    }
}
