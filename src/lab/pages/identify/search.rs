//! Where the searches went, and how sharply their end is known.

use super::drive::range;
use super::text;
use super::{Story, digits, number};
use crate::identify::Identified;
use crate::report::{Color, Marker, Page, Plot, PlotError, Stroke};

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

/// Starts and ends in the plane of two parameters (thesis, Fig. 5.12).
pub fn starts(page: &mut Page, story: &Story<'_>) -> Result<(), PlotError> {
    let parameters = &story.found.parameters;
    let rank =
        |it: &Identified| INTERESTING.iter().position(|name| *name == it.name).unwrap_or(INTERESTING.len());
    let mut places: Vec<usize> = (0..parameters.len()).collect();
    places.sort_by_key(|place| (!parameters[*place].identifiable, rank(&parameters[*place])));
    let (&[x, y, ..], true) = (places.as_slice(), story.found.paths.len() > 1) else { return Ok(()) };
    let paths = &story.found.paths;
    let point = |values: &[f64]| (values[x], values[y]);
    let all = || paths.iter().flat_map(|path| [point(&path.from), point(&path.to)]);
    let (Some(x_range), Some(y_range)) = (range(all().map(|p| p.0)), range(all().map(|p| p.1))) else {
        return Ok(());
    };
    let gap = (f64::NAN, f64::NAN);
    let plot = Plot::new("Starts and ends of the searches", &axis(&parameters[y]), x_range, y_range)
        .x_label(&axis(&parameters[x]))
        .height(360)
        .curve(
            "belong together",
            Color::Muted,
            Stroke::Dotted,
            paths.iter().flat_map(|path| [point(&path.from), point(&path.to), gap]),
        )
        .points("start", Color::Second, Marker::Ring, paths.iter().map(|path| point(&path.from)))
        .points("end", Color::First, Marker::Dot, paths.iter().map(|path| point(&path.to)));
    page.plot("Where the searches began and ended", &plot, &format!("{}.", text::ends(story)))
}

/// Profile likelihoods of the vehicle's parameters.
pub fn profiles(page: &mut Page, story: &Story<'_>) -> Result<(), PlotError> {
    let of_vehicle = story.found.parameters.iter().filter(|it| !super::is_sensors(it));
    for parameter in of_vehicle.filter(|it| it.profile.len() > 2) {
        // The interval given belongs to what is told: the two are to be compared.
        let given = [parameter.ci95.0, parameter.ci95.1].into_iter().filter(|_| parameter.identifiable);
        let values = parameter.profile.iter().map(|point| point.0).chain(given);
        let Some(x) = range(values) else { continue };
        // At kinks of the tire a refit may find a little less than the search did.
        let profile: Vec<(f64, f64)> =
            parameter.profile.iter().map(|(value, ratio)| (*value, ratio.max(0.0))).collect();
        let half = 0.5 * (parameter.ci95.1 - parameter.ci95.0);
        let parabola = (0..=200).map(|i| {
            let at = x.start + (x.end - x.start) * f64::from(i) / 200.0;
            (at, LIMIT * ((at - parameter.value) / half).powi(2))
        });
        let plot = Plot::new(&format!("Profile of {}", parameter.name), "2 ln ratio", x.clone(), -0.5..TOP)
            .x_label(&axis(parameter))
            .height(170)
            .curve("95 %", Color::Notice, Stroke::Dashed, [(x.start, LIMIT), (x.end, LIMIT)].into_iter())
            .curve("by the interval given", Color::Muted, Stroke::Dotted, parabola)
            .curve("profile", Color::First, Stroke::Solid, between(&profile).into_iter())
            .points("computed", Color::First, Marker::Dot, profile.into_iter());
        page.plot(&format!("Profile likelihood: {}", parameter.name), &plot, &compared(parameter))?;
    }
    Ok(())
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
