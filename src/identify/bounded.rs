//! A step of a search within bounds.

use nalgebra::{DMatrix, DVector};

/// The step that solves the normal equations `information · step = pull`, no number going farther than its limits, down and
/// up: one that would stops there, and the others make the best of that. `None` where the equations have no solution.
pub fn bounded_step(
    information: &DMatrix<f64>,
    pull: &DVector<f64>,
    limits: &[(f64, f64)],
) -> Option<DVector<f64>> {
    let mut step = DVector::zeros(limits.len());
    let mut free: Vec<usize> = (0..limits.len()).collect();
    while !free.is_empty() {
        for place in &free {
            step[*place] = 0.0;
        }
        let left = (pull - information * &step).select_rows(&free);
        let own = information.select_rows(&free).select_columns(&free);
        let solved = own.cholesky()?.solve(&left);
        for (place, by) in free.iter().zip(&solved) {
            step[*place] = *by;
        }
        let beyond = |place: usize| (limits[place].0 - step[place]).max(step[place] - limits[place].1);
        let farthest = (0..free.len()).max_by(|a, b| beyond(free[*a]).total_cmp(&beyond(free[*b])))?;
        if beyond(free[farthest]) <= 0.0 {
            break;
        }
        let held = free.remove(farthest);
        step[held] = step[held].max(limits[held].0).min(limits[held].1);
    }
    Some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// GIVEN two numbers that take each other's place, one of which can hardly move WHEN a step is taken THEN the other one goes
    /// where it is best beside that, and not where it was best beside the step that could not be.
    #[test]
    fn what_a_number_cannot_do_the_other_does_without_it() {
        let information = DMatrix::from_row_slice(2, 2, &[2.0, 1.5, 1.5, 2.0]);
        let pull = DVector::from_vec(vec![2.0, 1.0]);
        let step = bounded_step(&information, &pull, &[(-0.1, 0.1), (-9.0, 9.0)]).unwrap();
        assert_eq!(step[0], 0.1);
        assert!((step[1] - (1.0 - 1.5 * 0.1) / 2.0).abs() < 1e-12, "{step}");
        // Without bounds both would have gone elsewhere.
        let step = bounded_step(&information, &pull, &[(-9.0, 9.0); 2]).unwrap();
        let best = information.clone().cholesky().unwrap().solve(&pull);
        assert!((step - best).amax() < 1e-12);
        // Nowhere to go.
        assert_eq!(bounded_step(&information, &pull, &[(0.0, 0.0); 2]).unwrap(), DVector::zeros(2));
        assert!(bounded_step(&-information, &pull, &[(-9.0, 9.0); 2]).is_none());
    }
}
