//! A recording that is played in its own time, faster, or as fast as it can be read.

use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use tokio::sync::mpsc;
use tokio::time::{Instant, sleep_until};

use super::Happening;
use crate::can::Frame;
use crate::can::recording::{LogError, Reader};
use physics::Micros;

/// How fast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// So many times as fast as it was.
    Times(f64),
    /// Without waiting.
    AtOnce,
}

/// Reads a recording, in a thread of its own: a pipe may be slow, and nobody is to wait for it.
pub struct Playback {
    frames: mpsc::Receiver<Result<Frame, String>>,
    pace: Pace,
    /// What comes next, until its time has come.
    waiting: Option<Frame>,
    /// Time of the frame that was handed out last.
    last: Option<Micros>,
    /// A moment, and what the recording's clock showed then.
    anchor: Option<(Instant, Micros)>,
    paused: Option<Instant>,
    over: bool,
}

impl Playback {
    /// Frames that are read ahead.
    const AHEAD: usize = 1024;
    /// A pause of the recording is played as at most this, s.
    const LONGEST_PAUSE: f64 = 5.0;

    /// Opens the recording; `-` is the standard input.
    ///
    /// # Errors
    /// If it cannot be opened or is evidently none.
    pub fn open(path: PathBuf, pace: Pace) -> Result<Self, LogError> {
        let mut reader = Reader::open(&path)?;
        let (sender, frames) = mpsc::channel(Self::AHEAD);
        let read = move || {
            loop {
                let item = match reader.next_frame() {
                    Ok(Some(frame)) => Ok(frame),
                    Ok(None) if reader.stats().frames == 0 => {
                        Err(format!("{}: there is no frame in it", reader.name()))
                    }
                    Ok(None) => break,
                    Err(error) => Err(error.to_string()),
                };
                let failed = item.is_err();
                // Whoever listened has gone.
                if sender.blocking_send(item).is_err() || failed {
                    break;
                }
            }
        };
        let name = path.display().to_string();
        thread::Builder::new()
            .name("recording".into())
            .spawn(read)
            .map_err(|source| LogError::Open { name, source })?;
        Ok(Self { frames, pace, waiting: None, last: None, anchor: None, paused: None, over: false })
    }

    /// Stops or goes on.
    pub fn pause(&mut self, pause: bool) {
        match (pause, self.paused) {
            (true, None) => self.paused = Some(Instant::now()),
            (false, Some(since)) => {
                self.paused = None;
                if let Some((at, _)) = &mut self.anchor {
                    *at += since.elapsed();
                }
            }
            _ => {}
        }
    }

    /// What its clock shows: never beyond a frame that has not been handed out.
    pub fn now(&self) -> Option<Micros> {
        let last = self.last?;
        let (Pace::Times(speed), Some((at, time))) = (self.pace, self.anchor) else { return Some(last) };
        if self.over {
            return Some(last);
        }
        let elapsed = self.paused.unwrap_or_else(Instant::now).saturating_duration_since(at);
        let shown = time + Micros::from_seconds(elapsed.as_secs_f64() * speed);
        let most = self.waiting.map_or(last, |frame| frame.time);
        Some(if most < last { last } else { shown.clamp(last, most) })
    }

    /// As [`Source::next`](super::Source::next).
    pub(super) async fn next(&mut self) -> Happening {
        loop {
            if self.over || self.paused.is_some() {
                return std::future::pending().await;
            }
            if let Some(frame) = self.waiting {
                if let Some(due) = self.due(frame.time) {
                    sleep_until(due).await;
                }
                self.waiting = None;
                self.last = Some(frame.time);
                return Happening::Frame(frame);
            }
            match self.frames.recv().await {
                Some(Ok(frame)) => self.waiting = Some(frame),
                Some(Err(reason)) => {
                    self.over = true;
                    return Happening::Failed(reason);
                }
                None => {
                    self.over = true;
                    return Happening::Over;
                }
            }
        }
    }

    /// When this time of the recording comes; `None`: it has come.
    fn due(&mut self, time: Micros) -> Option<Instant> {
        let Pace::Times(speed) = self.pace else { return None };
        let now = Instant::now();
        let (at, shown) = *self.anchor.get_or_insert((now, time));
        let after = (time - shown).seconds() / speed;
        let ahead = after - now.saturating_duration_since(at).as_secs_f64();
        if ahead > Self::LONGEST_PAUSE {
            // The rest of the pause is left out.
            let due = now + Duration::from_secs_f64(Self::LONGEST_PAUSE);
            self.anchor = Some((due, time));
            return Some(due);
        }
        if ahead < -Self::LONGEST_PAUSE {
            self.anchor = Some((now, time));
        }
        (ahead > 0.0).then(|| now + Duration::from_secs_f64(ahead))
    }
}
