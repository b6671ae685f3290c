//! What is found beside the ordinary car of simulated drives.

use nalgebra::DMatrix;

use super::super::super::bench::recorded;
use super::super::answer::as_configured;
use super::super::bend::with_bend;
use super::super::inputs::Held;
use super::super::numbers::free;
use super::super::{Asked, Ordinary};
use super::*;
use physics::model::effect::{self, KINDS, named};

/// A library of these only: each test has a cause and what could be taken for it. All of it is asked in `causes`.
fn among(names: &[&str]) -> Vec<&'static Kind> {
    names.iter().map(|name| named(name).unwrap()).collect()
}

/// GIVEN what acts for a part of a drive WHEN its run branches off from the one without it THEN it says the same as a run
/// from the beginning.
#[test]
fn a_run_that_branches_off_says_the_same() {
    let (vehicle, recording) = recorded("");
    let own = with_bend(&vehicle);
    let drives = [FreeDrive::new(&recording, &own, Held::EveryThird, 600.0).unwrap()];
    let model = as_configured(&own, &[]);
    let free = free(&model, &own, &drives);
    let found = FreeFit {
        at: free.iter().map(|free| free.prior.0).collect(),
        covariance: DMatrix::zeros(0, 0),
        predicted: Vec::new(),
        noise: [0.01, 0.1],
        time_constants_s: [0.1; 2],
        starts: Vec::new(),
        model,
        free,
    };
    let trials = trial::trials(&found, &drives, KINDS, Scope::Car);
    let search = Search {
        drives: &drives,
        vehicle: &own,
        tried: BTreeMap::new(),
        plain: [0.0; 2],
        references: 0,
        is_simulated: false,
    };
    let tracks = search.tracks(&found.model, &found.free, &found.at);
    let (mut patches, mut differ) = (0, 0);
    for trial in trials.iter().step_by(7) {
        let Some(between) = trial.acts() else { continue };
        let model = trial.put_into(&found.model);
        let own = trial.free(&model);
        let free: Vec<_> = found.free.iter().copied().chain(own.iter().copied()).collect();
        let mut at = found.at.clone();
        at.extend(own.iter().map(|free| free.prior.0 + free.step));
        let whole = search.errors_of(&model, &free, &at, 0);
        let branched = search.branched(&tracks, between, (&model, &free, &at), 0);
        for (whole, branched) in whole.iter().flatten().zip(branched.iter().flatten()) {
            assert!(
                (whole - branched).abs() < 1e-7 || whole.is_nan() && branched.is_nan(),
                "{}",
                trial.name()
            );
        }
        let plain = search.errors_of(&found.model, &found.free, &found.at, 0);
        differ += usize::from(
            whole.iter().flatten().zip(plain.iter().flatten()).any(|(a, b)| (a - b).abs() > 1e-5),
        );
        patches += usize::from(trial.is_patch());
    }
    assert!(patches > 5 && differ > 10, "{patches} patches, {differ} differ");
}

/// What is found in a drive with these effects, by a search among these kinds.
fn found(effects: &str, library: &[&'static Kind]) -> Beyond {
    let (vehicle, recording) = recorded(effects);
    let asked = Asked { library, searches: &|_| true, ..Asked::CAR };
    Ordinary::of(&vehicle, &[], &[recording], asked).unwrap().beyond
}

/// GIVEN a yaw rate whose zero jumps, on driving that is fitted to and on driving that is held out THEN that is named
/// first, with its size and moment.
#[test]
#[ignore = "long: a car fitted, and more"]
fn a_jump_of_a_sensor_is_found_with_its_moment() {
    let library = among(&["sensor_bias", "sensor_drift", "road_bank", "crosswind", "tire_radius"]);
    for at in [15.0, 20.0] {
        let jump = "[[effect]]\nkind = \"sensor_bias\"\nchannel = \"yaw_rate\"\nbias = 0.03\nat_s = ";
        let beyond = found(&format!("{jump}{at:?}\n"), &library);
        let first = &beyond.findings[0];
        assert_eq!((first.effect.as_str(), first.channel.as_deref()), ("sensor_bias", Some("yaw_rate")));
        assert!((first.parameters["bias"].value - 0.03).abs() < 0.004, "{:?}", first.parameters);
        assert!((first.parameters["at_s"].value - at).abs() < 1.0, "{:?}", first.parameters);
        assert!(beyond.is_unusual && first.explained_share["yaw_rate"] > 0.05, "{first:?}");
    }
}

/// GIVEN a gyroscope whose zero drifts, beside wheels that turn as they should THEN the drift is named, with its size and
/// its course.
#[test]
#[ignore = "long: a car fitted, and more"]
fn a_drifting_gyroscope_is_told_from_the_road() {
    let drift = "[[effect]]\nkind = \"sensor_drift\"\nchannel = \"yaw_rate\"\n\
                 series = { t = [0.0, 10.0, 22.0, 35.0, 45.0], value = [0.02, -0.03, 0.04, -0.03, 0.02] }\n";
    let library = among(&["sensor_bias", "sensor_drift", "road_bank", "crosswind"]);
    let beyond = found(drift, &library);
    let first = &beyond.findings[0];
    assert_eq!((first.effect.as_str(), first.channel.as_deref()), ("sensor_drift", Some("yaw_rate")));
    let rms = first.parameters["drift_rms"];
    // A fifth of it is for what lines between few points smooth away.
    assert!((rms.value - 0.019).abs() < 0.004 && rms.std < 0.2 * rms.value + 0.0015, "{rms:?}");
    let course = first.series.as_ref().unwrap();
    let drifted = effect::Series { t: course.t.clone(), value: course.value.clone() };
    let [low, high, again] = [10.0, 22.0, 35.0].map(|t| drifted.at(t));
    assert!(high - low > 0.04 && high - again > 0.04, "{course:?}");
    assert!(!first.place.intervals.is_empty(), "{:?}", first.place);
    // Nothing else is named that no ordinary car has, and no jump.
    assert!(
        beyond.findings.iter().skip(1).all(|other| other.kind == Nature::Ordinary),
        "{:?}",
        beyond.findings
    );
}

/// GIVEN an accelerometer far ahead of the centre of gravity, which the ordinary car can only take for one that comes
/// before its time THEN that is named first, with its place.
#[test]
#[ignore = "long: a car fitted, and more"]
fn an_accelerometer_that_sits_ahead_is_not_called_early() {
    let library = among(&["accelerometer_position", "sensor_delay", "sensor_scale", "body_roll", "payload"]);
    let beyond = found("[[effect]]\nkind = \"accelerometer_position\"\nforward_of_cg_m = 1.5\n", &library);
    let first = &beyond.findings[0];
    assert_eq!(first.effect, "accelerometer_position", "{:?}", beyond.findings);
    assert!((first.parameters["forward_of_cg_m"].value - 1.5).abs() < 0.2, "{:?}", first.parameters);
    let is_early = |finding: &Finding| finding.channel.as_deref() == Some("lateral_acceleration");
    assert!(!beyond.findings.iter().any(is_early), "{:?}", beyond.findings);
}

/// GIVEN an ordinary car, its steering late THEN these are told, and nothing unusual.
#[test]
#[ignore = "long: a car fitted, and more"]
fn an_ordinary_car_has_nothing_unusual() {
    let late = "[[effect]]\nkind = \"sensor_delay\"\nchannel = \"steering_wheel_angle\"\ndelay_s = 0.08\n\
                [[effect]]\nkind = \"relaxation_length\"\nlength_m = 0.5\n";
    let beyond = found(late, KINDS);
    assert!(!beyond.is_unusual, "{:?}", beyond.findings);
    let delay = beyond.findings.iter().find(|finding| finding.effect == "sensor_delay").unwrap();
    assert_eq!(delay.channel.as_deref(), Some("steering_wheel_angle"));
    assert!((delay.parameters["delay_s"].value - 0.08).abs() < 0.02, "{:?}", delay.parameters);
}

mod by_hand {
    use super::*;

    /// GIVEN a car that pulls to the left when it brakes, as no effect of the library has it THEN that is told as a law, with
    /// its number.
    #[test]
    #[ignore = "by hand: laws searched, a minute; the commands' tests ask the same of a drive"]
    fn what_no_library_has_is_told_as_a_law() {
        let pull = "[[effect]]\nkind = \"law\"\nplace = \"front slip angle\"\n\
                    expression = \"coefficient * a_x\"\ncoefficient = 0.0008\n";
        let beyond =
            found(pull, &among(&["roll_steer", "brake_yaw_moment", "steering_compliance", "sensor_bias"]));
        let first = &beyond.findings[0];
        let law = first.law.as_ref().unwrap();
        assert_eq!((first.kind, law.place.as_str()), (Nature::Law, "front slip angle"), "{law:?}");
        assert_eq!(law.terms[0].feature, "a_x");
        assert_eq!(law.terms[0].unit, "rad/(m/s²)");
        assert!((law.terms[0].coefficient.value / 0.0008 - 1.0).abs() < 0.15, "{law:?}");
        assert!(beyond.is_unusual && first.explained_share["yaw_rate"] > 0.05, "{:?}", first.explained_share);
    }
}
