//! The handling curve: what steering the tires want beyond the geometry of the curve.

use std::collections::BTreeMap;

use super::scene::Scene;
use crate::identify::understeer::{self, Gradient, Instant, Moment};
use crate::report::Color;
use crate::report::interactive::{Figure, Line, Numbers, Points, Shape, Source};
use physics::Quantity;
use physics::model::{GRAVITY, Uncertain};

impl Scene<'_> {
    /// The figure, with the understeer gradient where the drive tells it.
    pub fn handling(&self) -> Figure {
        let (lateral, is_sensor) = self.lateral_acceleration();
        let x_axis = if is_sensor {
            "lateral acceleration, m/s²"
        } else {
            "lateral acceleration (speed × yaw rate), m/s²"
        };
        let mut figure =
            Figure::new("Handling curve", x_axis, "road wheel angle less wheelbase × yaw rate / speed, °");
        let (moments, elsewhere) = self.on_one_surface(self.moments(&lateral));
        let wheelbase = self.vehicle.wheelbase_m.value;
        let told = understeer::gradient(&moments, wheelbase, self.vehicle.steering_ratio);
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
            &moments,
            wheelbase,
            ratio,
        ));
        if !elsewhere.is_empty() {
            let name = "the same on another surface";
            figure.points.push(points(name, Shape::Dots, &elsewhere, wheelbase, ratio));
        }
        let offset = told.map_or_else(|| middle(&moments, wheelbase), |it| it.offset / ratio);
        let ends = ends(&moments);
        let configured = understeer::of_vehicle(self.vehicle);
        figure.lines.push(line(
            "the configured car",
            Source::Expected,
            Color::Ink,
            offset,
            configured.value,
            ends,
        ));
        if let Some(learned) = self.learned() {
            let name = "from the cornering stiffness learned last";
            figure.lines.push(line(name, Source::Estimated, Color::Third, offset, learned.value, ends));
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

    fn moments(&self, lateral: &[f32]) -> Vec<Moment> {
        let steering = self.drive.signal(Quantity::SteeringWheelAngle).unwrap_or_default();
        let yaw_rate = self.drive.signal(Quantity::YawRate).unwrap_or_default();
        let ratio = self.vehicle.steering_ratio.value;
        // As the track has it: an offset would look like another curve at each speed.
        let offset = self.drive.last.offsets.yaw_rate.map_or(0.0, |it| it.value);
        let of = |column: &[f32], place: usize| column.get(place).map_or(f64::NAN, |it| f64::from(*it));
        understeer::moments(self.drive.times.iter().enumerate().map(|(place, t)| Instant {
            t: *t,
            speed: of(&self.drive.speed, place),
            yaw_rate: of(yaw_rate, place) - offset,
            lateral_acceleration: of(lateral, place),
            road_angle: of(steering, place) / ratio,
        }))
    }

    /// Those between two changes of the surface, and all others: tires are softer on gravel, and one line through both says
    /// nothing of either. Of the stretches it is the one that tells most.
    fn on_one_surface(&self, moments: Vec<Moment>) -> (Vec<Moment>, Vec<Moment>) {
        let surface = |it: &Moment| {
            let place = self.drive.times.partition_point(|time| *time < it.t);
            self.drive.changes.get(place).copied().unwrap_or_default()
        };
        let mut told: BTreeMap<u32, f64> = BTreeMap::new();
        for it in &moments {
            *told.entry(surface(it)).or_default() += it.lateral_acceleration * it.lateral_acceleration;
        }
        let most = told.iter().max_by(|one, other| one.1.total_cmp(other.1)).map(|(surface, _)| *surface);
        moments.into_iter().partition(|it| Some(surface(it)) == most)
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

    /// The gradient by the cornering stiffnesses at the end, if these were valid.
    fn learned(&self) -> Option<Uncertain> {
        let [front, rear] = self.drive.last.cornering;
        let as_uncertain = |it: physics::estimates::Estimate| Uncertain { value: it.value, std: it.std };
        let (front, rear) = (as_uncertain(front?), as_uncertain(rear?));
        self.drive.last.cornering_valid.then(|| understeer::of_stiffness(front, rear))
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
