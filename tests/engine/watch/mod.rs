//! What `gripd monitor` and `gripd view` know: that it is what is on the bus, and how old.

mod live;
mod played;

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use gripd::can::Frame;
use gripd::can::candump::Reader;
use gripd::dbc::Database;
use gripd::estimates::State;
use gripd::signals::publish::built_in_database;
use gripd::watch::{Column, Estimator, Happening, Told, Watch, Word};
use gripd::{Config, Faults, Micros, Quantity};
use testing::program::{gripd, project};

fn demo_car() -> Config {
    Config::load(&project("config/demo.toml")).unwrap()
}

/// 30 s of the demo drive, what a replay of it publishes beside it (`all.log`), and its estimates.
fn drive() -> &'static Path {
    static MADE: OnceLock<PathBuf> = OnceLock::new();
    MADE.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("watch");
        std::fs::create_dir_all(&folder).unwrap();
        let scenario = std::fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
        let shorter = scenario.replace("duration_s = 120.0", "duration_s = 30.0");
        assert_ne!(scenario, shorter, "the scenario has another length now");
        std::fs::write(folder.join("drive.toml"), shorter).unwrap();
        let run = |arguments: &str| {
            let mut command = gripd();
            command.current_dir(&folder).args(arguments.split_whitespace());
            assert!(command.status().unwrap().success(), "{arguments}");
        };
        run("simulate drive.toml -o drive.log");
        let car = project("config/demo.toml");
        run(&format!("replay -q -c {} drive.log --all -o all.log --estimates estimates.csv", car.display()));
        folder
    })
}

fn frames(name: &str) -> Vec<Frame> {
    let mut reader = Reader::open(&drive().join(name)).unwrap();
    std::iter::from_fn(|| reader.next_frame().unwrap()).collect()
}

fn is_published(frame: &Frame) -> bool {
    (0x6A0..=0x6A6).contains(&frame.id.number())
}

fn show(watch: &mut Watch, frames: &[Frame]) {
    for frame in frames {
        watch.take(&Happening::Frame(*frame), Some(frame.time));
    }
}

/// A published signal as of just before a moment, read from the frames through the output DBC and nothing else.
fn read(frames: &[Frame], database: &Database, until: Micros, signal: &str) -> Option<f64> {
    let (message, signal) = database.signal(signal).unwrap();
    let frame = frames.iter().rfind(|frame| frame.id == message.id && frame.time < until)?;
    let bits = signal.bits(frame.data()).unwrap();
    (signal.value_named("not_available") != Some(bits)).then(|| signal.physical(bits))
}

const PUBLISHED: [(&str, &str, f64); 12] = [
    ("mu_max", "GRIP_FRICTION.MuMax", 1.0),
    ("mu_max_low", "GRIP_FRICTION.MuMaxLow", 1.0),
    ("mu_used", "GRIP_FRICTION.MuUsed", 1.0),
    ("mu_source", "GRIP_FRICTION.MuSource", 1.0),
    ("slope_fl", "GRIP_STIFFNESS_LONG.SlopeFL", 1.0),
    ("slope_std", "GRIP_STIFFNESS_LONG.SlopeStd", 1.0),
    ("slip_offset_fr", "GRIP_SLIP_OFFSET.OffsetFR", 1.0),
    ("cornering_rear", "GRIP_STIFFNESS_LAT.CorneringRear", 1.0),
    ("sideslip", "GRIP_MOTION.Sideslip", 1.0),
    ("speed", "GRIP_MOTION.Speed", 1.0),
    ("excitation_long", "GRIP_STATUS.ExcitationLong", 0.01),
    ("state", "GRIP_STATUS.State", 1.0),
];

#[test]
fn every_row_is_what_the_published_frames_say() {
    let all = frames("all.log");
    let inputs: Vec<Frame> = all.iter().filter(|frame| !is_published(frame)).copied().collect();
    let published: Vec<Frame> = all.iter().filter(|frame| is_published(frame)).copied().collect();
    let database = built_in_database().unwrap();
    let mut own = Watch::new(&demo_car(), Estimator::Own).unwrap();
    show(&mut own, &inputs);
    let mut bus = Watch::new(&demo_car(), Estimator::Bus).unwrap();
    show(&mut bus, &all);
    assert_eq!((own.told(), bus.told()), (Told::ByOwn, Told::ByBus));
    let rows = own.series().rows();
    assert!((290..=300).contains(&rows.len()), "{} rows", rows.len());
    let mut there = 0;
    for row in rows {
        for (column, signal, factor) in PUBLISHED {
            let shown = row.get(Column::Estimate(column));
            let sent = read(&published, &database, row.time, signal).map(|value| (value * factor) as f32);
            assert_eq!((!shown.is_nan()).then_some(shown), sent, "{column} at {}", row.time);
            there += usize::from(sent.is_some());
        }
    }
    assert!(there > 2000, "hardly anything was published: {there}");
    // Whether the frames are on the bus or come from the own engine makes no difference.
    let values = |watch: &Watch| -> Vec<u32> {
        watch.series().rows().iter().flat_map(|row| row.values.map(f32::to_bits)).collect()
    };
    assert!(values(&own) == values(&bus));
}

#[test]
fn the_rows_are_the_estimates_of_a_replay() {
    let mut watch = Watch::new(&demo_car(), Estimator::Own).unwrap();
    show(&mut watch, &frames("drive.log"));
    let text = std::fs::read_to_string(drive().join("estimates.csv")).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let table: Vec<Vec<Option<f64>>> =
        lines.map(|line| line.iter().map(|cell| cell.parse().ok()).collect()).collect();
    for (name, resolution) in [
        ("speed", 0.05),
        ("slope_fl", 0.125),
        ("cornering_front", 0.01),
        ("mu_used", 0.002),
        ("sideslip", 5e-4),
    ] {
        let place = header.iter().position(|column| *column == name).unwrap();
        let mut compared = 0;
        for row in watch.series().rows() {
            let shown = f64::from(row.get(Column::Estimate(name)));
            if shown.is_nan() {
                continue;
            }
            compared += 1;
            // Samples wait some tens of milliseconds for late frames, and are then published every 20 ms.
            let near = table.iter().filter(|line| {
                let before = row.time.seconds() - line[0].unwrap();
                (0.0..=0.15).contains(&before)
            });
            let closest =
                near.filter_map(|line| line[place]).map(|value| (value - shown).abs()).reduce(f64::min);
            assert!(closest.unwrap() <= 0.501 * resolution, "{name} at {}: {shown}, {closest:?}", row.time);
        }
        assert!(compared > 100, "{name}: {compared}");
    }
}

#[test]
fn what_falls_silent_is_stale_and_no_longer_shown() {
    let all = frames("all.log");
    let mut watch = Watch::new(&demo_car(), Estimator::Bus).unwrap();
    show(&mut watch, &all);
    let end = all.last().unwrap().time;
    let last = watch.round();
    assert!(last.speed > 1.0 && matches!(watch.word("GRIP_MOTION"), Word::Fresh(_)));
    assert!((watch.input_rate() - 450.0).abs() < 30.0, "{}", watch.input_rate());
    // The inputs go on, gripd does not.
    let rows = watch.series().made();
    watch.advance(end + Micros::from_millis(200));
    assert_eq!(watch.told(), Told::ByBus, "a tenth of a second is no silence");
    watch.advance(end + Micros::from_millis(900));
    assert_eq!(watch.told(), Told::Silent);
    let Word::Stale(age) = watch.word("GRIP_MOTION") else { panic!("{:?}", watch.word("GRIP_MOTION")) };
    assert!(age >= Micros::from_millis(890));
    assert!(watch.round().speed.is_nan() && watch.round().state.is_none());
    assert_eq!(watch.last_round().speed.to_bits(), last.speed.to_bits());
    let row = watch.series().since(rows).last().unwrap();
    assert!(row.get(Column::Estimate("speed")).is_nan());
    assert!(row.get(Column::Input(Quantity::YawRate)).is_nan());
    assert!(watch.inputs().all(|input| input.is_stale && input.newest.is_some()));
    // It comes back: as if nothing had been, and nothing is counted as an error.
    let later: Vec<Frame> = all
        .iter()
        .map(|frame| {
            let mut frame = *frame;
            frame.time = frame.time + Micros::from_millis(60_000);
            frame
        })
        .collect();
    show(&mut watch, &later);
    assert_eq!(watch.told(), Told::ByBus);
    assert_eq!(watch.damage(), [0, 0, 0]);
}

#[test]
fn frames_that_are_not_sound_are_counted_and_not_believed() {
    let all = frames("all.log");
    let (before, after) =
        all.split_at(all.iter().position(|frame| frame.time > Micros::from_millis(20_000)).unwrap());
    let mut watch = Watch::new(&demo_car(), Estimator::Bus).unwrap();
    show(&mut watch, before);
    assert_eq!(watch.damage(), [0, 0, 0]);
    let good = watch.round();
    let frame = after.iter().find(|frame| frame.id.number() == 0x6A4).unwrap();
    let mut data = frame.data().to_vec();
    // Another speed, under the old checksum.
    data[2] ^= 0x10;
    show(&mut watch, &[Frame::data_frame(frame.time, frame.id, &data).unwrap()]);
    assert_eq!(watch.damage(), [1, 0, 0]);
    assert_eq!(watch.round().speed.to_bits(), good.speed.to_bits(), "it was believed");
    show(&mut watch, &[Frame::remote(frame.time, frame.id, 8).unwrap()]);
    assert_eq!(watch.damage(), [1, 0, 1]);
    // One that never came, and one that came twice.
    let mut rest = after.to_vec();
    let lost = rest.iter().position(|frame| frame.id.number() == 0x6A0).unwrap();
    rest.remove(lost);
    let twice = rest.iter().position(|frame| frame.id.number() == 0x6A5).unwrap();
    rest.insert(twice, rest[twice]);
    show(&mut watch, &rest);
    assert_eq!(watch.damage(), [1, 2, 1]);
    let counts: Vec<_> = watch.messages().map(|(heard, _)| heard.counter_errors).collect();
    assert_eq!(counts, [1, 0, 0, 0, 0, 1, 0]);
}

#[test]
fn without_a_gripd_it_says_so_and_still_sees_what_is_wrong_with_the_inputs() {
    let inputs = frames("drive.log");
    let mut watch = Watch::new(&demo_car(), Estimator::Bus).unwrap();
    assert_eq!((watch.told(), watch.inputs().count()), (Told::Never, 12));
    let half = inputs.len() / 2;
    show(&mut watch, &inputs[..half]);
    assert_eq!((watch.told(), watch.bus_publishes()), (Told::Never, false));
    assert!(watch.round().speed.is_nan());
    assert_eq!(watch.faults(), Faults::empty());
    assert!(watch.inputs().all(|input| !input.is_stale && input.newest.is_some()));
    let row = watch.series().rows().back().unwrap();
    assert!(row.get(Column::Input(Quantity::WheelSpeedFl)) > 1.0);
    // The steering wheel's messages stop coming.
    let steering = watch.traffic().iter().find(|traffic| traffic.name() == "STEERING").unwrap().id();
    let rest: Vec<Frame> = inputs[half..].iter().filter(|frame| frame.id != steering).copied().collect();
    show(&mut watch, &rest);
    assert!(watch.faults().contains(Faults::TIMEOUT));
    assert!(watch.occurrences(Faults::TIMEOUT) > 0);
    let stale: Vec<_> = watch.inputs().filter(|input| input.is_stale).map(|input| input.quantity).collect();
    assert_eq!(stale, [Quantity::SteeringWheelAngle]);
    // The other estimator is there at once, for it has been listening.
    watch.set_estimator(Estimator::Own);
    assert_eq!(watch.told(), Told::ByOwn);
    assert_eq!(watch.round().state, Some(State::Degraded));
}

#[test]
fn a_configuration_that_publishes_nothing_still_tells_what_it_would() {
    let mut config = demo_car();
    config.publish.enabled = false;
    let mut watch = Watch::new(&config, Estimator::Own).unwrap();
    show(&mut watch, &frames("drive.log"));
    assert_eq!(watch.round().state, Some(State::Running));
}
