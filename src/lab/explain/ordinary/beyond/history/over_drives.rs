//! What a number is in each of several drives, and which course over the drives that is: none, a step, or growth.
//!
//! The likelihood of a number's values x in the drives is quadratic where a fit stands, −2 ln L = x'Λx − 2g'x, all other
//! numbers refitted. Beside that the same number differs from drive to drive by some scatter, because the equations are
//! simpler than the car; how much that is, is thought of before and learned from the drives. Every course is judged with
//! both, its own numbers and the scatter integrated out.

use nalgebra::{DMatrix, DVector};

use super::super::references::WORTH;
use crate::explain::result::Estimate;

/// How a number goes over the drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// It is another one from a drive on.
    Step,
    /// It grows by the same from drive to drive.
    Growth,
}

impl Shape {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Step, Self::Growth];
}

/// A shape from a drive on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Course {
    /// The first drive that has it.
    pub since: usize,
    /// How it goes on.
    pub shape: Shape,
}

impl Course {
    /// The course over so many drives; the last one has all of it.
    pub fn over(self, drives: usize) -> DVector<f64> {
        let of = |drive: usize| match self.shape {
            _ if drive < self.since => 0.0,
            Shape::Step => 1.0,
            Shape::Growth => (drive + 1 - self.since) as f64 / (drives - self.since) as f64,
        };
        DVector::from_fn(drives, |drive, _| of(drive))
    }
}

/// What the drives say of a number.
#[derive(Clone, Debug)]
pub struct Profile {
    /// Λ, drives × drives.
    pub information: DMatrix<f64>,
    /// g, at x = 0.
    pub gradient: DVector<f64>,
    /// What it is thought to differ by from drive to drive …
    pub scatter: f64,
    /// … and what a change of it could be.
    pub usual: f64,
}

/// Scatters between these multiples of what is thought are summed over, so many of them. Numerical.
const SCATTERS: (f64, f64, usize) = (0.125, 32.0, 33);

/// What begins at a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged {
    /// Its likelier shape.
    pub course: Course,
    /// Twice the logarithm of the odds for that against none …
    pub evidence: f64,
    /// … and for both shapes together.
    pub together: f64,
}

/// How well courses fit, and with which numbers.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// −2 ln of their likelihood, scatter and numbers integrated out; up to what all courses of the same drives share.
    pub cost: f64,
    /// The number before each course, in the order of the courses.
    pub numbers: Vec<Estimate>,
}

impl Profile {
    /// Linear in these courses, beside a level that all drives share.
    pub fn fitted(&self, courses: &[DVector<f64>]) -> Fitted {
        let count = self.gradient.len();
        let level = DVector::from_element(count, 1.0);
        let mut columns = vec![level];
        columns.extend_from_slice(courses);
        let columns = DMatrix::from_columns(&columns);
        let (low, high, steps) = SCATTERS;
        let ratio = (high / low).powf(1.0 / (steps - 1) as f64);
        let all: Vec<(f64, Vec<Estimate>)> = (0..steps)
            .filter_map(|step| self.fitted_with(&columns, self.scatter * low * ratio.powi(step as i32)))
            .collect();
        let least = all.iter().map(|(cost, _)| *cost).fold(f64::INFINITY, f64::min);
        let weights: Vec<f64> = all.iter().map(|(cost, _)| (0.5 * (least - cost)).exp()).collect();
        let sum: f64 = weights.iter().sum();
        // Of a mixture the mean, and its variance with that of the means.
        let of = |place: usize| {
            let mean = |what: &dyn Fn(&Estimate) -> f64| -> f64 {
                all.iter().zip(&weights).map(|((_, all), weight)| weight * what(&all[place])).sum::<f64>()
                    / sum
            };
            let value = mean(&|it| it.value);
            let square = mean(&|it| it.std * it.std + (it.value - value).powi(2));
            Estimate { value, std: square.sqrt() }
        };
        let numbers = if all.is_empty() { Vec::new() } else { (1..columns.ncols()).map(of).collect() };
        Fitted { cost: least - 2.0 * sum.ln() + 2.0 * (steps as f64).ln(), numbers }
    }

    /// The same with a scatter, its own cost counted in.
    fn fitted_with(&self, columns: &DMatrix<f64>, scatter: f64) -> Option<(f64, Vec<Estimate>)> {
        let count = self.gradient.len();
        let square = scatter * scatter;
        let blurred = DMatrix::identity(count, count) + square * &self.information;
        let factor = blurred.lu();
        let weights = factor.solve(&self.information)?;
        let towards = factor.solve(&self.gradient)?;
        let mut cost = factor.determinant().abs().ln() - square * self.gradient.dot(&towards);
        // Learned scatter: a scaled inverse χ² about what is thought.
        let share = (self.scatter / scatter).powi(2);
        cost += WORTH * (share - share.ln() - 1.0);
        let prior = self.usual.powi(-2);
        let mut information = columns.transpose() * weights * columns;
        for i in 0..columns.ncols() {
            information[(i, i)] += prior;
        }
        let slopes = columns.transpose() * towards;
        let factor = information.cholesky()?;
        let at = factor.solve(&slopes);
        cost -= slopes.dot(&at);
        cost += factor.determinant().ln() - columns.ncols() as f64 * prior.ln();
        let inverse = factor.inverse();
        let numbers =
            (0..columns.ncols()).map(|i| Estimate { value: at[i], std: inverse[(i, i)].max(0.0).sqrt() });
        cost.is_finite().then(|| (cost, numbers.collect()))
    }

    /// The likelier shape from a drive on.
    pub fn from(&self, since: usize) -> Judged {
        let none = self.fitted(&[]).cost;
        let last = self.gradient.len() - 1;
        let judged = |shape| {
            let course = Course { since, shape };
            (course, none - self.fitted(&[course.over(self.gradient.len())]).cost)
        };
        let step = judged(Shape::Step);
        // In the last drive alone nothing grows.
        let growth = (since < last).then(|| judged(Shape::Growth));
        let (course, evidence) = growth.filter(|growth| growth.1 > step.1).unwrap_or(step);
        let less = growth.map_or(f64::INFINITY, |growth| (growth.1 - step.1).abs());
        Judged { course, evidence, together: evidence + 2.0 * (-0.5 * less).exp().ln_1p() }
    }

    /// By how much it grows from drive to drive after a step at `since`; none where that is in the last drive.
    pub fn trend(&self, since: usize) -> Option<Estimate> {
        let count = self.gradient.len();
        if since + 1 >= count {
            return None;
        }
        let step = Course { since, shape: Shape::Step }.over(count);
        let per_drive = DVector::from_fn(count, |drive, _| drive.saturating_sub(since) as f64);
        self.fitted(&[step, per_drive]).numbers.last().copied()
    }

    /// Its value in each drive, relative to the mean of the first `healthy` ones. The deviations are such that the
    /// difference of any two drives has both (quasi-variances, Firth & de Menezes 2004).
    pub fn values(&self, healthy: usize) -> Vec<Estimate> {
        let count = self.gradient.len();
        // What all drives have in common is the car's, and here of no interest.
        let mut information = self.information.clone();
        for i in 0..count {
            information[(i, i)] += 1e-2 * self.usual.powi(-2);
        }
        let Some(factor) = information.cholesky() else { return Vec::new() };
        let at = factor.solve(&self.gradient);
        let covariance = factor.inverse();
        let level = at.iter().take(healthy.max(1)).sum::<f64>() / healthy.max(1) as f64;
        let apart = |i: usize, j: usize| covariance[(i, i)] + covariance[(j, j)] - 2.0 * covariance[(i, j)];
        let sums: Vec<f64> = (0..count).map(|i| (0..count).map(|j| apart(i, j)).sum()).collect();
        let total = sums.iter().sum::<f64>() / (2.0 * (count as f64 - 1.0)).max(1.0);
        let of = |i: usize| {
            let own = match count {
                0..=2 => 0.5 * total,
                _ => (sums[i] - total) / (count as f64 - 2.0),
            };
            // No drive knows more than if it knew everything else.
            let least = 1.0 / self.information[(i, i)].max(1e-300);
            Estimate { value: at[i] - level, std: own.max(least).sqrt() }
        };
        (0..count).map(of).collect()
    }

    /// The deviation that a step from this drive on would be known with.
    pub fn step_std(&self, since: usize) -> f64 {
        let step = Course { since, shape: Shape::Step }.over(self.gradient.len());
        self.fitted(&[step]).numbers.first().map_or(f64::INFINITY, |it| it.std)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All moments, the likeliest one first.
    fn judged(profile: &Profile) -> Vec<Judged> {
        let mut all: Vec<Judged> = (1..profile.gradient.len()).map(|since| profile.from(since)).collect();
        all.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        all
    }

    /// Drives that say each by itself what a number is, all as clearly.
    fn said(values: &[f64], std: f64) -> Profile {
        let count = values.len();
        let information = DMatrix::identity(count, count) * std.powi(-2);
        let gradient = &information * DVector::from_row_slice(values);
        Profile { information, gradient, scatter: 0.1, usual: 1.0 }
    }

    #[test]
    fn a_step_is_a_step_and_where_it_is() {
        let profile = said(&[0.03, -0.05, 0.02, 1.52, 1.45, 1.51], 0.05);
        let all = judged(&profile);
        assert_eq!(all[0].course, Course { since: 3, shape: Shape::Step });
        assert!(all[0].evidence > 20.0 && all[0].together >= all[0].evidence, "{all:?}");
        assert!(all[1].together < all[0].together - 6.0, "{all:?}");
        let trend = profile.trend(3).unwrap();
        assert!(trend.value.abs() < 2.0 * trend.std, "{trend:?}");
        let values = profile.values(3);
        assert!((values[4].value - 1.45).abs() < 0.02 && (values[4].std - 0.05).abs() < 0.02, "{values:?}");
    }

    #[test]
    fn growth_is_growth() {
        let profile = said(&[0.02, -0.03, 0.01, 0.5, 1.0, 1.5], 0.05);
        assert_eq!(judged(&profile)[0].course, Course { since: 3, shape: Shape::Growth });
        let trend = profile.trend(3).unwrap();
        assert!((trend.value - 0.5).abs() < 2.0 * trend.std && trend.value > 2.0 * trend.std, "{trend:?}");
    }

    /// GIVEN drives that differ by what they are thought to differ by, or by twice that all the time THEN no course has
    /// evidence that pays for choosing it.
    #[test]
    fn scatter_is_no_change() {
        let mut random = 1_u64;
        let mut dice = || {
            let mut sum = 0.0;
            for _ in 0..12 {
                random =
                    random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                sum += (random >> 11) as f64 / (1_u64 << 53) as f64;
            }
            sum - 6.0
        };
        let mut most = [f64::NEG_INFINITY; 2];
        for _ in 0..300 {
            for (scatter, most) in [0.1, 0.2].into_iter().zip(&mut most) {
                let values: Vec<f64> = (0..6).map(|_| scatter * dice()).collect();
                *most = most.max(judged(&said(&values, 0.02))[0].evidence);
            }
        }
        // Before the choice among nine courses is paid for, 4.4.
        assert!(most[0] < 8.0 && most[1] < 17.0, "{most:?}");
    }

    /// GIVEN what all drives have in common is not known at all THEN their differences are told nevertheless.
    #[test]
    fn what_is_common_need_not_be_known() {
        let mut profile = said(&[0.0, 0.0, 0.0, 0.8, 0.8], 0.05);
        let common = DVector::from_element(5, 1.0);
        let taken = &profile.information * &common;
        profile.information -= &taken * taken.transpose() / taken.dot(&common);
        profile.gradient -=
            &taken * (taken.dot(&DVector::from_row_slice(&[0.0, 0.0, 0.0, 0.8, 0.8])) / taken.dot(&common));
        let values = profile.values(3);
        for (value, truth) in values.iter().zip([0.0, 0.0, 0.0, 0.8, 0.8]) {
            assert!((value.value - truth).abs() < 0.01 && (value.std - 0.05).abs() < 0.01, "{values:?}");
        }
        assert_eq!(judged(&profile)[0].course.since, 3);
    }
}
