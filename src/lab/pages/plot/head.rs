//! The words of the page: what drive it is, and at its end how to read it; and its time axis.

use super::friction::MEAN_S;
use super::scene::{Scene, most};
use crate::pages::file_name;
use crate::report::Fact;
use crate::report::interactive::{Mark, Numbers, Plots};
use physics::Quantity;
use physics::model::GRAVITY;

impl Scene<'_> {
    /// What the page is about.
    pub fn lead(&self) -> String {
        let names: Vec<&str> = self.drive.clocks.iter().map(|clock| clock.name.as_str()).collect();
        match names.as_slice() {
            [] => "Nothing of a recording.".into(),
            names => format!(
                "What was measured, and what gripd makes of it. Drag over a plot to zoom: all panels show the same time. \
                 A double click shows all again. Recording: {}.",
                list(names)
            ),
        }
    }

    /// The plots without panels.
    pub fn empty_plots(&self) -> Plots {
        Plots {
            clocks: self.drive.clocks.clone(),
            marks: self.marks(),
            times: Numbers::rounded(self.grid.times().to_vec(), 3),
            stretch_s: self.grid.stretch_s(),
            ..Plots::default()
        }
    }

    /// Numbers at its head.
    pub fn facts(&self) -> Vec<Fact> {
        let drive = self.drive;
        let steps = || (0..drive.times.len()).map(|place| drive.step_s(place));
        let seconds: f64 = steps().sum();
        let speed = || drive.speed.iter().map(|it| if it.is_finite() { f64::from(*it) } else { 0.0 });
        let way: f64 = steps().zip(speed()).map(|(step, speed)| step * speed).sum();
        let fact = |name: &str, value: String, note: String| Fact { name: name.into(), value, note };
        let mut facts = vec![
            fact("Length", format!("{:.0} s", seconds), format!("{:.2} km", way / 1000.0)),
            fact(
                "Highest speed",
                most(drive.speed.iter().copied())
                    .map_or_else(|| "–".into(), |it| format!("{:.0} km/h", it * 3.6)),
                String::new(),
            ),
        ];
        let (across, is_sensor) = self.lateral_acceleration();
        let means = self.means(&across, &across);
        if let Some(hardest) = means.iter().map(|it| it.1.abs()).reduce(f64::max) {
            let by = if is_sensor { "accelerometer" } else { "speed × yaw rate" };
            facts.push(fact(
                "Most lateral acceleration",
                format!("{hardest:.1} m/s²"),
                format!("{:.2} g over {MEAN_S} s, {by}", hardest / GRAVITY),
            ));
        }
        let count = drive.flags.len().max(1) as f64;
        let share = |valid: usize| format!("{:.0} %", 100.0 * valid as f64 / count);
        let valid =
            |of: fn(&super::drive::Flags) -> bool| share(drive.flags.iter().filter(|it| of(it)).count());
        let note = || String::from("of the time");
        facts.push(fact("Sideslip valid", valid(|it| it.motion), note()));
        facts.push(fact("Cornering stiffness valid", valid(|it| it.cornering), note()));
        facts.push(fact("Slip slope valid", valid(|it| it.slope), note()));
        facts.push(fact("Friction valid", valid(|it| it.friction), note()));
        facts
    }

    /// Recordings after the first, and what was noticed of the road.
    fn marks(&self) -> Vec<Mark> {
        let mut marks: Vec<Mark> = self
            .drive
            .clocks
            .iter()
            .skip(1)
            .map(|clock| Mark { at_s: clock.from_s, name: file_name(&clock.name).into() })
            .collect();
        let changes = self.drive.changes.windows(2).zip(self.drive.times.iter().skip(1));
        let noticed = changes.filter(|(pair, _)| pair[1] > pair[0]);
        marks.extend(noticed.map(|(_, time)| Mark { at_s: *time, name: "another surface noticed".into() }));
        marks
    }

    /// What has to be known to read it.
    pub fn notes(&self) -> Vec<String> {
        let missing: Vec<&str> = Quantity::ALL
            .into_iter()
            .filter(|quantity| !self.drive.quantities.contains(quantity))
            .map(Quantity::name)
            .collect();
        let mut notes = vec![
            "Solid: measured, as decoded from the bus and as the estimators take it, every 10 ms unless the configuration \
             says otherwise. Heavier and dashed in one way or another: estimated by gripd, the same numbers that gripd replay writes and the \
             service publishes. Dotted: what would be expected, from other sensors or from the configured car. A light \
             ground with a strip at its foot: valid, it may be acted upon. Shaded around a line: its 95 % interval. No line: \
             not available."
                .into(),
            "Times are seconds from the first frame of the first recording; the dates beside them are the \
             recording's own clock, in UTC. The numbers in the legends are those at the cursor. In the figures, what lies \
             outside of the zoomed time is faint."
                .into(),
        ];
        if let Some(stretch) = self.grid.stretch_s() {
            notes.push(format!(
                "This drive has more samples than a page can carry. Of each {stretch:.2} s there are the lowest and the highest \
                 value of every line: no peak is lost, and each is at most {stretch:.2} s from where it stands. --from and --to \
                 give every sample of a part."
            ));
        }
        if !missing.is_empty() {
            notes.push(format!("Not configured, and so not shown: {}.", missing.join(", ")));
        }
        notes
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
