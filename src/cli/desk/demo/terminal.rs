//! The demo's lines on the terminal.

use std::fmt::Write as _;

use super::findings::{Findings, Quality};
use crate::cli::desk::closing::{Line, percent, table};
use bus::watch::Round;
use lab::report::number;
use physics::estimates::{MuSource, State};

/// Above the lines. Brackets: published, but not valid yet.
pub const HEADER: &str = "\
 time  speed  slip slope               cornering stiffness, 1/rad     friction
    s   km/h     FL      FR       ±      front     ±    rear     ±    used  least   max  from         state
";

/// One line.
pub fn line(round: &Round, changes_before: u32) -> String {
    let mut line = String::new();
    // Writing to a string cannot fail.
    let _ = write!(
        line,
        "{:>5} {:>6}  {} {} {:>6}   {} {:>5} {} {:>5}  {:>6} {:>6} {} {:<11} {}",
        number(round.time, 0),
        number(round.speed * 3.6, 0),
        bracketed(round.slope[0], 1, 7, round.slope_valid),
        bracketed(round.slope[1], 1, 7, round.slope_valid),
        number(round.slope_std, 1),
        bracketed(round.cornering[0], 1, 7, round.cornering_valid),
        number(round.cornering_std[0], 1),
        bracketed(round.cornering[1], 1, 7, round.cornering_valid),
        number(round.cornering_std[1], 1),
        number(round.mu_used, 2),
        number(round.mu_low, 2),
        bracketed(round.mu_max, 2, 6, round.mu_valid),
        round.mu_source.map_or("", MuSource::name).replace('_', " "),
        round.state.map_or("", State::name)
    );
    if round.surface_changes > changes_before {
        line += "  << surface change";
    }
    for fault in round.faults.names() {
        let _ = write!(line, "  ! {fault}");
    }
    line.truncate(line.trim_end().len());
    line + "\n"
}

fn bracketed(value: f64, decimals: usize, width: usize, valid: bool) -> String {
    let text = number(value, decimals);
    if valid || !value.is_finite() {
        format!("{text:>width$} ")
    } else {
        format!("{:>width$}", format!("({text})"), width = width + 1)
    }
}

/// What was found, in a few lines.
pub fn summary(findings: &Findings, published: u64) -> String {
    let mut text = String::from("\nsurface changes\n");
    for change in &findings.changes {
        let noticed = match change.delay {
            Some(delay) => format!("noticed after {delay:.1} s"),
            None => "not noticed".into(),
        };
        let _ = writeln!(text, "  {:<28} {:>5.1} s  {noticed}", format!("to {}", change.to), change.at);
    }
    let _ = writeln!(text, "  {:<28} {:>5}", "false alarms", findings.false_notices());
    let _ = writeln!(text, "published frames {published}\n");
    let line = |quality: &Quality| {
        let rms = if quality.rms.is_finite() {
            format!("{} {}", number(quality.rms, quality.decimals), quality.unit)
        } else {
            "–".into()
        };
        Line { name: quality.name.into(), valid: quality.valid, told: vec![percent(quality.covered), rms] }
    };
    let lines: Vec<Line> = findings.quality.iter().map(line).collect();
    text + &table(&[("truth within 95 %", Some(20)), ("rms error", None)], &lines)
}
