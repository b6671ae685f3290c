//! The thread that writes recordings: it may wait for the disk as long as it likes.

use std::io::{self, BufWriter, Write};
use std::path::PathBuf;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use flate2::Compression;
use flate2::write::GzEncoder;

use super::folder::{Folder, Names};
use super::ring::{Back, Origin};
use super::{Counts, Trigger, locked};
use crate::can::write_line;
use crate::new_file::{NewFile, Stream};
use crate::service::saved;
use physics::Micros;

/// What it works with.
pub(super) struct Writer {
    pub frames: Back,
    pub triggers: Receiver<Trigger>,
    pub folder: Folder,
    /// Names of the interfaces, as they stand in the lines.
    pub input: String,
    pub output: String,
    pub fingerprint: Arc<Mutex<String>>,
    pub counts: Arc<Counts>,
    /// What came too late for the recording that is written, and has one of its own after it.
    pub left: Option<Trigger>,
}

/// What became of a recording.
struct Written {
    path: PathBuf,
    frames: u64,
    /// All that came while it was written.
    causes: String,
    /// Frames are missing in it: the disk was too slow.
    has_gaps: bool,
}

impl Writer {
    /// From so long before the first cause.
    pub const BEFORE: Micros = Micros::from_millis(20_000);
    /// To so long after the last one.
    pub const AFTER: Micros = Micros::from_millis(10_000);
    /// But no longer than this after the first one; what comes then has a recording of its own.
    const LONGEST: Micros = Micros::from_millis(120_000);
    /// So often it looks for new frames: a small part of what the ring holds, on any bus.
    const PAUSE: Duration = Duration::from_millis(500);
    /// Where the bus is silent, no stamp says that the time is over.
    const SILENCE: Duration = Duration::from_secs(2);

    /// Until the loop ends. Says once that it cannot write and why, and once that it can again.
    pub fn work(mut self) {
        let mut failing = None;
        while let Some(trigger) = self.next() {
            match self.record(&trigger) {
                Ok(written) => {
                    self.counts.written.fetch_add(1, Relaxed);
                    failing = None;
                    let Written { path, frames, causes, has_gaps } = written;
                    tracing::info!("{}: {frames} frames around {causes}", path.display());
                    if has_gaps {
                        tracing::warn!("{}: frames are missing in it, the disk was too slow", path.display());
                    }
                }
                Err(error) => {
                    self.counts.missed.fetch_add(1, Relaxed);
                    if failing.replace(error.kind()) != Some(error.kind()) {
                        tracing::warn!(
                            "service.record_faults: {}: nothing can be recorded there: {error}. The service goes on \
                             without; its user must be able to write into that folder, and the disk must have room",
                            self.folder.path().display()
                        );
                    }
                }
            }
        }
    }

    /// The next cause; `None` at the end of the service.
    fn next(&mut self) -> Option<Trigger> {
        self.left.take().or_else(|| self.triggers.recv().ok())
    }

    fn record(&mut self, first: &Trigger) -> io::Result<Written> {
        let mut causes = first.cause;
        let names = self.folder.next(first.time.0.div_euclid(Micros::PER_SECOND), &causes.word())?;
        self.folder.make_room(0)?;
        let mut recording = Recording::begin(&names)?;
        self.frames.rewind();
        let mut span = Span::around(first.time);
        let mut is_last = false;
        loop {
            let is_over = self.copy(&mut recording, span)?;
            let bytes = recording.bytes();
            self.folder.make_room(bytes)?;
            if is_over || is_last || span.is_over() || bytes > self.folder.limits().bytes {
                break;
            }
            match self.triggers.recv_timeout(Self::PAUSE) {
                Ok(next) => match &mut self.left {
                    Some(left) => left.cause.add(next.cause),
                    None if span.extend(next.time) => causes.add(next.cause),
                    None => self.left = Some(next),
                },
                Err(RecvTimeoutError::Timeout) => {}
                // What came until the end is still there.
                Err(RecvTimeoutError::Disconnected) => is_last = true,
            }
        }
        let Recording { frames, has_gaps, .. } = recording;
        recording.finish()?;
        let state = NewFile::create_private(&names.state)?;
        let fingerprint = locked(&self.fingerprint).clone();
        state.writer()?.write_all(saved::text(&first.learned, &fingerprint)?.as_bytes())?;
        state.commit()?;
        Ok(Written { path: names.recording, frames, causes: causes.to_string(), has_gaps })
    }

    /// Writes what there is; true once what comes is of later.
    fn copy(&mut self, recording: &mut Recording, span: Span) -> io::Result<bool> {
        while let Some((frame, origin, lost)) = self.frames.next() {
            if frame.time < span.from {
                continue;
            }
            if frame.time > span.to {
                // From before a clock was set back by more than that; else it is over.
                if recording.frames == 0 {
                    continue;
                }
                return Ok(true);
            }
            // What was overwritten before the first line was too old anyway, or the lead is shorter.
            recording.has_gaps |= lost && recording.frames > 0;
            let interface = if origin == Origin::Output { &self.output } else { &self.input };
            recording.line.clear();
            write_line(&mut recording.line, interface, &frame);
            recording.packer.write_all(&recording.line)?;
            recording.frames += 1;
        }
        Ok(false)
    }
}

/// What is recorded, in stamps, and when it is over on a bus that has none.
#[derive(Clone, Copy)]
struct Span {
    from: Micros,
    to: Micros,
    latest: Micros,
    deadline: Instant,
}

impl Span {
    fn around(time: Micros) -> Self {
        Self {
            from: time - Writer::BEFORE,
            to: time + Writer::AFTER,
            latest: time + Writer::LONGEST,
            deadline: Self::deadline(),
        }
    }

    /// To this cause's end, too, if that is not too long.
    fn extend(&mut self, time: Micros) -> bool {
        let to = time + Writer::AFTER;
        let is_short = to <= self.latest;
        if is_short {
            self.to = self.to.max(to);
            self.deadline = Self::deadline();
        }
        is_short
    }

    fn deadline() -> Instant {
        Instant::now() + Duration::from_micros(Writer::AFTER.0.unsigned_abs()) + Writer::SILENCE
    }

    fn is_over(&self) -> bool {
        Instant::now() > self.deadline
    }
}

/// A recording under its hidden name.
struct Recording {
    file: NewFile,
    packer: GzEncoder<BufWriter<Stream>>,
    frames: u64,
    has_gaps: bool,
    line: Vec<u8>,
}

impl Recording {
    fn begin(names: &Names) -> io::Result<Self> {
        let file = NewFile::create(&names.recording)?;
        let output = BufWriter::with_capacity(1 << 14, file.stream()?);
        let packer = GzEncoder::new(output, Compression::fast());
        Ok(Self { file, packer, frames: 0, has_gaps: false, line: Vec::new() })
    }

    /// On the disk so far.
    fn bytes(&self) -> u64 {
        self.packer.get_ref().get_ref().written()
    }

    fn finish(self) -> io::Result<()> {
        self.packer.finish()?.flush()?;
        self.file.commit()
    }
}
