//! The report as people read it.

use std::io::{self, Write};

use super::Report;
use super::configuration::ConfigurationReport;
use super::recording::{ChannelReport, RecordingReport};
use lab::explain::chain::{ChainReport, Confidence};

/// Writes everything.
pub fn write(out: &mut impl Write, report: &Report) -> io::Result<()> {
    configuration(out, &report.configuration)?;
    if let Some(recordings) = &report.recordings {
        writeln!(out)?;
        recording(out, recordings)?;
    }
    if let Some(chain) = &report.chain {
        writeln!(out)?;
        audit(out, chain)?;
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

fn configuration(out: &mut impl Write, report: &ConfigurationReport) -> io::Result<()> {
    writeln!(out, "configuration {}: usable; interface {}", report.file, report.interface)?;
    writeln!(
        out,
        "\n{:<26} {:<40} {:>10}  {:<28} {:>10}  {:<22} {:>6} {:>8}  checks",
        "quantity", "signal", "id", "unit", "one step", "range, SI", "late", "time-out"
    )?;
    for q in &report.quantities {
        let unit = format!(
            "{} x {} = {}",
            if q.unit.is_empty() { "1" } else { &q.unit },
            number(q.to_si),
            q.si_unit
        );
        let range = format!(
            "{} … {}",
            number(q.carried[0].max(q.plausible[0])),
            number(q.carried[1].min(q.plausible[1]))
        );
        let checks = match (q.counter, q.checksum) {
            (true, true) => "counter, checksum",
            (true, false) => "counter",
            (false, true) => "checksum",
            (false, false) => "none",
        };
        writeln!(
            out,
            "{:<26} {:<40} {:>10}  {:<28} {:>10}  {:<22} {:>3} ms {:>5} ms  {checks}",
            q.quantity,
            q.source,
            q.id,
            unit,
            number(q.resolution),
            range,
            q.delay_ms,
            q.timeout_ms
        )?;
    }
    if !report.missing.is_empty() {
        writeln!(out, "\nnot configured:")?;
        for missing in &report.missing {
            writeln!(out, "  {:<26} {}", missing.quantity, missing.cost)?;
        }
    }
    for warning in &report.mapping_warnings {
        writeln!(out, "\n{warning}")?;
    }
    for warning in &report.dbc_warnings {
        writeln!(out, "\nDBC: {warning}")?;
    }
    if let Some(first) = &report.first_other_dbc_warning {
        let count = report.other_dbc_warnings;
        writeln!(out, "\nDBC: {count} warnings about messages that are not needed, the first: {first}")?;
    }
    for warning in &report.publish_warnings {
        writeln!(out, "output DBC: {warning}")?;
    }
    if report.published.is_empty() {
        writeln!(out, "\npublished: nothing")?;
    } else {
        writeln!(out, "\npublished every {} ms:", report.publish_period_ms)?;
        for frame in &report.published {
            writeln!(out, "  {:>10}  {}", frame.id, frame.message)?;
        }
    }
    if !report.vehicle_defaults.is_empty() {
        writeln!(out, "\n[vehicle] not given, so taken as:")?;
        for default in &report.vehicle_defaults {
            writeln!(out, "  {:<30} {} ± {}", default.key, number(default.value), number(default.std))?;
        }
    }
    Ok(())
}

fn recording(out: &mut impl Write, report: &RecordingReport) -> io::Result<()> {
    for file in &report.files {
        writeln!(
            out,
            "recording {} ({}): {:.1} s, {} frames, {} lines skipped, {} times backwards, {} dropped by the \
             recorder",
            file.file,
            file.format,
            file.seconds,
            file.frames,
            file.skipped_lines,
            file.time_backwards,
            file.dropped
        )?;
        for line in &file.first_skipped {
            writeln!(out, "  line {line}")?;
        }
        if let Some(broken) = &file.broken {
            writeln!(out, "  broken: {broken}")?;
        }
    }
    writeln!(
        out,
        "{} frames of {} identifiers are not needed; {:.1} % of all frames bear the stamp of the one before; \
         {} samples made",
        report.unneeded_frames,
        report.unneeded_ids,
        100.0 * report.batch_stamps,
        report.samples
    )?;
    for message in &report.messages {
        if message.frames == 0 {
            writeln!(out, "warning: {} ({}) never comes", message.message, message.id)?;
        }
        for (count, what) in [
            (message.wrong_frames, "too short or of the wrong kind"),
            (message.checksum_failures, "with a wrong checksum"),
            (message.counter_repeats, "repeated by their counter"),
        ] {
            if count > 0 {
                let of = message.frames;
                writeln!(
                    out,
                    "warning: {} ({}): {count} of {of} frames {what}",
                    message.message, message.id
                )?;
            }
        }
    }
    if !report.faults.is_empty() {
        let faults: Vec<String> =
            report.faults.iter().map(|(name, count)| format!("{name} {count}")).collect();
        writeln!(out, "faults: {}", faults.join(", "))?;
    }
    writeln!(
        out,
        "\n{:<26} {:>8} {:>8} {:>9} {:>9} {:>7} {:>7} {:>10} {:>10} {:>10} {:>10} {:>10}",
        "quantity",
        "frames",
        "rate/Hz",
        "jitter/ms",
        "gap/s",
        "batch",
        "absent",
        "min",
        "mean",
        "max",
        "step",
        "noise"
    )?;
    for channel in &report.quantities {
        quantity(out, channel)?;
    }
    for channel in report.quantities.iter().filter(|channel| channel.min.is_none()) {
        writeln!(out, "warning: {} never has a value: as if it were not configured", channel.quantity)?;
    }
    for channel in &report.quantities {
        for [from, to] in &channel.stuck {
            writeln!(out, "warning: {} stands still from {from:.1} s to {to:.1} s", channel.quantity)?;
        }
    }
    Ok(())
}

fn quantity(out: &mut impl Write, channel: &ChannelReport) -> io::Result<()> {
    writeln!(
        out,
        "{:<26} {:>8} {:>8} {:>9} {:>9} {:>6.1}% {:>6.1}% {:>10} {:>10} {:>10} {:>10} {:>10}",
        channel.quantity,
        channel.frames,
        optional(channel.rate_hz),
        optional(channel.jitter_ms),
        optional(channel.longest_gap_s),
        100.0 * channel.batch_stamps,
        100.0 * channel.not_available,
        optional(channel.min),
        optional(channel.mean),
        optional(channel.max),
        optional(channel.resolution_seen),
        optional(channel.white_noise_std)
    )
}

fn audit(out: &mut impl Write, chain: &ChainReport) -> io::Result<()> {
    writeln!(out, "measurement chain: {:.0} s, {:.0} s of them moving", chain.seconds, chain.moving_seconds)?;
    if chain.findings.is_empty() {
        let words = if chain.compared {
            "nothing found wrong"
        } else {
            "nothing could be compared, so nothing is said"
        };
        writeln!(out, "  {words}")?;
    }
    for finding in &chain.findings {
        let confidence = match finding.confidence {
            Confidence::Certain => "CERTAIN",
            Confidence::Likely => "likely",
            Confidence::Unclear => "unclear",
        };
        let value = finding.amount().map_or(String::new(), |amount| format!(" {amount}"));
        writeln!(out, "  {confidence}: {} of {}{value}", finding.effect, finding.channel)?;
        writeln!(out, "    because  {}", finding.evidence)?;
        writeln!(out, "    repair   {}", finding.repair)?;
        if !finding.or.is_empty() {
            writeln!(out, "    or       {}", finding.or.join("; "))?;
        }
    }
    if !chain.relations.is_empty() {
        writeln!(
            out,
            "\n  {:<50} {:>18} {:>20} {:>10}",
            "relation (should be 1)", "slope", "later by, ms", "explained"
        )?;
    }
    for relation in &chain.relations {
        let pair = |value: Option<f64>, std: Option<f64>, scale: f64, digits: usize| match (value, std) {
            (Some(value), Some(std)) => format!("{:.digits$} ± {:.digits$}", scale * value, scale * std),
            _ => "-".into(),
        };
        writeln!(
            out,
            "  {:<50} {:>18} {:>20} {:>10}",
            relation.relation,
            pair(relation.gain, relation.gain_std, 1.0, 3),
            pair(relation.delay_s, relation.delay_std, 1e3, 1),
            relation.explained.map_or_else(|| "-".into(), |e| format!("{:.0} %", 100.0 * e))
        )?;
    }
    if !chain.offsets.is_empty() {
        writeln!(out, "\n  offsets (the estimators learn them; to take them out, change `offset`)")?;
    }
    for offset in &chain.offsets {
        writeln!(
            out,
            "  {:<26} {:>10} ± {:<10} {}",
            offset.channel,
            number(offset.value),
            number(offset.std),
            offset.from
        )?;
    }
    for unclear in &chain.unclear {
        writeln!(out, "  unclear: {}: {}", unclear.what, unclear.to_do)?;
    }
    Ok(())
}
