//! Chapter 6: from stiffness to friction.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::abs_tests::{self, AbsTest, Found};
use super::{Claim, Experiment, Outcome, Picture};
use crate::report::{Color, Marker, Plot, Stroke};
use physics::estimate::mapping::{Calibration, Mapping, MappingFit, MappingKind, Pair, Refusal};
use physics::estimates::Estimate;
use physics::model::TireKind;

/// In the order of the thesis.
pub const EXPERIMENTS: &[Experiment] = &[
    Experiment { figure: "6.1, eq. 6.2", title: "Friction from ABS brakings", run: abs_friction },
    Experiment { figure: "6.1", title: "Stiffness and friction, a multitude of surfaces", run: two_weeks },
    Experiment { figure: "6.2", title: "Stiffness and friction, one day on two surfaces", run: one_day },
];

/// How good is what everything is compared with?
fn abs_friction() -> Result<Outcome, String> {
    let frictions = [1.0, 0.6, 0.4, 0.2];
    let tests: Vec<_> =
        frictions.iter().map(|mu| AbsTest { settle_s: 6.0, ..AbsTest::settled(*mu, 60.0) }).collect();
    let mut claims = Vec::new();
    let (mut worst, mut measuring) = (0.0_f64, 0.0_f64);
    let mut texts = Vec::new();
    let mut inside = (0, 0);
    for (name, tire) in [
        ("piecewise linear", TireKind::Piecewise),
        ("brush", TireKind::Brush),
        ("magic formula", TireKind::MagicFormula),
    ] {
        let found = abs_tests::drive(&tests, tire, 60.0, 11)?;
        let measured: Vec<_> = found.iter().filter_map(|found| Some((found, found.braking.mu?))).collect();
        if measured.len() != frictions.len() {
            return Err(format!("{} of {} brakings gave a friction", measured.len(), frictions.len()));
        }
        let text: Vec<_> =
            measured.iter().map(|(found, (mu, _))| format!("{mu:.3} of {:.1}", found.true_mu)).collect();
        texts.push(format!("{name} tire: {}", text.join(", ")));
        for (found, (mu, std)) in measured {
            worst = worst.max((mu / found.true_mu - 1.0).abs());
            measuring = measuring.max((mu - found.used_mu).abs());
            inside.0 += usize::from((mu - found.used_mu).abs() < 1.96 * std);
            inside.1 += 1;
        }
    }
    claims.push(Claim::new(
        "The deceleration during an ABS braking (6.2) gives reasonable values of the available friction",
        "assumed; no other reference at hand",
        format!("{}: within {:.0} %", texts.join("; "), 100.0 * worst),
        worst < 0.1,
        "the ABS cycles about the peak; what it loses is least with tires that have no force to lose beyond it",
    ));
    claims.push(Claim::better(
        "What is measured is what the tires used, drag and rolling resistance taken off, and its interval says \
         how well",
        format!("within {measuring:.3}; {} of {} in the 95 % interval", inside.0, inside.1),
        measuring < 0.03 && inside.0 * 100 >= inside.1 * 90,
        "the rest of the difference to the available friction is the ABS's, not the measurement's",
    ));
    Ok(Outcome { claims, pictures: Vec::new() })
}

/// Two weeks: surfaces whose stiffness says nothing of their friction, and a third of the brakings
/// before the slope had settled.
fn many_surfaces() -> Result<Vec<Found>, String> {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut found = Vec::new();
    for day in 0..6 {
        // The same tires on another day: warmer, softer, another pressure.
        let tires = rng.random_range(0.85..1.15);
        let tests: Vec<_> = (0..4)
            .map(|test| {
                let (friction, slope) = (rng.random_range(0.15..0.95), tires * rng.random_range(15.0..42.0));
                if test % 3 == 1 {
                    AbsTest::too_soon(friction, slope)
                } else {
                    AbsTest::settled(friction, slope)
                }
            })
            .collect();
        found.extend(abs_tests::drive(&tests, TireKind::Piecewise, 30.0, 60 + day)?);
    }
    Ok(found)
}

fn asphalt(rng: &mut impl Rng) -> (f64, f64) {
    (rng.random_range(0.88..1.04), rng.random_range(86.0..104.0))
}

fn gravel(rng: &mut impl Rng) -> (f64, f64) {
    (rng.random_range(0.5..0.66), rng.random_range(43.0..58.0))
}

/// One day: asphalt and gravel in turn. `hasty`: in some tests the brakes are touched too soon.
fn two_surfaces(seed: u64, drives: u64, hasty: bool) -> Result<Vec<Found>, String> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut found = Vec::new();
    for number in 0..drives {
        let tests: Vec<_> = (0..5)
            .map(|test| {
                let (friction, slope) =
                    if (test + number) % 2 == 0 { asphalt(&mut rng) } else { gravel(&mut rng) };
                if hasty && test == 3 {
                    AbsTest::too_soon(friction, slope)
                } else {
                    AbsTest::settled(friction, slope)
                }
            })
            .collect();
        found.extend(abs_tests::drive(&tests, TireKind::Piecewise, 80.0, 100 * seed + number)?);
    }
    Ok(found)
}

/// The pairs as the thesis would have them: every braking with the slope there was, all alike.
fn unweighted(found: &[Found]) -> Vec<Pair> {
    let plain = |pair: Pair| Pair { slope_std: 0.0, mu_std: 0.02, ..pair };
    found.iter().filter_map(|found| found.braking.as_if_settled()).map(plain).collect()
}

fn pairs(found: &[Found]) -> Vec<Pair> {
    found.iter().filter_map(|found| found.braking.pair()).collect()
}

fn fit_of(calibration: &Calibration, kind: MappingKind) -> Result<&MappingFit, String> {
    calibration.fit(Some(kind)).ok_or_else(|| "too few brakings for a fit".into())
}

/// Slope found / slope of the surface. What all have in common (the data sheet's mass, radius and load
/// share) is no error of a pair, and taken out by `scale`.
fn slope_error<'a>(found: impl Iterator<Item = &'a Found>, scale: f64) -> f64 {
    median(found.filter_map(ratio).map(|ratio| 100.0 * (ratio / scale - 1.0).abs()))
}

fn ratio(found: &Found) -> Option<f64> {
    Some(found.braking.slope?.value / found.true_slope)
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<_> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn draw(title: &str, x: f64, y: f64, found: &[Found], all: &Calibration, mapping: Option<&Mapping>) -> Plot {
    let points = |pair: bool| {
        let chosen = move |found: &&Found| found.braking.pair().is_some() == pair;
        let point = |found: &Found| found.braking.as_if_settled().map(|pair| (pair.slope, pair.mu));
        found.iter().filter(chosen).filter_map(point)
    };
    let slopes = (0..=200).map(|i| x * f64::from(i) / 200.0);
    let mut plot = Plot::new(title, "mu_ABS", 0.0..x, 0.0..y).height(380).x_label("slope k");
    if let Some(mapping) = mapping {
        let row = |k: f64| {
            let mapped = mapping.at(Estimate { value: k, std: 0.0, age_s: 0.0 })?;
            Some((k, mapped.low, mapped.high))
        };
        plot = plot.band(
            "ours: 95 % interval of the next braking",
            Color::First,
            slopes.clone().filter_map(row),
        );
    }
    for (name, kind, stroke) in [
        ("quadratic mapping (6.10), all brakings", MappingKind::Quadratic, Stroke::Dashed),
        ("linear mapping (6.5), all brakings", MappingKind::Linear, Stroke::Solid),
    ] {
        let Some(fit) = all.fit(Some(kind)) else { continue };
        let line =
            move |k: f64| (k, fit.regression.at(if kind == MappingKind::Quadratic { k * k } else { k }));
        plot = plot.curve(name, Color::Second, stroke, slopes.clone().map(line));
    }
    plot.points("slope settled before the braking", Color::First, Marker::Dot, points(true)).points(
        "braked before the slope had settled",
        Color::Notice,
        Marker::Cross,
        points(false),
    )
}

/// Fig. 6.1.
fn two_weeks() -> Result<Outcome, String> {
    let found = many_surfaces()?;
    let all = Calibration::new(&unweighted(&found));
    let linear = fit_of(&all, MappingKind::Linear)?;
    let settled = pairs(&found);
    let ours = Calibration::new(&settled);
    let (r_square, p_value) = (linear.regression.r_square, linear.p_value);
    let is_settled =
        |settled: bool| found.iter().filter(move |found| found.braking.pair().is_some() == settled);
    let too_soon = is_settled(false).count();
    let scale = median(is_settled(true).filter_map(ratio));
    let (wrong, right) = (slope_error(is_settled(false), scale), slope_error(is_settled(true), scale));
    let truth: Vec<_> = found
        .iter()
        .map(|found| Pair {
            slope: found.true_slope,
            slope_std: 0.0,
            mu: found.true_mu,
            mu_std: 0.0,
            roughness: None,
        })
        .collect();
    let truth = Calibration::new(&truth);
    let true_r_square = fit_of(&truth, MappingKind::Linear)?.regression.r_square;
    let verdict = match &ours.chosen {
        Ok(_) => "mapped".into(),
        Err(reason) => format!("refused: {reason}"),
    };
    let claims = vec![
        Claim::new(
            "Over two weeks and many surfaces slope and friction hardly correlate; the mappings have no relevance",
            "little correlation",
            format!("R² = {r_square:.2}, p = {p_value:.2} over {} brakings", linear.regression.points),
            p_value > 0.05 && r_square < 0.25,
            &format!(
                "the surfaces themselves have R² = {true_r_square:.2}; brakings that came too soon keep the slope of the \
                 surface before, which adds a correlation of its own"
            ),
        ),
        Claim::new(
            "One reason: braked before the slope was stable, a pair has a wrong slope",
            "suspected",
            format!(
                "{too_soon} brakings too soon: slope off by {wrong:.0} % (median); the settled ones by {right:.0} %"
            ),
            too_soon > 0 && wrong > 3.0 * right,
            "",
        ),
        Claim::new(
            "Another: the surfaces themselves have low correlation",
            "suspected",
            format!("R² = {true_r_square:.2} between their true slopes and frictions"),
            true_r_square < 0.25,
            "so drawn, and the tires' stiffness differs by ±15 % from day to day",
        ),
        Claim::better(
            "`gripd calibrate` leaves out what was not settled, and refuses to map the rest",
            format!("{} pairs; {verdict}", settled.len()),
            matches!(ours.chosen, Err(Refusal::NoConnection { .. })),
            "",
        ),
    ];
    let picture = Picture {
        name: "figure_6_1".into(),
        heading: "Figure 6.1: a multitude of surfaces".into(),
        plot: draw("mu_ABS over slope, many surfaces", 50.0, 1.0, &found, &all, None),
        caption:
            "Each point is an ABS braking in a simulated drive, with the slope that the estimator had before \
                  it. Neither line says anything; ours refuses a mapping."
                .into(),
    };
    Ok(Outcome { claims, pictures: vec![picture] })
}

/// Fig. 6.2.
fn one_day() -> Result<Outcome, String> {
    let found = two_surfaces(6, 4, true)?;
    let all = Calibration::new(&unweighted(&found));
    let settled = pairs(&found);
    let ours = Calibration::new(&settled);
    let (line, parabola) = (fit_of(&ours, MappingKind::Linear)?, fit_of(&ours, MappingKind::Quadratic)?);
    let with_outliers = fit_of(&all, MappingKind::Linear)?;
    let mapping = ours.chosen.as_ref().ok().and_then(Mapping::new);
    let outliers: Vec<_> = found
        .iter()
        .filter(|found| {
            found.braking.as_if_settled().is_some_and(|pair| {
                (pair.mu - line.regression.at(pair.slope)).abs() > 3.0 * line.residual_std()
            })
        })
        .collect();
    let explained = outliers.iter().filter(|found| found.braking.pair().is_none()).count();
    let is_linear = ours.chosen.as_ref().is_ok_and(|chosen| chosen.kind == MappingKind::Linear);
    let mut claims = vec![
        Claim::new(
            "On one day and two surfaces, braked after the slope had converged, slope and friction correlate",
            "higher correlation, with outliers",
            format!(
                "R² = {:.2} over the {} settled pairs (p = {:.0e}); {:.2} with the hasty brakings",
                line.regression.r_square,
                settled.len(),
                line.p_value,
                with_outliers.regression.r_square
            ),
            line.p_value < 0.001 && line.regression.r_square > 0.7,
            "",
        ),
        Claim::new(
            "No quadratic trend: the linear mapping is the reasonable one",
            "linear",
            format!(
                "AICc {:.1} linear, {:.1} quadratic, lower is better; residual {:.3} against {:.3}",
                line.regression.aicc,
                parabola.regression.aicc,
                line.residual_std(),
                parabola.residual_std()
            ),
            is_linear && line.regression.aicc < parabola.regression.aicc,
            "",
        ),
        Claim::new(
            "The outliers are brakings before convergence",
            "one of the reasons suspected for Fig. 6.1",
            format!(
                "{} of {} points beyond 3 standard deviations were braked too soon",
                explained,
                outliers.len()
            ),
            !outliers.is_empty() && explained == outliers.len(),
            "",
        ),
    ];
    claims.push(another_day(mapping.as_ref(), line)?);
    let picture = Picture {
        name: "figure_6_2".into(),
        heading: "Figure 6.2: one day, asphalt and gravel".into(),
        plot: draw("mu_ABS over slope, two surfaces", 140.0, 1.4, &found, &all, mapping.as_ref()),
        caption: "Settled slopes make a line, and its interval says what it is worth; it ends where the slopes do. \
                  Brakings too soon after a change of surface are the outliers, and have drawn the thesis's lines \
                  to them."
            .into(),
    };
    Ok(Outcome { claims, pictures: vec![picture] })
}

/// Does the interval hold what was not in the calibration?
fn another_day(mapping: Option<&Mapping>, line: &MappingFit) -> Result<Claim, String> {
    let mut inside = 0;
    let mut asked = 0;
    let mut half_widths = 0.0;
    for found in two_surfaces(7, 3, false)? {
        let Some(pair) = found.braking.pair() else { continue };
        let slope = Estimate { value: pair.slope, std: pair.slope_std, age_s: 0.0 };
        let Some(mapped) = mapping.and_then(|mapping| mapping.at(slope)) else { continue };
        asked += 1;
        half_widths += 0.5 * (mapped.high - mapped.low);
        inside += u32::from((mapped.low..=mapped.high).contains(&found.true_mu));
    }
    let r = &line.regression;
    let width = half_widths / f64::from(asked.max(1));
    Ok(Claim::better(
        "The mapping's 95 % interval holds the true friction of the same surfaces in other drives",
        format!(
            "mu = ({:.4} ± {:.4}) k + ({:.2} ± {:.2}); ±{width:.2} about it holds {inside} of {asked}",
            r.a,
            r.covariance.aa.sqrt(),
            r.b,
            r.covariance.bb.sqrt()
        ),
        asked >= 10 && f64::from(inside) >= 0.85 * f64::from(asked),
        "and there is none outside the calibrated slopes; between the two surfaces no braking has checked it",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_weeks_are_refused_and_one_day_is_mapped() {
        let refused = Calibration::new(&pairs(&many_surfaces().unwrap())).chosen;
        assert!(matches!(refused, Err(Refusal::NoConnection { .. })), "{refused:?}");
        let chosen = Calibration::new(&pairs(&two_surfaces(6, 4, true).unwrap())).chosen.unwrap();
        assert_eq!(chosen.kind, MappingKind::Linear);
        // Halfway between the surfaces' means: (0.96 − 0.58) / (95 − 50.5).
        assert!((chosen.coefficients[0] - 0.0085).abs() < 0.002, "{chosen:?}");
        assert!(chosen.residual_std < 0.1);
    }

    #[test]
    fn the_friction_of_an_abs_braking_is_what_the_tires_used() {
        for tire in [TireKind::Piecewise, TireKind::Brush, TireKind::MagicFormula] {
            let tests = [0.9, 0.5, 0.2].map(|mu| AbsTest { settle_s: 6.0, ..AbsTest::settled(mu, 60.0) });
            for found in abs_tests::drive(&tests, tire, 60.0, 5).unwrap() {
                let (mu, std) = found.braking.mu.unwrap();
                assert!((mu - found.used_mu).abs() < 3.0 * std, "{tire:?} {found:?}");
                assert!(mu > 0.85 * found.true_mu && mu < 1.05 * found.true_mu, "{tire:?} {found:?}");
            }
        }
    }
}
