//! The handling curve: what steering the tires want beyond the geometry of the curve.

use crate::report::Color;
use crate::report::interactive::{Figure, Line, Numbers, Points, Shape, Source};
use identify::understeer::{self, Gradient, Moment};
use physics::model::{GRAVITY, Uncertain, Vehicle};

/// What there is to draw.
pub struct Handling<'a> {
    /// The configured car.
    pub vehicle: &'a Vehicle,
    /// Is the lateral acceleration a sensor's?
    pub is_sensor: bool,
    /// Nearly steady moments that one line goes through.
    pub moments: Vec<Moment>,
    /// Those on another surface.
    pub elsewhere: Vec<Moment>,
    /// What else tells the gradient, rad per m/s², and its name.
    pub told: Option<(&'static str, Uncertain)>,
}

impl Handling<'_> {
    /// The figure, with the understeer gradient where the moments tell it.
    pub fn figure(&self) -> Figure {
        let x_axis = if self.is_sensor {
            "lateral acceleration, m/s²"
        } else {
            "lateral acceleration (speed × yaw rate), m/s²"
        };
        let mut figure =
            Figure::new("Handling curve", x_axis, "road wheel angle less wheelbase × yaw rate / speed, °");
        let Self { moments, elsewhere, .. } = self;
        let wheelbase = self.vehicle.wheelbase_m.value;
        let told = understeer::gradient(moments, wheelbase, self.vehicle.steering_ratio);
        let told = match told {
            Ok(gradient) => {
                figure.answer = self.answer(&gradient);
                Some(gradient)
            }
            Err(untold) => {
                figure.answer = format!("This drive does not tell the understeer gradient: {untold}.");
                None
            }
        };
        if moments.is_empty() {
            figure.answer.clear();
            figure.empty = "This drive does not tell the understeer gradient: there is no moment of nearly steady driving above \
                            21 km/h with steering, yaw rate and speed."
                .into();
            return figure;
        }
        let ratio = 1.0 + told.map_or(0.0, |it| it.ratio_error);
        figure.points.push(points(
            "a second of nearly steady driving",
            Shape::Rings,
            moments,
            wheelbase,
            ratio,
        ));
        if !elsewhere.is_empty() {
            let name = "the same on another surface";
            figure.points.push(points(name, Shape::Dots, elsewhere, wheelbase, ratio));
        }
        let offset = told.map_or_else(|| middle(moments, wheelbase), |it| it.offset / ratio);
        let ends = ends(moments);
        let configured = understeer::of_vehicle(self.vehicle);
        figure.lines.push(line(
            "the configured car",
            Source::Expected,
            Color::Ink,
            offset,
            configured.value,
            ends,
        ));
        if let Some((name, gradient)) = self.told {
            figure.lines.push(line(name, Source::Estimated, Color::Third, offset, gradient.value, ends));
        }
        if let Some(gradient) = told {
            let name = "straight line through the moments";
            let mut fitted = line(name, Source::Measured, Color::Second, offset, gradient.value, ends);
            let (low, high) = gradient.ci95;
            let edge = |slope: f64| line("", Source::Measured, Color::Second, offset, slope, ends).y;
            fitted.interval = Some((edge(low), edge(high)));
            figure.lines.push(fitted);
        }
        figure.caption = "Rising to the right: the car understeers, it takes more steering for the same curve when it is faster. \
                          Each ring is a second of nearly steady driving. The line is fitted up to 4 m/s²; tires bend before they slide, \
                          so the gradient of a gentler drive is a tenth or so less."
            .into();
        figure
    }

    fn answer(&self, gradient: &Gradient) -> String {
        let per_g = |value: f64| value.to_degrees() * GRAVITY;
        let (low, high) = gradient.ci95;
        let mut answer = format!(
            "Understeer gradient {:.2} ° per g (95 %: {:.2} to {:.2}), from {} s of nearly steady driving.",
            per_g(gradient.value),
            per_g(low),
            per_g(high),
            gradient.moments
        );
        let ratio = self.vehicle.steering_ratio;
        if ratio.std > 0.0 {
            let half = 0.5 * (high - low);
            if gradient.half_with_known_ratio < 0.5 * half {
                answer += &format!(
                    " Most of the interval comes from the steering ratio, {} ± {}: if that were known, it would be ± {:.2}.",
                    ratio.value,
                    ratio.std,
                    per_g(gradient.half_with_known_ratio)
                );
            }
        }
        answer
    }
}

/// What the tires want in a moment, °.
fn beyond(moment: &Moment, wheelbase: f64, ratio: f64) -> f64 {
    (moment.road_angle / ratio - wheelbase * moment.curvature).to_degrees()
}

fn points(name: &str, shape: Shape, moments: &[Moment], wheelbase: f64, ratio: f64) -> Points {
    let numbers =
        |of: &dyn Fn(&Moment) -> f64, decimals| Numbers::rounded(moments.iter().map(of).collect(), decimals);
    Points {
        name: name.into(),
        source: Source::Measured,
        color: if shape == Shape::Rings { Color::First } else { Color::Muted },
        shape,
        times: numbers(&|it| it.t, 1),
        x: numbers(&|it| it.lateral_acceleration, 2),
        y: numbers(&|it| beyond(it, wheelbase, ratio), 3),
        shade: None,
    }
}

/// The steering's offset (rad) where no line tells it: the middle one.
fn middle(moments: &[Moment], wheelbase: f64) -> f64 {
    let mut all: Vec<f64> = moments.iter().map(|it| beyond(it, wheelbase, 1.0)).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(0.0).to_radians()
}

fn ends(moments: &[Moment]) -> [f64; 2] {
    let of = |it: &Moment| it.lateral_acceleration;
    [moments.iter().map(of).fold(0.0, f64::min), moments.iter().map(of).fold(0.0, f64::max)]
}

/// A line of this gradient (rad per m/s²) through the offset (rad).
fn line(name: &str, source: Source, color: Color, offset: f64, gradient: f64, ends: [f64; 2]) -> Line {
    // With the origin, about which intervals open.
    let x = vec![ends[0], 0.0, ends[1]];
    let y = x.iter().map(|lateral| (offset + gradient * lateral).to_degrees()).collect();
    Line {
        name: name.into(),
        source,
        color,
        x: Numbers::rounded(x, 2),
        y: Numbers::rounded(y, 4),
        interval: None,
    }
}
