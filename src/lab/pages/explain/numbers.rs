//! Numbers with the digits that mean something.

use crate::explain::Estimate;

/// A number with so many decimals; a dash where there is none.
pub fn number(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    // What has run away is no number to read all digits of.
    let text = if value.abs() < 1e7 { format!("{value:.decimals$}") } else { format!("{value:.0e}") };
    let is_zero = text.bytes().all(|byte| matches!(byte, b'-' | b'.' | b'0'));
    if is_zero { text.replace('-', "") } else { text.replace('-', "−") }
}

/// The same with its sign, whichever it is.
pub fn signed(value: f64, decimals: usize) -> String {
    let text = number(value, decimals);
    if value.is_finite() && !text.starts_with('−') { format!("+{text}") } else { text }
}

/// A share as a probability: never quite certain.
pub fn probability(share: f64) -> String {
    match 100.0 * share {
        percent if percent > 99.0 => "> 99 %".into(),
        percent if percent < 1.0 => "< 1 %".into(),
        percent => format!("{} %", number(percent, 0)),
    }
}

/// To three significant digits.
pub fn three(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let size = value.abs().log10().floor();
    if value.is_finite() && !(-4.0..6.0).contains(&size) {
        let scaled = number(value / 10f64.powf(size), 2);
        return format!("{scaled}·10{}", raised(size as i32));
    }
    number(value, (2.0 - size).clamp(0.0, 7.0) as usize)
}

/// Value and standard deviation, two digits of it if the first is small (so that rounding changes it by
/// no more than a tenth or so), else one; three digits of the value where it has none.
pub fn plus_minus(estimate: Estimate) -> String {
    let Estimate { value, std } = estimate;
    if !(value.is_finite() && std.is_finite() && std > 0.0) {
        return three(value);
    }
    let size = value.abs().max(std).log10().floor();
    let first = std.log10().floor();
    let last = if std / 10f64.powf(first) < 3.55 { first - 1.0 } else { first };
    if !(-3.0..6.0).contains(&size) {
        let by = 10f64.powf(size);
        let decimals = (size - last).clamp(0.0, 6.0) as usize;
        let (value, std) = (number(value / by, decimals), number(std / by, decimals));
        return format!("({value} ± {std})·10{}", raised(size as i32));
    }
    let decimals = (-last).clamp(0.0, 6.0) as usize;
    format!("{} ± {}", number(value, decimals), number(std, decimals))
}

fn raised(power: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digit = |letter: char| letter.to_digit(10).and_then(|it| DIGITS.get(it as usize)).copied();
    power.to_string().chars().map(|letter| digit(letter).unwrap_or('⁻')).collect()
}

/// Number and unit, ratios without.
pub fn with_unit(number: &str, unit: &str) -> String {
    match unit {
        "" => number.to_owned(),
        "°" => format!("{number}°"),
        unit => format!("{number} {unit}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(value: f64, std: f64) -> String {
        plus_minus(Estimate { value, std })
    }

    #[test]
    fn numbers_have_the_digits_that_mean_something() {
        assert_eq!(said(0.553_21, 0.0213), "0.553 ± 0.021");
        assert_eq!(said(1684.3, 23.4), "1684 ± 23");
        assert_eq!(said(1.23e-5, 8.1e-7), "(1.23 ± 0.08)·10⁻⁵");
        assert_eq!(said(-0.0004, 0.012), "0.000 ± 0.012");
        assert_eq!(said(f64::NAN, 0.1), "–");
        assert_eq!((number(-8.2e23, 1), number(-880.64, 1)), ("−8e23".into(), "−880.6".into()));
        assert_eq!(said(35.2, f64::NAN), "35.2");
        assert_eq!(three(2.5e-7), "2.50·10⁻⁷");
        assert_eq!(signed(-3.25, 1), "−3.2");
        assert_eq!(signed(0.0, 1), "+0.0");
        assert_eq!(signed(f64::INFINITY, 1), "–");
        assert_eq!(probability(0.9999), "> 99 %");
        assert_eq!(probability(f64::NAN), "– %");
    }
}
