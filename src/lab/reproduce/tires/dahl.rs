//! The Dahl tire: what (4.13) does, and what Fig. 4.9 shows.

use super::{STYLES, picture, slip_plot, slips};
use crate::report::{Marker, Plot};
use crate::reproduce::{Claim, Outcome};
use physics::model::tire::DahlTire;

/// Seconds of rolling at 20 m/s until the force at a constant slip is all but settled.
fn settled(tire: &DahlTire, friction: f64, slip: f64, seconds: f64) -> f64 {
    let (along, step) = (20.0, 1e-3);
    let steps = (seconds / step) as u32;
    let z = (0..steps).fold(0.0, |z, _| tire.advance(friction, z, along * (1.0 + slip), along, step));
    tire.force(z)
}

/// Figure 4.9.
pub fn run() -> Result<Outcome, String> {
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
            "the reason: with (4.13) slip decides only how soon the friction is reached",
            "not said",
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
