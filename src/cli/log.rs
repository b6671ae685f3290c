//! The log of a service: lines go through a thread of their own, so that whoever reads them, or does not, never
//! makes a frame wait.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;
use std::time::Duration;

use tracing_subscriber::fmt::MakeWriter;

/// Takes lines and hands them on; what does not fit because nobody reads is counted and said later.
#[derive(Clone, Debug)]
pub struct Log {
    lines: SyncSender<Entry>,
    lost: Arc<AtomicU64>,
}

#[derive(Debug)]
enum Entry {
    Line(Vec<u8>),
    /// Everything before it is written: the answer says so.
    Flush(SyncSender<()>),
}

impl Log {
    /// Lines that wait at most: some 100 KiB.
    const WAITING: usize = 1000;
    /// So long the end of the service waits for the reader of its last lines.
    const PATIENCE: Duration = Duration::from_millis(300);

    /// Starts the thread; `None` if it cannot be had.
    pub fn start() -> Option<Self> {
        let (lines, waiting) = sync_channel(Self::WAITING);
        let lost = Arc::new(AtomicU64::new(0));
        let of_thread = Arc::clone(&lost);
        thread::Builder::new().name("log".into()).spawn(move || write(&waiting, &of_thread)).ok()?;
        Some(Self { lines, lost })
    }

    /// Waits until all lines are written, but not for ever.
    pub fn flush(&self) {
        let (written, answer) = sync_channel(1);
        if self.lines.try_send(Entry::Flush(written)).is_ok() {
            let _ = answer.recv_timeout(Self::PATIENCE);
        }
    }
}

fn write(waiting: &Receiver<Entry>, lost: &AtomicU64) {
    let mut stderr = io::stderr();
    // Where nobody is at the other end any more, lines go nowhere.
    while let Ok(entry) = waiting.recv() {
        match entry {
            Entry::Line(line) => drop(stderr.write_all(&line)),
            Entry::Flush(written) => drop(written.try_send(())),
        }
        let lost = lost.swap(0, Relaxed);
        if lost > 0 {
            let _ = writeln!(stderr, "{lost} lines of the log were lost: nobody read them in time");
        }
    }
}

/// One line on its way.
impl Write for Log {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        if self.lines.try_send(Entry::Line(line.to_vec())).is_err() {
            self.lost.fetch_add(1, Relaxed);
        }
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl<'a> MakeWriter<'a> for Log {
    type Writer = Self;

    fn make_writer(&'a self) -> Self {
        self.clone()
    }
}
