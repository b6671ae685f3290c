//! Questions with defaults, one line each: an empty line, or the end of the input, takes the default.

use std::io::{self, BufRead, Write};

use super::answers::Answers;
use super::is_unsure;
use super::sizes::Size;
use crate::cli::printable::printable;
use bus::propose::{CarClass, Confidence, Proposal};
use physics::Quantity;
use physics::model::{DrivenAxle, Uncertain};

/// How often the same question is asked at most.
const TRIES: usize = 5;

/// Where questions go, and where answers come from.
pub struct Questions<R, W> {
    answers: R,
    questions: W,
}

impl<R: BufRead, W: Write> Questions<R, W> {
    /// Of these two.
    pub fn new(answers: R, questions: W) -> Self {
        Self { answers, questions }
    }

    /// Signals that were found with doubt: a no leaves them out.
    pub fn about_signals(
        &mut self,
        proposal: &mut Proposal,
        named: impl Fn(Quantity) -> bool,
    ) -> io::Result<()> {
        for choice in &mut proposal.quantities {
            if !is_unsure(choice.confidence) || named(choice.quantity) {
                continue;
            }
            let signal = choice.mapping.as_ref().map(|mapped| mapped.signals.join(" + "));
            let signal = signal.unwrap_or_default();
            let question = format!("{}: take {signal}? ({}) yes or no", choice.quantity, choice.why);
            let answer = self.ask(&question, "yes", |text| match text {
                "y" | "yes" => Ok(true),
                "n" | "no" => Ok(false),
                _ => Err("yes or no".into()),
            })?;
            if answer == Some(false) {
                choice.confidence = Confidence::NotFound;
                choice.why.push_str("; left out by you");
            }
        }
        Ok(())
    }

    /// What no option told of the car. What is not answered stays open: a class of cars, or the recording, tells it.
    pub fn about_the_car(&mut self, answers: &mut Answers) -> io::Result<()> {
        if answers.class.is_none() {
            let question =
                format!("What kind of car is it: {}", CarClass::ALL.map(CarClass::name).join(", "));
            answers.class = self.ask(&question, CarClass::default().name(), str::parse)?;
        }
        let class = answers.class.unwrap_or_default();
        if answers.driven.is_none() {
            let question = "Which axle is driven: front, rear, all";
            let default = format!("as the recording says, else {}", class.driven().name());
            let known = |text: &str| DrivenAxle::named(text).ok_or_else(|| "front, rear or all".to_owned());
            answers.driven = self.ask(question, &default, known)?;
        }
        let unknown = format!("not known: that of a {class}");
        let mut number_of = |answer: &mut Option<Uncertain>, size: Size, question: &str| -> io::Result<()> {
            if answer.is_none() {
                *answer = self.ask(question, &unknown, |text| size.parse(text))?;
            }
            Ok(())
        };
        number_of(&mut answers.mass, Size::MASS, "Mass with driver and load, kg (1600, or 1600+-50)")?;
        number_of(&mut answers.wheelbase, Size::WHEELBASE, "Wheelbase, m")?;
        number_of(
            &mut answers.cg_to_front,
            Size::CG_TO_FRONT,
            "From the front axle to the centre of gravity, m",
        )?;
        number_of(&mut answers.wheel_radius, Size::WHEEL_RADIUS, "Rolling radius of the tires, m")
    }

    /// The answer; `None` for the default.
    fn ask<T>(
        &mut self,
        question: &str,
        default: &str,
        parse: impl Fn(&str) -> Result<T, String>,
    ) -> io::Result<Option<T>> {
        for _ in 0..TRIES {
            write!(self.questions, "{} [{default}]: ", printable(question))?;
            self.questions.flush()?;
            let mut line = String::new();
            if self.answers.read_line(&mut line)? == 0 {
                writeln!(self.questions)?;
                return Ok(None);
            }
            match line.trim() {
                "" => return Ok(None),
                text => match parse(text) {
                    Ok(answer) => return Ok(Some(answer)),
                    Err(why) => writeln!(self.questions, "{}", printable(&why))?,
                },
            }
        }
        writeln!(self.questions, "taken: {default}")?;
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(lines: &str, answers: Answers) -> (Answers, String) {
        let mut answers = answers;
        let mut said = Vec::new();
        Questions::new(lines.as_bytes(), &mut said).about_the_car(&mut answers).unwrap();
        (answers, String::from_utf8(said).unwrap())
    }

    #[test]
    fn an_empty_line_or_none_takes_the_default() {
        let (answers, said) = asked("\n\n1650+-40\n", Answers::default());
        assert_eq!(answers.mass, Some(Uncertain { value: 1650.0, std: 40.0 }));
        assert!(answers.class.is_none() && answers.driven.is_none() && answers.wheelbase.is_none());
        assert!(said.contains("midsize") && said.contains("Wheelbase"), "{said}");
    }

    #[test]
    fn what_an_option_told_is_not_asked_and_a_wrong_answer_is_asked_again() {
        let told = Answers { mass: Some(Uncertain::known(790.0)), ..Answers::default() };
        let (answers, said) = asked("lorry\nrace\nrear\ntwo metres\n2.98\n\n\n", told);
        assert_eq!((answers.class, answers.driven), (Some(CarClass::Race), Some(DrivenAxle::Rear)));
        assert_eq!(answers.wheelbase, Some(Uncertain::known(2.98)));
        assert!(!said.contains("Mass") && said.contains("there is no class `lorry`"), "{said}");
    }

    #[test]
    fn who_never_answers_right_gets_the_default() {
        let (answers, said) = asked(&"lorry\n".repeat(TRIES), Answers::default());
        assert!(answers.class.is_none() && said.contains("taken: midsize"), "{said}");
    }
}
