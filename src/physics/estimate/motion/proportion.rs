//! Is one signal the other times a factor?

/// Mean squares of both signals, and their mean product.
#[derive(Clone, Copy, Debug, Default)]
pub struct Proportion {
    squares: [f64; 2],
    product: f64,
}

impl Proportion {
    /// Takes both, with this share of the mean.
    pub fn step(&mut self, [one, other]: [f64; 2], share: f64) {
        self.product += share * (one * other - self.product);
        for (square, signal) in self.squares.iter_mut().zip([one, other]) {
            *square += share * (signal * signal - *square);
        }
    }

    /// The first signal over the second.
    pub fn factor(&self) -> f64 {
        self.product / self.squares[1]
    }

    /// Standard deviation of the factor, if so many errors are independent.
    pub fn std(&self, worth: f64) -> f64 {
        (self.rest() / self.squares[1] / worth).sqrt()
    }

    /// Mean square of the first signal that the second one does not explain.
    pub fn rest(&self) -> f64 {
        (self.squares[0] - self.factor() * self.product).max(0.0)
    }

    /// Mean square of the second signal.
    pub fn square(&self) -> f64 {
        self.squares[1]
    }

    /// Mean product.
    pub fn product(&self) -> f64 {
        self.product
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_is_found_and_what_it_leaves() {
        let mut proportion = Proportion::default();
        for i in 1..=4000 {
            let (signal, error) = ((0.1 * f64::from(i)).sin(), 0.1 * (0.37 * f64::from(i)).sin());
            proportion.step([0.8 * signal + error, signal], 1.0 / f64::from(i));
        }
        assert!((proportion.factor() - 0.8).abs() < 1e-2, "{proportion:?}");
        assert!((proportion.rest() - 0.005).abs() < 5e-4, "{proportion:?}");
        assert!((proportion.std(100.0) - 0.01).abs() < 1e-3, "{proportion:?}");
        assert!((proportion.square() - 0.5).abs() < 1e-2 && (proportion.product() - 0.4).abs() < 1e-2);
    }
}
