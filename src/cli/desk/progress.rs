//! A progress bar, on a terminal only.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Shows that long work goes on.
pub struct Progress {
    bar: ProgressBar,
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
        Self { bar }
    }

    /// Work that is a part of another one's, which has a bar.
    pub fn hidden() -> Self {
        Self { bar: ProgressBar::hidden() }
    }

    /// A part has begun.
    pub fn begin(&self, part: String) {
        self.bar.set_message(part);
    }

    /// A part is done.
    pub fn part_done(&self) {
        self.bar.inc(1);
    }

    /// Work in stages, each of which tells what share of it is done.
    pub fn of_share() -> Self {
        let bar = ProgressBar::new(Self::PARTS);
        if !std::io::stderr().is_terminal() {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {percent:>3} %, {elapsed}  {wide_msg}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        Self { bar }
    }

    /// A stage is this far (0–1).
    pub fn at(&self, stage: &str, share: f64) {
        self.bar.set_message(stage.to_owned());
        self.bar.set_position((share.clamp(0.0, 1.0) * Self::PARTS as f64) as u64);
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
        Self { bar }
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
        self.bar.finish_and_clear();
    }
}
