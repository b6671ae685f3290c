//! Is what is there all the time told by more than one moment?
//!
//! A gust, a pothole or a kerb can look like a constant of the car that shows in one manoeuvre only. Without that moment the rest of
//! the drive says otherwise.

use nalgebra::DVector;

use super::fit::{Data, Fit};
use super::model::Place;
use super::naming::Refitted;

/// The rest contradicts a number that is so many of its standard deviations away. Statistical: once in 370 times by chance.
const CONTRADICTS: f64 = 3.0;

/// The rest surely says the same of a number so many standard deviations from nothing. Statistical.
const SURELY: f64 = 2.0;

/// Does no single block say what all others deny? Of courses and of what begins at a moment nothing is asked.
pub fn shows_throughout(data: &Data<'_>, of: &Refitted<'_>) -> bool {
    if of.candidate.live.is_some() || of.onset().is_some() {
        return true;
    }
    let mut sizes = sizes(&of.fit).peekable();
    sizes.peek().is_none() || sizes.any(|size| size.is_told_throughout(data, &of.fit))
}

/// A main number of the last effect: its place among what is free, and how far it is from nothing.
struct Size {
    place: usize,
    value: f64,
}

fn sizes<'f>(fit: &'f Fit<'_>) -> impl Iterator<Item = Size> + use<'f> {
    let last = fit.model.effects.len().saturating_sub(1);
    fit.free.iter().enumerate().filter_map(move |(place, free)| {
        let Place::Effect(effect, number) = free.place else { return None };
        let spec = fit.model.effects[effect].kind.parameters.get(number)?;
        let value = fit.model.get(free.place) - free.mean;
        (effect == last && spec.is_main).then_some(Size { place, value })
    })
}

impl Size {
    /// By the normal equations of the fit without each block in turn.
    fn is_told_throughout(&self, data: &Data<'_>, fit: &Fit<'_>) -> bool {
        let count = fit.free.len();
        let (information, _) = data.normal(&fit.sums, &fit.model, &fit.free);
        data.counted(&fit.sums).all(|block| {
            let left = &information - block.gram.view((1, 1), (count, count));
            let Some(left) = left.cholesky() else { return true };
            let mut own = DVector::zeros(count);
            own[self.place] = 1.0;
            let own = left.solve(&own);
            // At the fit all slopes add up to nothing: without the block's they are minus that.
            let by = -own.dot(&block.gram.view((1, 0), (count, 1)).column(0));
            let (rest, std) = (self.value + by, own[self.place].max(0.0).sqrt());
            by.abs() < CONTRADICTS * std || rest * self.value.signum() > SURELY * std
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::bench::{fitted, recorded, training};
    use super::super::candidates;
    use super::super::fit::Learn;
    use super::super::naming::{refit, scan};
    use super::*;
    use physics::model::effect::named;
    use predict::GriddedDrive;

    /// Further stops in the drive.
    const STOPS: &str = "[[brake_pressure]]\nkind = \"points\"\npoints = [[0, 0], [5, 0], [5.4, 15], [6.5, 15], [7, 0], [13, 0], \
                         [13.4, 15], [14.5, 15], [15, 0], [26, 0], [26.4, 15], [27.5, 15], [28, 0], [40, 0], [40.4, 15], \
                         [41.5, 15], [42, 0]]\n";

    /// Unequal brakes, fitted to a drive with something in it: do they show throughout it?
    fn brakes(hidden: &str) -> bool {
        let (vehicle, recording) = recorded(&format!("{STOPS}{hidden}"));
        let drives = [GriddedDrive::new(&recording, &vehicle)];
        let data = training(&drives);
        let plain = fitted(&data, &vehicle);
        let library = candidates::library(&[named("brake_imbalance").unwrap()], &plain.model, |_| true, &[]);
        let scanned = scan(&data, &plain, &library);
        let front = scanned.iter().max_by(|a, b| a.gain.total_cmp(&b.gain)).unwrap();
        let refitted = refit(&data, &plain, (&plain, Learn::Noise), front, 4);
        shows_throughout(&data, &refitted)
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
