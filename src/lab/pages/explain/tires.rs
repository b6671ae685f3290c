//! The tires of each axle: lateral force over slip angle, by the sensors and as fitted.

use super::words::sentence;
use crate::explain::Explanation;
use crate::explain::ordinary::{AxleForce, AxleTires, TireCurve};
use crate::pages::axles;
use crate::report::Color;
use crate::report::interactive::{Figure, Line, Numbers, Points, Shape, Source};

/// More points of an axle hide each other.
const MOST_POINTS: usize = 1500;

/// A figure for each axle; `on_axis` puts a moment of a recording on the page's time axis.
pub fn figures(explanation: &Explanation, on_axis: impl Fn(&str, f64) -> Option<f64>) -> Vec<Figure> {
    let Some(ordinary) = &explanation.ordinary else { return Vec::new() };
    let stiffness = &explanation.cornering_stiffness;
    let of = |(name, axle, stiffness): (&str, &AxleTires, _)| {
        let points = points(axle, &on_axis);
        if points.times.is_empty() {
            return None;
        }
        let title = sentence(&format!("{name} axle: force over slip angle"));
        let mut figure =
            Figure::new(&title, "slip angle of the tires, °", "lateral force / static axle load");
        figure.points.push(points);
        figure.lines.push(line("the configured car's tire", Source::Expected, Color::Ink, &axle.configured));
        figure.lines.push(line("the fitted tire", Source::Estimated, Color::Second, &axle.fitted));
        figure.answer = axles::line(name, stiffness)
            .map_or_else(String::new, |line| format!("Cornering stiffness of the axle: {line}."));
        figure.caption = "Force: by lateral acceleration and yaw rate, less what was fitted of the sensors' zeros, delays and \
                          roll. Slip angle: of the ordinary car's free run, what gives way in the steering taken out; so the \
                          fitted front tire can be steeper than its axle. The curves are those at static load."
            .into();
        Some(figure)
    };
    let [front, rear] = &ordinary.tires;
    [("front", front, &stiffness.front), ("rear", rear, &stiffness.rear)].into_iter().filter_map(of).collect()
}

fn points(axle: &AxleTires, on_axis: impl Fn(&str, f64) -> Option<f64>) -> Points {
    let on_axis = &on_axis;
    let all: Vec<(f64, AxleForce)> = axle
        .measured
        .iter()
        .flat_map(|(name, forces)| forces.iter().filter_map(move |it| Some((on_axis(name, it.t)?, *it))))
        .collect();
    let every = all.len().div_ceil(MOST_POINTS).max(1);
    let column = |of: fn(&(f64, AxleForce)) -> f64, decimals| {
        Numbers::rounded(all.iter().step_by(every).map(of).collect(), decimals)
    };
    Points {
        name: "by the sensors, means of 0.2 s".into(),
        source: Source::Measured,
        color: Color::First,
        shape: Shape::Dots,
        times: column(|(t, _)| *t, 1),
        x: column(|(_, it)| it.slip_angle.to_degrees(), 3),
        y: column(|(_, it)| it.force, 4),
        shade: None,
    }
}

fn line(name: &str, source: Source, color: Color, curve: &TireCurve) -> Line {
    Line {
        name: name.into(),
        source,
        color,
        x: Numbers::rounded(curve.iter().map(|it| it[0].to_degrees()).collect(), 3),
        y: Numbers::rounded(curve.iter().map(|it| it[1]).collect(), 4),
        interval: None,
    }
}
