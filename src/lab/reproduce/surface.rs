//! Chapter 7: what the surface does to the slope.

use super::numeric::within;
use super::{Claim, Experiment, Outcome, Picture};
use crate::report::{Color, Marker, Plot, Stroke};
use physics::model::tire::{Brush, Contact, Curve, MagicFormula, Shape};

/// In the order of the thesis.
pub const EXPERIMENTS: &[Experiment] = &[
    Experiment { figure: "7.1", title: "The secant effect", run: secant },
    Experiment { figure: "7.2", title: "Sliding before break-away, by the brush model", run: sliding_share },
    Experiment { figure: "7.3", title: "Tire and surface in series", run: series },
];

/// Slope at zero slip, the same on every surface: what differs is the friction.
const STIFFNESS: f64 = 50.0;

/// As identified by the thesis's kind of tire: a peak and a slow fall behind it.
const MAGIC: MagicFormula = MagicFormula { shape: 1.65, curvature: 0.0 };

/// The slope of the straight line through the origin that fits a curve best, from zero up to a force, points
/// evenly spread over the slip.
fn fitted(curve: &impl Curve, friction: f64, up_to: f64) -> f64 {
    let end = curve.slip(STIFFNESS, friction, up_to);
    let (mut products, mut squares) = (0.0, 0.0);
    for i in 1..=1000 {
        let slip = end * f64::from(i) / 1000.0;
        products += slip * curve.force(STIFFNESS, friction, slip);
        squares += slip * slip;
    }
    products / squares
}

fn secant() -> Result<Outcome, String> {
    let demand = 0.4;
    let slopes = |demand: f64| [1.0, 0.5].map(|friction| fitted(&MAGIC, friction, demand));
    let brush = |demand: f64| [1.0, 0.5].map(|friction| fitted(&Brush, friction, demand));
    let [high, low] = slopes(demand);
    let [brush_high, brush_low] = brush(demand);
    let [gentle_high, gentle_low] = slopes(0.1);
    let [brush_gentle_high, brush_gentle_low] = brush(0.1);
    // On one curve: the more force, the smaller the slope.
    let falling = |friction: f64, demands: &[f64]| {
        let slopes: Vec<f64> = demands.iter().map(|demand| fitted(&MAGIC, friction, *demand)).collect();
        slopes.iter().zip(slopes.iter().skip(1)).all(|(one, next)| next < one)
    };
    let falls = falling(1.0, &[0.1, 0.3, 0.5, 0.7, 0.9]) && falling(0.5, &[0.1, 0.2, 0.3, 0.4, 0.45]);
    let drop = |[high, low]: [f64; 2]| 100.0 * (1.0 - low / high);

    let slips = || (0..=300).map(|i| f64::from(i) * 1e-4);
    let line = |slope: f64| slips().map(move |slip| (slip, slope * slip));
    let ends = [1.0, 0.5].map(|friction| (MAGIC.slip(STIFFNESS, friction, demand), demand));
    let plot = Plot::new("Figure 7.1: the secant effect", "μ_x = F_x / F_N", 0.0..0.03, 0.0..1.0)
        .x_label("slip s")
        .height(420)
        .curve(
            "μ_max = 1.0",
            Color::First,
            Stroke::Solid,
            slips().map(|s| (s, MAGIC.force(STIFFNESS, 1.0, s))),
        )
        .curve(
            "μ_max = 0.5",
            Color::Second,
            Stroke::Solid,
            slips().map(|s| (s, MAGIC.force(STIFFNESS, 0.5, s))),
        )
        .curve(&format!("fitted up to 0.4: {high:.1}"), Color::First, Stroke::Dashed, line(high))
        .curve(&format!("fitted up to 0.4: {low:.1}"), Color::Second, Stroke::Dashed, line(low))
        .points("fitted up to here", Color::Notice, Marker::Ring, ends.into_iter());
    let caption = "Magic formula, the same slope of 50 at zero slip on both surfaces. A straight line through the \
                   same forces is flatter on the slippery one.";
    let claims = vec![
        Claim::new(
            "at the same force the fitted slope is smaller on low friction",
            "more pronounced on low μ_max",
            format!("up to μ_x = 0.4: {high:.1} on 1.0, {low:.1} on 0.5 (−{:.0} %)", drop([high, low])),
            low < high,
            "",
        ),
        Claim::new(
            "the higher up on the curve, the smaller the fitted slope",
            "falls with force",
            format!(
                "friction 1: {:.1} up to μ_x = 0.1, {:.1} up to 0.5, {:.1} up to 0.9",
                fitted(&MAGIC, 1.0, 0.1),
                fitted(&MAGIC, 1.0, 0.5),
                fitted(&MAGIC, 1.0, 0.9)
            ),
            falls,
            "",
        ),
        Claim::new(
            "with little slip the effect is very small and does not explain the differences seen between surfaces",
            "a minor part",
            format!(
                "up to μ_x = 0.1: magic formula −{:.1} %, brush −{:.1} %",
                drop([gentle_high, gentle_low]),
                drop([brush_gentle_high, brush_gentle_low])
            ),
            drop([brush_gentle_high, brush_gentle_low]) < 10.0 && drop([gentle_high, gentle_low]) < 10.0,
            "gravel in figure 5.3 halves the slope; the brush tire, which begins to slide at once, has the largest effect",
        ),
        Claim::better(
            "how large it is depends on the curve's own bend at zero slip",
            format!(
                "up to μ_x = 0.4: brush −{:.0} %, magic formula −{:.0} %",
                drop([brush_high, brush_low]),
                drop([high, low])
            ),
            brush_low < brush_high,
            "the brush curve leaves its tangent with s², the magic formula with s³",
        ),
    ];
    let heading = "Figure 7.1: the secant effect".into();
    let picture = Picture { name: "figure_7_1".into(), heading, plot, caption: caption.into() };
    Ok(Outcome { claims, pictures: vec![picture] })
}

/// Section 7.2 has no measured figure (its 7.2 is a sketch of two springs); its statement is that classical
/// theory ties the slope at zero slip to the tire alone.
fn sliding_share() -> Result<Outcome, String> {
    let share =
        |friction: f64, force: f64| STIFFNESS * Brush.slip(STIFFNESS, friction, force) / (3.0 * friction);
    let slopes = [1.0, 0.8, 0.4, 0.1].map(|friction| Brush.slope(STIFFNESS, friction, 0.0));
    let same = slopes.iter().all(|slope| (slope - STIFFNESS).abs() < 1e-9);
    let shares = [0.1, 0.3].map(|force| [1.0, 0.4].map(|friction| share(friction, force)));
    let grows = shares.iter().all(|[high, low]| low > high && *high > 0.0);
    let [[gentle_high, gentle_low], [high, low]] = shares.map(|pair| pair.map(|share| 100.0 * share));
    let claims = vec![
        Claim::new(
            "classical theory: friction does not act on the slope at zero slip",
            "very little",
            format!("brush, μ_max 1.0 to 0.1: {:.2} throughout", slopes[3]),
            same,
            "",
        ),
        Claim::new(
            "brush: a part of the contact patch always slides, more of it on low friction",
            "always a part",
            format!(
                "at μ_x = 0.1: {gentle_high:.1} % on 1.0, {gentle_low:.1} % on 0.4; at 0.3: {high:.0} %, {low:.0} %"
            ),
            grows,
            "",
        ),
    ];
    Ok(Outcome { claims, pictures: vec![] })
}

fn series() -> Result<Outcome, String> {
    let tire = 50.0;
    let k = |road: f64| Contact::in_series(tire, road);
    // The springs themselves: stretch both with one force and add up.
    let stretched = |road: f64| {
        let force = 1.0;
        force / (force / tire + force / road)
    };
    let roads = || (1..=500).map(f64::from);
    let worst = roads().map(|road| (k(road) / stretched(road) - 1.0).abs()).fold(0.0, f64::max);
    let rises = roads().zip(roads().skip(1)).all(|(one, next)| k(next) > k(one) && k(next) < tire);
    let (half, hard) = (k(tire), k(1e6));
    let plot = Plot::new("Figure 7.3: combined stiffness", "combined stiffness k", 0.0..500.0, 0.0..50.0)
        .x_label("stiffness of the surface k_R")
        .height(420)
        .curve("k, tire stiffness k_T = 50", Color::First, Stroke::Solid, roads().map(|road| (road, k(road))))
        .points("k_R = k_T: half", Color::Notice, Marker::Ring, [(tire, half)].into_iter());
    let at = |share: f64| tire * share / (1.0 - share);
    let claims = vec![
        Claim::new(
            "tire and surface are springs in series",
            "k = 1/(1/k_T + 1/k_R)",
            format!("{} that of two springs stretched by one force, k_R 1–500", within(worst)),
            worst < 1e-12,
            "",
        ),
        Claim::new(
            "a hard road shows the tire's stiffness, a soft one its own",
            "rises towards k_T = 50",
            format!(
                "k = {:.1} at k_R = 5, {half:.0} at 50, {:.1} at 500, {hard:.2} at 1e6",
                k(5.0),
                k(500.0)
            ),
            rises && (k(500.0) - 45.45).abs() < 0.01 && (hard - tire).abs() < 0.01,
            "",
        ),
        Claim::better(
            "where the slope stops telling surfaces apart",
            format!("within 5 % of the tire's own from k_R = {:.0} on, 19 times k_T", at(0.95)),
            (k(at(0.95)) / tire - 0.95).abs() < 1e-9,
            "",
        ),
    ];
    let picture = Picture {
        name: "figure_7_3".into(),
        heading: "Figure 7.3: combined stiffness of tire and surface".into(),
        plot,
        caption: "For a tire of stiffness 50.".into(),
    };
    Ok(Outcome { claims, pictures: vec![picture] })
}
