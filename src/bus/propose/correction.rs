//! A proposed entry put right, where the comparison of all sensors says what is wrong with it.

use super::proposal::{Choice, Confidence, Mapped, Proposal};
use physics::Quantity;

/// What is wrong with a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Correction {
    /// It is the wrong way round.
    Turned,
    /// It is so many times what it should be.
    Times(f64),
    /// It is late by so much, s.
    Late(f64),
    /// It reads so much where it should read zero, SI.
    Zero(f64),
    /// It is the other quantity's, and the other's is its own.
    Exchanged(Quantity),
    /// It does not belong to the others.
    Foreign,
}

impl Proposal {
    /// Puts it right, and says so in `words`; false where there is nothing to put right, or no entry could.
    pub fn correct(&mut self, quantity: Quantity, correction: Correction, words: &str) -> bool {
        if let Correction::Exchanged(other) = correction {
            return self.exchange(quantity, other, words);
        }
        let Some(choice) = self.live(quantity) else { return false };
        if correction == Correction::Foreign {
            choice.confidence = Confidence::NotFound;
        } else {
            let Some(mapped) = choice.mapping.as_mut() else { return false };
            if !mapped.correct(correction) {
                return false;
            }
        }
        choice.repaired.push(words.to_owned());
        true
    }

    fn live(&mut self, quantity: Quantity) -> Option<&mut Choice> {
        let found = |choice: &&mut Choice| choice.confidence > Confidence::NotFound;
        self.quantities.iter_mut().find(|choice| choice.quantity == quantity).filter(found)
    }

    fn exchange(&mut self, one: Quantity, other: Quantity, words: &str) -> bool {
        if one == other || !(self.has(one) && self.has(other)) {
            return false;
        }
        let mappings = [one, other].map(|quantity| self.live(quantity).and_then(|c| c.mapping.take()));
        let [of_one, of_other] = mappings;
        for (quantity, mapping) in [(one, of_other), (other, of_one)] {
            if let Some(choice) = self.live(quantity) {
                choice.mapping = mapping;
                choice.repaired.push(words.to_owned());
            }
        }
        true
    }
}

impl Mapped {
    /// The value is gain · raw + offset.
    fn correct(&mut self, correction: Correction) -> bool {
        match correction {
            Correction::Turned => self.scale(-1.0),
            Correction::Times(factor) if factor.is_finite() && factor != 0.0 => self.scale(1.0 / factor),
            Correction::Zero(zero) if zero.is_finite() => {
                let offset = rounded(self.offset.unwrap_or(0.0) - zero, 4);
                self.offset = Some(offset).filter(|offset| *offset != 0.0);
                true
            }
            Correction::Late(seconds) => {
                let late = (self.delay_ms.unwrap_or(0.0) + 1e3 * seconds).round();
                // Nothing is early, and what is later than a second is no delay.
                if !(0.0..=1000.0).contains(&late) {
                    return false;
                }
                self.delay_ms = Some(late).filter(|late| *late > 0.0);
                true
            }
            _ => false,
        }
    }

    fn scale(&mut self, factor: f64) -> bool {
        let gain = self.gain.unwrap_or(1.0) * factor;
        // Five digits: no drive tells more.
        let digits = 4 - gain.abs().log10().floor() as i32;
        let gain = rounded(gain, digits.clamp(0, 12));
        if !gain.is_finite() || gain == 0.0 {
            return false;
        }
        self.gain = Some(gain).filter(|gain| *gain != 1.0);
        self.offset = self.offset.map(|offset| rounded(offset * factor, 4)).filter(|offset| *offset != 0.0);
        true
    }
}

fn rounded(value: f64, decimals: i32) -> f64 {
    let power = 10f64.powi(decimals);
    (value * power).round() / power
}

#[cfg(test)]
mod tests {
    use super::*;

    fn proposal() -> Proposal {
        let choice = |quantity, signal: &str| Choice {
            quantity,
            confidence: Confidence::Sure,
            mapping: Some(Mapped { signals: vec![signal.to_owned()], ..Mapped::default() }),
            names: 1.0,
            data: None,
            why: String::new(),
            alternatives: Vec::new(),
            contradicted: Vec::new(),
            repaired: Vec::new(),
        };
        Proposal {
            quantities: vec![choice(Quantity::YawRate, "E.Y"), choice(Quantity::LateralAcceleration, "E.A")],
            notes: Vec::new(),
            driven_s: None,
            fd: false,
        }
    }

    fn mapped(proposal: &Proposal, quantity: Quantity) -> &Mapped {
        proposal.choice(quantity).unwrap().mapping.as_ref().unwrap()
    }

    #[test]
    fn what_was_wrong_is_taken_back_in_any_order() {
        let mut proposal = proposal();
        let quantity = Quantity::YawRate;
        // Recorded as −1.25 · truth + 0.02, and 85 ms late.
        for correction in
            [Correction::Zero(0.02), Correction::Turned, Correction::Times(1.25), Correction::Late(0.0852)]
        {
            assert!(proposal.correct(quantity, correction, "so"));
        }
        let yaw = mapped(&proposal, quantity);
        let read = |recorded: f64| yaw.gain.unwrap() * recorded + yaw.offset.unwrap();
        assert!((read(-1.25 * 0.4 + 0.02) - 0.4).abs() < 1e-9, "{yaw:?}");
        assert_eq!(yaw.delay_ms, Some(85.0));
        assert_eq!(proposal.choice(quantity).unwrap().repaired.len(), 4);
        // Turned twice it is as it was.
        assert!(proposal.correct(quantity, Correction::Turned, "so"));
        assert_eq!(mapped(&proposal, quantity).gain, Some(0.8));
    }

    #[test]
    fn what_cannot_be_is_left_alone() {
        let mut proposal = proposal();
        let before = proposal.clone();
        assert!(!proposal.correct(Quantity::YawRate, Correction::Late(-0.05), "early"));
        assert!(!proposal.correct(Quantity::YawRate, Correction::Times(0.0), "nothing"));
        assert!(!proposal.correct(Quantity::BrakePressure, Correction::Turned, "not there"));
        let with_none = Correction::Exchanged(Quantity::BrakePressure);
        assert!(!proposal.correct(Quantity::YawRate, with_none, "not there"));
        assert_eq!(proposal, before);
    }

    #[test]
    fn exchanged_and_foreign_signals() {
        let mut proposal = proposal();
        let (yaw, lateral) = (Quantity::YawRate, Quantity::LateralAcceleration);
        assert!(proposal.correct(yaw, Correction::Exchanged(lateral), "mixed up"));
        assert_eq!(mapped(&proposal, yaw).signals, ["E.A"]);
        assert_eq!(mapped(&proposal, lateral).signals, ["E.Y"]);
        assert!(proposal.correct(lateral, Correction::Foreign, "of another drive"));
        assert!(!proposal.has(lateral) && proposal.has(yaw));
        assert!(!proposal.correct(lateral, Correction::Turned, "gone"));
    }
}
