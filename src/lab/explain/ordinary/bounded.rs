//! A damped step of a search within bounds.

use nalgebra::{DMatrix, DVector};

use super::numbers::Free;

/// Where Levenberg's and Marquardt's step leads; what would leave its bounds stays there for this step, and the others make the best
/// of that. None where the equations have no solution.
pub fn bounded_step(
    information: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: f64,
    free: &[Free],
    at: &[f64],
) -> Option<Vec<f64>> {
    let (mut information, mut wanted) = (information.clone(), gradient.clone());
    for i in 0..free.len() {
        information[(i, i)] *= 1.0 + damping;
    }
    let mut is_held = vec![false; free.len()];
    loop {
        let step = information.clone().cholesky()?.solve(&wanted);
        let within = |i: usize| (at[i] + step[i]).clamp(free[i].bounds.0, free[i].bounds.1);
        let outside: Vec<usize> =
            (0..free.len()).filter(|i| !is_held[*i] && within(*i) != at[*i] + step[*i]).collect();
        if outside.is_empty() {
            return Some((0..free.len()).map(within).collect());
        }
        for i in outside {
            is_held[i] = true;
            let by = within(i) - at[i];
            wanted.axpy(-by, &information.column(i).clone_owned(), 1.0);
            information.row_mut(i).fill(0.0);
            information.column_mut(i).fill(0.0);
            (information[(i, i)], wanted[i]) = (1.0, by);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::numbers::{Number, Scope};
    use super::*;

    /// GIVEN two numbers that take each other's place, one of which can hardly move WHEN a step is taken THEN the other one goes
    /// where it is best beside that, and not where it was best beside the step that could not be.
    #[test]
    fn what_a_number_cannot_do_the_other_does_without_it() {
        let free = [(-0.1, 0.1), (-9.0, 9.0)].map(|bounds| Free {
            number: Number::SpeedScale,
            of: Scope::Car,
            prior: (0.0, 1.0),
            bounds,
            step: 0.01,
        });
        let information = DMatrix::from_row_slice(2, 2, &[2.0, 1.5, 1.5, 2.0]);
        let gradient = DVector::from_vec(vec![2.0, 1.0]);
        let next = bounded_step(&information, &gradient, 0.0, &free, &[0.0, 0.0]).unwrap();
        assert_eq!(next[0], 0.1);
        assert!((next[1] - (1.0 - 1.5 * 0.1) / 2.0).abs() < 1e-12, "{next:?}");
        // Without bounds both would have gone elsewhere.
        let wide = free.map(|free| Free { bounds: (-9.0, 9.0), ..free });
        let next = bounded_step(&information, &gradient, 0.0, &wide, &[0.0, 0.0]).unwrap();
        let best = information.cholesky().unwrap().solve(&gradient);
        assert!((next[0] - best[0]).abs() + (next[1] - best[1]).abs() < 1e-12, "{next:?} {best}");
    }
}
