//! Hours of bad luck: random faults of all kinds on two interfaces, one a minute, in the guest.
//!
//! GIVEN a service that listens on one bus and publishes on another WHEN links, clocks, disks, other nodes, sensors and
//! its own process have faults, one after the other, THEN it never panics, sends not one frame on a bus that is not its
//! own and none that is older than a tenth of a second, needs no more memory at the end than at the beginning, and
//! writes less than a megabyte of log. Two hours of it, the faults of a seed that is printed:
//!
//! ```text
//! CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUNNER=$PWD/tests/vcan/run.sh VCAN_TIMEOUT=8000 \
//!     cargo test --release --test vcan campaign::by_hand -- --ignored --nocapture
//! ```
//!
//! `GRIPD_CAMPAIGN_S` (7200), `GRIPD_CAMPAIGN_EVERY_S` (60; no fault lasts longer than ten), `GRIPD_CAMPAIGN_SEED` (1).

mod car;
mod kinds;
mod watch;

use std::fs;

use self::car::Car;
use self::kinds::KINDS;
use self::watch::Watch;
use super::lateness::used_by;
use super::wrong_bus::Ear;
use super::*;
use testing::dice::Dice;
use testing::setting::setting;

/// All that a fault may have to do with.
struct Stage {
    gripd: Gripd,
    car: Car,
    watch: Watch,
    /// Where the car sends; where gripd publishes, and a third one, by the names that they had at first.
    input: Interface,
    outputs: [Interface; 2],
    /// What is heard on each of the outputs, whatever it is called, and on the input.
    ears: [Ear; 2],
    ear_at_input: Ear,
    /// Which of them has the name of the output now.
    right: usize,
    config: PathBuf,
    /// The configuration as it should be.
    text: String,
    folder: PathBuf,
    /// Frames on a bus that was not gripd's.
    wrong: usize,
}

impl Stage {
    /// Counts what was heard where nothing may be heard.
    fn count_wrong(&mut self) {
        self.wrong += self.ears[1 - self.right].take() + self.ear_at_input.take();
        self.ears[self.right].take();
    }
}

/// The demo's car on a road on which its speed always changes: what is published tells of which moment it is.
fn drive(folder: &Path) -> Vec<Frame> {
    let demo = fs::read_to_string(project("config/scenarios/demo.toml")).unwrap();
    let (before, rest) = demo.split_once("points = [\n").unwrap();
    let (_, after) = rest.split_once("\n]\n").unwrap();
    let points = "points = [[0, 10], [5, 25], [10, 10], [15, 25], [20, 10]]\n";
    let scenario = format!("{before}{points}{after}")
        .replace("duration_s = 120.0", "duration_s = 20.0")
        .replace("initial_speed_mps = 15.0", "initial_speed_mps = 10.0")
        .replace("rms = 1.5\n", "rms = 0.01\n");
    let (file, log) = (folder.join("drive.toml"), folder.join("drive.log"));
    fs::write(&file, scenario).unwrap();
    let mut simulate = Command::new(gripd());
    simulate.args(["-q", "simulate"]).arg(&file).arg("-o").arg(&log);
    assert!(simulate.status().unwrap().success());
    frames(&log)
}

mod by_hand {
    use super::*;

    #[test]
    #[ignore = "by hand: two hours"]
    fn faults_of_all_kinds() {
        campaign(setting("GRIPD_CAMPAIGN_S", 7200), setting("GRIPD_CAMPAIGN_EVERY_S", 60));
    }
}

fn campaign(seconds: u64, every_s: u64) {
    let Some(input) = Interface::new("gs_ca0") else { return };
    let (Some(output), Some(other)) = (Interface::new("gs_ca1"), Interface::new("gs_ca2")) else { return };
    let seed = setting("GRIPD_CAMPAIGN_SEED", 1);
    let folder = tempfile::tempdir_in("/dev/shm").unwrap();
    let path = folder.path();
    let service = format!(
        "\n[publish]\ninterface = \"{}\"\n[service]\nstate_file = \"{state}\"\nstate_every_s = 5\n\
         record_faults = \"{faults}\"\nrecord_files = 10\nmetrics = \"{metrics}\"\n",
        output.0,
        state = path.join("state/learned.toml").display(),
        faults = path.join("faults").display(),
        metrics = path.join("metrics").display(),
    );
    fs::create_dir(path.join("state")).unwrap();
    let config = edited_car(|text| text + &service);
    let drive = drive(path);
    let watch = Watch::start(input.0, output.0);
    let gripd = Gripd::start(config.path(), input.0);
    let mut stage = Stage {
        gripd,
        car: Car::start(input.0, drive),
        watch,
        ears: [Ear::at(&output), Ear::at(&other)],
        ear_at_input: Ear::at(&input),
        input,
        outputs: [output, other],
        right: 0,
        config: config.path().to_owned(),
        text: fs::read_to_string(config.path()).unwrap(),
        folder: path.to_owned(),
        wrong: 0,
    };
    stage.watch.wait_for_rounds(100);
    println!("seed {seed}, {seconds} s, a fault each {every_s} s");
    let mut dice = Dice::new("campaign", seed, 0);
    let mut left = Vec::new();
    let begun = Instant::now();
    let mut resident = Vec::new();
    let mut count = 0;
    while begun.elapsed() < Duration::from_secs(seconds) {
        let next = Instant::now() + Duration::from_secs(every_s);
        // Each kind once before any of them comes again.
        if left.is_empty() {
            left = KINDS.to_vec();
        }
        let kind = left.swap_remove(dice.below(left.len()));
        let at = begun.elapsed().as_secs();
        let what = (kind.happens)(&mut stage, &mut dice);
        count += 1;
        println!("{at:5} s  {}: {what}", kind.name);
        stage.watch.wait_for_rounds(50);
        while Instant::now() < next {
            std::thread::sleep(Duration::from_millis(200));
            stage.count_wrong();
        }
        assert!(stage.gripd.is_running(), "it has ended:\n{}", stage.gripd.log());
        resident.push(used_by(stage.gripd.id()).1);
        assert_eq!(stage.wrong, 0, "frames on a wrong bus after {}: {what}", kind.name);
        assert_eq!(stage.watch.problems(), [] as [String; 0], "after {}: {what}", kind.name);
    }
    let Stage { gripd, watch, wrong, .. } = stage;
    let log = gripd.log();
    let early = resident[resident.len() / 4];
    let late = resident[resident.len() - 1];
    println!(
        "{count} faults in {} s: {} rounds, {} motions compared, the oldest {:.0?} ms old (while the bus had no gaps, and at all), {:.1} rounds at once; {wrong} frames on a wrong bus; \
         {early} KiB after a quarter, {late} KiB at the end; {} bytes of log; recordings: {}",
        begun.elapsed().as_secs(),
        watch.rounds(),
        watch.compared(),
        watch.oldest_ms(),
        watch.burst(),
        log.len(),
        fs::read_dir(path.join("faults")).map_or(0, Iterator::count),
    );
    println!("{:?}", gripd.end(SIGTERM));
    assert!(!log.contains("panicked"), "{log}");
    assert!(log.len() < 1_000_000, "{} bytes of log", log.len());
    assert!(late < early + 1024, "{early} KiB, then {late}: {resident:?}");
    assert!(watch.compared() as u64 > 20 * seconds, "{} motions compared", watch.compared());
}
