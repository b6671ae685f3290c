//! Formulas written in a line, with their indices and powers set as such.

use crate::report::escape;

/// `F_z^(1 − e)` with an index and a power. An index is what follows `x_`, where x is one letter: words
/// with an underline stay.
pub fn html(text: &str) -> String {
    let letters: Vec<char> = text.chars().collect();
    let mut html = String::new();
    let mut place = 0;
    while let Some(&letter) = letters.get(place) {
        let rest = letters.get(place + 1..).unwrap_or_default();
        let before = letters.get(..place).unwrap_or_default();
        let (inside, taken) = match letter {
            '_' if is_symbol(before) => index(rest),
            '^' => power(rest),
            _ => (String::new(), 0),
        };
        if inside.is_empty() {
            html += &escape(&letter.to_string());
            place += 1;
        } else {
            let tag = if letter == '_' { "sub" } else { "sup" };
            html += &format!("<{tag}>{}</{tag}>", escape(&inside));
            place += 1 + taken;
        }
    }
    html
}

/// Does it end with a single letter, with or without a mark above?
fn is_symbol(before: &[char]) -> bool {
    let mut letters = before.iter().rev().copied().filter(|letter| !is_mark(*letter));
    let last = letters.next();
    let is_alone = letters.next().is_none_or(|letter| !letter.is_alphanumeric() && letter != '_');
    last.is_some_and(char::is_alphabetic) && is_alone
}

/// A dot or bar above the letter before.
fn is_mark(letter: char) -> bool {
    ('\u{300}'..='\u{36f}').contains(&letter)
}

/// Letters and digits; parts are separated by commas without space.
fn index(rest: &[char]) -> (String, usize) {
    let mut taken = 0;
    while let Some(&letter) = rest.get(taken) {
        let goes_on = letter == ',' && rest.get(taken + 1).is_some_and(|next| is_of_index(*next));
        if !is_of_index(letter) && !goes_on {
            break;
        }
        taken += 1;
    }
    (rest.iter().take(taken).collect(), taken)
}

/// A raised 2 is a digit, too, but a power.
fn is_of_index(letter: char) -> bool {
    letter.is_alphabetic() || letter.is_ascii_digit()
}

/// What is in brackets, or a number.
fn power(rest: &[char]) -> (String, usize) {
    if rest.first() == Some(&'(') {
        let end = rest.iter().position(|letter| *letter == ')').unwrap_or(0);
        return (rest.get(1..end).unwrap_or_default().iter().collect(), end + 1);
    }
    let is_part =
        |place: usize, letter: &char| is_of_index(*letter) || place == 0 && matches!(letter, '-' | '−');
    let taken = rest.iter().enumerate().take_while(|(place, letter)| is_part(*place, letter)).count();
    (rest.iter().take(taken).collect(), taken)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_and_powers_are_set_and_names_stay() {
        assert_eq!(html("C ∝ F_z^(1 − e)"), "C ∝ F<sub>z</sub><sup>1 − e</sup>");
        assert_eq!(html("a_y,read = a_y + g φ,  φ̈"), "a<sub>y,read</sub> = a<sub>y</sub> + g φ,  φ̈");
        assert_eq!(html("v̇_y < 3"), "v̇<sub>y</sub> &lt; 3");
        assert_eq!(html("|a_y| above"), "|a<sub>y</sub>| above");
        assert_eq!(html("δ_sw² x^-2"), "δ<sub>sw</sub>² x<sup>-2</sup>");
        assert_eq!(html("yaw_rate of wheel_speed_fl"), "yaw_rate of wheel_speed_fl");
        assert_eq!(html("_ ^ ^( a_"), "_ ^ ^( a_");
    }
}
