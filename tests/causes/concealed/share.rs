//! Shares with their uncertainty.

use serde_json::{Value, json};

/// So many of so many.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Share {
    pub hits: usize,
    pub of: usize,
}

impl Share {
    /// How many of a list have something.
    pub fn of<T>(list: impl IntoIterator<Item = T>, has: impl Fn(T) -> bool) -> Self {
        list.into_iter()
            .fold(Share::default(), |s, x| Share { hits: s.hits + usize::from(has(x)), of: s.of + 1 })
    }

    pub fn value(&self) -> f64 {
        self.hits as f64 / self.of as f64
    }

    /// Wilson's 95 % score interval (Wilson 1927): [0, 1] for none of none.
    pub fn interval(&self) -> (f64, f64) {
        if self.of == 0 {
            return (0.0, 1.0);
        }
        const Z: f64 = 1.959_963_984_540_054;
        let (n, p) = (self.of as f64, self.value());
        let middle = (p + Z * Z / (2.0 * n)) / (1.0 + Z * Z / n);
        let half = Z / (1.0 + Z * Z / n) * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
        ((middle - half).max(0.0), (middle + half).min(1.0))
    }

    pub fn to_json(self) -> Value {
        let (low, high) = self.interval();
        json!({ "hits": self.hits, "of": self.of, "wilson95": [low, high] })
    }
}

impl std::fmt::Display for Share {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.of == 0 {
            return f.write_str("–");
        }
        write!(f, "{}/{}", self.hits, self.of)
    }
}

#[test]
fn wilsons_interval_is_the_textbooks() {
    let close = |share: Share, low: f64, high: f64| {
        let (l, h) = share.interval();
        assert!((l - low).abs() < 5e-4 && (h - high).abs() < 5e-4, "{share:?}: {l} {h}");
    };
    // Newcombe 1998, table I: the score method without continuity correction.
    close(Share { hits: 81, of: 263 }, 0.2553, 0.3662);
    close(Share { hits: 15, of: 148 }, 0.0624, 0.1605);
    close(Share { hits: 0, of: 20 }, 0.0, 0.1611);
    close(Share { hits: 1, of: 29 }, 0.0061, 0.1718);
    assert_eq!(Share::default().interval(), (0.0, 1.0));
    assert_eq!(Share::of([1, 2, 3, 4], |x| x > 1), Share { hits: 3, of: 4 });
}
