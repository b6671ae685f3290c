//! Which channel is wrong? Several relations share channels; one cause is more likely than two.

use nalgebra::{DMatrix, DVector};

/// What relations say, with how well they say it.
pub(super) struct Evidence {
    /// Each relation's deviation.
    pub(super) seen: Vec<f64>,
    /// Its covariance: noise, model errors, and priors that relations share.
    pub(super) covariance: DMatrix<f64>,
}

/// A possible cause: how much of it each relation shows.
pub(super) struct Cause<C> {
    pub(super) channel: C,
    pub(super) pattern: Vec<f64>,
}

/// A cause fitted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Attribution<C> {
    pub(super) channel: C,
    pub(super) value: f64,
    pub(super) std: f64,
    /// How much of the misfit it takes away (χ²).
    pub(super) gain: f64,
}

/// Misfit without any cause (χ²), and all causes, best first.
pub(super) fn attribute<C: Copy>(
    evidence: &Evidence,
    causes: &[Cause<C>],
) -> Option<(f64, Vec<Attribution<C>>)> {
    let seen = DVector::from_column_slice(&evidence.seen);
    let factor = evidence.covariance.clone().cholesky()?;
    let weighted = factor.solve(&seen);
    let misfit = seen.dot(&weighted);
    let mut attributions: Vec<Attribution<C>> = causes
        .iter()
        .filter_map(|cause| {
            let pattern = DVector::from_column_slice(&cause.pattern);
            let information = pattern.dot(&factor.solve(&pattern));
            (information > 0.0).then(|| {
                let value = pattern.dot(&weighted) / information;
                let gain = value * value * information;
                Attribution { channel: cause.channel, value, std: information.sqrt().recip(), gain }
            })
        })
        .collect();
    attributions.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    Some((misfit, attributions))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_channel_that_all_deviating_relations_share_is_the_cause() {
        // a − b, c − b, d − a; b is off by −0.05.
        let evidence = Evidence {
            seen: vec![0.05, 0.051, 0.001],
            covariance: DMatrix::from_diagonal(&DVector::from_element(3, 1e-4)),
        };
        let cause = |channel, pattern: [f64; 3]| Cause { channel, pattern: pattern.to_vec() };
        let causes = [
            cause('a', [1.0, 0.0, -1.0]),
            cause('b', [-1.0, -1.0, 0.0]),
            cause('c', [0.0, 1.0, 0.0]),
            cause('d', [0.0, 0.0, 1.0]),
        ];
        let (misfit, best) = attribute(&evidence, &causes).unwrap();
        assert_eq!(best[0].channel, 'b');
        assert!((best[0].value + 0.0505).abs() < 1e-9);
        assert!(misfit - best[0].gain < 1.0 && best[1].gain < 0.6 * misfit);
    }
}
