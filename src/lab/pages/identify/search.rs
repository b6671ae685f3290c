//! Where the searches went, and how sharply their end is known.

use super::text;
use super::{Story, digits, number};
use crate::pages::explain::words::sentence;
use crate::report::Color;
use crate::report::interactive::{Figure, Line, Numbers, Points, Shape, Source};
use identify::Identified;

/// What is most asked for, first.
const INTERESTING: [&str; 5] = [
    "longitudinal_stiffness",
    "lateral_stiffness",
    "lateral_stiffness_front",
    "lateral_stiffness_rear",
    "friction",
];

/// 2 ln(likelihood ratio) at the ends of the 95 % interval: χ² of one degree of freedom.
const LIMIT: f64 = 3.84;
/// Higher than this a profile is not drawn: its lines end there.
const TOP: f64 = 12.0;
/// An interval this many times as wide as the profile's is said to be wider.
const WIDER: f64 = 1.2;

/// Starts and ends in the plane of two parameters (thesis, Fig. 5.12); nothing of one parameter or one search.
pub fn starts(story: &Story<'_>) -> Option<Figure> {
    let parameters = &story.found.parameters;
    let rank =
        |it: &Identified| INTERESTING.iter().position(|name| *name == it.name).unwrap_or(INTERESTING.len());
    let mut places: Vec<usize> = (0..parameters.len()).collect();
    places.sort_by_key(|place| (!parameters[*place].identifiable, rank(&parameters[*place])));
    let (&[x, y, ..], true) = (places.as_slice(), story.found.paths.len() > 1) else { return None };
    let paths = &story.found.paths;
    let point = |values: &[f64]| (values[x], values[y]);
    let gap = (f64::NAN, f64::NAN);
    let mut figure =
        Figure::new("Where the searches began and ended", &axis(&parameters[x]), &axis(&parameters[y]));
    let both = paths.iter().flat_map(|path| [point(&path.from), point(&path.to), gap]);
    figure.points = vec![
        points("belong together", Color::Muted, Shape::Path, both),
        points("start", Color::Second, Shape::Rings, paths.iter().map(|path| point(&path.from))),
        points("end", Color::First, Shape::Dots, paths.iter().map(|path| point(&path.to))),
    ];
    figure.answer = format!("{}.", sentence(&text::ends(story)));
    Some(figure)
}

/// Profile likelihoods of the vehicle's parameters.
pub fn profiles(story: &Story<'_>) -> Vec<Figure> {
    let of_vehicle = story.found.parameters.iter().filter(|it| !super::is_sensors(it));
    of_vehicle.filter(|it| it.profile.len() > 2).map(profile).collect()
}

fn profile(parameter: &Identified) -> Figure {
    let title = format!("Profile likelihood: {}", parameter.name);
    let mut figure = Figure::new(&title, &axis(parameter), "2 ln likelihood ratio");
    // At kinks of the tire a refit may find a little less than the search did.
    let profile: Vec<(f64, f64)> =
        parameter.profile.iter().map(|(value, ratio)| (*value, ratio.max(0.0))).collect();
    // The interval given belongs to what is told: the two are to be compared.
    let given = [parameter.ci95.0, parameter.ci95.1].into_iter().filter(|_| parameter.identifiable);
    let ends = profile.iter().map(|point| point.0).chain(given);
    let (from, to) =
        ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    let half = 0.5 * (parameter.ci95.1 - parameter.ci95.0);
    let parabola = (0..=200).map(|step| {
        let at = from + (to - from) * f64::from(step) / 200.0;
        (at, LIMIT * ((at - parameter.value) / half).powi(2))
    });
    let line = |name: &str, source: Source, color: Color, points: Vec<(f64, f64)>| {
        let low = points.into_iter().filter(|point| point.1 <= TOP);
        let (x, y) = low.unzip();
        Line { name: name.into(), source, color, x: Numbers::new(x), y: Numbers::new(y), interval: None }
    };
    figure.lines = vec![
        line("95 %", Source::Bound, Color::Notice, vec![(from, LIMIT), (to, LIMIT)]),
        line("by the interval given", Source::Bound, Color::Muted, parabola.collect()),
        line("profile", Source::Measured, Color::First, between(&profile)),
    ];
    let shown = profile.iter().copied().filter(|point| point.1 <= TOP);
    figure.points = vec![points("computed", Color::First, Shape::Rings, shown)];
    figure.caption = compared(parameter);
    figure
}

/// Points of no time.
fn points(name: &str, color: Color, shape: Shape, all: impl Iterator<Item = (f64, f64)>) -> Points {
    let (x, y) = all.unzip();
    Points {
        name: name.into(),
        source: Source::Measured,
        color,
        shape,
        times: Numbers::default(),
        x: Numbers::new(x),
        y: Numbers::new(y),
        shade: None,
    }
}

/// The profile as a line. Between two points it is nearly a parabola, so its root is nearly straight.
fn between(profile: &[(f64, f64)]) -> Vec<(f64, f64)> {
    const STEPS: u32 = 12;
    let Some(lowest) = profile.iter().min_by(|a, b| a.1.total_cmp(&b.1)) else { return Vec::new() };
    let root = |(x, y): (f64, f64)| if x < lowest.0 { -y.sqrt() } else { y.sqrt() };
    let piece = |(from, to): (&(f64, f64), &(f64, f64))| {
        let (ends, roots) = ([from.0, to.0], [root(*from), root(*to)]);
        (0..=STEPS).map(move |step| {
            let share = f64::from(step) / f64::from(STEPS);
            let on = |[from, to]: [f64; 2]| from + share * (to - from);
            (on(ends), on(roots).powi(2))
        })
    };
    profile.iter().zip(profile.iter().skip(1)).flat_map(piece).collect()
}

/// From where to where the profile is below its 95 % limit; not a number where it does not get there.
fn limits(profile: &[(f64, f64)]) -> [f64; 2] {
    let line = between(profile);
    let below = |point: &&(f64, f64)| point.1 <= LIMIT;
    let is_bounded = |end: Option<&(f64, f64)>| end.is_some_and(|end| end.1 > LIMIT);
    let end = |inner: Option<&(f64, f64)>, outer| {
        inner.filter(|_| is_bounded(outer)).map_or(f64::NAN, |point| point.0)
    };
    [end(line.iter().find(below), line.first()), end(line.iter().rfind(below), line.last())]
}

/// What the profile says beside the interval that is given, and why they need not be the same.
fn compared(parameter: &Identified) -> String {
    if !parameter.identifiable {
        return parameter.reason.clone();
    }
    let [low, high] = limits(&parameter.profile);
    let times = (parameter.ci95.1 - parameter.ci95.0) / (high - low);
    if times.is_nan() {
        return "The profile does not reach its limit: this recording alone leaves an end open.".into();
    }
    let decimals = digits(parameter.value, (high - low) / 4.0);
    let own = format!("By itself this curve says {} to {}.", number(low, decimals), number(high, decimals));
    if times < WIDER {
        return own;
    }
    format!(
        "{own} The interval given is {} times as wide: the curve takes the residuals for white noise and the inputs \
         for exact, while here they are coloured (segments disagree by more than their noise) or steering, \
         torques and wheel speeds are noisy.",
        number(times, 1)
    )
}

fn axis(parameter: &Identified) -> String {
    if parameter.unit == "1" {
        parameter.name.into()
    } else {
        format!("{}, {}", parameter.name, parameter.unit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_where_the_line_between_the_points_passes_them() {
        let point = |at: f64| (at, (at - 5.0).powi(2));
        let profile = [2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0].map(point);
        let [low, high] = limits(&profile);
        // 1.96 to either side; the line has steps of a twelfth.
        assert!((low - 3.04).abs() < 0.09 && (high - 6.96).abs() < 0.09, "{low} to {high}");
        assert!(
            between(&profile).iter().all(|at| (at.1 - point(at.0).1).abs() < 1e-9),
            "a parabola stays one"
        );
        let [low, high] = limits(&profile[..5]);
        assert!(low.is_finite() && high.is_nan(), "open to the right");
    }
}
