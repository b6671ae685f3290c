//! Is what is there all the time told by more than one moment?
//!
//! A gust, a pothole or a kerb can look like a constant of the car that shows in one manoeuvre only. Without that moment the rest of
//! the drive says otherwise.

use nalgebra::{DMatrix, DVector};

use super::fit::{Data, Fit};
use super::naming::Refitted;

/// The rest contradicts a number that is so many of its standard deviations away. Statistical: once in 370 times by chance.
const CONTRADICTS: f64 = 3.0;

/// The rest surely says the same of a number so many standard deviations from nothing. Statistical.
const SURELY: f64 = 2.0;

/// Does no single block say what all others deny? Of courses and of what begins at a moment nothing is asked.
pub fn shows_throughout(data: &Data<'_>, of: &Refitted<'_>) -> bool {
    let Refitted { candidate, fit, .. } = of;
    if candidate.live.is_some() || of.onset().is_some() {
        return true;
    }
    let Some(effect) = fit.model.effects.len().checked_sub(1) else { return true };
    let (information, _) = data.normal(&fit.sums, &fit.model, &fit.free);
    let fitted = fit.main_numbers(effect).filter_map(|(value, place)| Some((value, place?)));
    let mut told = fitted.map(|number| is_told_throughout(data, fit, &information, number)).peekable();
    told.peek().is_none() || told.any(|is_told| is_told)
}

/// Of a number, so far from nothing and at this place among what is free: by the normal equations without each block in turn.
fn is_told_throughout(
    data: &Data<'_>,
    fit: &Fit<'_>,
    information: &DMatrix<f64>,
    (value, place): (f64, usize),
) -> bool {
    let count = fit.free.len();
    data.counted(&fit.sums).all(|block| {
        let left = information - block.gram.view((1, 1), (count, count));
        let Some(left) = left.cholesky() else { return true };
        let mut own = DVector::zeros(count);
        own[place] = 1.0;
        let own = left.solve(&own);
        // At the fit all slopes add up to nothing: without the block's they are minus that.
        let by = -own.dot(&block.gram.view((1, 0), (count, 1)).column(0));
        let (rest, std) = (value + by, own[place].max(0.0).sqrt());
        by.abs() < CONTRADICTS * std || rest * value.signum() > SURELY * std
    })
}

#[cfg(test)]
mod tests {
    use super::super::bench::refitted;
    use super::*;
    use physics::model::effect::named;

    /// Further stops in the drive.
    const STOPS: &str = "[[brake_pressure]]\nkind = \"points\"\npoints = [[0, 0], [5, 0], [5.4, 15], [6.5, 15], [7, 0], [13, 0], \
                         [13.4, 15], [14.5, 15], [15, 0], [26, 0], [26.4, 15], [27.5, 15], [28, 0], [40, 0], [40.4, 15], \
                         [41.5, 15], [42, 0]]\n";

    /// Unequal brakes, fitted to a drive with something in it: do they show throughout it?
    fn brakes(hidden: &str) -> bool {
        let kind = named("brake_imbalance").unwrap();
        refitted(&format!("{STOPS}{hidden}"), kind, &[], |data, _, brakes| shows_throughout(data, &brakes))
    }

    /// GIVEN brakes that pull whenever they are on, and a single brake once, while braking THEN the first alone are unequal throughout.
    #[test]
    #[ignore = "long: two cars fitted"]
    fn one_moment_is_not_the_whole_drive() {
        assert!(brakes("[[effect]]\nkind = \"brake_imbalance\"\nleft_more_front = 0.2\n"));
        let once =
            "[[effect]]\nkind = \"brake_yaw_moment\"\nvalue = 700\nfront_share = 1.0\nvectoring = 0.0\n";
        assert!(!brakes(&format!("{once}intervals = [[21, 22]]\n")));
    }
}
