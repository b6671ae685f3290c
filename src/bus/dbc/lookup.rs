//! Names that are nearly right.

/// The candidates most like the name, best first, at most three; none if nothing is like it.
pub(super) fn nearest<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Vec<String> {
    // A third of the letters may be wrong, two in any case.
    let allowed = (name.len() / 3).max(2);
    let wanted = letters(name);
    let mut found: Vec<(usize, &str)> = candidates
        .filter(|candidate| candidate.len().abs_diff(name.len()) <= allowed)
        .map(|candidate| (distance(&wanted, &letters(candidate)), candidate))
        .filter(|(distance, _)| *distance <= allowed)
        .collect();
    found.sort();
    found.into_iter().take(3).map(|(_, name)| name.to_owned()).collect()
}

fn letters(text: &str) -> Vec<char> {
    text.chars().take(128).map(|c| c.to_ascii_lowercase()).collect()
}

/// Number of letters to insert, delete or replace (Levenshtein).
fn distance(a: &[char], b: &[char]) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(from != to);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_comes_first_and_strangers_not_at_all() {
        let names = ["ESP_Gierrate", "ESP_VZ_Gierrate", "LWI_Lenkradwinkel"];
        assert_eq!(nearest("esp_gierate", names.into_iter())[0], "ESP_Gierrate");
        assert_eq!(nearest("Temperature", names.into_iter()), Vec::<String>::new());
    }

    #[test]
    fn distances() {
        assert_eq!(distance(&letters("kitten"), &letters("sitting")), 3);
        assert_eq!(distance(&[], &letters("abc")), 3);
    }
}
