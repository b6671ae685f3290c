//! A session at the terminal: what happens, what is pressed, what is drawn.

use std::future::poll_fn;
use std::io;
use std::pin::Pin;
use std::time::Duration;

use crossterm::event::{Event, EventStream, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use futures_core::Stream;
use tokio::signal::unix::{SignalKind, signal};
use tokio::time::{MissedTickBehavior, interval};

use super::draw::{Mode, draw};
use super::look::Look;
use super::screen::Screen;
use super::sections::Teller;
use crate::cli::Failure;
use crate::cli::desk::watched::Subject;
use bus::watch::{Estimator, Happening, Source, Watch};
use physics::{Micros, Wheel};

/// Time between two pictures.
const PICTURE: Duration = Duration::from_millis(100);

/// Watches until told to end.
pub async fn run(subject: Subject, look: Look) -> Result<(), Failure> {
    let mut interrupt = signal(SignalKind::interrupt()).map_err(Failure::work)?;
    let mut terminate = signal(SignalKind::terminate()).map_err(Failure::work)?;
    let mut hangup = signal(SignalKind::hangup()).map_err(Failure::work)?;
    let mut source = subject.open()?;
    let driven = subject.driven();
    let mut screen = Screen::take()
        .map_err(|error| Failure::work(format_args!("cannot use the terminal: {error}; try --once")))?;
    let mut session = Session {
        watch: subject.watch,
        frozen: None,
        name: subject.name,
        driven,
        look,
        mode: Mode::default(),
        note: None,
    };
    let mut keys = Keys { events: Some(EventStream::new()) };
    let mut pictures = interval(PICTURE);
    pictures.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        tokio::select! {
            biased;
            _ = interrupt.recv() => break,
            _ = terminate.recv() => break,
            _ = hangup.recv() => break,
            event = keys.next() => {
                match event {
                    Event::Key(key) if session.press(key, &mut source) == Pressed::Quit => break,
                    // A new size, above all: at once.
                    _ => session.draw(&mut screen)?,
                }
            }
            _ = pictures.tick() => {
                session.advance(&source);
                session.draw(&mut screen)?;
            }
            happening = source.next(), if !session.mode.over => {
                session.take(&happening, source.now());
            }
        }
    }
    Ok(())
}

#[derive(PartialEq, Eq)]
enum Pressed {
    GoOn,
    Quit,
}

struct Session {
    watch: Watch,
    /// While paused: what is shown, while the other one goes on.
    frozen: Option<Box<Watch>>,
    name: String,
    driven: Vec<Wheel>,
    look: Look,
    mode: Mode,
    note: Option<String>,
}

impl Session {
    fn take(&mut self, happening: &Happening, now: Option<Micros>) {
        self.watch.take(happening, now);
        match happening {
            Happening::Over => self.mode.over = true,
            Happening::Failed(reason) => {
                self.mode.over = true;
                self.note = Some(reason.clone());
            }
            _ => {}
        }
    }

    fn advance(&mut self, source: &Source) {
        if let Some(now) = source.now() {
            self.watch.advance(now);
        }
    }

    fn press(&mut self, key: KeyEvent, source: &mut Source) -> Pressed {
        if key.kind == KeyEventKind::Release {
            return Pressed::GoOn;
        }
        match key.code {
            KeyCode::Char('c' | 'd') if key.modifiers.contains(KeyModifiers::CONTROL) => {
                return Pressed::Quit;
            }
            KeyCode::Esc if self.mode.help => self.mode.help = false,
            KeyCode::Char('q') | KeyCode::Esc => return Pressed::Quit,
            KeyCode::Char('?' | 'h') => self.mode.help = !self.mode.help,
            KeyCode::Char('p' | ' ') => {
                self.mode.paused = !self.mode.paused;
                self.frozen = self.mode.paused.then(|| Box::new(self.watch.clone()));
                // A bus goes on; of a recording nothing is to be missed.
                if let Source::Recording(playback) = source {
                    playback.pause(self.mode.paused);
                }
            }
            KeyCode::Char('e') => {
                let other = match self.watch.estimator() {
                    Estimator::Bus => Estimator::Own,
                    Estimator::Own => Estimator::Bus,
                };
                for watch in [Some(&mut self.watch), self.frozen.as_deref_mut()].into_iter().flatten() {
                    watch.set_estimator(other);
                }
            }
            _ => {}
        }
        Pressed::GoOn
    }

    fn draw(&self, screen: &mut Screen) -> Result<(), Failure> {
        let teller = Teller {
            watch: self.frozen.as_deref().unwrap_or(&self.watch),
            name: &self.name,
            driven: &self.driven,
            look: self.look,
            width: 0,
        };
        let drawn = screen.terminal.draw(|frame| draw(frame, &teller, self.mode, self.note.as_deref()));
        drawn
            .map(drop)
            .map_err(|error: io::Error| Failure::work(format_args!("cannot write on the terminal: {error}")))
    }
}

/// What is pressed, as long as there is something to press it on.
struct Keys {
    events: Option<EventStream>,
}

impl Keys {
    /// Cancel-safe.
    async fn next(&mut self) -> Event {
        if let Some(events) = &mut self.events
            && let Some(Ok(event)) = poll_fn(|context| Pin::new(&mut *events).poll_next(context)).await
        {
            return event;
        }
        // Without keys there are still signals.
        self.events = None;
        std::future::pending().await
    }
}
