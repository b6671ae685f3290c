//! A signal that ends the program also removes what it had begun to write.

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use signal_hook::low_level::emulate_default_handler;

use bus::new_file;

/// Waits for signals from now on, on a thread of its own. Without it they end the program all the same, and what was
/// begun stays under its hidden name.
pub fn tidies_up() {
    let ignored = ignored();
    // As `nohup`, or a shell for what it runs in the background, asked for.
    let heard = [SIGHUP, SIGINT, SIGTERM].into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0);
    let Ok(mut signals) = Signals::new(heard) else { return };
    let wait = move || {
        for signal in &mut signals {
            new_file::abandon_all();
            // The shell is to see what ended it.
            let _ = emulate_default_handler(signal);
        }
    };
    let _ = std::thread::Builder::new().name("signals".into()).spawn(wait);
}

/// Signals that this process was started to ignore: signal n at bit n − 1, as the kernel tells.
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}
