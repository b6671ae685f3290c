//! What is told, in sections of lines. The screen puts them side by side, the snapshot below one another.

use ratatui::text::Line;

use super::look::{Look, Tone};
use super::strip::{Scale, curve, least};
use bus::watch::{
    Column, InputNow, Link, Round, Told, Traffic, Watch, Word, fault_words, quantity_label, quantity_shown,
    source_words, state_words,
};
use lab::report::number;
use physics::estimates::State;
use physics::time::Clock;
use physics::{Micros, Wheel};

/// A heading and lines.
pub struct Section {
    /// The heading.
    pub title: &'static str,
    /// What more to say of it where there is room: a unit, above all.
    pub detail: &'static str,
    /// A word on it, at its end.
    pub mark: Option<(Tone, String)>,
    /// The lines.
    pub lines: Vec<Line<'static>>,
}

/// What is needed to tell.
#[derive(Clone, Copy)]
pub struct Teller<'a> {
    /// Of what.
    pub watch: &'a Watch,
    /// The interface's or recording's name.
    pub name: &'a str,
    /// The wheels whose slope can be told.
    pub driven: &'a [Wheel],
    /// How.
    pub look: Look,
    /// Letters in a line.
    pub width: usize,
}

impl Teller<'_> {
    /// Friction: available with its interval, in use, and where it is known from.
    pub fn friction(&self) -> Section {
        let (round, word) = self.round_of("GRIP_FRICTION");
        let mut mark = self.mark(word, round.mu_max, round.mu_valid);
        if matches!(word, Word::Fresh(_)) && !round.mu_max.is_finite() && round.mu_low.is_finite() {
            mark = Some((Tone::Doubtful, "lower bound only".into()));
        }
        let tone = tone_of(&mark);
        let interval = if round.mu_low.is_finite() && !round.mu_max.is_finite() {
            format!("at least {}", number(round.mu_low, 2))
        } else {
            interval(round.mu_low, round.mu_high, 2)
        };
        let available = Line::from(vec![
            self.look.text(Tone::Quiet, "available  "),
            self.look.text(tone, format!("{:>5}", number(round.mu_max, 2))),
            self.look.text(Tone::Plain, format!("  {interval}")),
        ]);
        let source = round.mu_source.map_or("–", |source| source_words(Some(source)));
        let from =
            Line::from(vec![self.look.text(Tone::Quiet, "known from "), self.look.text(Tone::Plain, source)]);
        let used = Line::from(vec![
            self.look.text(Tone::Quiet, "in use     "),
            self.look.text(Tone::First, format!("{:>5}", number(round.mu_used, 2))),
            self.look.text(Tone::First, format!("  {}", self.curve("mu_used", 20))),
        ]);
        let scale = Scale { used: round.mu_used, low: round.mu_low, best: round.mu_max, high: round.mu_high };
        let bar = Line::from(vec![
            self.look.text(Tone::Quiet, "0 "),
            self.look.text(tone, scale.letters(self.width.saturating_sub(6))),
            self.look.text(Tone::Quiet, format!(" {}", Scale::END)),
        ]);
        Section { title: "Friction", detail: "95 % interval", mark, lines: vec![available, from, used, bar] }
    }

    /// Slip slopes of the driven wheels.
    pub fn slope(&self) -> Section {
        let (round, word) = self.round_of("GRIP_STIFFNESS_LONG");
        let any =
            self.driven.iter().map(|wheel| round.slope[*wheel as usize]).find(|slope| slope.is_finite());
        let mark = self.mark(word, any.unwrap_or(f64::NAN), round.slope_valid);
        let tone = tone_of(&mark);
        let line = |wheel: &Wheel| {
            let value = round.slope[*wheel as usize];
            let column = ["slope_fl", "slope_fr", "slope_rl", "slope_rr"][*wheel as usize];
            self.estimate(&wheel.name().to_uppercase(), value, round.slope_std, 1, tone, column)
        };
        let lines = self.driven.iter().map(line).collect();
        Section { title: "Slip slope", detail: "95 % interval", mark, lines }
    }

    /// Cornering stiffness of both axles.
    pub fn cornering(&self) -> Section {
        let (round, word) = self.round_of("GRIP_STIFFNESS_LAT");
        let mark = self.mark(word, round.cornering[0], round.cornering_valid);
        let tone = tone_of(&mark);
        let line = |(place, (name, column)): (usize, (&str, &'static str))| {
            self.estimate(name, round.cornering[place], round.cornering_std[place], 2, tone, column)
        };
        let axles = [("front", "cornering_front"), ("rear", "cornering_rear")];
        let lines = axles.into_iter().enumerate().map(line).collect();
        Section { title: "Cornering stiffness", detail: "1/rad, 95 %", mark, lines }
    }

    /// Sideslip and speed.
    pub fn motion(&self) -> Section {
        let (round, word) = self.round_of("GRIP_MOTION");
        let mark = self.mark(word, round.sideslip, round.motion_valid);
        let tone = tone_of(&mark);
        let line = |name: &str, value: f64, decimals: usize, unit: &str, column: &'static str, tone: Tone| {
            Line::from(vec![
                self.look.text(Tone::Quiet, format!("{name:<9} ")),
                self.look.text(tone, format!("{:>7}", signed(value, decimals))),
                self.look.text(Tone::Quiet, format!(" {unit:<5} ")),
                self.look.text(Tone::First, self.curve(column, 23)),
            ])
        };
        let speed_tone = if matches!(word, Word::Fresh(_)) { Tone::Plain } else { Tone::Doubtful };
        let lines = vec![
            line("sideslip", round.sideslip.to_degrees(), 2, "°", "sideslip", tone),
            line("speed", round.speed * 3.6, 1, "km/h", "speed", speed_tone),
        ];
        Section { title: "Motion", detail: "", mark, lines }
    }

    /// State and faults in words.
    pub fn state(&self) -> Section {
        let (round, word) = self.round_of("GRIP_STATUS");
        let mark = match (word, round.state) {
            (Word::Never, _) => None,
            (Word::Stale(age), _) => Some((Tone::Bad, format!("stale, {}", age_words(age)))),
            (_, Some(State::Running)) => Some((Tone::Good, "running".into())),
            (_, other) => {
                Some((Tone::Doubtful, other.map_or_else(String::new, |s| s.name().replace('_', " "))))
            }
        };
        let mut lines = Vec::new();
        if !matches!(word, Word::Never) && round.state != Some(State::Running) {
            lines.push(Line::from(self.look.text(Tone::Plain, state_words(round.state))));
        }
        let faults = self.watch.faults();
        for fault in faults.iter() {
            let name = fault.names().next().unwrap_or_default().replace('_', " ");
            lines.push(Line::from(vec![
                self.look.text(Tone::Bad, format!("! {name}")),
                self.look.text(Tone::Plain, format!(": {}", fault_words(fault))),
            ]));
        }
        if faults.is_empty() {
            lines.push(Line::from(self.look.text(Tone::Quiet, "no faults")));
        }
        if round.excitation[0].is_finite() {
            let [long, lat] = round.excitation.map(|share| number(100.0 * share, 0));
            for text in [
                format!("excitation {long} % along, {lat} % across"),
                format!("surface changes {}", round.surface_changes),
            ] {
                lines.push(Line::from(self.look.text(Tone::Quiet, text)));
            }
        }
        Section { title: "State and faults", detail: "", mark, lines }
    }

    /// Every configured input.
    pub fn inputs(&self) -> Section {
        let spark = self.width.saturating_sub(32).min(24);
        let line = |input: InputNow| {
            let (factor, unit, decimals) = quantity_shown(input.quantity);
            let value = input.newest.map_or(f64::NAN, |(value, _)| factor * value);
            let age = input.newest.map_or_else(|| "never".to_owned(), |(_, age)| age_words(age));
            let (tone, remark) = match (input.is_stale, input.is_doubted) {
                _ if input.newest.is_none() => (Tone::Bad, ""),
                (true, _) => (Tone::Bad, "stale"),
                (_, true) => (Tone::Doubtful, "left out"),
                _ => (Tone::Plain, ""),
            };
            let column = Column::Input(input.quantity);
            let curve = curve(self.watch.series(), column, spark, least(column));
            let end = if remark.is_empty() {
                self.look.text(Tone::First, curve)
            } else {
                self.look.text(tone, format!("{remark:<spark$}"))
            };
            Line::from(vec![
                self.look.text(Tone::Quiet, format!("{:<10}", quantity_label(input.quantity))),
                self.look.text(tone, format!("{:>8}", signed(value, decimals))),
                self.look.text(Tone::Quiet, format!(" {unit:<5}")),
                self.look.text(if input.is_stale { Tone::Bad } else { Tone::Quiet }, format!("{age:>7} ")),
                end,
            ])
        };
        let rate = format!("{:.0} frames/s", self.watch.input_rate());
        let lines = self.watch.inputs().map(line).collect();
        Section { title: "Inputs", detail: "", mark: Some((Tone::Quiet, rate)), lines }
    }

    /// How often each needed identifier comes.
    pub fn traffic(&self) -> Section {
        let now = self.watch.now();
        let line = |traffic: &Traffic| {
            let age = traffic
                .last()
                .map_or_else(|| "never".to_owned(), |last| age_words((now - last).max(Micros(0))));
            Line::from(vec![
                self.look.text(Tone::Plain, format!("{:<16.16} ", traffic.name())),
                self.look.text(Tone::Quiet, format!("{:>8} ", traffic.id().to_string())),
                self.look.text(Tone::Plain, format!("{:>5.0}/s", traffic.rate(now))),
                self.look.text(Tone::Quiet, format!("{age:>7}")),
            ])
        };
        let lines = self.watch.traffic().iter().map(line).collect();
        Section { title: "Input messages", detail: "", mark: None, lines }
    }

    /// The published messages: in one line, or each.
    pub fn published(&self, each: bool) -> Section {
        let now = self.watch.now();
        let [crc, counter, shape] = self.watch.damage();
        let mark = match (self.watch.told(), crc + counter + shape) {
            (Told::ByOwn, 0) => None,
            (Told::Never, _) => Some((Tone::Doubtful, "none so far".to_owned())),
            (Told::Silent, _) => Some((Tone::Bad, "stale".to_owned())),
            (_, 0) => Some((Tone::Good, "all frames sound".to_owned())),
            _ => Some((Tone::Bad, format!("errors: crc {crc} ctr {counter} shape {shape}"))),
        };
        let title = match self.watch.told() {
            Told::ByOwn => "What gripd would publish",
            _ => "Published messages",
        };
        let lines = if each {
            self.watch
                .messages()
                .map(|(heard, word)| {
                    let errors = [heard.crc_errors, heard.counter_errors, heard.misshapen];
                    let tone = if errors == [0; 3] { Tone::Quiet } else { Tone::Bad };
                    let (age_tone, age) = match word {
                        Word::Never => (Tone::Quiet, "never".to_owned()),
                        Word::Fresh(age) => (Tone::Quiet, age_words(age)),
                        Word::Stale(age) => (Tone::Bad, format!("stale {}", age_words(age))),
                    };
                    let [crc, counter, _] = errors;
                    Line::from(vec![
                        self.look.text(Tone::Plain, format!("{:<19} ", heard.traffic().name())),
                        self.look.text(Tone::Plain, format!("{:>3.0}/s ", heard.traffic().rate(now))),
                        self.look.text(age_tone, format!("{age:>7} ")),
                        self.look.text(tone, format!("crc {crc} ctr {counter}")),
                    ])
                })
                .collect()
        } else {
            let messages = self.watch.messages().count();
            let fresh: Vec<_> =
                self.watch.messages().filter(|(_, word)| matches!(word, Word::Fresh(_))).collect();
            let rate: f64 = fresh.iter().map(|(heard, _)| heard.traffic().rate(now)).sum();
            let each = rate / fresh.len().max(1) as f64;
            vec![Line::from(
                self.look.text(Tone::Plain, format!("{} of {messages} come, {each:.0}/s each", fresh.len())),
            )]
        };
        Section { title, detail: "", mark, lines }
    }

    /// What stands above everything: where from, whose estimates, and what is wrong with that.
    pub fn header(&self) -> Vec<Line<'static>> {
        let link = match self.watch.link() {
            Some(Link::Up) => (Tone::Good, ": up".to_owned()),
            Some(Link::Down) => (Tone::Bad, ": the interface is down; waiting for it".to_owned()),
            Some(Link::Gone) => (Tone::Bad, ": there is no such interface; waiting for it".to_owned()),
            None => (Tone::Quiet, String::new()),
        };
        let told = match self.watch.told() {
            Told::ByBus => (Tone::Plain, "estimates as a gripd on this bus publishes them"),
            Told::Silent => (Tone::Bad, "the gripd on this bus has fallen silent: what is shown is old"),
            Told::Never => {
                (Tone::Doubtful, "no gripd publishes on this bus (e: estimate here; nothing is sent)")
            }
            Told::ByOwn => (Tone::Plain, "estimates made here, from the inputs; nothing is sent"),
        };
        let mut first = vec![
            self.look.text(Tone::Title, "gripd monitor  "),
            self.look.text(Tone::Plain, self.name.to_owned()),
            self.look.text(link.0, link.1),
        ];
        let is_up = !matches!(self.watch.link(), Some(Link::Down | Link::Gone));
        if let Some(silence) = self.watch.silence().filter(|silence| is_up && *silence > Micros(1_000_000)) {
            first.push(self.look.text(Tone::Bad, format!("  nothing has come for {}", age_words(silence))));
        } else if is_up && self.watch.silence().is_some() {
            first.push(self.look.text(Tone::Quiet, format!("  {}", clock(self.watch.now()))));
        }
        if self.watch.dropped() > 0 {
            first.push(self.look.text(Tone::Bad, format!("  {} frames lost", self.watch.dropped())));
        }
        let mut lines = vec![Line::from(first), Line::from(self.look.text(told.0, told.1))];
        if let (count, Some(error)) = self.watch.errors() {
            lines.push(Line::from(
                self.look.text(Tone::Bad, format!("{count} errors on the bus; last: {error}")),
            ));
        }
        lines
    }

    /// One estimate with its interval.
    fn estimate(
        &self,
        name: &str,
        value: f64,
        std: f64,
        decimals: usize,
        tone: Tone,
        column: &'static str,
    ) -> Line<'static> {
        let half = 1.96 * std;
        Line::from(vec![
            self.look.text(Tone::Quiet, format!("{name:<5} ")),
            self.look.text(tone, format!("{:>6}", number(value, decimals))),
            self.look.text(Tone::Plain, format!("  {:<15} ", interval(value - half, value + half, decimals))),
            self.look.text(Tone::First, self.curve(column, 29)),
        ])
    }

    /// The last minute, in what is left of the line.
    fn curve(&self, column: &'static str, taken: usize) -> String {
        let column = Column::Estimate(column);
        curve(self.watch.series(), column, self.width.saturating_sub(taken).min(40), least(column))
    }

    /// What a message said last, and how it is with it.
    fn round_of(&self, message: &str) -> (Round, Word) {
        (self.watch.last_round(), self.watch.word(message))
    }

    /// Whether values may be acted upon.
    fn mark(&self, word: Word, value: f64, valid: bool) -> Option<(Tone, String)> {
        Some(match word {
            Word::Never => return None,
            Word::Stale(age) => (Tone::Bad, format!("stale, {}", age_words(age))),
            Word::Fresh(_) if !value.is_finite() => (Tone::Doubtful, "not available".into()),
            Word::Fresh(_) if valid => (Tone::Good, "valid".into()),
            Word::Fresh(_) => (Tone::Doubtful, "not valid".into()),
        })
    }
}

fn tone_of(mark: &Option<(Tone, String)>) -> Tone {
    mark.as_ref().map_or(Tone::Quiet, |(tone, _)| *tone)
}

/// `low – high`, with what there is of it.
fn interval(low: f64, high: f64, decimals: usize) -> String {
    match (low.is_finite(), high.is_finite()) {
        (false, false) => String::new(),
        (true, false) => format!("{} or more", number(low, decimals)),
        _ => format!("{} – {}", signed(low, decimals), signed(high, decimals)),
    }
}

/// With a true minus; a dash where there is none.
fn signed(value: f64, decimals: usize) -> String {
    let text = number(value, decimals);
    // No minus before nothing but zeros.
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|c| matches!(c, '0' | '.')) => digits.to_owned(),
        Some(digits) => format!("−{digits}"),
        None => text,
    }
}

/// Milliseconds, seconds, minutes.
pub fn age_words(age: Micros) -> String {
    let seconds = age.seconds();
    if seconds < 1.0 {
        format!("{:.0} ms", 1000.0 * seconds)
    } else if seconds < 100.0 {
        format!("{seconds:.1} s")
    } else if seconds < 6000.0 {
        format!("{:.0} min", seconds / 60.0)
    } else {
        "long".into()
    }
}

/// Hours, minutes and seconds of the frames' clock; it says so where they are UTC.
pub fn clock(now: Micros) -> String {
    let all = now.0.div_euclid(Micros::PER_SECOND);
    let seconds = all.rem_euclid(86_400);
    let utc = if Clock::of(now).date().is_some() { " UTC" } else { "" };
    format!("{:02}:{:02}:{:02}{utc}", seconds / 3600, seconds / 60 % 60, seconds % 60)
}
