//! The faults, each at most ten seconds long.

use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::UnixStream;

use nix::sys::signal::Signal::{SIGCONT, SIGSTOP, SIGUSR1, SIGUSR2};

use super::super::bad_day::set_clock;
use super::super::traffic::{Flood, send_all};
use super::super::wrong_bus::swap;
use super::car::Wrong;
use super::*;

/// A kind of fault.
#[derive(Clone, Copy)]
pub struct Kind {
    pub name: &'static str,
    /// Makes it happen and undoes it; what it was in particular.
    pub happens: fn(&mut Stage, &mut Dice) -> String,
}

const fn kind(name: &'static str, happens: fn(&mut Stage, &mut Dice) -> String) -> Kind {
    Kind { name, happens }
}

pub const KINDS: &[Kind] = &[
    kind("the input goes down", |stage, dice| {
        let lasts = tenths(dice, 1, 50);
        stage.input.set("down");
        std::thread::sleep(lasts);
        stage.input.set("up");
        format!("for {lasts:?}")
    }),
    kind("the output goes down", |stage, dice| {
        let lasts = tenths(dice, 1, 50);
        stage.outputs[0].set("down");
        std::thread::sleep(lasts);
        stage.outputs[0].set("up");
        format!("for {lasts:?}")
    }),
    kind("both flap", |stage, dice| {
        let count = 2 + dice.below(9);
        for _ in 0..count {
            for link in [&stage.input, &stage.outputs[0]] {
                link.set("down");
                std::thread::sleep(Duration::from_millis(dice.below(200) as u64));
                link.set("up");
            }
            std::thread::sleep(Duration::from_millis(dice.below(300) as u64));
        }
        format!("{count} times")
    }),
    kind("the input is removed and made anew", |stage, dice| {
        let lasts = tenths(dice, 1, 30);
        stage.count_wrong();
        stage.input.remove();
        std::thread::sleep(lasts);
        assert!(Interface::create(stage.input.0));
        stage.ear_at_input = Ear::at(&stage.input);
        format!("after {lasts:?}")
    }),
    kind("output and another interface swap their names", |stage, _| {
        stage.count_wrong();
        let [output, other] = stage.outputs.each_ref().map(|interface| interface.0);
        // What is heard until the names change is right, and after that wrong.
        stage.right = 1 - stage.right;
        let was_right = 1 - stage.right;
        let before = swap(output, other, &stage.ears[was_right]);
        stage.ears[was_right].forget(before);
        "while all send".to_owned()
    }),
    kind("the process stands still", |stage, dice| {
        let lasts = tenths(dice, 2, 40);
        stage.gripd.signal(SIGSTOP);
        std::thread::sleep(lasts);
        stage.gripd.signal(SIGCONT);
        format!("for {lasts:?}")
    }),
    kind("its clock is set", |_, dice| {
        let step = *dice.of(&[-3600.0, -5.0, -0.9, -0.3, 0.2, 0.7, 4.0, 3600.0]);
        set_clock(step);
        format!("by {step} s")
    }),
    kind("hangups", |stage, dice| {
        let count = 1 + dice.below(50);
        (0..count).for_each(|_| stage.gripd.signal(SIGHUP));
        std::thread::sleep(Duration::from_secs(2));
        format!("{count} at once")
    }),
    kind("a broken configuration", |stage, dice| {
        let broken = match dice.below(4) {
            0 => stage.text[..dice.below(stage.text.len())].to_owned() + "[",
            1 => stage.text.replace("WHEELS.SpeedFL", "WHEELS.NoSuch"),
            2 => stage.text.replace("wheelbase_m = 2.65", "wheelbase_m = \u{7}"),
            _ => String::new(),
        };
        fs::write(&stage.config, &broken).unwrap();
        stage.gripd.signal(SIGHUP);
        std::thread::sleep(Duration::from_millis(2500));
        fs::write(&stage.config, &stage.text).unwrap();
        stage.gripd.signal(SIGHUP);
        std::thread::sleep(Duration::from_millis(2500));
        format!("of {} bytes", broken.len())
    }),
    kind("another configuration", |stage, dice| {
        let ratio = 14.0 + dice.below(30) as f64 / 10.0;
        let text = stage
            .text
            .replace("steering_ratio = { value = 15.5", &format!("steering_ratio = {{ value = {ratio:?}"));
        for text in [&text, &stage.text] {
            fs::write(&stage.config, text).unwrap();
            stage.gripd.signal(SIGHUP);
            std::thread::sleep(Duration::from_millis(2500));
        }
        format!("with a steering ratio of {ratio}")
    }),
    kind("a flood on the input", |stage, dice| {
        let lasts = tenths(dice, 5, 20);
        let noise = (0..1000).map(|number| data(0x200 + number % 0x300, &[0xA5; 8])).collect();
        let flood = Flood::start(stage.input.0, noise);
        std::thread::sleep(lasts);
        drop(flood);
        format!("for {lasts:?}")
    }),
    kind("a stranger sends what gripd does", |stage, dice| {
        let count = 10 + dice.below(200);
        for _ in 0..count {
            send_all(stage.outputs[0].0, &[data(0x6A0, &[0; 8])]);
            std::thread::sleep(Duration::from_millis(20));
        }
        format!("{count} frames")
    }),
    kind("a message that is wrong", |stage, dice| {
        let id = *dice.of(&[Car::INERTIAL, Car::STEERING, Car::DRIVE, Car::WHEELS]);
        let place = if id == Car::INERTIAL { 2 + 2 * dice.below(3) } else { 0 };
        let wrong = *dice.of(&[
            Wrong::Missing,
            Wrong::Twice,
            Wrong::Short,
            Wrong::Remote,
            Wrong::Ones,
            Wrong::Frozen,
            Wrong::Checksum,
            Wrong::Reversed(place),
        ]);
        let lasts = tenths(dice, 1, 80);
        let spoil = || stage.car.spoil(Some(id), wrong, lasts);
        if id == Car::WHEELS {
            stage.watch.without_comparing(spoil)
        } else {
            spoil()
        }
        format!("{id:03X} {wrong:?} for {lasts:?}")
    }),
    kind("silence", |stage, dice| {
        let lasts = tenths(dice, 1, 80);
        stage.car.spoil(None, Wrong::Missing, lasts);
        format!("for {lasts:?}")
    }),
    kind("a folder that cannot be used", |stage, dice| {
        let folder = stage.folder.join(*dice.of(&["state", "faults"]));
        let aside = stage.folder.join("aside");
        let lasts = tenths(dice, 10, 80);
        let is_there = fs::rename(&folder, &aside).is_ok();
        // Something else in its place.
        fs::write(&folder, "").unwrap();
        std::thread::sleep(lasts);
        fs::remove_file(&folder).unwrap();
        if is_there {
            fs::rename(&aside, &folder).unwrap();
        }
        format!("{} for {lasts:?}", folder.file_name().unwrap().display())
    }),
    kind("a state of another mode or contents", |stage, dice| {
        let state = stage.folder.join("state/learned.toml");
        let mode = *dice.of(&[0o000, 0o400, 0o777]);
        let _ = fs::set_permissions(&state, fs::Permissions::from_mode(mode));
        if dice.once_in(2) {
            let _ = fs::write(&state, "damaged");
        }
        format!("{mode:o}")
    }),
    kind("it is to forget", |stage, dice| {
        let signal = *dice.of(&[SIGUSR1, SIGUSR2]);
        stage.gripd.signal(signal);
        format!("{signal}")
    }),
    kind("readers of the metrics that hang", |stage, dice| {
        let count = 1 + dice.below(5);
        let readers: Vec<_> = (0..count).map(|_| UnixStream::connect(stage.folder.join("metrics"))).collect();
        std::thread::sleep(Duration::from_secs(2));
        drop(readers);
        format!("{count}")
    }),
];

/// Tenths of seconds.
fn tenths(dice: &mut Dice, least: usize, most: usize) -> Duration {
    Duration::from_millis(100 * (least + dice.below(most - least + 1)) as u64)
}
