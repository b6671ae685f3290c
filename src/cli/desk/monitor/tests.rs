//! What is drawn, on terminals of all sizes.

use std::path::Path;
use std::sync::OnceLock;

use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::style::Color;

use super::draw::{Mode, draw};
use super::look::Look;
use super::sections::Teller;
use crate::cli::desk::SimulatedFrames;
use bus::Config;
use bus::can::Frame;
use bus::service::{Engine, Sink};
use bus::signals::Outputs;
use bus::watch::{Estimator, Happening, Link, Watch};
use lab::report::number;
use physics::model::{Scenario, Simulation};
use physics::{Micros, Wheel};

const DRIVEN: [Wheel; 2] = [Wheel::Fl, Wheel::Fr];

fn demo_car() -> Config {
    Config::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("config/demo.toml")).unwrap()
}

/// Everything on the bus of 40 s of the demo drive, what gripd publishes included.
fn frames() -> &'static [Frame] {
    static FRAMES: OnceLock<Vec<Frame>> = OnceLock::new();
    struct Both(Vec<Frame>);
    impl Sink for Both {
        fn publish(&mut self, frame: &Frame) {
            self.0.push(*frame);
        }
    }
    FRAMES.get_or_init(|| {
        let config = demo_car();
        let text = include_str!("../../../../config/scenarios/demo.toml");
        let text = text.replace("duration_s = 120.0", "duration_s = 40.0");
        let mut simulation = Simulation::new(&Scenario::parse(&text).unwrap(), 1).unwrap();
        let input = config.input_database().unwrap();
        let radius = config.vehicle.wheel_radius_m.value;
        let mut car = SimulatedFrames::new(Outputs::compile(&config.signals, &input, radius).unwrap());
        let mut engine = Engine::new(&config).unwrap();
        let mut both = Both(Vec::new());
        while let Some(tick) = simulation.next_tick() {
            let mut sent = Vec::new();
            car.take(tick.readings, &mut |frame| sent.push(*frame));
            for frame in sent {
                both.0.push(frame);
                engine.frame(&frame, &mut both);
            }
        }
        both.0
    })
}

fn watch(estimator: Estimator, frames: &[Frame]) -> Watch {
    let mut watch = Watch::new(&demo_car(), estimator).unwrap();
    watch.take(&Happening::Link(Link::Up), None);
    for frame in frames {
        watch.take(&Happening::Frame(*frame), Some(frame.time));
    }
    watch
}

fn screen(watch: &Watch, (width, height): (u16, u16), mode: Mode, colors: bool) -> Terminal<TestBackend> {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
    let teller = Teller { watch, name: "vcan0", driven: &DRIVEN, look: Look::new(colors), width: 0 };
    terminal.draw(|frame| draw(frame, &teller, mode, None)).unwrap();
    terminal
}

/// The letters on it, a line for each row.
fn text(watch: &Watch, size: (u16, u16), mode: Mode) -> String {
    let terminal = screen(watch, size, mode, true);
    let cells = terminal.backend().buffer().content();
    let rows = cells.chunks(usize::from(size.0));
    rows.map(|row| row.iter().map(|cell| cell.symbol()).collect::<String>() + "\n").collect()
}

#[track_caller]
fn assert_shows(text: &str, all: &[&str]) {
    for words in all {
        assert!(text.contains(words), "no `{words}` in\n{text}");
    }
}

/// The line that begins a column with this.
#[track_caller]
fn line<'a>(text: &'a str, start: &str) -> &'a str {
    let found = text.lines().find_map(|line| line.find(start).map(|at| &line[at..]));
    found.unwrap_or_else(|| panic!("no `{start}` in\n{text}"))
}

#[test]
fn everything_has_room_on_the_smallest_usual_terminal() {
    let watch = watch(Estimator::Bus, frames());
    let text = text(&watch, (80, 24), Mode::default());
    println!("{text}");
    assert!(!text.contains("more lines"), "{text}");
    assert_shows(&text, &["vcan0: up", "as a gripd on this bus publishes", "no faults", "q quit"]);
    assert_shows(&text, &["450 frames/s", "7 of 7 come, 50/s each", "all frames sound"]);
    for input in watch.inputs() {
        assert_shows(&text, &[bus::watch::quantity_label(input.quantity)]);
    }
    // The numbers are those of the frames.
    let round = watch.round();
    let half = 1.96 * round.slope_std;
    assert_shows(line(&text, "FL      "), &[&number(round.slope[0], 1), &number(round.slope[0] - half, 1)]);
    assert_shows(line(&text, "rear "), &[&number(round.cornering[1], 2)]);
    assert_shows(line(&text, "in use"), &[&number(round.mu_used, 2)]);
    assert_shows(line(&text, "speed  "), &[&number(3.6 * round.speed, 1), "km/h"]);
    assert!(line(&text, "0 ━").contains('░') || line(&text, "0 ━").contains('▒'), "{text}");
    assert!(line(&text, "FL      ").chars().any(|letter| ('▁'..='█').contains(&letter)), "no curve: {text}");
}

#[test]
fn a_large_terminal_shows_each_message() {
    let watch = watch(Estimator::Bus, frames());
    let text = text(&watch, (160, 45), Mode::default());
    println!("{text}");
    assert_shows(&text, &["Input messages", "WHEELS", "1A0", "GRIP_FRICTION", "GRIP_STATUS", "crc 0 ctr 0"]);
    let middling = super::tests::text(&watch, (100, 45), Mode::default());
    println!("{middling}");
    assert_shows(&middling, &["Input messages", "GRIP_STATUS", "no faults"]);
    let narrow = super::tests::text(&watch, (40, 60), Mode::default());
    println!("{narrow}");
    assert_shows(&narrow, &["Friction", "no faults", "Slip slope", "wheel FL", "GRIP_STATUS"]);
}

#[test]
fn no_size_is_too_small() {
    let watch = watch(Estimator::Own, &frames()[..500]);
    let help = Mode { help: true, paused: true, over: true };
    for size in [(1, 1), (2, 40), (80, 1), (10, 3), (40, 12), (79, 24), (300, 100), (124, 19), (76, 10)] {
        screen(&watch, size, Mode::default(), true);
        screen(&watch, size, help, true);
    }
    let small = text(&watch, (60, 15), Mode { paused: true, ..Mode::default() });
    assert_shows(&small, &["PAUSED", "more lines on a larger terminal", "q quit", "? help"]);
    let narrow = text(&watch, (20, 12), Mode::default());
    assert_shows(&narrow, &["q quit"]);
    assert!(!narrow.contains("whose"), "{narrow}");
}

#[test]
fn what_is_old_missing_or_wrong_is_said() {
    let inputs: Vec<Frame> =
        frames().iter().filter(|frame| !(0x6A0..=0x6A6).contains(&frame.id.number())).copied().collect();
    let never = text(&watch(Estimator::Bus, &inputs), (80, 24), Mode::default());
    assert_shows(&never, &["no gripd publishes on this bus", "e: estimate here", "none so far"]);
    assert!(line(&never, "FL      ").contains('–'), "{never}");

    let own = text(&watch(Estimator::Own, &inputs), (80, 24), Mode::default());
    assert_shows(&own, &["made here, from the inputs; nothing is sent", "What gripd would publish"]);

    let mut silent = watch(Estimator::Bus, frames());
    let end = silent.now();
    silent.advance(end + Micros::from_millis(3400));
    let quiet = text(&silent, (80, 24), Mode::default());
    assert_shows(&quiet, &["nothing has come for 3.4 s"]);
    silent.take(&Happening::Link(Link::Down), None);
    let silent = text(&silent, (80, 24), Mode::default());
    println!("{silent}");
    assert_shows(&silent, &["interface is down", "has fallen silent", "stale, 3.4 s"]);
    assert_shows(&silent, &["! bus down: the interface is down or gone"]);

    // One checksum is wrong, and what is under it has another value.
    let mut spoiled = frames().to_vec();
    let at = spoiled.iter().rposition(|frame| frame.id.number() == 0x6A0).unwrap();
    let mut data = spoiled[at].data().to_vec();
    data[5] ^= 0xFF;
    spoiled[at] = Frame::data_frame(spoiled[at].time, spoiled[at].id, &data).unwrap();
    let spoiled = text(&watch(Estimator::Bus, &spoiled), (160, 45), Mode::default());
    assert_shows(&spoiled, &["errors: crc 1 ctr 0 shape 0", "crc 1 ctr 0"]);

    // The steering wheel falls silent in mid-drive.
    let half = frames().len() / 2;
    let kept = |(place, frame): &(usize, &Frame)| *place < half || frame.id.number() != 0x1C0;
    let deaf: Vec<Frame> = frames().iter().enumerate().filter(kept).map(|(_, frame)| *frame).collect();
    let deaf = text(&watch(Estimator::Own, &deaf), (80, 24), Mode::default());
    println!("{deaf}");
    assert_shows(&deaf, &["degraded", "! timeout: an input has not come for too long"]);
    assert_shows(line(&deaf, "steering"), &["stale"]);
}

#[test]
fn help_and_pause_are_seen() {
    let watch = watch(Estimator::Own, &frames()[..2000]);
    let mode = Mode { help: true, paused: true, over: true };
    let text = text(&watch, (80, 24), mode);
    assert_shows(&text, &["Help", "Nothing is sent", "not available", "PAUSED", "the recording is over"]);
}

#[test]
fn without_colours_there_are_none_and_what_is_wrong_still_stands_out() {
    let mut watch = watch(Estimator::Bus, frames());
    watch.take(&Happening::Link(Link::Gone), None);
    let colored = |colors| {
        let terminal = screen(&watch, (80, 24), Mode::default(), colors);
        let cells = terminal.backend().buffer().content().to_vec();
        let colors = cells.iter().filter(|cell| cell.fg != Color::Reset || cell.bg != Color::Reset).count();
        let reversed =
            cells.iter().filter(|cell| cell.modifier.contains(ratatui::style::Modifier::REVERSED)).count();
        (colors, reversed)
    };
    assert!(colored(true).0 > 50 && colored(true).1 == 0);
    assert!(colored(false).0 == 0 && colored(false).1 > 10, "{:?}", colored(false));
}
