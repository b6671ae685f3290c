//! Numbers of a car as users tell them: what no car can be is refused, with what was probably meant.

use identify::Parameter;
use physics::model::Uncertain;

/// What a number of a car can be.
#[derive(Clone, Copy)]
pub struct Size {
    unit: &'static str,
    /// What it can be at all.
    bounds: (f64, f64),
    /// What it is in nearly all cars: what was meant is looked for there.
    usual: (f64, f64),
    /// Other units that it is told in, what one of them is, and slips of the point.
    slips: &'static [(f64, &'static str)],
}

const LENGTHS: &[(f64, &str)] = &[(1e-3, "mm"), (1e-2, "cm"), (0.0254, "inches"), (0.1, ""), (10.0, "")];
const MASSES: &[(f64, &str)] = &[(1e3, "t"), (1e-3, "g"), (10.0, ""), (0.1, ""), (100.0, "")];
const RATIOS: &[(f64, &str)] = &[(0.1, ""), (10.0, ""), (1e-2, "")];

impl Size {
    /// With driver and load.
    pub const MASS: Self = Self::of(Parameter::Mass, "kg", (600.0, 4000.0), MASSES);
    /// Between the axles.
    pub const WHEELBASE: Self = Self::of(Parameter::Wheelbase, "m", (1.8, 4.5), LENGTHS);
    /// From the front axle to the centre of gravity.
    pub const CG_TO_FRONT: Self = Self::of(Parameter::CgToFront, "m", (0.7, 2.5), LENGTHS);
    /// Of the centre of gravity; no car that drives is higher than its track lets it stand.
    pub const CG_HEIGHT: Self = Self { unit: "m", bounds: (0.1, 3.0), usual: (0.3, 1.2), slips: LENGTHS };
    /// Between the wheels of an axle.
    pub const TRACK: Self = Self::of(Parameter::TrackFront, "m", (1.2, 2.1), LENGTHS);
    /// Of a rolling wheel.
    pub const WHEEL_RADIUS: Self = Self::of(Parameter::WheelRadius, "m", (0.25, 0.45), LENGTHS);
    /// Steering wheel angle over road wheel angle.
    pub const STEERING_RATIO: Self = Self::of(Parameter::SteeringRatio, "", (8.0, 25.0), RATIOS);

    const fn of(
        parameter: Parameter,
        unit: &'static str,
        usual: (f64, f64),
        slips: &'static [(f64, &'static str)],
    ) -> Self {
        Self { unit, bounds: parameter.bounds(), usual, slips }
    }

    /// A number of this size.
    pub fn parse(self, text: &str) -> Result<Uncertain, String> {
        let number = number(text)?;
        let (least, most) = self.bounds;
        if (least..=most).contains(&number.value) {
            return Ok(number);
        }
        let meant = self.meant(number.value).map_or_else(String::new, |meant| format!("; {meant}"));
        Err(format!("`{text}`: no car has that: it is {least} to {most} {}", self.unit).trim_end().to_owned()
            + &meant)
    }

    /// What was probably meant, as a question.
    fn meant(self, value: f64) -> Option<String> {
        let (least, most) = self.usual;
        let is_usual = |(factor, _): &&(f64, &str)| (least..=most).contains(&(factor * value));
        let (factor, unit) = self.slips.iter().find(is_usual)?;
        let meant = (1e4 * factor * value).round() / 1e4;
        let from = if unit.is_empty() { String::new() } else { format!(", if it is in {unit}") };
        Some(format!("did you mean {meant}{from}?"))
    }
}

/// `1600`, or `1600+-50`, `1600±50`, `1600+/-50`.
fn number(text: &str) -> Result<Uncertain, String> {
    let parts: Vec<&str> = ["+/-", "+-", "±"]
        .iter()
        .find_map(|sign| text.split_once(sign))
        .map_or(vec![text], |(a, b)| vec![a, b]);
    let parsed = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    let wrong = || format!("`{text}` is no number; write 1600, or 1600+-50 with its standard deviation");
    let value = parts.first().and_then(|text| parsed(text)).ok_or_else(wrong)?;
    let std = parts.get(1).map_or(Some(0.0), |text| parsed(text)).ok_or_else(wrong)?;
    if value <= 0.0 || std < 0.0 {
        return Err(format!("`{text}`: must be more than zero, and its deviation not less"));
    }
    Ok(Uncertain { value, std })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_with_and_without_a_deviation() {
        assert_eq!(number("1600"), Ok(Uncertain::known(1600.0)));
        for text in ["1600+-50", "1600 ± 50", "1600+/-50", "1.6e3+-50"] {
            assert_eq!(number(text), Ok(Uncertain { value: 1600.0, std: 50.0 }), "{text}");
        }
        for text in ["", "heavy", "1600+-", "-3", "0", "1600+--5", "inf", "NaN"] {
            assert!(number(text).is_err(), "{text}");
        }
    }

    #[test]
    fn what_no_car_has_is_refused_with_what_was_meant() {
        for (size, text, meant) in [
            (Size::WHEELBASE, "26.3", "0.8 to 12 m; did you mean 2.63?"),
            (Size::WHEELBASE, "2650+-5", "did you mean 2.65, if it is in mm?"),
            (Size::WHEELBASE, "265", "did you mean 2.65, if it is in cm?"),
            (Size::MASS, "1.65", "100 to 60000 kg; did you mean 1650, if it is in t?"),
            (Size::MASS, "15", "did you mean 1500?"),
            (Size::WHEEL_RADIUS, "12.5", "did you mean 0.3175, if it is in inches?"),
            (Size::STEERING_RATIO, "150", "0.5 to 60; did you mean 15?"),
        ] {
            let why = size.parse(text).unwrap_err();
            assert!(why.contains(meant), "{why}");
        }
        assert_eq!(Size::CG_HEIGHT.parse("0.55"), Ok(Uncertain::known(0.55)));
    }
}
