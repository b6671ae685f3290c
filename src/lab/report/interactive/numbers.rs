//! Numbers as the page carries them: with as many digits as a screen can show.

use serde::ser::{Serialize, SerializeSeq, Serializer};

/// Numbers of one kind, rounded alike. Not-a-number is a gap.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Numbers {
    values: Vec<f64>,
    decimals: i32,
}

impl Numbers {
    /// A step of the rounding is at most this share of the range: a third of a pixel on a large screen.
    const STEP: f64 = 1.0 / 4000.0;
    /// No number of a car needs more.
    const MOST_DECIMALS: i32 = 9;

    /// Rounded as their range asks for.
    pub fn new(values: Vec<f64>) -> Self {
        let finite = || values.iter().copied().filter(|value| value.is_finite());
        let range = finite().fold(f64::NEG_INFINITY, f64::max) - finite().fold(f64::INFINITY, f64::min);
        // What does not move is told to four digits.
        let range = if range > 0.0 { range } else { finite().next().map_or(1.0, f64::abs) };
        let decimals = if range > 0.0 { -(range * Self::STEP).log10().floor() } else { 0.0 };
        Self::rounded(values, decimals as i32)
    }

    /// Rounded to so many decimals.
    pub fn rounded(values: Vec<f64>, decimals: i32) -> Self {
        Self { values, decimals: decimals.clamp(0, Self::MOST_DECIMALS) }
    }

    /// How many there are, gaps included.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// There is no number, but gaps perhaps.
    pub fn is_empty(&self) -> bool {
        !self.values.iter().any(|value| value.is_finite())
    }

    /// As they were given.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
}

impl Serialize for Numbers {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let scale = 10_f64.powi(self.decimals);
        let mut list = serializer.serialize_seq(Some(self.values.len()))?;
        for value in &self.values {
            let rounded = (value * scale).round() / scale;
            match rounded {
                _ if !rounded.is_finite() => list.serialize_element(&None::<f64>)?,
                // Without a point: two characters less of each.
                _ if rounded.fract() == 0.0 && rounded.abs() < 1e15 => {
                    list.serialize_element(&(rounded as i64))?;
                }
                _ => list.serialize_element(&rounded)?,
            }
        }
        list.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_those_of_the_range() {
        let text = |values: &[f64]| serde_json::to_string(&Numbers::new(values.to_vec())).unwrap();
        assert_eq!(text(&[-40.123_456, 0.0, f64::NAN, 39.999_99]), "[-40.12,0,null,40]");
        assert_eq!(text(&[0.001_234_5, 0.001_334_5]), "[0.0012345,0.0013345]");
        assert_eq!(text(&[-0.000_01, 100.0]), "[0,100]");
        assert_eq!(text(&[1234.567, 1234.567]), "[1234.6,1234.6]");
        assert_eq!(text(&[f64::NAN, f64::INFINITY]), "[null,null]");
        assert_eq!(text(&[]), "[]");
        assert!(Numbers::new(vec![f64::NAN]).is_empty());
    }
}
