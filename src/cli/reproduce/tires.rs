//! Chapter 4: tire models.

use super::numeric::crossing;
use super::{Claim, Experiment, Outcome, Picture};
use crate::model::tire::{Brush, Contact, Curve, DahlTire, MagicFormula, PiecewiseLinear, ellipse};
use crate::report::{Color, Marker, Plot, Stroke};

/// In the order of the thesis.
pub const EXPERIMENTS: &[Experiment] = &[
    Experiment { figure: "4.5–4.6", title: "Magic formula and piecewise linear tire", run: longitudinal },
    Experiment { figure: "4.7", title: "Piecewise linear against magic formula", run: comparison },
    Experiment { figure: "4.8", title: "Brush tire", run: brush },
    Experiment { figure: "4.9", title: "Dahl tire", run: dahl },
    Experiment { figure: "4.10–4.11", title: "Lateral tire models", run: lateral },
    Experiment { figure: "4.12", title: "Friction circle", run: circle },
];

/// A peak and a slow fall behind it.
const MAGIC: MagicFormula = MagicFormula { shape: 1.65, curvature: 0.0 };
/// Slopes at zero slip on surfaces of friction 1, 0.5 and 0.1: their difference is exaggerated, as in the
/// thesis.
const EXAGGERATED: [(f64, f64); 3] = [(1.0, 50.0), (0.5, 35.0), (0.1, 15.0)];
/// The same for slip angles, per rad; the thesis draws them to ±1.
const EXAGGERATED_LATERAL: [(f64, f64); 3] = [(1.0, 11.5), (0.5, 8.0), (0.1, 3.5)];
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
                "peak within {:.1} %, slope within {:.1e}; μ_max 1: peak at s = {peaks_at:.3}, {behind:.2} at 0.1",
                100.0 * peak,
                slope
            ),
            peak < 1e-3 && slope < 1e-4 && peaks_at < 0.1 && behind < 1.0,
            "",
        ),
        Claim::new(
            "piecewise linear: C s up to μ_max, constant beyond",
            "kink at μ_max/C",
            format!(
                "limit within {kink_peak:.0e}, slope within {kink_slope:.0e}; kink at s = {:.3}",
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
    let half = crossing(0.0..0.05, |slip| magic.force(stiffness, 1.0, slip) < 0.3);
    let (low, all) = (difference(half), difference(0.1));
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
            "over the whole curve the piecewise linear model resembles the magic formula quite well",
            "quite well",
            format!("largest difference {all:.2}, at the kink"),
            all < 0.15,
            "the kink is where the magic formula bends: no choice of the slope brings them nearer there and keeps \
             it at zero slip",
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
            format!("slope within {worst_slope:.0e} on 1.0, 0.5, 0.2"),
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
            format!("within {off:.0e}"),
            off < 1e-12,
            "",
        ),
    ];
    let caption = "Slope 50. The forces at the same slip differ only where the patch slides.";
    Ok(Outcome { claims, pictures: vec![picture("figure_4_8", "Figure 4.8: brush tire", plot, caption)] })
}

/// Seconds of rolling at 20 m/s until the force at a constant slip is all but settled.
fn settled(tire: &DahlTire, friction: f64, slip: f64, seconds: f64) -> f64 {
    let (along, step) = (20.0, 1e-3);
    let steps = (seconds / step) as u32;
    let z = (0..steps).fold(0.0, |z, _| tire.advance(friction, z, along * (1.0 + slip), along, step));
    tire.force(z)
}

fn dahl() -> Result<Outcome, String> {
    let surfaces_of = [1.0, 0.5, 0.2];
    // The same spring in both; the rolling one sheds its deflection within 0.2 m.
    let rolling = DahlTire::rolling(50.0, 0.2);
    let dragged = DahlTire::dragged(rolling.stiffness);

    let over_way =
        Plot::new("Figure 4.9: Dahl tire over its displacement", "μ_x = F_x / F_N", 0.0..20.0, 0.0..1.05)
            .x_label("relative displacement of tire and road ∫ v_r dt, mm")
            .height(420);
    let ways = || (0..=400).map(|i| f64::from(i) * 5e-5);
    let over_way = surfaces_of.iter().zip(STYLES).fold(over_way, |plot, (friction, (color, stroke))| {
        let points = ways()
            .map(|way| (1e3 * way, dragged.force(dragged.advance(*friction, 0.0, 1.0 + way, 1.0, 1.0))));
        plot.curve(&format!("μ_max = {friction:.1}"), color, stroke, points)
    });
    let steady = slip_plot("Figure 4.9: steady state of the Dahl tire");
    let steady = surfaces_of.iter().zip(STYLES).fold(steady, |plot, (friction, (color, stroke))| {
        let curve = slips().map(|slip| (slip, rolling.steady(*friction, slip)));
        plot.curve(&format!("μ_max = {friction:.1}, with shedding"), color, stroke, curve)
    });
    let steady = surfaces_of.iter().zip(STYLES).fold(steady, |plot, (friction, (color, _))| {
        let points = (1..=20).map(|i| f64::from(i) * 5e-3).map(|s| (s, settled(&dragged, *friction, s, 5.0)));
        plot.points(&format!("μ_max = {friction:.1}, (4.13) after 5 s"), color, Marker::Cross, points)
    });

    // What the thesis draws: force that grows with slip, from nothing to the friction. With (4.13) itself:
    let small = settled(&dragged, 1.0, 0.002, 30.0);
    let large = settled(&dragged, 1.0, 0.1, 30.0);
    let after = [0.05, 0.5, 5.0].map(|seconds| settled(&dragged, 1.0, 0.002, seconds));
    let spring = {
        let way = 1e-6;
        dragged.force(dragged.advance(1.0, 0.0, 1.0 + way, 1.0, 1.0)) / way
    };
    let slope = rolling.steady(1.0, 1e-7) / 1e-7;
    let settles = settled(&rolling, 1.0, 0.01, 5.0);
    let (at_small, at_large) = (rolling.steady(1.0, 0.002), rolling.steady(1.0, 0.1));
    let grows = slips().zip(slips().skip(1)).all(|(a, b)| rolling.steady(1.0, b) > rolling.steady(1.0, a));
    let claims = vec![
        Claim::new(
            "(4.13) has steady-state forces that grow with slip",
            "curves from 0 to μ_max",
            format!("s = 0.002: {small:.3}, s = 0.1: {large:.3}, both μ_max"),
            large - small > 0.1,
            "ż = 0 in (4.13) means σ0 |z| = μ F_N at any slip but none; what slip decides is how soon",
        ),
        Claim::new(
            "why: only the time to get there depends on slip",
            "",
            format!(
                "s = 0.002 at 20 m/s: {:.2} after 0.05 s, {:.2} after 0.5 s, {:.2} after 5 s",
                after[0], after[1], after[2]
            ),
            after[0] < 0.5 && after[2] > 0.999,
            "",
        ),
        Claim::new(
            "over the displacement it is a spring that yields towards the friction",
            "linear differential equation",
            format!("spring {spring:.1} 1/m for σ0 = {:.0} 1/m; ends at μ_max", dragged.stiffness),
            (spring / dragged.stiffness - 1.0).abs() < 1e-3,
            "",
        ),
        Claim::better(
            "with deflection shed by rolling (−κ|r0 ω| z) there is a slip curve, of slope σ0/κ",
            format!(
                "slope {slope:.1} for 50; {at_small:.3} at s = 0.002, {at_large:.2} at 0.1; reached from zero within {:.0e}",
                (settles - rolling.steady(1.0, 0.01)).abs()
            ),
            (slope / 50.0 - 1.0).abs() < 1e-3 && grows && (settles - rolling.steady(1.0, 0.01)).abs() < 1e-6,
            "a hyperbola: it bends from the first slip on and reaches μ_max never; it has no s-shape either",
        ),
    ];
    let pictures = vec![
        picture(
            "figure_4_9",
            "Figure 4.9: Dahl tire, steady state over slip",
            steady,
            "Crosses: (4.13) held at a slip for 5 s at 20 m/s; it is at μ_max at every slip. Lines: with deflection shed \
             within 0.2 m of rolling.",
        ),
        picture(
            "figure_4_9_displacement",
            "Figure 4.9, over the displacement",
            over_way,
            "What (4.13) describes: force over the way that the contact patch has been displaced.",
        ),
    ];
    Ok(Outcome { claims, pictures })
}

fn lateral() -> Result<Outcome, String> {
    let angles: Vec<f64> = (-400..=400).map(|i| f64::from(i) * 2.5e-3).collect();
    let plot = |title: &str| {
        Plot::new(title, "μ_y = F_y / F_N", -1.0..1.0, -1.05..1.05).x_label("slip angle α, rad").height(420)
    };
    let caption = "The difference of the slopes at α = 0 is exaggerated, as in the thesis.";
    let pictures = vec![
        picture(
            "figure_4_10",
            "Figure 4.10: lateral magic formula",
            surfaces(plot("Figure 4.10: lateral magic formula"), &MAGIC, &EXAGGERATED_LATERAL, &angles),
            caption,
        ),
        picture(
            "figure_4_11",
            "Figure 4.11: lateral piecewise linear tire",
            surfaces(
                plot("Figure 4.11: lateral piecewise linear tire"),
                &PiecewiseLinear,
                &EXAGGERATED_LATERAL,
                &angles,
            ),
            caption,
        ),
    ];
    let odd = |curve: &dyn Fn(f64, f64, f64) -> f64| {
        let pairs = EXAGGERATED_LATERAL.iter().flat_map(|it| angles.iter().map(move |angle| (it, angle)));
        pairs.map(|((mu, k), a)| (curve(*k, *mu, *a) + curve(*k, *mu, -a)).abs()).fold(0.0, f64::max)
    };
    let odd_magic = odd(&|k, mu, a| MAGIC.force(k, mu, a));
    let odd_piecewise = odd(&|k, mu, a| PiecewiseLinear.force(k, mu, a));
    let (peak, _) = errors(&MAGIC, &EXAGGERATED_LATERAL, 1.0);
    let (limit, _) = errors(&PiecewiseLinear, &EXAGGERATED_LATERAL, 1.0);
    let claims = vec![
        Claim::new(
            "the lateral magic formula is odd and peaks at ±μ_max",
            "±1.0, ±0.5, ±0.1",
            format!("peak within {:.2} %, odd within {odd_magic:.0e}", 100.0 * peak),
            peak < 1e-3 && odd_magic < 1e-12,
            "",
        ),
        Claim::new(
            "the lateral piecewise linear tire has three parts (4.14)",
            "±μ_max outside, C α within",
            format!("limit within {limit:.0e}, odd within {odd_piecewise:.0e}"),
            limit < 1e-12 && odd_piecewise < 1e-12,
            "",
        ),
    ];
    Ok(Outcome { claims, pictures })
}

fn circle() -> Result<Outcome, String> {
    let contact = Contact { stiffness_x: 50.0, stiffness_y: 11.5, friction_x: 1.0, friction_y: 0.8 };
    let used = |[x, y]: [f64; 2]| (x / contact.friction_x).hypot(y / contact.friction_y);
    let grid =
        || (-20..=20).flat_map(|i| (-20..=20).map(move |j| (f64::from(i) * 5e-3, f64::from(j) * 0.02)));
    let alone = |(slip, angle): (f64, f64)| {
        [
            PiecewiseLinear.force(contact.stiffness_x, contact.friction_x, slip),
            PiecewiseLinear.force(contact.stiffness_y, contact.friction_y, angle),
        ]
    };
    let together = |pair| ellipse::scaled_back(&contact, alone(pair));
    let largest_alone = grid().map(|pair| used(alone(pair))).fold(0.0, f64::max);
    let largest = grid().map(|pair| used(together(pair))).fold(0.0, f64::max);
    let largest_brush =
        grid().map(|(slip, angle)| used(Brush.combined(&contact, slip, angle))).fold(0.0, f64::max);
    let turned = grid()
        .map(|pair| {
            let ([x, y], [sx, sy]) = (alone(pair), together(pair));
            (x * sy - y * sx).abs()
        })
        .fold(0.0, f64::max);
    let boundary = (0..=360).map(|degrees| {
        let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
        (contact.friction_y * sin, contact.friction_x * cos)
    });
    let plot = Plot::new("Figure 4.12: friction circle", "μ_x", -1.8..1.8, -1.2..1.2)
        .x_label("μ_y")
        .height(600)
        .points(
            "each slip as if alone (piecewise linear)",
            Color::Muted,
            Marker::Dot,
            grid().map(alone).map(|[x, y]| (y, x)),
        )
        .points("scaled back (4.15)", Color::First, Marker::Dot, grid().map(together).map(|[x, y]| (y, x)))
        .points(
            "brush, combined slip",
            Color::Second,
            Marker::Cross,
            grid().map(|(slip, angle)| Brush.combined(&contact, slip, angle)).map(|[x, y]| (y, x)),
        )
        .curve("friction ellipse", Color::Truth, Stroke::Solid, boundary);
    let claims = vec![
        Claim::new(
            "the resulting force lies within the ellipse of μ_xmax and μ_ymax",
            "(μ_x/μ_xmax)² + (μ_y/μ_ymax)² ≤ 1",
            format!("at most {largest:.3} of it; each slip as if alone would reach {largest_alone:.2}"),
            largest <= 1.0 + 1e-12 && largest > 0.999 && turned < 1e-12,
            "",
        ),
        Claim::better(
            "the brush tire needs no scaling: combined slip is in the model",
            format!("at most {largest_brush:.3} of the ellipse"),
            largest_brush <= 1.0 + 1e-9,
            "",
        ),
    ];
    let caption = "μ_xmax = 1.0, μ_ymax = 0.8; slips to ±0.1, slip angles to ±0.4 rad.";
    Ok(Outcome {
        claims,
        pictures: vec![picture("figure_4_12", "Figure 4.12: friction circle", plot, caption)],
    })
}
