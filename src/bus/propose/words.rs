//! Names, taken apart into words, whatever the house that chose them writes between the words.

/// The words of a name: `ESP_wheelSpeedFrL` has `esp`, `wheel`, `speed`, `fr`, `l`.
#[derive(Clone, Debug, Default)]
pub(super) struct Words(Vec<String>);

impl Words {
    /// Of a name or of a sentence.
    pub(super) fn of(text: &str) -> Self {
        let letters: Vec<char> = text.chars().flat_map(plain).collect();
        let mut words: Vec<String> = Vec::new();
        let mut word = String::new();
        for (place, &letter) in letters.iter().enumerate() {
            let before = place.checked_sub(1).and_then(|p| letters.get(p)).copied().unwrap_or(' ');
            let after = letters.get(place + 1).copied().unwrap_or(' ');
            // fooBar, FOOBar, foo1: a new word begins.
            let begins = (before.is_lowercase() && letter.is_uppercase())
                || (before.is_uppercase() && letter.is_uppercase() && after.is_lowercase())
                || before.is_ascii_digit() != letter.is_ascii_digit();
            if (begins || !letter.is_alphanumeric()) && !word.is_empty() {
                words.push(std::mem::take(&mut word));
            }
            if letter.is_alphanumeric() {
                word.extend(letter.to_lowercase());
            }
        }
        if !word.is_empty() {
            words.push(word);
        }
        // QBit is one word to its author.
        let joined: Vec<String> = words
            .windows(2)
            .filter_map(|pair| match pair {
                [one, next] if one.len() == 1 && (3..=4).contains(&next.len()) => {
                    Some(format!("{one}{next}"))
                }
                _ => None,
            })
            .collect();
        words.extend(joined.into_iter().filter(|word| word == "qbit"));
        Self(words)
    }

    /// Is one of the wanted among them? `gier~`: anything that has it in it, `yaw*`: anything that begins so,
    /// else the word itself.
    pub(super) fn any(&self, wanted: &[&str]) -> bool {
        self.0.iter().any(|word| wanted.iter().any(|wanted| fits(word, wanted)))
    }

    /// Words that are letters.
    pub(super) fn iter(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(String::as_str).filter(|word| !word.starts_with(|c: char| c.is_ascii_digit()))
    }

    /// How many of them none of the wanted is.
    pub(super) fn others(&self, wanted: &[&[&str]]) -> usize {
        self.iter().filter(|word| !wanted.iter().any(|list| list.iter().any(|w| fits(word, w)))).count()
    }
}

fn fits(word: &str, wanted: &str) -> bool {
    match (wanted.strip_suffix('~'), wanted.strip_suffix('*')) {
        (Some(part), _) => word.contains(part),
        (None, Some(start)) => word.starts_with(start),
        (None, None) => word == wanted,
    }
}

/// Letters without their accents.
fn plain(letter: char) -> impl Iterator<Item = char> {
    let text: &[char] = match letter {
        'ä' => &['a', 'e'],
        'ö' => &['o', 'e'],
        'ü' => &['u', 'e'],
        'Ä' => &['A', 'e'],
        'Ö' => &['O', 'e'],
        'Ü' => &['U', 'e'],
        'ß' => &['s', 's'],
        'é' | 'è' | 'ê' => &['e'],
        'á' | 'à' | 'å' => &['a'],
        'ñ' => &['n'],
        'ó' => &['o'],
        'í' => &['i'],
        _ => &[],
    };
    let own = text.is_empty().then_some(letter);
    text.iter().copied().chain(own)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<String> {
        Words::of(text).0
    }

    #[test]
    fn names_of_all_houses_fall_into_words() {
        assert_eq!(words("ESP_wheelSpeedFrL"), ["esp", "wheel", "speed", "fr", "l"]);
        assert_eq!(words("VehLat2_A_Actl"), ["veh", "lat", "2", "a", "actl"]);
        assert_eq!(words("LW1_LRW_Sign"), ["lw", "1", "lrw", "sign"]);
        assert_eq!(words("WHL_SpdFLVal"), ["whl", "spd", "fl", "val"]);
        assert_eq!(words("Längsbeschl."), ["laengsbeschl"]);
    }

    #[test]
    fn beginnings_and_parts() {
        let words = Words::of("ESP_Querbeschleunigung");
        assert!(words.any(&["quer*"]) && words.any(&["beschl~"]) && !words.any(&["quer", "beschl*"]));
        assert_eq!(words.others(&[&["quer*"]]), 1);
    }
}
