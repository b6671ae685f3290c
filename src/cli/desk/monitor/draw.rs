//! The screen: sections side by side, as many as there is room for.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Paragraph};

use super::look::Tone;
use super::sections::{Section, Teller};

/// What the session adds to what is watched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mode {
    /// Nothing moves.
    pub paused: bool,
    /// The keys are explained.
    pub help: bool,
    /// A recording, and it is over.
    pub over: bool,
}

/// From here on two columns have room.
const TWO: u16 = 76;
/// From here on three.
const THREE: u16 = 124;

/// Draws all of it. `note` is something that went wrong.
pub fn draw(frame: &mut Frame, teller: &Teller, mode: Mode, note: Option<&str>) {
    let area = frame.area();
    let mut header = teller.header();
    header.extend(note.map(|note| Line::from(teller.look.text(Tone::Bad, note.to_owned()))));
    let [top, body, bottom] = Layout::vertical([
        Constraint::Length(u16::try_from(header.len()).unwrap_or(u16::MAX)),
        Constraint::Fill(1),
        Constraint::Length(1),
    ])
    .areas(area);
    frame.render_widget(Paragraph::new(header), top);
    if area.width >= THREE && body.height >= 18 {
        three(frame, teller, body);
    } else if area.width >= TWO {
        two(frame, teller, body);
    } else {
        let all = |teller: &Teller| {
            vec![
                teller.friction(),
                teller.state(),
                teller.slope(),
                teller.cornering(),
                teller.motion(),
                teller.inputs(),
                teller.published(true),
            ]
        };
        column(frame, teller, body, all);
    }
    frame.render_widget(Paragraph::new(footer(teller, mode, area.width)), bottom);
    if mode.help {
        help(frame, teller, area);
    }
}

fn three(frame: &mut Frame, teller: &Teller, body: Rect) {
    let [left, middle, right] = Layout::horizontal([Constraint::Fill(1); 3]).spacing(2).areas(body);
    column(frame, teller, left, |t| vec![t.inputs(), t.traffic()]);
    column(frame, teller, middle, |t| vec![t.friction(), t.slope(), t.cornering(), t.motion()]);
    column(frame, teller, right, |t| vec![t.state(), t.published(true)]);
}

fn two(frame: &mut Frame, teller: &Teller, body: Rect) {
    let beside = |teller: &Teller| -> [Vec<Section>; 2] {
        let estimates = vec![teller.friction(), teller.slope(), teller.cornering(), teller.motion()];
        [vec![teller.inputs()], estimates]
    };
    let height = beside(teller).iter().map(|sections| rows(sections)).max().unwrap_or(0);
    let rest = body.height.saturating_sub(height);
    // What is wrong comes first, then one line on what is published; all of it where there is room.
    let (state, each) = (teller.state(), teller.published(true));
    let below = rows(std::slice::from_ref(&state)).max(rows(std::slice::from_ref(&each)));
    let [upper, lower] = Layout::vertical([Constraint::Length(height), Constraint::Fill(1)]).areas(body);
    let [left, right] = Layout::horizontal([Constraint::Fill(1); 2]).spacing(2).areas(upper);
    column(frame, teller, left, |t| vec![t.inputs()]);
    column(frame, teller, right, |t| vec![t.friction(), t.slope(), t.cornering(), t.motion()]);
    if rest >= below.max(8) {
        let [left, right] = Layout::horizontal([Constraint::Fill(1); 2]).spacing(2).areas(lower);
        column(frame, teller, left, |t| vec![t.state(), t.traffic()]);
        column(frame, teller, right, |t| vec![t.published(true)]);
    } else {
        let room = usize::from(rest.saturating_sub(2 + 1));
        column(frame, teller, lower, |t| {
            let mut state = t.state();
            state.lines.truncate(room.max(1));
            vec![state, t.published(false)]
        });
    }
}

/// Rows that sections take.
fn rows(sections: &[Section]) -> u16 {
    let rows: usize = sections.iter().map(|section| 1 + section.lines.len()).sum();
    u16::try_from(rows).unwrap_or(u16::MAX)
}

/// Sections below one another; how much does not fit is said.
fn column(frame: &mut Frame, teller: &Teller, area: Rect, sections: impl Fn(&Teller) -> Vec<Section>) {
    let width = usize::from(area.width);
    let mut lines = Vec::new();
    for section in sections(&Teller { width, ..*teller }) {
        lines.push(heading(teller, &section, width));
        lines.extend(section.lines);
    }
    if let Some(room) = usize::from(area.height).checked_sub(1).filter(|room| lines.len() > room + 1) {
        let more = format!("… {} more lines on a larger terminal", lines.len() - room);
        lines.truncate(room);
        lines.push(Line::from(teller.look.text(Tone::Quiet, more)));
    }
    frame.render_widget(Paragraph::new(lines), area);
}

/// `─ Friction ─────────── valid ─`
fn heading(teller: &Teller, section: &Section, width: usize) -> Line<'static> {
    let mut spans = vec![
        teller.look.text(Tone::Quiet, "─ "),
        teller.look.text(Tone::Title, section.title),
        Span::raw(" "),
    ];
    let mark = section.mark.as_ref().map(|(tone, text)| teller.look.text(*tone, text.clone()));
    let mut taken: usize = spans.iter().map(Span::width).sum();
    let end = mark.as_ref().map_or(0, |mark| mark.width() + 3);
    let detail = teller.look.text(Tone::Quiet, section.detail);
    if !section.detail.is_empty() && taken + detail.width() + 2 + end <= width {
        taken += detail.width() + 1;
        spans.extend([detail, Span::raw(" ")]);
    }
    spans.push(teller.look.text(Tone::Quiet, "─".repeat(width.saturating_sub(taken + end))));
    if let Some(mark) = mark {
        spans.extend([Span::raw(" "), mark, teller.look.text(Tone::Quiet, " ─")]);
    }
    Line::from(spans)
}

/// As many of the keys as there is room for.
fn footer(teller: &Teller, mode: Mode, width: u16) -> Line<'static> {
    let mut spans: Vec<Span<'static>> = Vec::new();
    if mode.paused {
        spans.push(teller.look.text(Tone::Doubtful, "PAUSED  "));
    }
    if mode.over {
        spans.push(teller.look.text(Tone::Doubtful, "the recording is over  "));
    }
    for (key, what) in [("q", "quit"), ("p", "pause"), ("?", "help"), ("e", "whose estimates")] {
        let taken: usize = spans.iter().map(Span::width).sum();
        if taken + key.len() + 1 + what.len() <= usize::from(width) {
            spans.push(teller.look.text(Tone::Title, key));
            spans.push(teller.look.text(Tone::Quiet, format!(" {what}   ")));
        }
    }
    Line::from(spans)
}

const HELP: &str = "\
q, Esc, Ctrl-C  quit
p, space        pause: the picture, or the recording
e               whose estimates: those on the bus, or made
                here from the same inputs. Nothing is sent.
? h             this

valid           may be acted upon
not valid       for information only
not available   nothing tells it at the moment
stale           the message has stopped coming
left out        an input that others contradict

Friction bar: ━ in use, ┃ best value, ▒ 95 % interval,
░ that much or any more. Curves: the last minute.";

fn help(frame: &mut Frame, teller: &Teller, area: Rect) {
    let lines: Vec<Line> = HELP.lines().map(|line| Line::from(teller.look.text(Tone::Plain, line))).collect();
    let (width, height) = (60.min(area.width), (lines.len() as u16 + 2).min(area.height));
    let place =
        Rect { x: area.x + (area.width - width) / 2, y: area.y + (area.height - height) / 2, width, height };
    frame.render_widget(Clear, place);
    frame.render_widget(Paragraph::new(lines).block(Block::bordered().title(" Help ")), place);
}
