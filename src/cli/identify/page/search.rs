//! Where the searches went, and how sharply their end is known.

use super::Story;
use super::drive::range;
use crate::cli::identify::text;
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
/// Higher than this a profile is not drawn.
const TOP: f64 = 12.0;

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
        let Some(x) = range(parameter.profile.iter().map(|point| point.0)) else { continue };
        // At kinks of the tire a refit may find a little less than the search did.
        let profile = parameter.profile.iter().map(|(value, cost)| (*value, cost.max(0.0)));
        let half = 0.5 * (parameter.ci95.1 - parameter.ci95.0);
        let parabola = (0..=60).map(|i| {
            let at = x.start + (x.end - x.start) * f64::from(i) / 60.0;
            (at, LIMIT * ((at - parameter.value) / half).powi(2))
        });
        let plot = Plot::new(&format!("Profile of {}", parameter.name), "2 ln ratio", x.clone(), -0.5..TOP)
            .x_label(&axis(parameter))
            .height(170)
            .curve("95 %", Color::Notice, Stroke::Dashed, [(x.start, LIMIT), (x.end, LIMIT)].into_iter())
            .curve("by the interval given", Color::Muted, Stroke::Dotted, parabola)
            .curve("profile", Color::First, Stroke::Solid, profile.clone())
            .points("computed", Color::First, Marker::Dot, profile);
        let caption = if parameter.identifiable { "" } else { parameter.reason.as_str() };
        page.plot(&format!("Profile likelihood: {}", parameter.name), &plot, caption)?;
    }
    Ok(())
}

fn axis(parameter: &Identified) -> String {
    if parameter.unit == "1" {
        parameter.name.into()
    } else {
        format!("{}, {}", parameter.name, parameter.unit)
    }
}
