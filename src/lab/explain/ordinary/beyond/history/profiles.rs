//! What each drive says of a number, all numbers of the car and of the measurement refitted.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::super::Search;
use super::super::climb::State;
use super::super::colour::Colour;
use super::super::references::SPREAD;
use super::super::rows::{Rows, normal, weights};
use super::super::trial::Trial;
use super::over_drives::Profile;
use crate::explain::model::Model;
use crate::explain::ordinary::numbers::{Free, Scope};

/// A car of all drives, ready to be asked for numbers.
pub struct Linear<'s, 'a> {
    search: &'s Search<'s>,
    state: &'s State<'a>,
    colour: Colour,
    rows: Rows,
    white: DVector<f64>,
    weights: DVector<f64>,
    /// How the predictions change with each of the car's numbers, weighed.
    weighed: Vec<DVector<f64>>,
    /// What the drives say of these, without what was thought of them before.
    information: DMatrix<f64>,
    gradient: DVector<f64>,
}

/// A number that each drive has of its own.
pub struct Spread {
    /// The number …
    pub main: Free,
    /// … and where that is in each drive, from where it makes no difference.
    at: DVector<f64>,
    /// The share of what it is thought to be that could be on these drives.
    could_be: f64,
    /// Of the car's numbers one that is in its place everywhere.
    instead_of: Option<usize>,
    /// What a change of it does beside what each of the car's does: numbers × drives.
    with: DMatrix<f64>,
    /// What each drive says of it alone.
    information: DVector<f64>,
    gradient: DVector<f64>,
}

impl<'s, 'a> Linear<'s, 'a> {
    /// Of a fitted car.
    pub fn new(search: &'s Search<'s>, state: &'s State<'a>) -> Self {
        let colour = search.short_colour(&state.errors);
        let rows = search.rows(&colour, &state.errors);
        let white = search.white(&colour, &rows, &state.errors);
        let own: Vec<DVector<f64>> =
            state.slopes.par_iter().map(|slopes| search.white(&colour, &rows, slopes)).collect();
        let weights = weights(&white, &rows);
        let weighed = own.iter().map(|own| own.component_mul(&weights)).collect();
        let (mut information, mut gradient) =
            normal(&own.iter().collect::<Vec<_>>(), &white, &rows, &state.free, &state.at);
        for (i, free) in state.free.iter().enumerate() {
            information[(i, i)] -= free.prior.1.powi(-2);
            gradient[i] -= free.prior.1.powi(-2) * (free.prior.0 - state.at[i]);
        }
        Self { search, state, colour, rows, white, weights, weighed, information, gradient }
    }

    /// A candidate where it makes no difference, in each of the ways in which it can be tried.
    pub fn candidate(&self, trial: &Trial) -> Vec<Spread> {
        let (model, free, _) = self.state.beside(trial);
        let own = &free[self.state.free.len()..];
        let Some(main) = own.iter().find(|free| trial.is_main(free)) else { return Vec::new() };
        let steps = trial.ways().iter().map(|share| share.map_or(main.step, |share| share * main.prior.1));
        let (low, high) = main.bounds;
        let can_be = steps.filter(|step| (low..=high).contains(&(main.prior.0 + step)));
        let nowhere = DVector::zeros(self.search.drives.len());
        can_be.map(|step| self.spread(&model, Free { step, ..*main }, nowhere.clone(), None)).collect()
    }

    /// A number of the car that stands at a place of what is free, as each drive has it.
    pub fn changed(&self, place: usize) -> Spread {
        let main = self.state.free[place];
        let by = self.state.at[place] - main.prior.0;
        let of = |drive: usize| if main.of.has(drive) { main.of.share(drive) * by } else { 0.0 };
        let at = DVector::from_fn(self.search.drives.len(), |drive, _| of(drive));
        self.spread(&self.state.model, main, at, Some(place))
    }

    fn spread(&self, model: &Model<'_>, main: Free, at: DVector<f64>, instead_of: Option<usize>) -> Spread {
        let drives = self.search.drives.len();
        let (mut free, mut there) = (self.state.free.clone(), self.state.at.clone());
        if let Some(place) = instead_of {
            free.remove(place);
            there.remove(place);
        }
        let first = free.len();
        for drive in 0..drives {
            free.push(Free { of: Scope::Recording(drive), ..main });
            there.push(main.prior.0 + at[drive]);
        }
        let mut spread = Spread {
            main,
            at,
            could_be: 1.0,
            instead_of,
            with: DMatrix::zeros(self.weighed.len(), drives),
            information: DVector::zeros(drives),
            gradient: DVector::zeros(drives),
        };
        for drive in 0..drives {
            let slope = self.search.slope(
                model,
                &free,
                (&there, &self.state.errors),
                (first + drive, main.step),
                None,
            );
            spread.could_be = spread.could_be.min(self.search.could_be(&slope, main.prior.1));
            let column = self.search.white(&self.colour, &self.rows, &slope);
            for (number, own) in self.weighed.iter().enumerate() {
                spread.with[(number, drive)] = own.dot(&column);
            }
            let weighed = column.component_mul(&self.weights);
            spread.information[drive] = weighed.dot(&column);
            spread.gradient[drive] = weighed.dot(&self.white);
        }
        spread
    }

    /// What the drives say of it, where this is thought of the car's numbers. None where the car itself is not told.
    pub fn profile(&self, spread: &Spread, thought: &[Free]) -> Option<Profile> {
        let kept: Vec<usize> = (0..thought.len()).filter(|place| Some(*place) != spread.instead_of).collect();
        let mut information =
            DMatrix::from_fn(kept.len(), kept.len(), |i, j| self.information[(kept[i], kept[j])]);
        let mut gradient = DVector::from_fn(kept.len(), |i, _| self.gradient[kept[i]]);
        for (i, place) in kept.iter().enumerate() {
            let precision = thought[*place].prior.1.powi(-2);
            information[(i, i)] += precision;
            gradient[i] += precision * (thought[*place].prior.0 - self.state.at[*place]);
        }
        let with = spread.with.select_rows(&kept);
        let factor = information.cholesky()?;
        let taken = factor.solve(&with);
        let own = DMatrix::from_diagonal(&spread.information) - taken.transpose() * with;
        let own = 0.5 * (&own + own.transpose());
        let towards = &spread.gradient - taken.transpose() * gradient + &own * &spread.at;
        let usual = spread.main.prior.1;
        Some(Profile {
            information: own,
            gradient: towards,
            scatter: SPREAD * spread.could_be * usual,
            usual,
        })
    }
}
