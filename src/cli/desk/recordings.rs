//! What there is to say of a recording that was read, or written.

use std::path::Path;

use super::Failure;
use bus::can::recording::{Format, Reader, Written};

/// The format that a name asks for: a candump log where it has no ending, or is no file's name. `or` is what else the command
/// could be told.
///
/// # Errors
/// An ending that no format has: what it was meant to be, nobody knows.
pub fn format_of(path: &Path, or: &str) -> Result<Format, Failure> {
    let unpacked = match path.extension().and_then(|end| end.to_str()) {
        Some("gz" | "zst") => path.with_extension(""),
        _ => path.to_owned(),
    };
    let Some(ending) = unpacked.extension() else { return Ok(Format::Candump) };
    Format::of_name(path).ok_or_else(|| {
        Failure::usage(format_args!(
            "{}: no format ends in .{}; name it .log (candump), .asc, .blf, .mf4, .trc or .csv{or}",
            path.display(),
            ending.to_string_lossy()
        ))
    })
}

/// Warns of what was damaged, lost or out of order.
pub fn warn(reader: &Reader) {
    let (name, stats, part) = (reader.name(), reader.stats(), reader.format().part());
    for skipped in stats.first_skipped.iter().take(3) {
        match part {
            "line" => {
                tracing::warn!("{name}:{}: {}; the line is skipped", skipped.line, skipped.reason);
            }
            _ => tracing::warn!("{name}: {part} {}: {}; it is skipped", skipped.line, skipped.reason),
        }
    }
    if stats.skipped_lines > 3 {
        tracing::warn!("{name}: {} {part}s skipped in all", stats.skipped_lines);
    }
    if let Some(line) = stats.first_backwards {
        match part {
            "line" => tracing::warn!("{name}:{line}: time runs backwards ({} times)", stats.time_backwards),
            _ => {
                tracing::warn!("{name}: {part} {line}: time runs backwards ({} times)", stats.time_backwards)
            }
        }
    }
    if stats.dropped > 0 {
        tracing::warn!("{name}: the recorder dropped {} frames", stats.dropped);
    }
}

/// Nothing but damage was found.
pub fn nothing_in(reader: &Reader) -> String {
    let (name, format) = (reader.name(), reader.format());
    if format == Format::Candump {
        // What nothing else fits is taken for this.
        return format!("{name}: no line is a candump line; is it a recording of `candump -L`?");
    }
    format!("{name}: nothing in this {format} recording is a frame; was it written by {format}'s own tools?")
}

/// What a format could not hold of what was to be written.
pub fn tell_losses(path: &Path, format: Format, written: &Written) {
    let path = path.display();
    for (loss, count) in &written.losses {
        tracing::warn!("{path}: {format}: {count} of {} frames {loss}", written.frames);
    }
    for (name, other) in &written.renamed {
        tracing::info!("{path}: {format} has no names of interfaces: {name} is read back as {other}");
    }
}
