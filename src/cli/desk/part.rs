//! `--from` and `--to`: a part of a recording, by either of its clocks.

use std::fmt;
use std::ops::Deref;
use std::path::Path;

use bus::can::Frame;
use bus::can::recording::{LogError, Reader};
use clap::Args;
use physics::Micros;
use physics::time::{Clock, Moment};

use super::Failure;

/// Which part of the recordings is asked for.
#[derive(Args, Clone, Default)]
pub struct Part {
    /// Only what is then or later: seconds after the first frame, or a time in UTC (2025-10-09T08:53:20.123Z).
    #[arg(long, value_name = "S|TIME")]
    from: Option<Box<str>>,
    /// Only what is then or earlier: seconds after the first frame, or a time in UTC.
    #[arg(long, value_name = "S|TIME")]
    to: Option<Box<str>>,
}

/// From when to when, as far as either is asked for.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ends {
    /// Not before that.
    pub from: Option<Moment>,
    /// Not after that.
    pub to: Option<Moment>,
}

impl Part {
    /// As the options say it.
    pub fn new(from: Option<&str>, to: Option<&str>) -> Self {
        Self { from: from.map(Into::into), to: to.map(Into::into) }
    }

    /// From when to when. What is asked wrongly is told with the span of this recording.
    pub fn ends(&self, path: &Path) -> Result<Ends, Failure> {
        let wrong = |option: &str, text: &str, why: &dyn fmt::Display| {
            let span = span(path).map_or_else(String::new, |span| format!("; {span}"));
            Failure::usage(format_args!("{option} {text}: {why}{span}"))
        };
        let moment = |option: &str, text: &Option<Box<str>>| match text.as_deref().map(str::parse::<Moment>) {
            None => Ok(None),
            Some(Ok(Moment::After(seconds))) if seconds < 0.0 => {
                Err(wrong(option, text.as_deref().unwrap_or_default(), &"must be zero or more seconds"))
            }
            Some(Ok(moment)) => Ok(Some(moment)),
            Some(Err(why)) => Err(wrong(option, text.as_deref().unwrap_or_default(), &why)),
        };
        let ends = Ends { from: moment("--from", &self.from)?, to: moment("--to", &self.to)? };
        let is_turned = match (ends.from.unwrap_or(Moment::After(0.0)), ends.to) {
            (Moment::After(from), Some(Moment::After(to))) => to <= from,
            (Moment::At(from), Some(Moment::At(to))) => to <= from,
            // Which of them is the later one is known when the recording begins.
            _ => false,
        };
        match (&self.from, &self.to) {
            (from, Some(to)) if is_turned => {
                let from = from.as_deref().unwrap_or("0 s");
                Err(wrong("--to", to, &format_args!("must be more than --from, which is {from}")))
            }
            _ => Ok(ends),
        }
    }

    /// Opens a recording, of which only the part is delivered.
    pub fn open(&self, path: &Path) -> Result<PartReader, Failure> {
        let ends = self.ends(path)?;
        let reader = Reader::open(path).map_err(Failure::work)?;
        Ok(PartReader { reader, ends, start: None, is_any_within: false })
    }
}

/// From when to when a recording is, by its clocks; nothing where it cannot be read.
fn span(path: &Path) -> Option<String> {
    let mut reader = Reader::open(path).ok()?;
    let first = reader.next_frame().ok()??.time;
    let last = last_of(&mut reader, first);
    Some(over(reader.name(), first, last))
}

fn last_of(reader: &mut Reader, mut last: Micros) -> Micros {
    while let Ok(Some(frame)) = reader.next_frame() {
        last = last.max(frame.time);
    }
    last
}

fn over(name: &str, first: Micros, last: Micros) -> String {
    format!("{name} is of {}", Clock::of(first).over([0.0, (last - first).seconds()]))
}

/// Why no more of a part can be read.
#[derive(Debug)]
pub enum PartError {
    /// The recording is broken.
    Log(LogError),
    /// Nothing of it is in the part.
    Nothing(String),
}

impl fmt::Display for PartError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Log(error) => error.fmt(f),
            Self::Nothing(why) => f.write_str(why),
        }
    }
}

impl From<PartError> for Failure {
    fn from(error: PartError) -> Self {
        match error {
            PartError::Log(error) => error.into(),
            PartError::Nothing(why) => Self::work(why),
        }
    }
}

impl From<LogError> for PartError {
    fn from(error: LogError) -> Self {
        Self::Log(error)
    }
}

/// A part of a recording.
pub struct PartReader {
    reader: Reader,
    ends: Ends,
    /// The time of the recording's first frame.
    start: Option<Micros>,
    is_any_within: bool,
}

impl PartReader {
    /// The next frame of the part; none at its end.
    ///
    /// # Errors
    /// Those of the recording, and that nothing of it is in the part.
    pub fn next_frame(&mut self) -> Result<Option<Frame>, PartError> {
        let mut latest = Micros(i64::MIN);
        while let Some(frame) = self.reader.next_frame()? {
            latest = latest.max(frame.time);
            let start = *self.start.get_or_insert(frame.time);
            let at = (frame.time - start).seconds();
            if self.ends.to.is_some_and(|to| at > to.seconds(start)) {
                break;
            }
            // Where clocks are set back, frames are earlier than the first one: without --from they belong to all of it.
            if self.ends.from.is_none_or(|from| at >= from.seconds(start)) {
                self.is_any_within = true;
                return Ok(Some(frame));
            }
        }
        match self.start {
            Some(start) if !self.is_any_within => {
                let last = last_of(&mut self.reader, latest);
                let span = over(self.reader.name(), start, last);
                Err(PartError::Nothing(format!("nothing is between --from and --to: {span}")))
            }
            _ => Ok(None),
        }
    }

    /// Its two clocks, when a frame has come.
    pub fn clock(&self) -> Clock {
        Clock::of(self.start.unwrap_or_default())
    }

    /// From where on its seconds are counted, if that is not the first frame that is used.
    pub fn counted_from(&self) -> Option<Micros> {
        self.start.filter(|_| self.ends.from.is_some_and(|from| from != Moment::After(0.0)))
    }
}

impl Deref for PartReader {
    type Target = Reader;

    fn deref(&self) -> &Reader {
        &self.reader
    }
}
