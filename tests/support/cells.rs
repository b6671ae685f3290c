//! Tables that are kept in the project, cell by cell against those that are found: what differs, for people to read.

use std::fmt::Write as _;

/// `GRIPD_RENEW=1` writes what is found instead of comparing it.
pub fn renew() -> bool {
    std::env::var_os("GRIPD_RENEW").is_some_and(|value| value == "1")
}

/// The first rows that differ by more than a tolerance, relative to the larger number; none if none does. The last printed
/// digit may always be one off: numbers on the edge of rounding fall to either side.
pub fn differences(
    header: &[String],
    kept: &[Vec<String>],
    found: &[Vec<String>],
    tolerance: f64,
) -> Option<String> {
    const MOST: usize = 5;
    let mut text = String::new();
    let mut rows = 0;
    for (number, (kept, found)) in kept.iter().zip(found).enumerate() {
        let same_length = kept.len() == found.len();
        let differ: Vec<usize> =
            (0..kept.len().min(found.len())).filter(|i| !is_near(&kept[*i], &found[*i], tolerance)).collect();
        if differ.is_empty() && same_length {
            continue;
        }
        rows += 1;
        if rows > MOST {
            continue;
        }
        let _ = writeln!(text, "row {} ({}):", number + 1, found.first().map_or("", String::as_str));
        if !same_length {
            let _ = writeln!(text, "    {} cells kept, {} found", kept.len(), found.len());
        }
        for i in differ {
            let column = header.get(i).map_or("", String::as_str);
            let _ = writeln!(text, "    {column}: kept {:?}, found {:?}", kept[i], found[i]);
        }
    }
    if rows > MOST {
        let _ = writeln!(text, "and {} rows more", rows - MOST);
    }
    if kept.len() != found.len() {
        let _ = writeln!(text, "{} rows kept, {} found", kept.len(), found.len());
    }
    (!text.is_empty()).then_some(text)
}

/// Are the words the same, and the numbers among them near each other?
fn is_near(kept: &str, found: &str, tolerance: f64) -> bool {
    let ((words, numbers), (other_words, others)) = (taken_apart(kept), taken_apart(found));
    words == other_words
        && numbers.iter().zip(&others).all(|((a, unit), (b, other_unit))| {
            (a - b).abs() <= (tolerance * a.abs().max(b.abs())).max(1.01 * unit.max(*other_unit))
        })
}

/// A cell without its numbers, and these, each with the worth of its last digit. A digit in a word (Sim1) belongs to it.
fn taken_apart(cell: &str) -> (String, Vec<(f64, f64)>) {
    let (mut words, mut numbers) = (String::new(), Vec::new());
    let mut rest = cell;
    while let Some(first) = rest.chars().next() {
        let in_a_word = words.chars().next_back().is_some_and(char::is_alphanumeric);
        let unsigned = rest.strip_prefix(['-', '−', '+']).unwrap_or(rest);
        let digits = unsigned.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(unsigned.len());
        let number = unsigned[..digits].trim_end_matches('.');
        match number.parse::<f64>() {
            Ok(value) if !in_a_word && number.starts_with(|c: char| c.is_ascii_digit()) => {
                let decimals = number.split_once('.').map_or(0, |(_, decimals)| decimals.len());
                let sign = if rest.starts_with(['-', '−']) { -1.0 } else { 1.0 };
                numbers.push((sign * value, 0.1_f64.powi(decimals as i32)));
                words.push('#');
                rest = &unsigned[number.len()..];
            }
            _ => {
                words.push(first);
                rest = &rest[first.len_utf8()..];
            }
        }
    }
    (words, numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(cells: &[&str]) -> Vec<Vec<String>> {
        cells.iter().map(|cell| vec![(*cell).to_owned()]).collect()
    }

    #[test]
    fn numbers_are_near_words_are_equal() {
        assert!(is_near("found in 97 % after 1.23 s", "found in 96 % after 1.24 s", 0.0));
        assert!(!is_near("found in 97 %", "found in 95 %", 0.01));
        assert!(is_near("found in 97 %", "found in 95 %", 0.05));
        assert!(!is_near("97 %", "97 s", 1.0));
        assert!(!is_near("Sim1", "Sim2", 1.0));
        assert!(!is_near("-1.5", "1.5", 0.1) && !is_near("−3", "3", 0.1));
        assert!(is_near("", "", 0.0) && !is_near("", "0", 1.0));
    }

    #[test]
    fn what_differs_is_told_by_row_and_column() {
        let header = ["mu".to_owned()];
        assert_eq!(differences(&header, &rows(&["1.0", "0.5"]), &rows(&["1.0", "0.5"]), 0.0), None);
        let told = differences(&header, &rows(&["1.0", "0.5"]), &rows(&["1.0", "0.9"]), 0.01).unwrap();
        assert_eq!(told, "row 2 (0.9):\n    mu: kept \"0.5\", found \"0.9\"\n");
        let told = differences(&header, &rows(&["1.0"]), &rows(&["1.0", "0.9"]), 0.01).unwrap();
        assert_eq!(told, "1 rows kept, 2 found\n");
    }
}
