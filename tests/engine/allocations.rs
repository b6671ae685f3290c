//! GIVEN the service after its start WHEN it works THEN it takes no memory from the heap: its time per
//! frame does not depend on the allocator, and there is nothing that could leak or fragment.

use std::io::Cursor;
use std::sync::OnceLock;

use gripd::can::Frame;
use gripd::can::candump::Reader;
use gripd::service::{BlackBox, Engine, Keeper, SavedState, Sink};
use gripd::{Config, Estimates, Micros, Sample};
use testing::allocator;
use testing::program;
use testing::program::project;

/// How often the allocator was called meanwhile, by this thread.
fn requests_of(work: impl FnOnce()) -> u64 {
    allocator::asked_by(work).requests
}

/// The demo drive of 120 s, as a log.
fn demo_drive() -> &'static str {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(|| {
        let mut simulate = program::gripd();
        simulate.arg("simulate").arg(project("config/scenarios/demo.toml")).args(["-o", "-"]);
        let output = simulate.output().unwrap();
        assert!(output.status.success());
        String::from_utf8(output.stdout).unwrap()
    })
}

fn reader(text: &str) -> Reader {
    Reader::from_read(Box::new(Cursor::new(text.to_owned())), "drive").unwrap()
}

fn frames(text: &str) -> Vec<Frame> {
    let mut reader = reader(text);
    std::iter::from_fn(|| reader.next_frame().unwrap()).collect()
}

#[derive(Default)]
struct Count {
    samples: u64,
    published: u64,
    running: u64,
}

impl Sink for Count {
    fn estimates(&mut self, _: &Sample, estimates: &Estimates) {
        self.samples += 1;
        self.running += u64::from(estimates.friction.max.is_some());
    }

    fn publish(&mut self, frame: &Frame) {
        self.published += u64::from(frame.length() == 8);
    }
}

#[test]
fn the_counter_counts() {
    assert_eq!(requests_of(|| drop(std::hint::black_box(Box::new(1)))), 2);
    assert_eq!(requests_of(|| {}), 0);
}

/// After one second, over everything there is in the demo drive: curves, three surfaces, ABS.
#[test]
fn the_engine_takes_none() {
    let plain = Config::load(&project("config/demo.toml")).unwrap();
    let mut with_effects = plain.clone();
    with_effects.effect = [
        "kind = 'relaxation_length'\nlength_m = 0.5",
        "kind = 'body_roll'\nroll_gain_rad_per_mps2 = 0.005",
        "kind = 'steering_compliance'\ncompliance_rad_per_nm = 1e-5",
    ]
    .map(|effect| toml::from_str(effect).unwrap())
    .to_vec();
    takes_none(&plain);
    takes_none(&with_effects);
}

fn takes_none(car: &Config) {
    let mut engine = Engine::new(car).unwrap();
    let drive = frames(demo_drive());
    let warm = drive[0].time + Micros::from_millis(1_000);
    let (start, rest) = drive.split_at(drive.partition_point(|frame| frame.time < warm));
    let mut sink = Count::default();
    start.iter().for_each(|frame| engine.frame(frame, &mut sink));
    let before = engine.counts().samples;
    let requests = requests_of(|| rest.iter().for_each(|frame| engine.frame(frame, &mut sink)));
    let samples = engine.counts().samples - before;
    assert!(samples > 11_800 && sink.published > 30_000 && sink.running > 0, "{samples} samples");
    assert_eq!(requests, 0, "in {samples} samples");
}

/// Nor does handing over what was learned, to a writer that waits for the disk in its own time.
#[test]
fn keeping_what_was_learned_takes_none() {
    let car = Config::load(&project("config/demo.toml")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state.toml");
    let mut engine = Engine::new(&car).unwrap();
    let mut keeper = Keeper::start(SavedState::new(&path, &car), 1, &mut engine).unwrap();
    let mut sink = Count::default();
    let drive = frames(demo_drive());
    let (start, rest) = drive.split_at(drive.len() / 100);
    start.iter().for_each(|frame| engine.frame(frame, &mut sink));
    let requests = requests_of(|| {
        for frame in rest {
            engine.frame(frame, &mut sink);
            keeper.offer(&engine);
        }
    });
    assert_eq!(requests, 0);
    keeper.finish(&engine);
    let learned = SavedState::new(&path, &car).load().unwrap().unwrap();
    assert!(learned.driving_s > 100.0 && learned.driving_s == engine.driving_s());
}

/// Nor does the black box, to whose ring each frame goes and whose writer is told of faults.
#[test]
fn recording_faults_takes_none() {
    let car = Config::load(&project("config/demo.toml")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut engine = Engine::new(&car).unwrap();
    let mut service = car.service.clone();
    service.record_faults = Some(folder.path().to_owned());
    let mut black_box = BlackBox::start(&service, "can0", "can0", &engine).unwrap();
    let mut sink = Count::default();
    let drive = frames(demo_drive());
    let (start, rest) = drive.split_at(drive.len() / 100);
    start.iter().for_each(|frame| engine.frame(frame, &mut sink));
    let requests = requests_of(|| {
        for (number, frame) in rest.iter().enumerate() {
            // Each message for half a second: there are faults.
            if number % 20_000 < 250 {
                continue;
            }
            black_box.input(frame);
            engine.frame(frame, &mut sink);
            black_box.look(&engine);
        }
    });
    assert_eq!(requests, 0);
    black_box.finish();
    assert!(std::fs::read_dir(folder.path()).unwrap().count() >= 2, "no recording and its state");
}

/// Nor do bad days change that: gaps, damaged frames, a clock that is set back. With the thesis's estimators, too.
#[test]
fn the_engine_takes_none_on_bad_days() {
    let mut engine = Engine::new(&Config::load(&project("config/demo.toml")).unwrap()).unwrap().with_thesis();
    let drive = frames(demo_drive());
    let mut bad = Vec::with_capacity(2 * drive.len());
    for (number, frame) in drive.iter().enumerate() {
        let mut frame = *frame;
        match number % 1000 {
            0..50 => continue,
            100 => frame = Frame::data_frame(frame.time, frame.id, &[0xFF; 8]).unwrap(),
            200 => frame = Frame::data_frame(frame.time, frame.id, &[]).unwrap(),
            300 => frame = Frame::remote(frame.time, frame.id, 8).unwrap(),
            400 => frame.time = frame.time - Micros::from_millis(500),
            _ => {}
        }
        if number > drive.len() / 2 {
            frame.time = frame.time - Micros::from_millis(100_000);
        }
        bad.push(frame);
    }
    let mut sink = Count::default();
    bad[..500].iter().for_each(|frame| engine.frame(frame, &mut sink));
    let requests = requests_of(|| bad[500..].iter().for_each(|frame| engine.frame(frame, &mut sink)));
    assert!(sink.samples > 8_000, "{} samples", sink.samples);
    assert_eq!(requests, 0);
}

#[test]
fn reading_a_recording_takes_none() {
    let mut reader = reader(demo_drive());
    // The first frame brings the interface's name.
    reader.next_frame().unwrap().unwrap();
    let mut frames = 0;
    let requests = requests_of(|| {
        while let Ok(Some(_)) = reader.next_frame() {
            frames += 1;
        }
    });
    assert!(frames > 50_000);
    assert_eq!(requests, 0, "in {frames} frames");
}
