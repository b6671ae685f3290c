//! One snapshot as plain text.

use std::io::Write;
use std::time::Duration;

use ratatui::text::Line;
use tokio::time::{Instant, sleep_until};

use super::look::Look;
use super::sections::{Section, Teller};
use crate::cli::Failure;
use crate::cli::desk::watched::Subject;
use bus::watch::{Happening, Watch};
use physics::Micros;

/// Letters in a line.
const WIDTH: usize = 76;
/// So long a bus is listened to if nothing else is said, s.
const LIVE_S: f64 = 3.0;

/// Listens or reads for so many seconds, then prints.
pub async fn run(mut subject: Subject, seconds: Option<f64>) -> Result<(), Failure> {
    subject.at_once();
    let mut source = subject.open()?;
    let (name, driven, is_recording) = (subject.name.clone(), subject.driven(), subject.is_recording());
    let mut watch = subject.watch;
    let deadline = Instant::now() + Duration::from_secs_f64(seconds.unwrap_or(LIVE_S).min(1e9));
    let most = seconds.map(Micros::from_seconds);
    let mut first: Option<Micros> = None;
    let mut broken = None;
    loop {
        let happening = tokio::select! {
            happening = source.next() => happening,
            () = sleep_until(deadline), if !is_recording => break,
        };
        if let Happening::Frame(frame) = &happening {
            let begun = *first.get_or_insert(frame.time);
            if is_recording && most.is_some_and(|most| frame.time - begun > most) {
                break;
            }
        }
        watch.take(&happening, source.now());
        match happening {
            Happening::Over => break,
            Happening::Failed(reason) => {
                broken = Some(reason);
                break;
            }
            _ => {}
        }
    }
    if let Some(now) = source.now().filter(|_| !is_recording) {
        watch.advance(now);
    }
    let teller = Teller { watch: &watch, name: &name, driven: &driven, look: Look::new(false), width: WIDTH };
    std::io::stdout().write_all(text(&teller).as_bytes())?;
    match broken {
        Some(reason) => Err(Failure::work(reason)),
        None if was_heard(&watch) => Ok(()),
        None => Err(Failure::work(format_args!(
            "{name}: none of the {} identifiers came that the configuration needs or publishes; is it this car's bus?",
            watch.ids().len()
        ))),
    }
}

fn was_heard(watch: &Watch) -> bool {
    watch.traffic().iter().any(|traffic| traffic.frames() > 0)
        || watch.messages().any(|(heard, _)| heard.traffic().frames() > 0)
}

/// All sections, one below the other.
pub fn text(teller: &Teller) -> String {
    let mut text = String::new();
    for line in teller.header() {
        text += &plain(&line);
    }
    let sections = [
        teller.friction(),
        teller.slope(),
        teller.cornering(),
        teller.motion(),
        teller.state(),
        teller.inputs(),
        teller.traffic(),
        teller.published(true),
    ];
    for Section { title, detail, mark, lines } in sections {
        let mark = mark.map_or(String::new(), |(_, mark)| format!(": {mark}"));
        let detail = if detail.is_empty() { String::new() } else { format!(" ({detail})") };
        text += &format!("\n{title}{detail}{mark}\n");
        for line in &lines {
            text += "  ";
            text += &plain(line);
        }
    }
    text
}

fn plain(line: &Line) -> String {
    let text: String = line.spans.iter().map(|span| span.content.as_ref()).collect();
    format!("{}\n", text.trim_end())
}
