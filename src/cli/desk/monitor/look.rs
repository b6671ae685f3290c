//! How things look, with and without colours.

use std::ffi::OsStr;

use ratatui::style::{Color, Modifier, Style};
use ratatui::text::Span;

/// What a piece of text stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// A number, a name.
    Plain,
    /// A heading.
    Title,
    /// All is well.
    Good,
    /// For information only, or old.
    Doubtful,
    /// Something is wrong.
    Bad,
    /// What only explains.
    Quiet,
    /// What is drawn.
    First,
}

/// With colours, or with bold and reversed letters alone.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    colors: bool,
}

impl Look {
    /// With colours or without.
    pub fn new(colors: bool) -> Self {
        Self { colors }
    }

    /// As the user wants it: `NO_COLOR` is a wish, and some terminals have none.
    pub fn of_environment() -> Self {
        let unwanted = std::env::var_os("NO_COLOR").is_some_and(|wish| !wish.is_empty());
        let monochrome =
            std::env::var_os("TERM").is_some_and(|name| name == OsStr::new("vt100") || name == "vt220");
        Self::new(!unwanted && !monochrome)
    }

    /// The style of a tone. Of the sixteen colours every terminal has, so that its own theme decides.
    pub fn style(self, tone: Tone) -> Style {
        let style = Style::new();
        let (color, modifier) = match tone {
            Tone::Plain => (None, Modifier::empty()),
            Tone::Title => (None, Modifier::BOLD),
            Tone::Good => (Some(Color::Green), Modifier::BOLD),
            Tone::Doubtful => (Some(Color::Yellow), Modifier::empty()),
            Tone::Bad => (Some(Color::Red), Modifier::BOLD),
            Tone::Quiet => (None, Modifier::DIM),
            Tone::First => (Some(Color::Cyan), Modifier::empty()),
        };
        match (self.colors, color) {
            (true, Some(color)) => style.fg(color).add_modifier(modifier),
            // What is wrong must be seen without red, too.
            (false, _) if tone == Tone::Bad => style.add_modifier(Modifier::REVERSED),
            _ => style.add_modifier(modifier),
        }
    }

    /// Text in that style.
    pub fn text(self, tone: Tone, text: impl Into<String>) -> Span<'static> {
        Span::styled(text.into(), self.style(tone))
    }
}
