//! Watches the service: prints what is published as it comes, and keeps it for the page.

use std::io::{self, BufWriter, Stdout, Write};

use super::row::Row;
use super::terminal;
use bus::can::{Frame, write_line};
use bus::service::Sink;
use bus::signals::publish::Incoming;
use bus::watch::Round;
use physics::{Estimates, Sample};

/// What is written to the standard output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Show {
    /// A line for each second.
    Seconds,
    /// Every frame, as candump writes it.
    Frames,
}

/// The observer of the demo.
pub struct Recorder {
    /// How its frames are read.
    messages: Vec<Incoming>,
    show: Show,
    interface: String,
    output: BufWriter<Stdout>,
    line: Vec<u8>,
    rows: Vec<Row>,
    latest: Estimates,
    next_line_s: f64,
    shown_changes: u32,
    published: u64,
    failure: Option<io::Error>,
}

impl Recorder {
    /// Reads frames as these messages say.
    pub fn new(messages: Vec<Incoming>, show: Show, interface: &str) -> Self {
        Self {
            messages,
            show,
            interface: interface.into(),
            output: BufWriter::new(io::stdout()),
            line: Vec::new(),
            rows: Vec::new(),
            latest: Estimates::default(),
            next_line_s: 0.0,
            shown_changes: 0,
            published: 0,
            failure: None,
        }
    }

    /// All rounds, and the number of frames they came in.
    ///
    /// # Errors
    /// If the standard output failed on the way.
    pub fn finish(mut self) -> io::Result<(Vec<Row>, u64)> {
        self.show_round();
        let flushed = self.output.flush();
        unless_pipe_closed(self.failure.map_or(flushed, Err))?;
        Ok((self.rows, self.published))
    }

    /// The last round is complete when the next one begins.
    fn show_round(&mut self) {
        let Some(row) = self.rows.last() else { return };
        if self.show != Show::Seconds || row.round.time < self.next_line_s {
            return;
        }
        let mut text = String::new();
        if self.next_line_s == 0.0 {
            text += terminal::HEADER;
        }
        text += &terminal::line(&row.round, self.shown_changes);
        self.shown_changes = row.round.surface_changes;
        self.next_line_s = row.round.time.floor() + 1.0;
        self.write(text.as_bytes());
    }

    fn write(&mut self, bytes: &[u8]) {
        if self.failure.is_none()
            && let Err(error) = self.output.write_all(bytes)
        {
            self.failure.get_or_insert(error);
        }
    }
}

impl Sink for Recorder {
    fn estimates(&mut self, _sample: &Sample, estimates: &Estimates) {
        self.latest = *estimates;
    }

    fn publish(&mut self, frame: &Frame) {
        self.published += 1;
        let time = frame.time.seconds();
        if self.rows.last().is_none_or(|row| row.round.time != time) {
            self.show_round();
            let bicycle = self.latest.thesis.lateral_velocities.bicycle.unwrap_or(f64::NAN);
            self.rows.push(Row { round: Round::at(time), bicycle });
        }
        let message = self.messages.iter().find(|message| message.id() == frame.id);
        if let (Some(row), Some(message)) = (self.rows.last_mut(), message) {
            row.round.read(message, frame);
        }
        if self.show == Show::Frames {
            let mut line = std::mem::take(&mut self.line);
            line.clear();
            write_line(&mut line, &self.interface, frame);
            self.write(&line);
            self.line = line;
        }
    }
}

/// A reader that has seen enough, as `head` has, is no failure.
pub fn unless_pipe_closed(written: io::Result<()>) -> io::Result<()> {
    match written {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}
