//! The demo's page.

mod plots;
mod tables;

use std::ops::Range;

use super::findings::{Change, Findings, Surface, at, driven};
use super::row::Row;
use lab::report::{Page, PlotError, number};
use physics::Wheel;
use physics::model::{Scenario, Truth};

/// Everything the page is made of.
pub struct Story<'a> {
    pub scenario: &'a Scenario,
    pub seed: u64,
    pub truth: &'a [Truth],
    pub rows: &'a [Row],
    pub findings: &'a Findings,
}

impl Story<'_> {
    /// The page.
    pub fn html(&self) -> Result<String, PlotError> {
        let mut page =
            Page::new("gripd demo: tire stiffness and friction from a car's CAN bus", &self.lead());
        self.slope(&mut page)?;
        page.heading("What was found on each surface");
        page.table(&self.surface_columns(), &self.surface_rows());
        self.friction(&mut page)?;
        self.lateral(&mut page)?;
        self.cornering(&mut page)?;
        self.offset(&mut page)?;
        self.inputs(&mut page)?;
        page.heading("How good the published numbers were");
        page.table(
            &["over the whole drive", "valid", "truth in the 95 % interval", "mean error", "rms error"],
            &self.findings.quality.iter().map(tables::quality_row).collect::<Vec<_>>(),
        );
        page.heading("How to read this");
        page.notes(NOTES);
        page.paragraph(&format!("Seed {}: the same seed draws the same page.", self.seed));
        Ok(page.html())
    }

    /// What was driven and what was found, in one sentence.
    fn lead(&self) -> String {
        let names: Vec<&str> = self.findings.surfaces.iter().map(|surface| surface.name.as_str()).collect();
        let noticed: Vec<String> = self.findings.changes.iter().map(noticed).collect();
        let mut text = format!("{:.0} s of simulated driving on {}.", self.scenario.duration_s, list(&names));
        if !noticed.is_empty() {
            let noticed: Vec<&str> = noticed.iter().map(String::as_str).collect();
            text += &format!(" gripd, reading only the car's CAN frames, noticed {}", list(&noticed));
            text += &match self.findings.false_notices() {
                0 => String::from("; it raised no false alarm."),
                1 => String::from("; it raised one false alarm."),
                count => format!("; it raised {count} false alarms."),
            };
        }
        let wheel = self.first_wheel() as usize;
        let slopes: Vec<(String, String)> = self
            .findings
            .surfaces
            .iter()
            .filter_map(|surface| {
                let round = &self.last_valid(surface, |row| row.round.slope_valid)?.round;
                let truth = self.findings.in_use.get(at(self.truth, round.time)?)?;
                Some((number(round.slope[wheel], 0), number(truth.slope[wheel], 0)))
            })
            .collect();
        if !slopes.is_empty() {
            let (found, true_): (Vec<&str>, Vec<&str>) =
                slopes.iter().map(|(a, b)| (a.as_str(), b.as_str())).unzip();
            text += &format!(" Slip slope found: {}; true in use: {}.", list(&found), list(&true_));
        }
        for surface in &self.findings.surfaces {
            if let Some(row) = self.last_valid(surface, |row| row.round.mu_valid)
                && let Some(truth) = at(self.truth, row.round.time).and_then(|index| self.truth.get(index))
            {
                let (found, true_) = (tables::friction(row), number(truth.mu_max, 2));
                text += &format!(" Friction found on {}: {found}; true: {true_}.", surface.name);
            }
        }
        text
    }

    fn first_wheel(&self) -> Wheel {
        driven(&self.scenario.vehicle).first().copied().unwrap_or(Wheel::Fl)
    }

    /// The last row that counts on this surface. Before the change was noticed, what is published is of
    /// the surface before.
    fn last_valid(&self, surface: &Surface, valid: impl Fn(&Row) -> bool) -> Option<&Row> {
        let on = self.noticed_part(surface);
        self.rows.iter().rfind(|row| on.contains(&row.round.time) && valid(row))
    }

    fn noticed_part(&self, surface: &Surface) -> Range<f64> {
        let Range { start, end } = surface.time;
        match self.findings.changes.iter().find(|change| change.at == start) {
            Some(Change { delay: Some(delay), .. }) => start + delay..end,
            _ => start..end,
        }
    }
}

fn side(wheel: Wheel) -> &'static str {
    match wheel {
        Wheel::Fl => "front left",
        Wheel::Fr => "front right",
        Wheel::Rl => "rear left",
        Wheel::Rr => "rear right",
    }
}

fn noticed(change: &Change) -> String {
    match change.delay {
        Some(delay) => format!("the {} after {delay:.1} s", change.to),
        None => format!("the {} not at all", change.to),
    }
}

/// "a, b and c".
fn list(words: &[&str]) -> String {
    match words {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

const NOTES: &[(&str, &str)] = &[
    (
        "gripd",
        "Decoded from the frames that gripd published on the bus, through its output DBC. Nothing else of \
         it is shown, but for the bicycle model's lateral velocity.",
    ),
    (
        "true",
        "From the simulated car: brush tires, load transfer, uneven tire radii, sensors with noise, \
         offsets, delays and tooth errors. gripd is told a data sheet's numbers, which are somewhat wrong.",
    ),
    (
        "not available",
        "Sent as such, never as an old value: a slope after a surface change until enough force has been \
         seen; the lateral motion below walking pace; the friction while too little of it is used.",
    ),
    ("valid", "May be acted upon. What is published but not valid is for information only."),
    (
        "95 % interval",
        "Value ± 1.96 standard deviations as published. For both slopes and both offsets one standard \
         deviation is published, that of the less certain one. Compared with the truth in use.",
    ),
];
