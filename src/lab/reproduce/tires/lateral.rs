//! Lateral models, and both forces together.

use super::{MAGIC, errors, picture, surfaces};
use crate::report::{Color, Marker, Plot, Stroke};
use crate::reproduce::numeric::within;
use crate::reproduce::{Claim, Outcome};
use physics::model::tire::{Brush, Contact, Curve, PiecewiseLinear, ellipse};

/// Slopes per rad on surfaces of friction 1, 0.5 and 0.1, exaggerated; the thesis draws them to ±1.
const EXAGGERATED_LATERAL: [(f64, f64); 3] = [(1.0, 11.5), (0.5, 8.0), (0.1, 3.5)];

/// Figures 4.10 and 4.11.
pub fn curves() -> Result<Outcome, String> {
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
            format!("peaks {}, odd {}", within(peak), within(odd_magic)),
            peak < 1e-3 && odd_magic < 1e-12,
            "",
        ),
        Claim::new(
            "the lateral piecewise linear tire has three parts (4.14)",
            "±μ_max outside, C α within",
            format!("limits {}, odd {}", within(limit), within(odd_piecewise)),
            limit < 1e-12 && odd_piecewise < 1e-12,
            "",
        ),
    ];
    Ok(Outcome { claims, pictures })
}

/// Figure 4.12.
pub fn circle() -> Result<Outcome, String> {
    let contact = Contact { stiffness_x: 50.0, stiffness_y: 11.5, friction_x: 1.0, friction_y: 0.8 };
    let used = |[x, y]: [f64; 2]| (x / contact.friction_x).hypot(y / contact.friction_y);
    let grid =
        || (-12..=12).flat_map(|i| (-12..=12).map(move |j| (f64::from(i) * 3e-3, f64::from(j) * 0.012)));
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
    let caption = "μ_xmax = 1.0, μ_ymax = 0.8; slips to ±0.036, slip angles to ±0.144 rad.";
    Ok(Outcome {
        claims,
        pictures: vec![picture("figure_4_12", "Figure 4.12: friction circle", plot, caption)],
    })
}
