//! The tables of the page.

use super::super::findings::{InUse, Quality, Surface, at, driven};
use super::super::row::Row;
use super::{Story, side};
use crate::cli::desk::closing::percent;
use lab::report::number;
use physics::model::Truth;

impl Story<'_> {
    pub(super) fn surface_columns(&self) -> Vec<&str> {
        let names = self.findings.surfaces.iter().map(|surface| surface.name.as_str());
        ["told last on each surface"].into_iter().chain(names).collect()
    }

    pub(super) fn surface_rows(&self) -> Vec<Vec<String>> {
        let each = |name: String, cell: &dyn Fn(&Surface) -> String| {
            std::iter::once(name).chain(self.findings.surfaces.iter().map(cell)).collect::<Vec<String>>()
        };
        let found = |surface: &Surface,
                     valid: &dyn Fn(&Row) -> bool,
                     value: &dyn Fn(&Row) -> f64,
                     std: &dyn Fn(&Row) -> f64| match self.last_valid(surface, valid) {
            Some(row) => {
                let (value, half) = (number(value(row), 1), number(1.96 * std(row), 1));
                format!("{value} ± {half}{}", before_end(surface, row))
            }
            None => "not valid".into(),
        };
        // The truth is that of the moment of the value beside it; without one, of the surface's end.
        let moment = |surface: &Surface, valid: &dyn Fn(&Row) -> bool| {
            let time = self.last_valid(surface, valid).map_or(surface.time.end - 0.01, |row| row.round.time);
            at(self.truth, time)
        };
        let truth = |surface: &Surface, valid: &dyn Fn(&Row) -> bool, value: &dyn Fn(&Truth) -> f64| {
            moment(surface, valid).and_then(|i| self.truth.get(i)).map_or(f64::NAN, value)
        };
        let in_use = |surface: &Surface, valid: &dyn Fn(&Row) -> bool, value: &dyn Fn(&InUse) -> f64| {
            moment(surface, valid).and_then(|i| self.findings.in_use.get(i)).map_or(f64::NAN, value)
        };
        let slope_valid = |row: &Row| row.round.slope_valid;
        let cornering_valid = |row: &Row| row.round.cornering_valid;
        let mut rows = Vec::new();
        for wheel in driven(&self.scenario.vehicle) {
            let index = wheel as usize;
            rows.push(each(format!("Slip slope, {}: gripd", side(wheel)), &|surface| {
                found(surface, &slope_valid, &|row| row.round.slope[index], &|row| row.round.slope_std)
            }));
        }
        let first = self.first_wheel() as usize;
        rows.push(each("\u{2003}true, in use (at zero slip)".into(), &|surface| {
            let used = in_use(surface, &slope_valid, &|i| i.slope[first]);
            let zero = truth(surface, &slope_valid, &|t| t.slope[first]);
            format!("{} ({})", number(used, 1), number(zero, 1))
        }));
        for (axle, name) in ["front", "rear"].into_iter().enumerate() {
            rows.push(each(format!("Cornering stiffness, {name}, 1/rad: gripd"), &|surface| {
                let std = |row: &Row| row.round.cornering_std[axle];
                found(surface, &cornering_valid, &|row| row.round.cornering[axle], &std)
            }));
            rows.push(each("\u{2003}true, at zero slip".into(), &|surface| {
                let zero = |t: &Truth| [t.cornering_front, t.cornering_rear][axle];
                number(truth(surface, &cornering_valid, &zero), 1)
            }));
        }
        rows.push(each("Friction available: gripd".into(), &|surface| self.friction_told(surface)));
        rows.push(each("\u{2003}true".into(), &|surface| {
            let truth = self.last_friction(surface).and_then(|row| at(self.truth, row.round.time));
            number(truth.and_then(|index| self.truth.get(index)).map_or(f64::NAN, |t| t.mu_max), 2)
        }));
        rows
    }

    /// What is told of the friction of a surface last: the friction itself where it is told, else a bound.
    fn last_friction(&self, surface: &Surface) -> Option<&Row> {
        self.last_valid(surface, |row| row.round.mu_valid)
            .or_else(|| self.last_valid(surface, |row| row.round.mu_low.is_finite()))
    }

    fn friction_told(&self, surface: &Surface) -> String {
        let Some(row) = self.last_friction(surface) else { return "nothing told".into() };
        let what = if row.round.mu_valid {
            friction(row)
        } else {
            format!("at least {}", number(row.round.mu_low, 2))
        };
        what + &before_end(surface, row)
    }
}

/// The friction with its interval.
pub(super) fn friction(row: &Row) -> String {
    let round = &row.round;
    let [max, low, high] = [round.mu_max, round.mu_low, round.mu_high].map(|value| number(value, 2));
    format!("{max} ({low} to {high})")
}

/// How much older than its surface's end a value is, where it is older at all.
fn before_end(surface: &Surface, row: &Row) -> String {
    let before = surface.time.end - row.round.time;
    if before < 1.0 { String::new() } else { format!(", {before:.0} s before the end") }
}

pub(super) fn quality_row(quality: &Quality) -> Vec<String> {
    let unit =
        |value: f64| format!("{} {}", number(value, quality.decimals), quality.unit).trim_end().to_owned();
    vec![
        quality.name.to_owned(),
        percent(quality.valid),
        percent(quality.covered),
        unit(quality.bias),
        unit(quality.rms),
    ]
}
