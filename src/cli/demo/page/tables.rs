//! The tables of the page.

use super::super::findings::{InUse, Quality, Surface, at, driven};
use super::super::recorder::Row;
use super::super::terminal::percent;
use super::{Story, side};
use crate::model::Truth;
use crate::report::number;

impl Story<'_> {
    pub(super) fn surface_columns(&self) -> Vec<&str> {
        let names = self.findings.surfaces.iter().map(|surface| surface.name.as_str());
        ["at the end of each surface"].into_iter().chain(names).collect()
    }

    pub(super) fn surface_rows(&self) -> Vec<Vec<String>> {
        let each = |name: String, cell: &dyn Fn(&Surface) -> String| {
            std::iter::once(name).chain(self.findings.surfaces.iter().map(cell)).collect::<Vec<String>>()
        };
        let found = |row: Option<&Row>, value: &dyn Fn(&Row) -> f64, std: &dyn Fn(&Row) -> f64| match row {
            Some(row) => format!("{} ± {}", number(value(row), 1), number(1.96 * std(row), 1)),
            None => "not valid".into(),
        };
        let end = |surface: &Surface| at(self.truth, surface.time.end - 0.01);
        let truth = |surface: &Surface, value: &dyn Fn(&Truth) -> f64| {
            end(surface).and_then(|i| self.truth.get(i)).map_or(f64::NAN, value)
        };
        let in_use = |surface: &Surface, value: &dyn Fn(&InUse) -> f64| {
            end(surface).and_then(|i| self.findings.in_use.get(i)).map_or(f64::NAN, value)
        };
        let mut rows = Vec::new();
        for wheel in driven(&self.scenario.vehicle) {
            let index = wheel as usize;
            rows.push(each(format!("Slip slope, {}: gripd", side(wheel)), &|surface| {
                let row = self.last_valid(surface, |row| row.round.slope_valid);
                found(row, &|row| row.round.slope[index], &|row| row.round.slope_std)
            }));
        }
        let first = self.first_wheel() as usize;
        rows.push(each("\u{2003}true, in use (at zero slip)".into(), &|surface| {
            let [used, zero] = [in_use(surface, &|i| i.slope[first]), truth(surface, &|t| t.slope[first])];
            format!("{} ({})", number(used, 1), number(zero, 1))
        }));
        for (axle, name) in ["front", "rear"].into_iter().enumerate() {
            rows.push(each(format!("Cornering stiffness, {name}, 1/rad: gripd"), &|surface| {
                let row = self.last_valid(surface, |row| row.round.cornering_valid);
                found(row, &|row| row.round.cornering[axle], &|row| row.round.cornering_std[axle])
            }));
            rows.push(each("\u{2003}true, at zero slip".into(), &|surface| {
                number(truth(surface, &|t| [t.cornering_front, t.cornering_rear][axle]), 1)
            }));
        }
        rows.push(each("Friction available: gripd".into(), &|surface| self.friction_found(surface)));
        rows.push(each("\u{2003}true".into(), &|surface| number(truth(surface, &|t| t.mu_max), 2)));
        rows
    }

    pub(super) fn friction_found(&self, surface: &Surface) -> String {
        if let Some(row) = self.last_valid(surface, |row| row.round.mu_valid) {
            let round = &row.round;
            let [max, low, high] = [round.mu_max, round.mu_low, round.mu_high].map(|value| number(value, 2));
            return format!("{max} ({low} to {high})");
        }
        let on = self.noticed_part(surface);
        let rows = self.rows.iter().filter(|row| on.contains(&row.round.time));
        let least = rows.map(|row| row.round.mu_low).fold(f64::NAN, f64::max);
        format!("at least {}", number(least, 2))
    }
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
