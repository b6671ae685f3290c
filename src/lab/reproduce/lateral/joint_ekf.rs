//! Figure 5.10: the joint EKF does not react to Sim2, and why.

use super::course::{AS_FIXED, GENTLE, HALVED, LateralDrive, STIFFNESS, halved, scenario};
use super::ekf::{self, Behaviour, EkfPoint, Track, WALKS};
use super::information::{bicycle, sensitivity, stiffness_std};
use super::map::{self, AMPLITUDES, Cell, FREQUENCIES};
use crate::report::{Color, Plot, Segment};
use crate::reproduce::{Claim, Outcome, Picture, SIM2};
use physics::model::GRAVITY;

/// Speed at which the information is worked out, m/s.
const SPEED: f64 = 25.0;
/// Noise of yaw rate, rad/s, and lateral acceleration, m/s².
const NOISE: [f64; 2] = [0.003, 0.07];

fn track(points: &[EkfPoint]) -> Track {
    Track::new(points.iter().map(|point| (point.t, point.stiffness)))
}

fn color(behaviour: Behaviour) -> Color {
    match behaviour {
        Behaviour::Follows => Color::First,
        Behaviour::Late => Color::Second,
        Behaviour::Blind => Color::Muted,
        Behaviour::Wrong => Color::Notice,
    }
}

/// Ends of the frequencies' cells on the axis, Hz: half way to the neighbours.
fn columns() -> Vec<(f64, f64)> {
    let inner: Vec<f64> = FREQUENCIES.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    let from = std::iter::once(0.0).chain(inner.iter().copied());
    from.zip(inner.iter().copied().chain(std::iter::once(1.1))).collect()
}

/// The map of one filter below the information that there is.
fn map_picture(cells: &[Cell], name: &str, heading: &str, of: impl Fn(&Cell) -> Track) -> Picture {
    let frequencies = || (1..=110).map(|i| 0.01 * f64::from(i));
    let mut plot = Plot::new(heading, "least std, %", 0.0..1.1, 0.0..10.0).x_label("steering frequency, Hz");
    let lines = [Color::First, Color::Second, Color::Third, Color::Truth];
    for (amplitude, color) in AMPLITUDES.iter().zip(lines) {
        let bound = |f| 100.0 * stiffness_std(SPEED, (f, *amplitude), 1.0, NOISE).unwrap_or(f64::NAN);
        plot = plot.line(
            &format!("least std of C_y after 1 s, {amplitude} rad"),
            color,
            frequencies().map(|f| (f, bound(f))),
        );
    }
    for amplitude in AMPLITUDES {
        let row = cells.iter().filter(|cell| cell.amplitude == amplitude);
        let segments = row.zip(columns()).map(|(cell, (from, to))| {
            let gap = 0.003;
            Segment { from: from + gap, to: to - gap, color: color(of(cell).behaviour) }
        });
        plot = plot.bar(&format!("{amplitude} rad"), segments.collect());
    }
    let plot = [
        ("follows within 10 s", Behaviour::Follows),
        ("follows later", Behaviour::Late),
        ("blind", Behaviour::Blind),
        ("wrong", Behaviour::Wrong),
    ]
    .into_iter()
    .fold(plot, |plot, (name, behaviour)| plot.explain(name, color(behaviour)));
    Picture {
        name: name.into(),
        heading: heading.into(),
        plot,
        caption: format!(
            "Over steering frequency, Hz. Above: Cramér–Rao bound at {SPEED} m/s, tires linear. Below: what the \
             filter does in Sim2 at 0.05, 0.1, 0.25, 0.5 and 1 Hz. To follow is to be within 20 % of the truth at the \
             end of every phase and seldom far off between. Tires slide with {}.",
            map::names(cells, |cell| !cell.grips())
        ),
    }
}

fn pictures(course: &LateralDrive, points: &[EkfPoint], suffix: &str, steering: &str) -> [Picture; 2] {
    let per_unit = 0.25 * course.car.mass * GRAVITY;
    let heading = |what: &str| format!("5.10 EKF {what} in Sim2, steering {steering}");
    let (vy, cy) = (heading("v_y"), heading("C_y"));
    let velocity = Plot::new(&vy, "v_y, m/s", 0.0..200.0, -4.0..4.0)
        .spans(&halved())
        .line("EKF", Color::First, points.iter().map(|p| (p.t, p.vy)))
        .line("true", Color::Truth, course.truth());
    let ours = course.line(|p| Some(p.ours.mean_stiffness()? * per_unit / 1e4));
    let stiffness = Plot::new(&cy, "C_y, 10⁴ N/rad", 0.0..200.0, 0.0..6.0)
        .spans(&halved())
        .line("EKF", Color::First, points.iter().map(|p| (p.t, p.stiffness * per_unit / 1e4)))
        .line("ours", Color::Second, ours)
        .line("true", Color::Truth, course.line(|p| Some(p.truth.cornering_front * per_unit / 1e4)));
    let caption = format!("Parameter noise {} of C_y per √s.", WALKS[0]);
    let picture = |name: &str, heading: String, plot| Picture {
        name: format!("figure_5_10_{name}{suffix}"),
        heading,
        plot,
        caption: caption.clone(),
    };
    [picture("vy", vy, velocity), picture("cy", cy, stiffness)]
}

/// Why it need not react: what is known of C_y.
fn information_claims() -> Option<[Claim; 2]> {
    let steady = |a: f64| {
        let gain = bicycle(a, STIFFNESS).yaw_rate_gain(SPEED);
        sensitivity(a, STIFFNESS, SPEED, 0.0).map(|change| change[0].norm() / gain)
    };
    let (neutral, understeer) = (steady(1.5)?, steady(1.3)?);
    let std = |frequency| stiffness_std(SPEED, (frequency, 0.01), 1.0, NOISE);
    let (slow, quick, quicker) = (std(0.05)?, std(0.5)?, std(1.0)?);
    Some([
        Claim::new(
            "Why, first: neutral steer. In steady cornering yaw rate and a_y do not depend on C_y",
            "",
            format!(
                "yaw rate gain changes by {:.4} % per % of C_y; by {:.2} % with the centre of gravity 0.2 m \
                 further forward",
                neutral, understeer
            ),
            neutral < 1e-6 && understeer > 0.05,
            "not named by the thesis: a = b, C_F = C_R",
        ),
        Claim::new(
            "… so only transients tell of C_y",
            "",
            format!(
                "least std after 1 s of ±0.01 rad: {:.0} % at 0.05 Hz, {:.1} % at 0.5 Hz, {:.1} % at 1 Hz",
                100.0 * slow,
                100.0 * quick,
                100.0 * quicker
            ),
            slow > 5.0 * quick && quick < 0.1,
            "weaker, but there: it does not excuse a filter that is blind at 0.25–1 Hz",
        ),
    ])
}

pub(super) fn run() -> Result<Outcome, String> {
    let course = |steering| {
        let scenario = scenario(SIM2, steering)?;
        LateralDrive::run(&scenario, scenario.seed)
    };
    let (fixed, gentle, slow) = (course(AS_FIXED)?, course(GENTLE)?, course((0.05, 0.01))?);
    let cells = map::cells()?;
    let measured = |course: &LateralDrive, walk| ekf::over(course, walk, |point| point.now);
    let (blind, tuned) = (measured(&gentle, WALKS[0]), measured(&gentle, WALKS[1]));
    let [blind_track, tuned_track] = [&blind, &tuned].map(|points| track(points));
    let (noisy, clean) =
        (track(&measured(&slow, WALKS[1])), track(&ekf::over(&slow, WALKS[1], ekf::noise_free)));
    let names = |walk: usize, behaviour| map::names(cells, |cell| cell.ekf[walk].behaviour == behaviour);
    let count = |of: &dyn Fn(&Cell) -> Track, behaviour| {
        cells.iter().filter(|cell| of(cell).behaviour == behaviour).count()
    };
    let at_fixed = |walk: usize| {
        cells
            .iter()
            .find(|cell| (cell.frequency, cell.amplitude) == AS_FIXED)
            .map_or(f64::NAN, |cell| cell.ekf[walk].least)
    };
    let quick = |cell: &&Cell| cell.grips() && cell.frequency >= 0.25;
    let (quick_count, quick_follow) = cells.iter().filter(quick).fold((0, 0), |(count, follow), cell| {
        (count + 1, follow + i32::from(cell.ekf[1].behaviour == Behaviour::Follows))
    });
    let ours = |behaviour| count(&|cell| cell.ours, behaviour);
    let in_map = |walk: usize| {
        format!(
            "within 10 s: {}. Later: {}. Blind: {}. Wrong: {}",
            names(walk, Behaviour::Follows),
            names(walk, Behaviour::Late),
            names(walk, Behaviour::Blind),
            names(walk, Behaviour::Wrong)
        )
    };
    let mut claims = vec![Claim::new(
        "The EKF does not react to the halving of C_y",
        "does not react",
        format!(
            "with a parameter noise of {}/√s C_yN is {} at the ends of the phases (truth {STIFFNESS}, {}, \
             {STIFFNESS}; ±0.01 rad, 0.5 Hz)",
            WALKS[0],
            blind_track,
            0.5 * STIFFNESS
        ),
        blind_track.behaviour == Behaviour::Blind,
        "",
    )];
    claims.extend(information_claims().ok_or("the bicycle has no frequency response")?);
    claims.extend([
        Claim::new(
            "Why, second: its tuning. With enough parameter noise the same filter follows gentle steering",
            "",
            format!(
                "with {}/√s C_yN is {}, {:.0} s and {:.0} s after the changes; follows in {quick_follow} of \
                 {quick_count} steerings of 0.25–1 Hz without sliding",
                WALKS[1],
                tuned_track,
                tuned_track.delays_s[0],
                tuned_track.delays_s[1]
            ),
            tuned_track.behaviour == Behaviour::Follows && 2 * quick_follow > quick_count,
            "not named by the thesis",
        ),
        Claim::new(
            "Why, third: at ±0.1 rad tires slide, which a linear tire denies: C_y comes out far too low",
            "",
            format!(
                "C_yN as low as {:.1}, {:.1} and {:.1} while halved to {} (the three parameter noises); a tire \
                 slides {:.0} % of that time",
                at_fixed(0),
                at_fixed(1),
                at_fixed(2),
                0.5 * STIFFNESS,
                100.0 * fixed.sliding(HALVED)
            ),
            at_fixed(1) < 0.5 * 0.5 * STIFFNESS,
            "not named by the thesis",
        ),
        Claim::new(
            "Where transients are slow, the sensors' noise decides: C_y is wrong even while nothing changes",
            "",
            format!(
                "0.05 Hz, 0.01 rad: C_yN {} on measured signals, {} on the same signals without noise",
                noisy,
                clean
            ),
            (noisy.ends[0] / STIFFNESS - 1.0).abs() > 0.3 && (clean.ends[0] / STIFFNESS - 1.0).abs() < 0.1,
            "noise in δ and in the estimated v_y multiplies C_y: errors in variables, which no parameter \
             noise takes away",
        ),
    ]);
    for (walk, noise) in WALKS.into_iter().enumerate() {
        let of = |cell: &Cell| cell.ekf[walk];
        let follows = |cell: &Cell| matches!(of(cell).behaviour, Behaviour::Follows | Behaviour::Late);
        let quick_only = cells.iter().filter(|cell| follows(cell)).all(|cell| cell.frequency >= 0.25);
        let any = cells.iter().any(follows);
        let (expected, holds) = if walk == 0 {
            ("follows nowhere", !any)
        } else {
            ("follows quick steering only", any && quick_only)
        };
        claims.push(Claim::new(
            &format!("Map over frequency and amplitude, parameter noise {noise}/√s: {expected}"),
            if walk == 0 { "one case, no reaction" } else { "" },
            in_map(walk),
            holds,
            "",
        ));
    }
    claims.push(Claim::better(
        "Our joint filter over the same map",
        format!(
            "follows within 10 s in {} of {}, later in {}, blind in {}, wrong in {} ({})",
            ours(Behaviour::Follows),
            cells.len(),
            ours(Behaviour::Late),
            ours(Behaviour::Blind),
            ours(Behaviour::Wrong),
            map::names(cells, |cell| cell.ours.behaviour == Behaviour::Wrong)
        ),
        ours(Behaviour::Follows) == cells.len(),
        &format!("its tires are linear, too; they slide with {}", map::names(cells, |cell| !cell.grips())),
    ));
    let map = |name: &str, heading: &str, walk: usize| {
        map_picture(cells, name, heading, |cell: &Cell| cell.ekf[walk])
    };
    let mut pictures = pictures(&gentle, &blind, "", "±0.01 rad at 0.5 Hz").to_vec();
    pictures.extend(self::pictures(&fixed, &measured(&fixed, WALKS[0]), "_sliding", "±0.1 rad at 0.5 Hz"));
    pictures.extend([
        map("figure_5_10_map_small", "Map of the EKF, parameter noise 0.0001/√s", 0),
        map("figure_5_10_map_moderate", "Map of the EKF, parameter noise 0.01/√s", 1),
        map("figure_5_10_map_large", "Map of the EKF, parameter noise 0.1/√s", 2),
        map_picture(cells, "figure_5_10_map_ours", "Map of our joint filter", |cell| cell.ours),
    ]);
    Ok(Outcome { claims, pictures })
}
