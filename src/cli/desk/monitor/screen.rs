//! The terminal, taken over and given back as it was, whatever happens.

use std::io::{self, IsTerminal, Stdout, Write};
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};

use crossterm::cursor::{Hide, Show};
use crossterm::execute;
use crossterm::terminal::{EnterAlternateScreen, LeaveAlternateScreen, disable_raw_mode, enable_raw_mode};
use ratatui::Terminal;
use ratatui::backend::CrosstermBackend;

/// Is it ours at the moment?
static TAKEN: AtomicBool = AtomicBool::new(false);

/// A terminal that is ours until this is dropped.
pub struct Screen {
    /// To draw on.
    pub terminal: Terminal<CrosstermBackend<Stdout>>,
}

impl Screen {
    /// Takes it.
    ///
    /// # Errors
    /// If the terminal does not let itself be taken; then it is as it was.
    pub fn take() -> io::Result<Self> {
        static HOOK: Once = Once::new();
        // What a panic says must be seen, and the terminal be usable after it.
        HOOK.call_once(|| {
            let before = std::panic::take_hook();
            std::panic::set_hook(Box::new(move |panic| {
                give_back();
                before(panic);
            }));
        });
        TAKEN.store(true, SeqCst);
        let taken = enable_raw_mode().and_then(|()| execute!(io::stdout(), EnterAlternateScreen, Hide));
        match taken.and_then(|()| Terminal::new(CrosstermBackend::new(io::stdout()))) {
            Ok(terminal) => Ok(Self { terminal }),
            Err(error) => {
                give_back();
                Err(error)
            }
        }
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        give_back();
    }
}

/// Where the log goes: not onto the terminal while it shows a picture.
pub fn stderr() -> Box<dyn Write> {
    if TAKEN.load(SeqCst) && io::stderr().is_terminal() {
        Box::new(io::sink())
    } else {
        Box::new(io::stderr())
    }
}

/// Once, and as far as it goes: of a terminal that has gone there is nothing to give back.
fn give_back() {
    if TAKEN.swap(false, SeqCst) {
        let mut stdout = io::stdout();
        let _ = execute!(stdout, LeaveAlternateScreen, Show);
        let _ = stdout.flush();
        let _ = disable_raw_mode();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::{Command, Stdio};

    /// In a terminal of its own.
    #[test]
    fn after_a_panic_the_terminal_is_as_it_was() {
        let program = std::env::current_exe().unwrap();
        let falls = "cli::desk::monitor::screen::tests::child::panics_with_the_screen_taken";
        let line = format!(
            "stty rows 24 cols 80; stty -g; {} --ignored --exact --nocapture {falls}; stty -g",
            program.display()
        );
        let output = Command::new("script").args(["-qec", &line, "/dev/null"]).stdin(Stdio::null()).output();
        let Ok(output) = output else { return println!("skipped: there is no script(1) here") };
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(text.contains("tottering") && text.contains("fallen on purpose"), "{text}");
        let (picture, after) = text.split_once("\x1b[?1049l").unwrap();
        assert!(picture.contains("\x1b[?1049h") && picture.contains("tottering"), "{text}");
        assert!(after.contains("fallen on purpose"), "what it says must be seen afterwards: {text}");
        assert!(after.contains("\x1b[?25h"), "the cursor stays hidden: {text}");
        let settings: Vec<&str> =
            text.lines().filter(|line| line.matches(':').count() > 25).map(str::trim).collect();
        assert_eq!(settings.len(), 2, "{text}");
        assert_eq!(settings[0], settings[1]);
    }

    mod child {
        use super::*;

        #[test]
        #[ignore = "child: is a part of the test above, and panics"]
        fn panics_with_the_screen_taken() {
            let mut screen = Screen::take().unwrap();
            screen.terminal.draw(|frame| frame.render_widget("tottering", frame.area())).unwrap();
            panic!("fallen on purpose");
        }
    }
}
