//! GIVEN a recorded drive WHEN it is played onto a bus where gripd runs THEN the estimates are on the
//! bus, well formed, and a replay of what candump recorded gives the same ones to the last bit.

use std::io::Write;

use super::*;

/// Plays a recording with canplayer while gripd runs and candump records.
fn show(name: &str, interface: &Interface, config: &Path, recording: &[Frame]) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let played = folder.join(format!("{name}.played.log"));
    let recorded = folder.join(format!("{name}.candump.log"));
    write(&played, recording);

    let candump = Recorder::start(interface.0);
    let gripd = Gripd::start(config, interface.0);
    let mut canplayer = Command::new("canplayer");
    canplayer.arg("-I").arg(&played).arg(format!("{}=car", interface.0));
    assert!(canplayer.status().unwrap().success());
    candump.save(&recorded);
    let tally = gripd.end(SIGINT);
    println!("{name}: {tally:?}");

    let all = frames(&recorded);
    let live: Vec<&Frame> = all.iter().filter(|frame| is_published(frame)).collect();
    let of_the_car = all.iter().filter(|frame| !is_published(frame) && frame.id.number() != 0x7FF);
    assert!(of_the_car.map(|f| (f.id, f.data())).eq(recording.iter().map(|f| (f.id, f.data()))));
    let seconds = (recording[recording.len() - 1].time - recording[0].time).seconds();
    let rounds = live.len() as f64 / published_ids().len() as f64;
    // Every 20 ms, less the start and less what the player's own pauses cost: a busy guest makes many.
    let expected = seconds * 50.0;
    assert!((0.5 * expected..expected + 1.0).contains(&rounds), "{rounds} rounds in {seconds} s");
    // With those that go on when the car has ended, and the last one.
    assert!(tally.published > live.len(), "{tally:?}, {} in the drive", live.len());
    assert_eq!((tally.unsent, tally.dropped, tally.foreign), (0, 0, 0));

    let replayed = folder.join(format!("{name}.replayed.log"));
    let mut replay = Command::new(process::gripd());
    replay.args(["replay", "-q", "-c"]).arg(config).arg(&recorded).arg("-o").arg(&replayed);
    assert!(replay.status().unwrap().success());
    let replayed = frames(&replayed);
    assert!(replayed.len() >= live.len() && replayed.len() - live.len() <= tally.late, "{tally:?}");
    let mut delays: Vec<Micros> = Vec::new();
    // Where the guest was too slow for a round, that is told.
    let is_told = |frame: &Frame| tally.late > 0 && (0x6A5..=0x6A6).contains(&frame.id.number());
    let same = |live: &Frame, replayed: &Frame| {
        live.id == replayed.id
            && (live.data() == replayed.data()
                || is_told(live) && live.data()[1] & 15 == replayed.data()[1] & 15)
    };
    let mut due = replayed.iter();
    for (number, live) in live.iter().enumerate() {
        let replayed = if tally.late == 0 { due.next() } else { due.find(|replayed| same(live, replayed)) };
        let replayed = replayed.filter(|replayed| same(live, replayed));
        let replayed = replayed.unwrap_or_else(|| panic!("published frame {number}: {live:?}"));
        // A replay stamps a published frame with the time of the frame that made it due.
        delays.push(live.time - replayed.time);
    }
    delays.sort();
    let median = delays[delays.len() / 2];
    println!(
        "{name}: on the bus {median} s after the frame that made it due (median), at most {} s",
        delays[delays.len() - 1]
    );
    assert!(delays[0] >= Micros(0) && median < Micros(10_000), "median {median} s");

    counters_and_checksums(&live, tally.late == 0);
    as_cantools_sees_them(&live);
}

fn write(path: &Path, recording: &[Frame]) {
    let mut writer = Writer::create(path, "car").unwrap();
    for frame in recording {
        writer.write(frame).unwrap();
    }
    writer.finish().unwrap();
}

/// AUTOSAR E2E profile 1A, bit by bit: CRC-8 SAE J1850 polynomial, start 0, over the two bytes of the
/// data ID (low first), then the payload without the checksum itself.
fn checksum(frame: &Frame) -> u8 {
    let id = frame.id.number() as u16;
    let bytes = id.to_le_bytes().into_iter().chain(frame.data()[1..].iter().copied());
    bytes.fold(0, |crc: u8, byte| {
        (0..8).fold(crc ^ byte, |crc, _| if crc & 0x80 != 0 { crc << 1 ^ 0x1D } else { crc << 1 })
    })
}

fn counters_and_checksums(published: &[&Frame], whole: bool) {
    for id in published_ids() {
        let of_this = published.iter().filter(|frame| frame.id == id);
        let mut count = 0;
        for (number, frame) in of_this.enumerate() {
            assert_eq!(frame.data()[0], checksum(frame), "{id}, frame {number}");
            assert!(!whole || usize::from(frame.data()[1] & 0xF) == number % 15, "{id}, frame {number}");
            count += 1;
        }
        assert_eq!(count, published.len() / published_ids().len(), "{id}");
    }
}

/// Cantools decodes every frame, and the numbers are those of a car that drives.
fn as_cantools_sees_them(published: &[&Frame]) {
    let Some(python) = testing::python() else { return };
    let dbc = project("dbc/gripd.dbc");
    let mut cantools = testing::reference(&python);
    cantools.arg("strict").arg(dbc).stdin(std::process::Stdio::piped()).stdout(std::process::Stdio::piped());
    let mut cantools = cantools.spawn().unwrap();
    let mut input = cantools.stdin.take().unwrap();
    let text: String = published
        .iter()
        .map(|f| format!("{} {}\n", f.id, f.data().iter().map(|b| format!("{b:02X}")).collect::<String>()))
        .collect();
    let writer = std::thread::spawn(move || input.write_all(text.as_bytes()));
    let output = cantools.wait_with_output().unwrap();
    writer.join().unwrap().unwrap();
    assert!(output.status.success());
    let answers: Vec<serde_json::Value> = String::from_utf8(output.stdout)
        .unwrap()
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(answers.len(), published.len());
    let texts = |message: &str, signal: &str| -> Vec<String> {
        let those = answers.iter().filter(|answer| answer["message"] == message);
        those.filter_map(|answer| answer["texts"][signal].as_str().map(str::to_owned)).collect()
    };
    let states = texts("GRIP_STATUS", "State");
    let running = states.iter().filter(|state| *state == "running").count();
    assert!(running > states.len() / 2, "{running} of {} are running: {:?}", states.len(), states.last());
    let speeds: Vec<f64> = answers
        .iter()
        .filter(|answer| answer["message"] == "GRIP_MOTION")
        .map(|answer| answer["values"]["Speed"].as_str().unwrap())
        .map(|bits| f64::from_bits(u64::from_str_radix(bits, 16).unwrap()))
        .collect();
    let driving = speeds.iter().filter(|speed| (5.0..35.0).contains(*speed)).count();
    assert!(driving > speeds.len() * 9 / 10, "{driving} of {} speeds are believable", speeds.len());
}

#[test]
#[ignore = "long: 30 s"]
fn a_simulated_drive() {
    let Some(interface) = Interface::new("gs_demo") else { return };
    show("demo", &interface, &demo_car(), &frames(simulated_drive()));
}

/// 15 s of the RAV4's recording; all 60 s of it with GRIPD_WHOLE_RAV4 set.
#[test]
fn a_real_car() {
    let Some(interface) = Interface::new("gs_rav4") else { return };
    let Some(log) = testing::shared("recordings/rav4/bus0.log.gz") else { return };
    let mut recording = frames(&log);
    if std::env::var_os("GRIPD_WHOLE_RAV4").is_none() {
        let end = recording[0].time + Micros::from_millis(15_000);
        recording.retain(|frame| frame.time < end);
    }
    assert!(recording.len() > 10_000);
    show("rav4", &interface, &project("config/rav4.toml"), &recording);
}
