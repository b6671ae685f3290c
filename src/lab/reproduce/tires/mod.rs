//! Chapter 4: tire models.

mod dahl;
mod lateral;

use super::numeric::within;
use super::{Claim, Experiment, Outcome, Picture};
use crate::report::{Color, Plot, Stroke};
use physics::model::tire::{Brush, Curve, MagicFormula, PiecewiseLinear, Shape};

/// In the order of the thesis.
pub const EXPERIMENTS: &[Experiment] = &[
    Experiment { figure: "4.5–4.6", title: "Magic formula and piecewise linear tire", run: longitudinal },
    Experiment { figure: "4.7", title: "Piecewise linear against magic formula", run: comparison },
    Experiment { figure: "4.8", title: "Brush tire", run: brush },
    Experiment { figure: "4.9", title: "Dahl tire", run: dahl::run },
    Experiment { figure: "4.10–4.11", title: "Lateral tire models", run: lateral::curves },
    Experiment { figure: "4.12", title: "Friction circle", run: lateral::circle },
];

/// A peak and a slow fall behind it.
const MAGIC: MagicFormula = MagicFormula { shape: 1.65, curvature: 0.0 };
/// Slopes at zero slip on surfaces of friction 1, 0.5 and 0.1: their difference is exaggerated, as in the
/// thesis.
const EXAGGERATED: [(f64, f64); 3] = [(1.0, 50.0), (0.5, 35.0), (0.1, 15.0)];
const STYLES: [(Color, Stroke); 3] =
    [(Color::First, Stroke::Solid), (Color::Second, Stroke::Dashed), (Color::Third, Stroke::Dotted)];

fn slips() -> impl Iterator<Item = f64> {
    (0..=400).map(|i| f64::from(i) * 2.5e-4)
}

/// As most figures of the chapter: slip to 0.1, force to 1.
fn slip_plot(title: &str) -> Plot {
    Plot::new(title, "μ_x = F_x / F_N", 0.0..0.1, 0.0..1.05).x_label("slip s").height(420)
}

/// A curve for each surface.
fn surfaces(plot: Plot, curve: &impl Curve, surfaces: &[(f64, f64); 3], slips: &[f64]) -> Plot {
    surfaces.iter().zip(STYLES).fold(plot, |plot, ((friction, stiffness), (color, stroke))| {
        let points = slips.iter().map(|slip| (*slip, curve.force(*stiffness, *friction, *slip)));
        plot.curve(&format!("μ_max = {friction:.1}"), color, stroke, points)
    })
}

fn picture(name: &str, heading: &str, plot: Plot, caption: &str) -> Picture {
    Picture { name: name.into(), heading: heading.into(), plot, caption: caption.into() }
}

/// The largest force on each surface within the picture, and the slope at zero, both against what they are to
/// be: the largest relative error of each.
fn errors(curve: &impl Curve, surfaces: &[(f64, f64); 3], to: f64) -> (f64, f64) {
    let mut worst = (0.0_f64, 0.0_f64);
    for (friction, stiffness) in surfaces {
        let forces = (0..=4000).map(|i| curve.force(*stiffness, *friction, to * f64::from(i) / 4000.0));
        worst.0 = worst.0.max((forces.fold(0.0, f64::max) / friction - 1.0).abs());
        worst.1 = worst.1.max((curve.force(*stiffness, *friction, 1e-7) / 1e-7 / stiffness - 1.0).abs());
    }
    worst
}

fn longitudinal() -> Result<Outcome, String> {
    let slips: Vec<f64> = slips().collect();
    let magic = slip_plot("Figure 4.5: magic formula");
    let piecewise = slip_plot("Figure 4.6: piecewise linear tire");
    let exaggerated = "The difference of the slopes at zero slip is exaggerated, as in the thesis.";
    let pictures = vec![
        picture(
            "figure_4_5",
            "Figure 4.5: magic formula",
            surfaces(magic, &MAGIC, &EXAGGERATED, &slips),
            exaggerated,
        ),
        picture(
            "figure_4_6",
            "Figure 4.6: piecewise linear tire",
            surfaces(piecewise, &PiecewiseLinear, &EXAGGERATED, &slips),
            exaggerated,
        ),
    ];
    let (peak, slope) = errors(&MAGIC, &EXAGGERATED, 0.1);
    let [peaks_at, behind] = {
        let at = MAGIC.peak_slip(50.0, 1.0);
        [at, MAGIC.force(50.0, 1.0, 0.1)]
    };
    let (kink_peak, kink_slope) = errors(&PiecewiseLinear, &EXAGGERATED, 0.1);
    let claims = vec![
        Claim::new(
            "magic formula: BCD is the slope at zero, D the largest force; it peaks and falls",
            "peaks at μ_max 1.0, 0.5, 0.1",
            format!(
                "peaks {}, slopes {}; friction 1: peak at s = {peaks_at:.3}, {behind:.2} at 0.1",
                within(peak),
                within(slope)
            ),
            peak < 1e-3 && slope < 1e-4 && peaks_at < 0.1 && behind < 1.0,
            "",
        ),
        Claim::new(
            "piecewise linear: C s up to μ_max, constant beyond",
            "kink at μ_max/C",
            format!(
                "limits {}, slopes {}; kink at s = {:.3} (friction 1)",
                within(kink_peak),
                within(kink_slope),
                1.0 / 50.0
            ),
            kink_peak < 1e-12 && kink_slope < 1e-9 && PiecewiseLinear.peak_slip(50.0, 1.0) == 0.02,
            "",
        ),
    ];
    Ok(Outcome { claims, pictures })
}

fn comparison() -> Result<Outcome, String> {
    // A tire without fall behind its peak, as drawn in the thesis.
    let magic = MagicFormula { shape: 1.3, curvature: 0.0 };
    let stiffness = 50.0;
    let difference = |to: f64| {
        let slips = slips().filter(move |slip| *slip <= to);
        slips
            .map(|slip| {
                (magic.force(stiffness, 1.0, slip) - PiecewiseLinear.force(stiffness, 1.0, slip)).abs()
            })
            .fold(0.0, f64::max)
    };
    let low = difference(magic.slip(stiffness, 1.0, 0.3));
    // The one that comes nearest over the whole curve.
    let apart = |(slope, friction): (f64, f64)| {
        slips()
            .map(|slip| {
                (magic.force(stiffness, 1.0, slip) - PiecewiseLinear.force(slope, friction, slip)).abs()
            })
            .fold(0.0, f64::max)
    };
    let grid =
        (100..=200).flat_map(|i| (160..=200).map(move |j| (0.25 * f64::from(i), 0.005 * f64::from(j))));
    let nearest = grid.min_by(|a, b| apart(*a).total_cmp(&apart(*b))).ok_or("an empty grid")?;
    let (tangent, all) = (difference(0.1), apart(nearest));
    let plot = slip_plot("Figure 4.7: comparison")
        .curve(
            "magic formula",
            Color::First,
            Stroke::Solid,
            slips().map(|s| (s, magic.force(stiffness, 1.0, s))),
        )
        .curve(
            "piecewise linear",
            Color::Second,
            Stroke::Dashed,
            slips().map(|s| (s, PiecewiseLinear.force(stiffness, 1.0, s))),
        )
        .curve(
            "piecewise linear, fitted",
            Color::Third,
            Stroke::Dotted,
            slips().map(|s| (s, PiecewiseLinear.force(nearest.0, nearest.1, s))),
        );
    let claims = vec![
        Claim::new(
            "with little slip both models are nearly the same",
            "very similar",
            format!("up to μ_x = 0.3 within {low:.3}"),
            low < 0.05,
            "",
        ),
        Claim::new(
            "over the whole curve it can be made to resemble the magic formula quite well",
            "quite well",
            format!(
                "fitted (slope {:.0}, limit {:.2}): within {all:.2}; with the slope at zero: {tangent:.2}, at the kink",
                nearest.0, nearest.1
            ),
            all < 0.12,
            "good for the force, not for its derivative: the fitted slope is not the slope at zero",
        ),
    ];
    let heading = "Figure 4.7: piecewise linear tire and magic formula";
    Ok(Outcome { claims, pictures: vec![picture("figure_4_7", heading, plot, "Slope 50, friction 1.")] })
}

fn brush() -> Result<Outcome, String> {
    let (stiffness, surfaces_of) = (50.0, [1.0, 0.5, 0.2]);
    let slips: Vec<f64> = slips().collect();
    let same = surfaces_of.map(|friction| (friction, stiffness));
    let plot = surfaces(slip_plot("Figure 4.8: brush tire"), &Brush, &same, &slips);
    let slope = surfaces_of.map(|mu| Brush.force(stiffness, mu, 1e-8) / 1e-8 / stiffness - 1.0);
    let worst_slope = slope.iter().fold(0.0, |worst: f64, it| worst.max(it.abs()));
    let saturates = surfaces_of
        .iter()
        .all(|mu| (Brush.force(stiffness, *mu, 3.0 * mu / stiffness) / mu - 1.0).abs() < 1e-12);
    // The thesis's polynomial (4.12) against the one that is built.
    let polynomial = |mu: f64, s: f64| {
        let x = stiffness * s;
        x - x * x / (3.0 * mu) + x.powi(3) / (27.0 * mu * mu)
    };
    let off = surfaces_of
        .iter()
        .flat_map(|mu| slips.iter().filter(move |s| **s < 3.0 * mu / stiffness).map(move |s| (*mu, *s)))
        .map(|(mu, s)| (Brush.force(stiffness, mu, s) - polynomial(mu, s)).abs())
        .fold(0.0, f64::max);
    let [full_slip, ..] = surfaces_of.map(|mu| 3.0 * mu / stiffness);
    let no_fall = Brush.force(stiffness, 1.0, 1.0) == 1.0;
    let claims = vec![
        Claim::new(
            "one slope at zero slip for every friction, bending as the patch begins to slide",
            "same slope",
            format!("{stiffness:.0} {} on 1.0, 0.5, 0.2", within(worst_slope)),
            worst_slope < 1e-6,
            "",
        ),
        Claim::new(
            "all of the patch slides at s = 3 μ_max/C; no stiction and no Stribeck effect: no fall behind it",
            "constant beyond",
            format!(
                "μ_max from s = {full_slip:.3} on (friction 1); still {:.2} at s = 1",
                Brush.force(stiffness, 1.0, 1.0)
            ),
            saturates && no_fall,
            "",
        ),
        Claim::new(
            "the force is the cubic (4.12), with C = 2 c_p a²/F_N",
            "(4.12)",
            within(off),
            off < 1e-12,
            "",
        ),
    ];
    let caption = "Slope 50. The forces at the same slip differ only where the patch slides.";
    Ok(Outcome { claims, pictures: vec![picture("figure_4_8", "Figure 4.8: brush tire", plot, caption)] })
}
