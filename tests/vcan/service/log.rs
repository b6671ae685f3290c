//! Records a bus with the kernel's stamps, and hardly disturbs it: frames wait in the socket, and are fetched all together
//! ten times a second, in a process that lets all others go first. (A candump wakes for every frame, and writes a line
//! at once: on one processor with slow system calls that made everybody late.)

use std::path::{Path, PathBuf};
use std::process::Child;
use std::time::Duration;

use gripd::can::candump::Writer;
use gripd::can::{Event, SocketCan, SocketCanConfig};

use super::process::{self, again};
use super::{data, traffic, wait_for};

/// Between two fetches.
const BETWEEN: Duration = Duration::from_millis(100);
/// For half a minute of a busy bus.
const QUEUE_BYTES: usize = 64_000_000;

/// A recording that goes on.
pub struct Log {
    child: Child,
    interface: String,
    file: PathBuf,
}

impl Log {
    pub fn start(interface: &str) -> Self {
        let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{interface}.log"));
        let _ = std::fs::remove_file(&file);
        let child = again(
            &["nice", "-n", "19"],
            "service::log::child::records",
            &[interface, file.to_str().unwrap()],
        );
        let log = Self { child, interface: interface.to_owned(), file };
        wait_for("the recorder's first line", || {
            traffic::send_all(interface, &[data(0x7FF, &[])]);
            std::fs::metadata(&log.file).is_ok_and(|file| file.len() > 0)
        });
        log
    }

    /// Once it has written everything.
    pub fn end(mut self) -> PathBuf {
        // It is in the queue behind all that came before.
        traffic::send_all(&self.interface, &[data(0x7FE, &[])]);
        wait_for("the recorder's last line", || {
            std::thread::sleep(BETWEEN);
            std::fs::read_to_string(&self.file).unwrap().contains(" 7FE#")
        });
        assert!(self.child.try_wait().unwrap().is_none(), "the recorder ended before it should");
        self.file.clone()
    }
}

impl Drop for Log {
    fn drop(&mut self) {
        // What was fetched is in the file.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What tests start, in a process of its own.
mod child {
    use super::*;

    #[test]
    #[ignore = "child: started by the tests of lateness"]
    fn records() {
        let Some([interface, file]) = process::asked() else { return };
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            let mut log = Writer::new(std::fs::File::create(&file).unwrap(), &interface);
            let config = SocketCanConfig::new(interface.parse().unwrap());
            let mut bus =
                SocketCan::open(SocketCanConfig { receive_buffer: Some(QUEUE_BYTES), ..config }).unwrap();
            loop {
                while let Ok(event) = tokio::time::timeout(Duration::ZERO, bus.recv()).await {
                    match event {
                        Event::Frame(frame) => log.write(&frame).unwrap(),
                        Event::Dropped(count) => panic!("{count} frames lost: nothing can be compared"),
                        _ => {}
                    }
                }
                log.flush().unwrap();
                tokio::time::sleep(BETWEEN).await;
            }
        });
    }
}
