//! What was found, put right, guessed and not found, and what to do next: for people.

use std::io::{self, Write};

use super::quoted;
use super::rounds::{Files, Settled};
use crate::cli::desk::check::cost;
use bus::propose::{Choice, Confidence as Found, Proposal, Source, VehicleTable};
use lab::explain::chain::{ChainReport, Confidence};
use lab::report::{self, WIDTH};
use physics::Quantity;
use physics::model::Uncertain;

/// All there is to say.
pub struct Report<'a> {
    /// The signals.
    pub proposal: &'a Proposal,
    /// The car.
    pub vehicle: &'a VehicleTable,
    /// How they agree with the recordings.
    pub settled: &'a Settled,
    /// What was read and written.
    pub files: &'a Files<'a>,
}

impl Report<'_> {
    /// Writes it.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let ChainReport { seconds, moving_seconds: moving, .. } = &self.settled.chain;
        let out_file = quoted(self.files.out);
        writeln!(out, "{out_file}: written, from {seconds:.0} s, {moving:.0} s of them moving")?;
        self.signals(out)?;
        self.gaps(out)?;
        self.doubts(out)?;
        self.car(out)?;
        self.next(out)
    }

    fn signals(&self, out: &mut impl Write) -> io::Result<()> {
        writeln!(out, "\nsignals")?;
        for choice in self.found() {
            let Some(mapped) = &choice.mapping else { continue };
            let mut entry = vec![mapped.signals.join(" + ")];
            entry.extend(mapped.gain.map(|gain| format!("gain {gain}")));
            entry.extend(mapped.offset.map(|offset| format!("offset {offset} {}", choice.quantity.unit())));
            entry.extend(mapped.delay_ms.map(|late| format!("{late} ms late")));
            entry.extend(mapped.not_available.iter().map(|code| format!("{code}: not available")));
            let (name, sure) = (choice.quantity.name(), choice.confidence.name());
            wrapped(out, &format!("  {name:<26} {sure:<7} "), 36, &entry.join(", "))?;
        }
        let repaired: Vec<(&Choice, &String)> = self
            .proposal
            .quantities
            .iter()
            .flat_map(|choice| choice.repaired.iter().map(move |words| (choice, words)))
            .collect();
        if !repaired.is_empty() {
            writeln!(out, "\nput right")?;
        }
        for (choice, words) in repaired {
            wrapped(out, &format!("  {:<26} ", choice.quantity.name()), 29, words)?;
        }
        Ok(())
    }

    fn found(&self) -> impl Iterator<Item = &Choice> {
        self.proposal.quantities.iter().filter(|choice| choice.confidence > Found::NotFound)
    }

    /// What is not there, those together that cost the same.
    fn gaps(&self, out: &mut impl Write) -> io::Result<()> {
        let has = |quantity| self.proposal.has(quantity);
        let brakes = has(Quantity::BrakePressure) || has(Quantity::BrakeTorque);
        let is_a_gap = |quantity: Quantity| match quantity {
            Quantity::BrakePressure | Quantity::BrakeTorque | Quantity::BrakeActive if brakes => false,
            _ => !has(quantity),
        };
        let mut gaps: Vec<(Vec<&Choice>, &str)> = Vec::new();
        for choice in self.proposal.quantities.iter().filter(|choice| is_a_gap(choice.quantity)) {
            let cost = cost(choice.quantity);
            match gaps.iter_mut().find(|(_, same)| *same == cost) {
                Some((choices, _)) => choices.push(choice),
                None => gaps.push((vec![choice], cost)),
            }
        }
        if !gaps.is_empty() {
            writeln!(out, "\nnot there, and what that costs")?;
        }
        for (choices, cost) in gaps {
            let names: Vec<_> = choices.iter().map(|choice| choice.quantity.name()).collect();
            wrapped(out, "  ", 6, &format!("{}: {cost}", names.join(", ")))?;
            if let Some(other) = choices.iter().flat_map(|choice| &choice.contradicted).next() {
                wrapped(out, "      ", 6, &format!("({}: {})", other.signal, other.data))?;
            }
        }
        Ok(())
    }

    /// What the comparison of the sensors leaves open.
    fn doubts(&self, out: &mut impl Write) -> io::Result<()> {
        let findings = &self.settled.chain.findings;
        if !findings.is_empty() {
            writeln!(out, "\nnot certain enough to be changed: look at it")?;
        }
        for finding in findings {
            let sure = match finding.confidence {
                Confidence::Certain => "certain, and not to be put right here",
                Confidence::Likely => "likely",
                Confidence::Unclear => "unclear",
            };
            let amount = finding.amount().map_or(String::new(), |amount| format!(" {amount}"));
            let words =
                format!("{sure}: {} of {}{amount}: {}", finding.effect, finding.channel, finding.repair);
            wrapped(out, "  ", 6, &words)?;
        }
        for channel in &self.settled.recordings.quantities {
            if channel.not_available > 0.5 && channel.min.is_some() {
                let share = 100.0 * channel.not_available;
                let words = format!("{} is not available in {share:.0} % of its frames", channel.quantity);
                wrapped(out, "  ", 6, &words)?;
            }
        }
        Ok(())
    }

    fn car(&self, out: &mut impl Write) -> io::Result<()> {
        writeln!(out, "\nthe car")?;
        let mut lines = [Vec::new(), Vec::new(), Vec::new()];
        let place = |source: &Source| match source {
            Source::Told => 0,
            Source::Recording(_) => 1,
            Source::Class => 2,
        };
        for number in self.vehicle.numbers() {
            lines[place(&number.source)].push(format!("{} {}", number.key, plain(number.value)));
        }
        let (axle, source) = self.vehicle.driven();
        lines[place(source)].push(format!("driven_axle {}", axle.name()));
        let class = format!("guessed, as a {} has them: ", self.vehicle.class());
        for (title, lines) in ["told by you: ", "from the recording: ", &class].into_iter().zip(&lines) {
            if !lines.is_empty() {
                wrapped(out, "  ", 6, &format!("{title}{}", lines.join(", ")))?;
            }
        }
        let matters = self.vehicle.matters(|quantity| self.proposal.has(quantity));
        if !matters.is_empty() {
            writeln!(out, "  of the guesses these matter most; an option tells the true number")?;
        }
        for (key, share, what) in matters {
            let option = option(key).map_or(String::new(), |option| format!(" ({option})"));
            wrapped(out, "      ", 10, &format!("{key} ± {:.0} %{option}: {what}", 100.0 * share))?;
        }
        Ok(())
    }

    fn next(&self, out: &mut impl Write) -> io::Result<()> {
        writeln!(out, "\nnext")?;
        let config = quoted(self.files.out);
        let logs: Vec<String> = self.files.logs.iter().map(|log| quoted(log)).collect();
        let plain: [(&str, &[&str]); 4] = [
            ("check", &[]),
            ("plot", &["--html drive.html"]),
            ("replay", &["--estimates estimates.csv", "-o published.log"]),
            ("explain", &["--html explained.html"]),
        ];
        for (command, more) in plain {
            let mut words = vec![format!("gripd {command} -c {config}")];
            words.extend(logs.iter().cloned());
            words.extend(more.iter().map(|word| (*word).to_owned()));
            command_line(out, &words)?;
        }
        Ok(())
    }
}

/// The option that tells a number.
fn option(key: &str) -> Option<&'static str> {
    Some(match key {
        "mass_kg" => "--mass",
        "wheelbase_m" => "--wheelbase",
        "cg_to_front_m" => "--cg-to-front",
        "cg_height_m" => "--cg-height",
        "track_front_m" | "track_rear_m" => "--track",
        "wheel_radius_m" => "--wheel-radius",
        "steering_ratio" => "--steering-ratio",
        _ => return None,
    })
}

fn plain(number: Uncertain) -> String {
    match number.std {
        0.0 => number.value.to_string(),
        std => format!("{} ± {std}", number.value),
    }
}

/// A text after a beginning, in lines; those that follow are indented.
fn wrapped(out: &mut impl Write, begin: &str, indent: usize, words: &str) -> io::Result<()> {
    out.write_all(report::wrapped(begin, indent, words).as_bytes())
}

/// A command that a shell takes, over several lines where it is long.
fn command_line(out: &mut impl Write, words: &[String]) -> io::Result<()> {
    let mut line = String::from("  ");
    for (place, word) in words.iter().enumerate() {
        if place > 0 && line.chars().count() + word.chars().count() + 3 > WIDTH {
            writeln!(out, "{line} \\")?;
            line = String::from("     ");
        }
        if place > 0 {
            line.push(' ');
        }
        line.push_str(word);
    }
    writeln!(out, "{line}")
}
