//! Chapter 3: friction models.

use super::numeric::within;
use super::{Claim, Experiment, Outcome, Picture};
use crate::report::{Color, Plot, Stroke};
use physics::model::friction::{
    Coulomb, Dahl, DynamicFriction, LuGre, StaticFriction, Stiction, Stribeck, Viscous,
};

/// In the order of the thesis.
pub const EXPERIMENTS: &[Experiment] = &[
    Experiment { figure: "3.2", title: "Static friction models", run: static_models },
    Experiment { figure: "3.3", title: "Pre-sliding displacement", run: pre_sliding },
];

/// In units of the normal load; the thesis's sketches have no scale.
const COULOMB: Coulomb = Coulomb { sliding: 0.7 };
const STICTION: Stiction = Stiction { sliding: 0.7, at_rest: 1.0 };
const STRIBECK: Stribeck =
    Stribeck { sliding: 0.7, at_rest: 1.0, viscous: 0.15, velocity: 0.15, exponent: 2.0 };

fn static_models() -> Result<Outcome, String> {
    let viscous = Viscous { coefficient: 0.8 };
    let velocities = || (-400..=400).map(|i| f64::from(i) * 2.5e-3);
    // At rest the force is any between what is held to the one and to the other side: a vertical line.
    let branch = |model: &dyn StaticFriction, name: &str, heading: &str, caption: &str| {
        let held = model.break_away();
        let points: Vec<(f64, f64)> = velocities()
            .flat_map(|v| {
                if v == 0.0 {
                    [model.sliding(-1e-9), -held, held, model.sliding(1e-9)]
                        .map(|force| (0.0, force))
                        .to_vec()
                } else {
                    vec![(v, model.sliding(v))]
                }
            })
            .collect();
        Picture {
            name: name.into(),
            heading: heading.into(),
            plot: Plot::new(heading, "force / normal load", -1.0..1.0, -1.2..1.2)
                .x_label("sliding velocity v, m/s")
                .height(300)
                .curve("friction", Color::First, Stroke::Solid, points.into_iter()),
            caption: caption.into(),
        }
    };
    let pictures = vec![
        branch(&COULOMB, "figure_3_2a", "Figure 3.2(a): Coulomb friction", "μ_C = 0.7."),
        branch(&viscous, "figure_3_2b", "Figure 3.2(b): viscous friction", "μ_V = 0.8 s/m."),
        branch(&STICTION, "figure_3_2c", "Figure 3.2(c): stiction", "μ_C = 0.7, μ_S = 1.0, at rest only."),
        branch(
            &STRIBECK,
            "figure_3_2d",
            "Figure 3.2(d): all combined, the Stribeck effect",
            "μ_C = 0.7, μ_S = 1.0, μ_V = 0.15 s/m, v_st = 0.15 m/s.",
        ),
    ];

    let spread = velocities()
        .filter(|v| *v > 0.0)
        .map(|v| (COULOMB.sliding(v) - 0.7).abs().max((COULOMB.sliding(-v) + 0.7).abs()))
        .fold(0.0, f64::max);
    let proportional = velocities().map(|v| (viscous.sliding(v) - 0.8 * v).abs()).fold(0.0, f64::max);
    let (held, slides) = (STICTION.force(0.0, 5.0), STICTION.force(1e-6, 5.0));
    let excess = |v: f64| STRIBECK.sliding(v) - STRIBECK.viscous * v - STRIBECK.sliding;
    let left = excess(STRIBECK.velocity) / (STRIBECK.at_rest - STRIBECK.sliding);
    let least = STRIBECK.least_force_velocity();
    let falls_then_rises = STRIBECK.sliding(1e-6) > STRIBECK.sliding(least)
        && STRIBECK.sliding(least) < STRIBECK.sliding(1.0)
        && least > 0.0
        && least < 1.0;
    let claims = vec![
        Claim::new(
            "Coulomb: depends on the direction of sliding only",
            "constant, odd",
            format!("±{:.2} {} over 0–1 m/s", COULOMB.sliding, within(spread)),
            spread < 1e-12,
            "",
        ),
        Claim::new(
            "viscous: proportional to the velocity",
            "straight line",
            format!("{:.2} s/m {}", viscous.coefficient, within(proportional)),
            proportional < 1e-12,
            "",
        ),
        Claim::new(
            "stiction: starting to slide takes more force than sliding",
            "μ_S > μ_C",
            format!("held {held:.2}, sliding {slides:.2}"),
            held > slides,
            "",
        ),
        Claim::new(
            "Stribeck: at v_st 37 % of the excess of stiction is active",
            "37 %",
            format!("{:.1} %", 100.0 * left),
            (left - 0.37).abs() < 0.005,
            "",
        ),
        Claim::new(
            "combined: the force falls from stiction, then grows with the viscous part",
            "falls, then grows",
            format!(
                "{:.2} at rest, least {:.2} at {least:.2} m/s, {:.2} at 1 m/s",
                STRIBECK.break_away(),
                STRIBECK.sliding(least),
                STRIBECK.sliding(1.0)
            ),
            falls_then_rises,
            "",
        ),
    ];
    Ok(Outcome { claims, pictures })
}

/// A contact that is pushed to and fro: the force over the way.
fn way(model: &dyn DynamicFriction, turns: &[f64]) -> Vec<(f64, f64)> {
    let (mut x, mut z, speed) = (0.0, 0.0, 1e-3);
    let mut path = vec![(0.0, 0.0)];
    for target in turns {
        let steps = 400;
        let (way, from): (f64, f64) = (target - x, x);
        let velocity = speed * way.signum();
        for i in 1..=steps {
            z = model.advance(z, velocity, way.abs() / speed / f64::from(steps));
            x = from + way * f64::from(i) / f64::from(steps);
            path.push((x, model.force(z, velocity)));
        }
    }
    path
}

/// Energy that a path takes.
fn work(path: &[(f64, f64)]) -> f64 {
    path.iter().zip(path.iter().skip(1)).map(|(a, b)| 0.5 * (a.1 + b.1) * (b.0 - a.0)).sum()
}

fn pre_sliding() -> Result<Outcome, String> {
    let dahl = Dahl::new(2000.0, 0.7);
    let sliding = Stribeck { viscous: 0.0, velocity: 5e-3, ..STRIBECK };
    let lugre = LuGre { stiffness: 2000.0, damping: 0.0, sliding };
    let turns = [2e-3, -2e-3, 2e-3];
    let (dahl_path, lugre_path) = (way(&dahl, &turns), way(&lugre, &turns));
    let small = [1e-6, 0.0];
    let spring = way(&dahl, &small);
    let back = spring.last().map_or(f64::NAN, |last| last.1);
    let peak = spring.iter().map(|point| point.1).fold(0.0, f64::max);
    let stiffness = peak / 1e-6;
    // The last turn and the one before it close the loop.
    let closed = &dahl_path[400..];
    let loss = work(closed);
    let coulomb_loss = 2.0 * 4e-3 * dahl.sliding;
    let lugre_top = lugre_path.iter().map(|point| point.1).fold(0.0, f64::max);

    let in_mm = |path: Vec<(f64, f64)>| path.into_iter().map(|(x, force)| (1e3 * x, force));
    let pictures = vec![Picture {
        name: "figure_3_3".into(),
        heading: "Figure 3.3: the contact is a spring until it breaks away".into(),
        plot: Plot::new("Figure 3.3: pre-sliding", "force / normal load", -2.2..2.2, -1.2..1.2)
            .x_label("displacement, mm")
            .height(380)
            .curve("Dahl", Color::First, Stroke::Solid, in_mm(dahl_path.clone()))
            .curve("LuGre, at 1 mm/s", Color::Second, Stroke::Dashed, in_mm(lugre_path))
            .curve(
                "spring of stiffness σ0",
                Color::OtherTruth,
                Stroke::Dotted,
                [(-0.55, -1.1), (0.55, 1.1)].into_iter(),
            ),
        caption:
            "The thesis sketches the deformed contact; this is the force that goes with it. Pushed to and \
                  fro by 2 mm. LuGre holds more, as stiction is part of it."
                .into(),
    }];
    let claims = vec![
        Claim::new(
            "before it breaks away the contact is a spring",
            "spring-like (σ0)",
            format!(
                "{stiffness:.0} 1/m for σ0 = 2000 1/m at {:.1} % of the limit; {:.1} % of the force left at the way back's end",
                100.0 * peak / dahl.sliding,
                100.0 * back.abs() / peak
            ),
            (stiffness / dahl.stiffness - 1.0).abs() < 0.02 && (back / peak).abs() < 0.03,
            "",
        ),
        Claim::new(
            "Dahl: pre-sliding and Coulomb friction, no stiction",
            "ends at μ_C",
            format!(
                "ends at {:.3}; loop takes {:.0} % of Coulomb's work",
                dahl.force(dahl.advance(0.0, 1.0, 1.0), 1.0),
                100.0 * loss / coulomb_loss
            ),
            (dahl.force(dahl.advance(0.0, 1.0, 1.0), 1.0) - 0.7).abs() < 1e-6
                && loss > 0.0
                && loss < coulomb_loss,
            "",
        ),
        Claim::new(
            "LuGre extends it by stiction and the Stribeck effect",
            "above μ_C when slow",
            format!(
                "{lugre_top:.2} at 1 mm/s, {:.2} at 5 mm/s, {:.2} at 50 mm/s",
                lugre.steady(5e-3),
                lugre.steady(0.05)
            ),
            lugre_top > 0.95 && (lugre.steady(0.05) - 0.7).abs() < 1e-3,
            "",
        ),
    ];
    Ok(Outcome { claims, pictures })
}
