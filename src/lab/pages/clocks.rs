//! From when on seconds are counted, in words.

use std::collections::BTreeMap;

use super::file_name;

/// More recordings than that are not listed by their dates.
const MOST: usize = 8;

/// By recording when it begins, in UTC; nothing where stamps are no dates.
pub fn lines(begins_utc: &BTreeMap<String, String>) -> Vec<String> {
    match begins_utc.len() {
        0 => Vec::new(),
        count => {
            let shown =
                begins_utc.iter().take(MOST).map(|(name, utc)| format!("{} at {utc}", file_name(name)));
            let mut shown: Vec<String> = shown.collect();
            if count > MOST {
                shown.push(format!("and {} more", count - MOST));
            }
            vec![format!("seconds are counted from the start of {}", shown.join(", "))]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_recording_has_its_own_start() {
        let begins = |count: usize| (0..count).map(|k| (format!("a/{k}.log"), "2025".to_owned())).collect();
        assert!(lines(&begins(0)).is_empty());
        assert_eq!(lines(&begins(2)), ["seconds are counted from the start of 0.log at 2025, 1.log at 2025"]);
        assert!(lines(&begins(11))[0].ends_with("and 3 more"));
    }
}
