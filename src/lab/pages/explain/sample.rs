//! Answers as the engine gives them, for tests of what is made of them.

use std::collections::BTreeMap;

use crate::explain::{
    Block, ByChannel, CourseEstimate, Driven, Estimate, Explanation, Finding, Missing, Models, Nature, OffBy,
    Parts, Ranked, SecondPass, Simulated, Trace, Verdict, Where, Without,
};
use physics::model::effect;

const RECORDING: &str = "lane_changes <dry>.log";

/// Each verdict once, with the sentence that it must say.
pub fn all() -> [(Explanation, &'static str); 5] {
    [
        (missing(), "Missing in the model: load transfer"),
        (several(), "Missing in the model: road bank; wrong in the measurement: late yaw rate"),
        (adequate(), "The plain model is adequate"),
        (unknown(), "Something is missing that no known effect explains"),
        (insufficient(), "This drive says too little to judge the model"),
    ]
}

/// Load transfer, which might be body roll.
pub fn missing() -> Explanation {
    let place = Where {
        equation: "lateral force balance".into(),
        channels: vec!["lateral_acceleration".into(), "yaw_rate".into()],
        regimes: vec!["|a_y| above 5 m/s²".into(), "12 to 25 m/s".into(), "quick steering & braking".into()],
        intervals: vec![[12.3, 18.9], [31.0, 38.2], [52.0, 57.5], [80.4, 96.1], [110.0, 113.0]],
        recording: RECORDING.into(),
        ..Where::default()
    };
    let finding = finding(
        "load_transfer",
        None,
        &[
            ("cg_height_m", 0.5532, 0.0213),
            ("load_sensitivity", 0.42, 0.11),
            ("front_roll_share", 0.56, 0.07),
        ],
        &place,
    );
    Explanation {
        verdict: Verdict::MissingPhysics,
        findings: vec![Finding { indistinguishable_from: vec!["body_roll".into()], ..finding }],
        place,
        ..plain(120.0, &[RECORDING], 1.0)
    }
}

/// A bank and a late sensor, in two long recordings.
pub fn several() -> Explanation {
    let names = ["motorway.log", "country road.log.zst"];
    let of = |name: &str, intervals: Vec<[f64; 2]>| Where {
        equation: "lateral force balance".into(),
        channels: vec!["yaw_rate".into()],
        regimes: vec!["everywhere".into()],
        intervals,
        recording: name.into(),
        ..Where::default()
    };
    let place = of(names[1], vec![[100.0, 160.0], [300.0, 420.0]]);
    let mut bank = finding("road_bank", None, &[("bank_rms_rad", 0.0312, 0.0018)], &place);
    let t: Vec<f64> = (0..600).map(f64::from).collect();
    bank.series = Some(CourseEstimate {
        value: t.iter().map(|t| 0.04 * (0.02 * t).sin()).collect(),
        std: t.iter().map(|t| if (200.0..230.0).contains(t) { 0.08 } else { 0.004 }).collect(),
        t,
        unit: "rad".into(),
    });
    let late = of(names[0], vec![[0.0, 600.0]]);
    let mut delay = finding("sensor_delay", Some("yaw_rate"), &[("delay_s", 0.0431, 0.0021)], &late);
    delay.probability = 0.9991;
    Explanation {
        verdict: Verdict::MissingPhysics,
        findings: vec![bank, delay],
        place,
        measurement_chain: vec![
            "yaw_rate is later than the wheels by 43 ms (likely)".into(),
            "steering_wheel_angle has an offset of 1.3° <learnt by the estimators>".into(),
        ],
        ..plain(600.0, &names, 0.6)
    }
}

/// What somebody's simulation leaves out: load transfer, a late sensor, and a stiffness that is another one.
pub fn beside_a_simulation() -> Explanation {
    let place = Where { recording: RECORDING.into(), ..Where::default() };
    let shares: ByChannel = [("yaw_rate".to_owned(), 0.4), ("lateral_acceleration".to_owned(), 0.2)].into();
    let side_forces = [("front_outer", -0.11), ("front_inner", 0.19), ("front", 0.03), ("rear", 0.001)];
    let without = Without {
        yaw_rate: Some(OffBy { rms: 0.021, most: 0.12, most_at_s: 34.2 }),
        turning_mps2: 6.0,
        turning_at_mps: 15.0,
        too_much_side_force: side_forces.map(|(part, share)| (part.to_owned(), share)).into(),
    };
    let second = |first: &Finding| SecondPass {
        first_parameters: first.parameters.clone(),
        moved: Vec::new(),
        evidence: 60.0,
        explained_share: shares.clone(),
        interplay: [("yaw_rate".to_owned(), 0.04)].into(),
        without: without.clone(),
    };
    let mut load = finding("load_transfer", None, &[("cg_height_m", 0.5532, 0.0213)], &place);
    let mut late = finding("sensor_delay", Some("yaw_rate"), &[("delay_s", 0.0431, 0.0021)], &place);
    let mut softer = Finding {
        effect: "lateral_stiffness_front".into(),
        kind: Nature::Ordinary,
        parameters: [("lateral_stiffness_front".to_owned(), estimate(12.0, 0.2))].into(),
        reference_value: Some(estimate(15.0, 0.1)),
        place: place.clone(),
        ..Finding::default()
    };
    for finding in [&mut load, &mut late, &mut softer] {
        finding.second_pass = Some(second(finding));
    }
    if let Some(second) = &mut late.second_pass {
        second.first_parameters.insert("delay_s".into(), Estimate { value: 0.06, std: 0.002 });
        second.moved.push("delay_s".into());
    }
    let mut answer = Explanation {
        verdict: Verdict::MissingPhysics,
        findings: vec![load, late, softer],
        simulation: Some(Simulated {
            name: "model.csv".into(),
            time_offset_s: 0.0,
            steered_alike: Some(true),
            emulated_fit: [("yaw_rate".to_owned(), 99.2)].into(),
            tuned: BTreeMap::new(),
            fell_away: vec!["body_roll".into()],
            is_bent: false,
        }),
        is_by_ordinary: true,
        ..plain(120.0, &[RECORDING], 1.0)
    };
    answer.error.ordinary = Some(answer.error.baseline.clone());
    answer
}

/// An hour.
pub fn long() -> Explanation {
    Explanation { verdict: Verdict::MissingPhysics, ..plain(3600.0, &["hour.log"], 1.0) }
}

/// Nothing.
pub fn adequate() -> Explanation {
    let base = plain(120.0, &[RECORDING], 0.0);
    let parameters = Models { extended: base.parameters.baseline.clone(), ..base.parameters.clone() };
    let fit = Models { extended: base.fit.baseline.clone(), ..base.fit };
    let error = Models { extended: base.error.baseline.clone(), ..base.error };
    Explanation {
        verdict: Verdict::Adequate,
        fit,
        error,
        parameters,
        unexplained: [("yaw_rate".into(), 0.004), ("lateral_acceleration".into(), 0.011)].into(),
        place: Where::default(),
        ranking: base.ranking.into_iter().map(|it| Ranked { score: 0.004 * it.score - 4.0, ..it }).collect(),
        to_drive: Vec::new(),
        improvement_ci95: BTreeMap::new(),
        log_likelihood: Models { extended: base.log_likelihood.baseline.clone(), ..base.log_likelihood },
        ..plain(120.0, &[RECORDING], 0.0)
    }
}

/// Something, but what?
pub fn unknown() -> Explanation {
    let place = Where {
        equation: "the yaw moment balance".into(),
        channels: vec!["yaw_rate".into()],
        regimes: vec!["braking harder than 3 m/s²".into()],
        intervals: vec![[40.0, 47.0], [90.0, 95.0]],
        recording: RECORDING.into(),
        ..Where::default()
    };
    Explanation { verdict: Verdict::UnknownPhysics, place, ..plain(120.0, &[RECORDING], 0.5) }
}

/// Straight ahead.
pub fn insufficient() -> Explanation {
    let base = adequate();
    Explanation {
        verdict: Verdict::InsufficientExcitation,
        ranking: Vec::new(),
        fit: Models {
            baseline: Parts { holdout: [("yaw_rate".into(), f64::NAN)].into(), ..Parts::default() },
            ..Models::default()
        },
        to_drive: vec![
            "steady turns both ways with 3 to 5 m/s²".into(),
            "brake and accelerate, straight ahead & hard".into(),
        ],
        ..base
    }
}

fn finding(name: &str, channel: Option<&str>, numbers: &[(&str, f64, f64)], place: &Where) -> Finding {
    let kind = effect::named(name).unwrap();
    Finding {
        effect: name.into(),
        channel: channel.map(Into::into),
        kind: Nature::of(kind),
        explained_share: Default::default(),
        probability: 0.97,
        indistinguishable_from: Vec::new(),
        to_tell_apart: kind.to_tell_apart.into(),
        parameters: numbers
            .iter()
            .map(|(name, value, std)| ((*name).into(), estimate(*value, *std)))
            .collect(),
        at_utc: None,
        series: None,
        place: place.clone(),
        about: kind.about.into(),
        equation: kind.equation.into(),
        evidence: 412.0,
        reference_value: None,
        second_pass: None,
        law: None,
    }
}

fn estimate(value: f64, std: f64) -> Estimate {
    Estimate { value, std }
}

/// Everything but verdict and findings; the plain model misses so much.
fn plain(seconds: f64, recordings: &[&str], misses: f64) -> Explanation {
    let fits = |by: &[(&str, f64)]| by.iter().map(|(name, fit)| ((*name).to_owned(), *fit)).collect();
    let estimates = |by: &[(&str, f64, f64)]| -> BTreeMap<String, Estimate> {
        by.iter().map(|(name, value, std)| ((*name).to_owned(), estimate(*value, *std))).collect()
    };
    let blocks = (seconds / 20.0) as usize;
    let split = recordings.iter().flat_map(|recording| {
        (0..blocks).map(|place| Block {
            t_utc: None,
            recording: (*recording).into(),
            t: [20.0 * place as f64, 20.0 * (place + 1) as f64],
            is_holdout: place % 3 == 2,
        })
    });
    let traces = recordings.iter().flat_map(|recording| traces(recording, seconds, misses));
    let driven = recordings.iter().map(|recording| Driven {
        recording: (*recording).into(),
        rows: (0..(seconds * 20.0) as usize)
            .map(|place| place as f64 * 0.05)
            .map(|t| [t, 18.0 + 6.0 * (0.05 * t).sin(), 0.3 * (0.5 * t).sin()])
            .collect(),
    });
    let missing = |ratios: [f64; 3]| {
        let rows = [
            ("lateral force balance", "m/s²"),
            ("yaw moment balance", "rad/s²"),
            ("longitudinal force balance", "m/s²"),
        ];
        let row = |((equation, unit), ratio): ((&str, &str), f64)| Missing {
            equation: equation.into(),
            unit: unit.into(),
            diffusion: 2e-3 * ratio.sqrt(),
            ratio,
        };
        rows.into_iter().zip(ratios).map(row).collect()
    };
    Explanation {
        verdict: Verdict::Adequate,
        findings: Vec::new(),
        ranking: ranking(),
        fit: Models {
            baseline: Parts {
                train: fits(&[
                    ("yaw_rate", 91.34),
                    ("lateral_acceleration", 84.9),
                    ("speed", 99.12),
                    ("wheel_speed_fl", 98.8),
                ]),
                holdout: fits(&[
                    ("yaw_rate", 90.2),
                    ("lateral_acceleration", 81.7),
                    ("speed", 99.02),
                    ("wheel_speed_fl", 98.7),
                ]),
            },
            ordinary: None,
            extended: Parts {
                train: fits(&[
                    ("yaw_rate", 95.4),
                    ("lateral_acceleration", 94.1),
                    ("speed", 99.13),
                    ("wheel_speed_fl", 98.8),
                ]),
                holdout: fits(&[
                    ("yaw_rate", 94.3),
                    ("lateral_acceleration", 92.8),
                    ("speed", 99.01),
                    ("wheel_speed_fl", 98.7),
                ]),
            },
        },
        error: Models {
            baseline: Parts {
                train: fits(&[("yaw_rate", 0.058)]),
                holdout: fits(&[("yaw_rate", 0.062), ("lateral_acceleration", 0.91), ("speed", 0.01)]),
            },
            ordinary: None,
            extended: Parts {
                train: fits(&[("yaw_rate", 0.010)]),
                holdout: fits(&[("yaw_rate", 0.011), ("lateral_acceleration", 0.36), ("speed", 0.01)]),
            },
        },
        prediction_fit: Models {
            baseline: Parts { train: fits(&[("yaw_rate", 97.1)]), holdout: fits(&[("yaw_rate", 97.0)]) },
            ordinary: None,
            extended: Parts { train: fits(&[("yaw_rate", 97.9)]), holdout: fits(&[("yaw_rate", 97.8)]) },
        },
        log_likelihood: Models {
            baseline: Parts { train: 84_210.3, holdout: 41_873.9 },
            ordinary: None,
            extended: Parts { train: 84_633.1, holdout: 42_080.2 },
        },
        improvement_ci95: [
            ("yaw_rate".into(), [2.31, 5.92]),
            ("lateral_acceleration".into(), [8.4, 13.7]),
            ("speed".into(), [-0.15, 0.12]),
        ]
        .into(),
        parameters: Models {
            baseline: estimates(&[
                ("mass_kg", 1512.0, 24.0),
                ("yaw_inertia_kgm2", 2690.0, 110.0),
                ("lateral_stiffness_front", 13.21, 0.14),
                ("lateral_stiffness_rear", 15.87, 0.19),
                ("steering_ratio", 15.62, 0.05),
                ("friction", 0.9, f64::NAN),
                ("yaw_rate_offset", 0.0061, 0.0004),
            ]),
            ordinary: None,
            extended: estimates(&[
                ("mass_kg", 1509.0, 24.0),
                ("yaw_inertia_kgm2", 2410.0, 95.0),
                ("lateral_stiffness_front", 14.93, 0.21),
                ("lateral_stiffness_rear", 16.41, 0.22),
                ("steering_ratio", 15.66, 0.05),
                ("friction", 0.9, f64::NAN),
                ("yaw_rate_offset", 0.0058, 0.0003),
            ]),
        },
        unexplained: [
            ("yaw_rate".into(), 0.02),
            ("lateral_acceleration".into(), 0.061),
            ("speed".into(), f64::NAN),
        ]
        .into(),
        place: Where::default(),
        to_drive: vec!["hard braking in a turn, to tell load transfer from body roll".into()],
        equations: Models {
            baseline: missing([2310.0, 480.0, 3.0]),
            ordinary: None,
            extended: missing([12.0, 21.0, 2.9]),
        },
        measurement_chain: Vec::new(),
        split: split.collect(),
        seconds: seconds * recordings.len() as f64,
        traces: traces.collect(),
        driven: driven.collect(),
        ..Explanation::empty(Verdict::Adequate)
    }
}

fn ranking() -> Vec<Ranked> {
    let scored = effect::KINDS.iter().enumerate().map(|(place, kind)| Ranked {
        effect: kind.name.into(),
        channel: kind.channels.first().map(ToString::to_string),
        score: 40.0 * (20.0 - 1.5 * place as f64) * if kind.name == "sensor_delay" { 0.3 } else { 1.0 },
        refitted: place % 3 != 1,
    });
    let mut ranking: Vec<Ranked> = scored.collect();
    for it in &mut ranking {
        if it.effect == "load_transfer" {
            it.score = 1412.0;
        }
    }
    ranking.sort_by(|a, b| b.score.total_cmp(&a.score));
    ranking
}

fn traces(recording: &str, seconds: f64, misses: f64) -> Vec<Trace> {
    let count = (seconds * 50.0) as usize;
    let t: Vec<f64> = (0..count).map(|place| place as f64 * 0.02).collect();
    // Noise that is the same each time.
    let noise = |place: usize, size: f64| size * ((place as f64 * 12.9898).sin() * 43_758.547).fract();
    let speed = |t: f64| 18.0 + 6.0 * (0.05 * t).sin();
    let turn = |t: f64| (0.5 * t).sin() * (0.09 * t).sin();
    let make = |channel: &str, unit: &str, truth: &dyn Fn(f64) -> f64, size: f64, miss: f64| Trace {
        recording: recording.into(),
        channel: channel.into(),
        unit: unit.into(),
        measured: t.iter().enumerate().map(|(place, t)| truth(*t) + noise(place, size)).collect(),
        baseline: t.iter().map(|t| truth(*t) * (1.0 + miss * turn(*t).abs())).collect(),
        extended: t.iter().map(|t| truth(*t) * (1.0 + 0.05 * miss)).collect(),
        t: t.clone(),
    };
    vec![
        make("lateral_acceleration", "m/s²", &|t| 7.0 * turn(t), 0.25, 0.35 * misses),
        make("yaw_rate", "rad/s", &|t| 0.35 * turn(t - 0.1), 0.008, -0.2 * misses),
        make("speed", "m/s", &speed, 0.05, 0.003 * misses),
        make("wheel_speed_fl", "rad/s", &|t| speed(t) / 0.31 * (1.0 - 0.01 * turn(t)), 0.2, 0.0),
    ]
}
