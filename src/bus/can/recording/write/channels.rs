//! Interfaces by number, for formats that have no names.

/// Numbers of interfaces in the order in which they came: `canN` keeps its N where nobody else has it.
#[derive(Default)]
pub struct Channels {
    names: Vec<(String, u8)>,
    last: usize,
}

/// The formats count them from 1, in a byte at the narrowest.
const MOST: u8 = 254;

impl Channels {
    /// From 0; `None` if there are no more.
    pub fn of(&mut self, interface: &str) -> Option<u8> {
        if let Some((name, number)) = self.names.get(self.last)
            && name == interface
        {
            return Some(*number);
        }
        if let Some(place) = self.names.iter().position(|(name, _)| name == interface) {
            self.last = place;
            return self.names.get(place).map(|(_, number)| *number);
        }
        let is_free = |number: &u8| self.names.iter().all(|(_, taken)| taken != number);
        let number = own_number(interface).filter(is_free).or_else(|| (0..=MOST).find(is_free))?;
        self.last = self.names.len();
        self.names.push((interface.to_owned(), number));
        Some(number)
    }

    /// Those that read back under another name.
    pub fn renamed(self) -> Vec<(String, String)> {
        let others = self.names.into_iter().filter(|(name, number)| own_number(name) != Some(*number));
        others.map(|(name, number)| (name, format!("can{number}"))).collect()
    }
}

/// The N of `canN`, written as it would be read back.
fn own_number(interface: &str) -> Option<u8> {
    let number: u8 = interface.strip_prefix("can")?.parse().ok()?;
    (number <= MOST && interface == format!("can{number}")).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_keep_their_number_where_they_can() {
        let mut channels = Channels::default();
        let numbers =
            ["can1", "vcan0", "can0", "can1", "can7", "can07", "can0"].map(|name| channels.of(name));
        assert_eq!(numbers, [1, 0, 2, 1, 7, 3, 2].map(Some));
        let renamed = channels.renamed();
        assert_eq!(renamed.len(), 3, "{renamed:?}");
        assert!(renamed.contains(&("can0".into(), "can2".into())));
    }

    #[test]
    fn numbers_come_to_an_end() {
        let mut channels = Channels::default();
        let found = (0..300).filter(|n| channels.of(&format!("bus{n}")).is_some()).count();
        assert_eq!(found, 255);
        assert_eq!(channels.of("bus3"), Some(3));
    }
}
