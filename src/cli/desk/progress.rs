//! A progress bar, on a terminal only.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, mpsc};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use identify::Stage;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use lab::explain::Work;

use super::forecast::Forecast;

/// Shows that long work goes on.
pub struct Progress {
    bar: ProgressBar,
    /// Of work in stages.
    staged: Option<Staged>,
}

/// Work in stages, watched from a thread of its own.
struct Staged {
    /// Counts the stage that it is in, if anything does.
    work: Work,
    forecast: Arc<Mutex<Forecast>>,
    began: Instant,
    /// Takes the watcher away.
    end: mpsc::Sender<()>,
    watcher: Option<JoinHandle<()>>,
}

impl Progress {
    /// Steps of a bar over a share.
    const PARTS: u64 = 1000;

    /// Work of unknown length over recordings, counted in lines.
    pub fn of_files(files: &[PathBuf]) -> Self {
        let names: Vec<_> = files.iter().map(|file| file.display().to_string()).collect();
        Self::lines(&names.join(", "))
    }

    /// Work of so many parts.
    pub fn of_parts(total: usize) -> Self {
        let bar = ProgressBar::new(total as u64);
        if !std::io::stderr().is_terminal() {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos} of {len}, {elapsed}  {wide_msg}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        Self { bar, staged: None }
    }

    /// Work that is a part of another one's, which has a bar.
    pub fn hidden() -> Self {
        Self { bar: ProgressBar::hidden(), staged: None }
    }

    /// A part has begun.
    pub fn begin(&self, part: String) {
        self.bar.set_message(part);
    }

    /// A part is done.
    pub fn part_done(&self) {
        self.bar.inc(1);
    }

    /// Work in stages of usual lengths, one bar for all of them, with the time that is left; `work` counts the one
    /// that it is in, if anything does.
    pub fn of_stages(stages: &'static [Stage], work: Work) -> Self {
        let is_shown = std::io::stderr().is_terminal();
        let bar = ProgressBar::new(Self::PARTS);
        if !is_shown {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        if let Ok(style) =
            ProgressStyle::with_template("{bar:30} {percent:>3} %, {elapsed}{prefix}  {wide_msg}")
        {
            bar.set_style(style);
        }
        bar.enable_steady_tick(TICK);
        let forecast = Arc::new(Mutex::new(Forecast::new(stages)));
        let began = Instant::now();
        let (end, ended) = mpsc::channel();
        let watched = (bar.clone(), forecast.clone());
        let counts = work.clone();
        let watch = move || {
            while ended.recv_timeout(TICK) == Err(mpsc::RecvTimeoutError::Timeout) {
                show(&watched, began, counts.share());
            }
        };
        let watcher = is_shown.then(|| std::thread::spawn(watch));
        Self { bar, staged: Some(Staged { work, forecast, began, end, watcher }) }
    }

    /// Work in stages is in this one, of which a share is done (0–1).
    pub fn at(&self, stage: &str, share: f64) {
        self.bar.set_message(stage.to_owned());
        if let Some(staged) = &self.staged
            && let Ok(mut forecast) = staged.forecast.lock()
        {
            if !forecast.is_in(stage) {
                // What was counted is of the stage before.
                staged.work.begin(0);
            }
            forecast.at(staged.began.elapsed().as_secs_f64(), stage, share);
        }
    }

    fn lines(name: &str) -> Self {
        let bar = ProgressBar::new_spinner();
        if !std::io::stderr().is_terminal() {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        if let Ok(style) =
            ProgressStyle::with_template("{spinner} {msg}: {human_pos} lines, {per_sec}, {elapsed}")
        {
            bar.set_style(style);
        }
        bar.set_message(name.to_owned());
        bar.enable_steady_tick(Duration::from_millis(200));
        Self { bar, staged: None }
    }

    /// So many lines are done. Cheap enough for every line.
    #[inline]
    pub fn advance(&self, lines: u64) {
        if lines.is_multiple_of(4096) {
            self.bar.set_position(lines);
        }
    }

    /// Takes the bar away.
    pub fn finish(self) {
        if let Some(Staged { end, watcher, .. }) = self.staged {
            drop(end);
            // It has nothing to say that could be lost.
            watcher.map(JoinHandle::join);
        }
        self.bar.finish_and_clear();
    }
}

/// How often what is shown is made new.
const TICK: Duration = Duration::from_millis(200);

/// As exactly as anyone knows it.
fn about(seconds: f64) -> String {
    match seconds {
        ..90.0 => format!("{:.0} s", seconds.max(1.0)),
        ..5400.0 => format!("{:.0} min", seconds / 60.0),
        _ => format!("{:.0} h", seconds / 3600.0),
    }
}

/// Puts the bar where the work is.
fn show((bar, forecast): &(ProgressBar, Arc<Mutex<Forecast>>), began: Instant, counted: Option<f64>) {
    let Ok(mut forecast) = forecast.lock() else { return };
    let seconds = began.elapsed().as_secs_f64();
    let left = forecast.left(seconds, counted);
    bar.set_position((forecast.share(seconds, left) * Progress::PARTS as f64) as u64);
    if let Some(left) = left {
        bar.set_prefix(format!(", about {} left", about(left)));
    }
}
