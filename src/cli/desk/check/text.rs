//! The report as people read it.

use std::io::{self, Write};

use super::Report;
use super::configuration::ConfigurationReport;
use super::layout::{Column, Layout};
use super::recording::{ChannelReport, RecordingReport};
use lab::explain::chain::{ChainReport, Confidence};

/// Writes everything; on a terminal no line is longer than that is wide.
pub fn write(out: &mut impl Write, is_terminal: bool, report: &Report) -> io::Result<()> {
    let mut out = Layout::new(out, is_terminal);
    configuration(&mut out, &report.configuration)?;
    if let Some(recordings) = &report.recordings {
        out.gap()?;
        recording(&mut out, recordings)?;
    }
    if let Some(chain) = &report.chain {
        out.gap()?;
        audit(&mut out, chain)?;
    }
    Ok(())
}

/// A number with four significant digits, whatever its size.
fn number(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 {
        "0".into()
    } else if (1e-3..1e5).contains(&magnitude) {
        let digits = (3 - magnitude.log10().floor() as i32).clamp(0, 6) as usize;
        format!("{value:.digits$}")
    } else if magnitude >= 1e100 {
        "any".into()
    } else {
        format!("{value:.2e}")
    }
}

fn optional(value: Option<f64>) -> String {
    value.map_or_else(|| "-".into(), number)
}

const SIGNALS: [Column; 9] = [
    ("quantity", 26, false),
    ("signal", 40, false),
    ("id", 10, true),
    (" unit", 29, false),
    ("one step", 9, true),
    (" range, SI", 23, false),
    ("late", 6, true),
    ("time-out", 8, true),
    (" checks", 18, false),
];

fn configuration(out: &mut Layout<impl Write>, report: &ConfigurationReport) -> io::Result<()> {
    out.line(&format!("configuration {}: usable; interface {}", report.file, report.interface))?;
    out.gap()?;
    let row = |q: &super::configuration::QuantityReport| {
        let unit = if q.unit.is_empty() { "1" } else { &q.unit };
        let (low, high) = (q.carried[0].max(q.plausible[0]), q.carried[1].min(q.plausible[1]));
        let checks = match (q.counter, q.checksum) {
            (true, true) => "counter, checksum",
            (true, false) => "counter",
            (false, true) => "checksum",
            (false, false) => "none",
        };
        vec![
            q.quantity.to_string(),
            q.source.to_string(),
            q.id.to_string(),
            format!(" {unit} x {} = {}", number(q.to_si), q.si_unit),
            number(q.resolution),
            format!(" {} … {}", number(low), number(high)),
            format!("{} ms", q.delay_ms),
            format!("{} ms", q.timeout_ms),
            format!(" {checks}"),
        ]
    };
    out.table(0, &SIGNALS, &report.quantities.iter().map(row).collect::<Vec<_>>())?;
    let effects = |is_taken: bool| -> Vec<&str> {
        let such = report.effects.iter().filter(|effect| effect.taken_out == is_taken);
        such.map(|effect| effect.effect.as_str()).collect()
    };
    let [left, taken] = [effects(false), effects(true)];
    if !taken.is_empty() {
        out.gap()?;
        out.line(&format!(
            "effects of the configuration that are taken out of all readings: {}; what is found wrong is wrong beside them",
            taken.join(", ")
        ))?;
    }
    if !left.is_empty() {
        out.gap()?;
        out.line(&format!("effects for simulations, of which nothing is used here: {}", left.join(", ")))?;
    }
    if !report.missing.is_empty() {
        out.gap()?;
        out.line("not configured:")?;
        for missing in &report.missing {
            out.line(&format!("  {:<26} {}", missing.quantity, missing.cost))?;
        }
    }
    for warning in &report.mapping_warnings {
        out.gap()?;
        out.line(&warning.to_string())?;
    }
    for warning in &report.dbc_warnings {
        out.gap()?;
        out.line(&format!("DBC: {warning}"))?;
    }
    if let Some(first) = &report.first_other_dbc_warning {
        let count = report.other_dbc_warnings;
        out.gap()?;
        out.line(&format!("DBC: {count} warnings about messages that are not needed, the first: {first}"))?;
    }
    for warning in &report.publish_warnings {
        out.line(&format!("output DBC: {warning}"))?;
    }
    out.gap()?;
    if report.published.is_empty() {
        out.line("published: nothing")?;
    } else {
        out.line(&format!("published every {} ms:", report.publish_period_ms))?;
        for frame in &report.published {
            out.line(&format!("  {:>10}  {}", frame.id, frame.message))?;
        }
    }
    if !report.vehicle_defaults.is_empty() {
        out.gap()?;
        out.line("[vehicle] not given, so taken as:")?;
        for default in &report.vehicle_defaults {
            out.line(&format!("  {:<30} {} ± {}", default.key, number(default.value), number(default.std)))?;
        }
    }
    Ok(())
}

const CHANNELS: [Column; 12] = [
    ("quantity", 26, false),
    ("frames", 8, true),
    ("rate/Hz", 8, true),
    ("jitter/ms", 9, true),
    ("gap/s", 9, true),
    ("batch", 7, true),
    ("absent", 7, true),
    ("min", 10, true),
    ("mean", 10, true),
    ("max", 10, true),
    ("step", 10, true),
    ("noise", 10, true),
];

fn recording(out: &mut Layout<impl Write>, report: &RecordingReport) -> io::Result<()> {
    for file in &report.files {
        out.line(&format!(
            "recording {} ({}): {}{:.1} s, {} frames, {} lines skipped, {} times backwards, {} dropped by the recorder",
            file.file,
            file.format,
            file.begins_utc.as_ref().map_or_else(String::new, |utc| format!("from {utc}, ")),
            file.seconds,
            file.frames,
            file.skipped_lines,
            file.time_backwards,
            file.dropped
        ))?;
        for line in &file.first_skipped {
            out.line(&format!("  line {line}"))?;
        }
        if let Some(broken) = &file.broken {
            out.line(&format!("  broken: {broken}"))?;
        }
    }
    out.line(&format!(
        "{} frames of {} identifiers are not needed; {:.1} % of all frames bear the stamp of the one before; \
         {} samples made",
        report.unneeded_frames,
        report.unneeded_ids,
        100.0 * report.batch_stamps,
        report.samples
    ))?;
    for message in &report.messages {
        if message.frames == 0 {
            out.line(&format!("warning: {} ({}) never comes", message.message, message.id))?;
        }
        for (count, what) in [
            (message.wrong_frames, "too short or of the wrong kind"),
            (message.checksum_failures, "with a wrong checksum"),
            (message.counter_repeats, "repeated by their counter"),
        ] {
            if count > 0 {
                let of = message.frames;
                out.line(&format!(
                    "warning: {} ({}): {count} of {of} frames {what}",
                    message.message, message.id
                ))?;
            }
        }
    }
    if !report.faults.is_empty() {
        let faults: Vec<String> =
            report.faults.iter().map(|(name, count)| format!("{name} {count}")).collect();
        out.line(&format!("faults: {}", faults.join(", ")))?;
    }
    out.gap()?;
    out.table(0, &CHANNELS, &report.quantities.iter().map(quantity).collect::<Vec<_>>())?;
    for channel in report.quantities.iter().filter(|channel| channel.min.is_none()) {
        out.line(&format!("warning: {} never has a value: as if it were not configured", channel.quantity))?;
    }
    let over = |stretch: &[f64; 2]| report.clock.over(*stretch);
    for stretch in &report.standing {
        out.line(&format!("the car stands from {}", over(stretch)))?;
    }
    for channel in &report.quantities {
        for stretch in channel.stuck.iter().filter(|stuck| report.is_while_driving(stuck)) {
            out.line(&format!("warning: {} stands still from {}", channel.quantity, over(stretch)))?;
        }
    }
    Ok(())
}

fn quantity(channel: &ChannelReport) -> Vec<String> {
    vec![
        channel.quantity.to_string(),
        channel.frames.to_string(),
        optional(channel.rate_hz),
        optional(channel.jitter_ms),
        optional(channel.longest_gap_s),
        format!("{:.1}%", 100.0 * channel.batch_stamps),
        format!("{:.1}%", 100.0 * channel.not_available),
        optional(channel.min),
        optional(channel.mean),
        optional(channel.max),
        optional(channel.resolution_seen),
        optional(channel.white_noise_std),
    ]
}

const RELATIONS: [Column; 4] = [
    ("relation (should be 1)", 48, false),
    ("slope", 16, true),
    ("later by, ms", 18, true),
    ("explained", 10, true),
];

fn audit(out: &mut Layout<impl Write>, chain: &ChainReport) -> io::Result<()> {
    out.line(&format!(
        "measurement chain: {:.0} s, {:.0} s of them moving",
        chain.seconds, chain.moving_seconds
    ))?;
    if chain.findings.is_empty() {
        out.line(if chain.compared {
            "  nothing found wrong"
        } else {
            "  nothing could be compared, so nothing is said"
        })?;
    }
    for finding in &chain.findings {
        let confidence = match finding.confidence {
            Confidence::Certain => "CERTAIN",
            Confidence::Likely => "likely",
            Confidence::Unclear => "unclear",
        };
        let value = finding.amount().map_or(String::new(), |amount| format!(" {amount}"));
        out.line(&format!("  {confidence}: {} of {}{value}", finding.effect, finding.channel))?;
        out.line(&format!("    because  {}", finding.evidence))?;
        out.line(&format!("    repair   {}", finding.repair))?;
        if !finding.or.is_empty() {
            out.line(&format!("    or       {}", finding.or.join("; ")))?;
        }
    }
    let pair = |value: Option<f64>, std: Option<f64>, scale: f64, digits: usize| match (value, std) {
        (Some(value), Some(std)) => format!("{:.digits$} ± {:.digits$}", scale * value, scale * std),
        _ => "-".into(),
    };
    let row = |relation: &lab::explain::chain::RelationReport| {
        vec![
            relation.relation.to_string(),
            pair(relation.gain, relation.gain_std, 1.0, 3),
            pair(relation.delay_s, relation.delay_std, 1e3, 1),
            relation.explained.map_or_else(|| "-".into(), |e| format!("{:.0} %", 100.0 * e)),
        ]
    };
    if !chain.relations.is_empty() {
        out.gap()?;
        out.table(2, &RELATIONS, &chain.relations.iter().map(row).collect::<Vec<_>>())?;
    }
    if !chain.offsets.is_empty() {
        out.gap()?;
        out.line("  offsets (the estimators learn them; to take them out, change `offset`)")?;
    }
    for offset in &chain.offsets {
        out.line(&format!(
            "  {:<26} {:>10} ± {:<10} {}",
            offset.channel,
            number(offset.value),
            number(offset.std),
            offset.from
        ))?;
    }
    for unclear in &chain.unclear {
        out.line(&format!("  unclear: {}: {}", unclear.what, unclear.to_do))?;
    }
    Ok(())
}
