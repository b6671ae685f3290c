//! Chapter 9: what limits the estimation of friction.

use super::limits_scatter::FIGURE_9_2;
use super::numeric::crossing;
use super::{Claim, Experiment, Outcome, Picture};
use crate::report::{Color, Marker, Plot, Stroke};
use physics::model::tire::{Brush, Curve, MagicFormula};

/// In the order of the thesis.
pub const EXPERIMENTS: &[Experiment] =
    &[Experiment { figure: "9.1", title: "Deviation from the tangent", run: deviation }, FIGURE_9_2];

const STIFFNESS: f64 = 30.0;
const MAGIC: MagicFormula = MagicFormula { shape: 1.65, curvature: 0.0 };

/// Slip and force where the curve has fallen behind its tangent by a part of the tangent's force.
fn behind_by_part(curve: &impl Curve, part: f64) -> (f64, f64) {
    let force = |slip: f64| curve.force(STIFFNESS, 1.0, slip);
    let slip = crossing(1e-9..0.1, |slip| 1.0 - force(slip) / (STIFFNESS * slip) < part);
    (slip, force(slip))
}

/// The force where it has fallen behind by a share of the friction: what noise in the force has to be compared
/// with.
fn force_behind_by(curve: &impl Curve, distance: f64) -> f64 {
    let force = |slip: f64| curve.force(STIFFNESS, 1.0, slip);
    force(crossing(0.0..0.1, |slip| STIFFNESS * slip - force(slip) < distance))
}

fn deviation() -> Result<Outcome, String> {
    let parts = [0.05, 0.1, 0.2];
    let (magic_points, brush_points) =
        (parts.map(|part| behind_by_part(&MAGIC, part)), parts.map(|part| behind_by_part(&Brush, part)));
    let [magic, brush] = [magic_points, brush_points].map(|points| points.map(|(_, force)| 100.0 * force));
    let [magic_distance, brush_distance] =
        [force_behind_by(&MAGIC, 0.05), force_behind_by(&Brush, 0.05)].map(|share| 100.0 * share);

    let slips = || (0..=400).map(|i| f64::from(i) * 2.5e-4);
    let magic_curve = |slip: f64| MAGIC.force(STIFFNESS, 1.0, slip);
    let brush_curve = |slip: f64| Brush.force(STIFFNESS, 1.0, slip);
    let plot = Plot::new("Figure 9.1: deviation from the tangent", "μ_x = F_x / F_N", 0.0..0.1, 0.0..1.1)
        .x_label("slip s")
        .height(420)
        .curve("magic formula", Color::First, Stroke::Solid, slips().map(|s| (s, magic_curve(s))))
        .curve("brush", Color::Second, Stroke::Solid, slips().map(|s| (s, brush_curve(s))))
        .curve("tangent at s = 0", Color::Truth, Stroke::Dashed, slips().map(|s| (s, STIFFNESS * s)))
        .points(
            "5, 10, 20 % behind the tangent",
            Color::Notice,
            Marker::Ring,
            magic_points.into_iter().chain(brush_points),
        );
    let claims = vec![
        Claim::new(
            "magic formula: no noticeable deviation from the tangent below half of the friction",
            "about 50 % of μ_max",
            format!(
                "5/10/20 % behind at {:.0}/{:.0}/{:.0} % of μ_max; 0.05 μ_max behind at {magic_distance:.0} %",
                magic[0], magic[1], magic[2]
            ),
            magic[0] > 35.0 && magic[1] > 45.0,
            "",
        ),
        Claim::new(
            "the same for the brush tire (on which the thesis's direct method stands)",
            "about 50 % of μ_max",
            format!(
                "5/10/20 % behind at {:.0}/{:.0}/{:.0} % of μ_max; 0.05 μ_max behind at {brush_distance:.0} %",
                brush[0], brush[1], brush[2]
            ),
            brush[0] > 35.0 && brush[1] > 45.0,
            "a parabolic pressure slides at the patch's end from the first slip on: the deviation grows with s, \
             the magic formula's with s²",
        ),
    ];
    let picture = Picture {
        name: "figure_9_1".into(),
        heading: "Figure 9.1: deviation from the tangent".into(),
        plot,
        caption: "Slope 30, friction 1.".into(),
    };
    Ok(Outcome { claims, pictures: vec![picture] })
}
