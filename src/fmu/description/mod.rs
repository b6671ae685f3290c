//! `modelDescription.xml` of a car's FMU.

mod fmi2;
mod fmi3;

use std::fmt::Write as _;

use crate::Version;
use crate::car::{Car, CarError, Part};
use crate::quantities::UNITS;
use crate::variables::{Causality, Variable, variables};

/// Name of the library in the archive, without its ending.
pub const LIBRARY: &str = "gripd";

/// The description.
///
/// # Errors
/// A car that cannot be written.
pub fn description(car: &Car, version: Version) -> Result<String, CarError> {
    let token = token(&car.text()?);
    let variables = variables(car);
    Ok(match version {
        Version::Two => fmi2::description(car, &variables, &token),
        Version::Three => fmi3::description(car, &variables, &token),
    })
}

/// What tells whether description, resource and library belong together: a hash of the resource (FNV-1a, from two starts)
/// and of the program's version.
pub fn token(resource: &str) -> String {
    let hash = |start: u64| {
        let bytes = resource.bytes().chain(env!("CARGO_PKG_VERSION").bytes());
        bytes.fold(start, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3))
    };
    let halves = [hash(0xCBF2_9CE4_8422_2325), hash(0x6C62_272E_07BB_0142)];
    format!("{{{:016x}{:016x}}}", halves[0], halves[1])
}

/// Text as it may stand in an attribute.
fn escaped(text: &str) -> String {
    let mut all = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => all.push_str("&amp;"),
            '<' => all.push_str("&lt;"),
            '>' => all.push_str("&gt;"),
            '"' => all.push_str("&quot;"),
            // XML has no others of these.
            c if c.is_control() => all.push(' '),
            c => all.push(c),
        }
    }
    all
}

/// In one sentence.
fn about(car: &Car) -> String {
    let kinds: Vec<_> = car.effect.iter().map(|effect| effect.kind().name).collect();
    let beyond = if kinds.is_empty() { "no effects".to_owned() } else { kinds.join(", ") };
    let late = match car.all_late_s() {
        0.0 => String::new(),
        late => format!("; all measured values are {late} s late, so that none is early"),
    };
    let what = match car.part {
        Part::Car => "The car",
        Part::Correction => "What a plain simulation lacks of the car",
    };
    escaped(&format!("{what} {} as gripd found it, with {beyond}{late}", car.name))
}

/// The elements of the units that are used.
fn units(variables: &[Variable]) -> String {
    let mut text = String::from("  <UnitDefinitions>\n");
    for (name, (factor, powers)) in UNITS {
        if !variables.iter().any(|variable| variable.unit == *name) {
            continue;
        }
        let mut base = String::new();
        for (unit, power) in ["kg", "m", "s", "rad"].into_iter().zip(powers) {
            if *power != 0 {
                // Writing to a string does not fail.
                let _ = write!(base, " {unit}=\"{power}\"");
            }
        }
        if *factor != 1.0 {
            let _ = write!(base, " factor=\"{factor:?}\"");
        }
        let _ = writeln!(text, "    <Unit name=\"{name}\"><BaseUnit{base}/></Unit>");
    }
    text.push_str("  </UnitDefinitions>\n");
    text
}

/// What stands between the units and the variables.
const BEFORE_VARIABLES: &str = "  <LogCategories><Category name=\"error\" description=\"Calls that are refused, and why\"/>\
     </LogCategories>\n  \
     <DefaultExperiment startTime=\"0.0\" stopTime=\"10.0\" stepSize=\"0.001\"/>\n  <ModelVariables>\n";

/// Attributes of a variable by its causality.
const fn kind(causality: Causality) -> &'static str {
    match causality {
        Causality::Independent => "causality=\"independent\" variability=\"continuous\"",
        Causality::Input => "causality=\"input\" variability=\"continuous\"",
        Causality::Output => "causality=\"output\" variability=\"continuous\" initial=\"calculated\"",
        Causality::Tunable => "causality=\"parameter\" variability=\"tunable\" initial=\"exact\"",
        Causality::Fixed => "causality=\"parameter\" variability=\"fixed\" initial=\"exact\"",
    }
}

/// `min` and `max` of a number.
fn range(variable: &Variable) -> String {
    variable.range.map_or_else(String::new, |(low, high)| format!(" min=\"{low:?}\" max=\"{high:?}\""))
}

/// A start value, as an attribute.
fn start(variable: &Variable) -> String {
    if variable.start.is_nan() {
        String::new()
    } else if variable.is_switch() {
        format!(" start=\"{}\"", variable.start != 0.0)
    } else {
        format!(" start=\"{:?}\"", variable.start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_of_the_whole_resource() {
        let tokens = ["a", "b", "ab", ""].map(token);
        assert!(tokens.iter().all(|token| token.len() == 34), "{tokens:?}");
        assert!(tokens.iter().enumerate().all(|(i, one)| !tokens[..i].contains(one)), "{tokens:?}");
    }

    #[test]
    fn names_cannot_end_an_attribute() {
        assert_eq!(escaped("a\"<b>&\u{7}"), "a&quot;&lt;b&gt;&amp; ");
    }
}
