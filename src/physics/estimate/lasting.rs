//! For how long something has been doubted: a doubt that is there ends later than it would begin.

/// A doubt, if there is one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lasting {
    since_s: Option<f64>,
}

impl Lasting {
    /// What a limit is multiplied by: a doubt ends at this share of what it begins at.
    pub fn limit(&self, ends: f64) -> f64 {
        if self.since_s.is_some() { ends } else { 1.0 }
    }

    /// Takes whether it is doubted now.
    pub fn step(&mut self, is_doubted: bool, elapsed_s: f64) {
        self.since_s = is_doubted.then(|| self.since_s.map_or(0.0, |since| since + elapsed_s));
    }

    /// For how long it has been doubted, s.
    pub fn lasts_s(&self) -> Option<f64> {
        self.since_s
    }

    /// Is it doubted?
    pub fn is_there(&self) -> bool {
        self.since_s.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_doubt_lasts_from_the_moment_at_which_it_begins() {
        let mut doubt = Lasting::default();
        assert_eq!((doubt.lasts_s(), doubt.limit(0.6)), (None, 1.0));
        doubt.step(true, 0.5);
        assert_eq!((doubt.lasts_s(), doubt.limit(0.6)), (Some(0.0), 0.6));
        doubt.step(true, 0.5);
        assert_eq!(doubt.lasts_s(), Some(0.5));
        doubt.step(false, 0.5);
        assert!(!doubt.is_there());
    }
}
