//! What of the filter outlives a drive: the stiffnesses and the errors of the sensors; motion and bank do not.

use super::{ANGLE_OFFSET, ANGLE_SCALE, AY_OFFSET, CorneringEstimator, FRONT, REAR, SPEED_SCALE, YAW_OFFSET};
use crate::estimate::learned::{ERRORS, Known, Learned, Trial};

impl CorneringEstimator {
    /// Between two drives an error of a sensor moves by this share of what it may be at all:
    /// temperature, a steering sensor that was reset, load, tires.
    const BETWEEN_DRIVES: f64 = 0.25;
    /// Beyond this many times what it may be at all, an error is not known.
    const FORGOTTEN: f64 = 1.5;
    /// Stiffnesses and errors are taken up as independent of each other. With variances these many times
    /// what they were they are nowhere surer than they were together, however they were correlated:
    /// P ≤ diag((1 + c) P₁, (1 + 1/c) P₂), here for c = 4.
    const APART: (f64, f64) = (5.0, 1.25);
    /// Readings (two for each window) for which an earlier drive's numbers are on trial.
    const TRIAL: u32 = 80;
    /// The errors of the sensors, in the order of [`Learned::errors`].
    const ERRORS: [usize; ERRORS] = [ANGLE_OFFSET, AY_OFFSET, YAW_OFFSET, SPEED_SCALE, ANGLE_SCALE];

    /// Starts from what an earlier drive learned, less sure of it. Before the first sample only.
    pub fn restore(&mut self, learned: &Learned) {
        let fresh = Self::prior(&self.car, &self.config);
        let mut state = fresh;
        for (i, stiffness) in [FRONT, REAR].into_iter().zip(learned.cornering) {
            let Some(stiffness) = stiffness else { continue };
            // Half of what makes a stiffness valid has to be news.
            let systematic = self.systematic_std[i - FRONT];
            let valid = self.config.valid_relative_std.powi(2) - systematic * systematic;
            let least = (2.0 * valid).max(0.0).sqrt();
            let relative = least.max(Self::APART.0.sqrt() * stiffness.std / stiffness.value);
            if relative < fresh.std(i) / fresh.mean[i] {
                state.mean[i] = 1.0 / stiffness.value;
                state.covariance[(i, i)] = (relative / stiffness.value).powi(2);
            }
        }
        let correlation = learned.correlation();
        let errors = learned.errors().map(|error| error.map(|e| (e.value, Self::APART.1.sqrt() * e.std)));
        for (place, i) in Self::ERRORS.into_iter().enumerate() {
            // What is known much worse than the data sheet has it is not known.
            let known = |place: usize| {
                let std = errors[place]?.1;
                (std < Self::FORGOTTEN * fresh.std(Self::ERRORS[place])).then_some(std)
            };
            let (Some((value, _)), Some(std)) = (errors[place], known(place)) else { continue };
            for (other, &j) in Self::ERRORS[..place].iter().enumerate() {
                let shared = known(other).map_or(0.0, |other_std| std * other_std);
                state.covariance[(i, j)] = correlation[(place, other)] * shared;
                state.covariance[(j, i)] = state.covariance[(i, j)];
            }
            state.mean[i] = value;
            state.covariance[(i, i)] = std * std + (Self::BETWEEN_DRIVES * fresh.std(i)).powi(2);
        }
        self.settled = learned.cornering;
        self.state = state;
        self.trial = Some(Trial::new(fresh, Self::TRIAL));
    }

    /// Puts into `learned` what outlives the drive; motion and bank do not.
    pub fn learn(&self, learned: &mut Learned) {
        learned.cornering = self.settled;
        if !(self.seen || self.trial.is_some()) {
            return;
        }
        let known = |i: usize| {
            let std = self.state.std(i);
            (std > 0.0).then(|| Known { value: self.state.mean[i], std })
        };
        learned.road_angle_offset = known(ANGLE_OFFSET);
        learned.lateral_acceleration_offset = known(AY_OFFSET);
        learned.yaw_rate_offset = known(YAW_OFFSET);
        learned.speed_scale = known(SPEED_SCALE);
        learned.road_angle_scale = known(ANGLE_SCALE);
        let mut triangle = learned.error_correlations.iter_mut();
        for (place, &i) in Self::ERRORS.iter().enumerate() {
            for (&j, correlation) in Self::ERRORS[place + 1..].iter().zip(&mut triangle) {
                let scale = self.state.std(i) * self.state.std(j);
                *correlation = if scale > 0.0 { self.state.covariance[(i, j)] / scale } else { 0.0 };
            }
        }
    }

    /// Remembers stiffnesses that are known well.
    pub(super) fn settle(&mut self) {
        for (i, settled) in [FRONT, REAR].into_iter().zip(&mut self.settled) {
            let compliance = self.state.mean[i];
            let relative = self.state.alone_std(i, &[FRONT, REAR]) / compliance;
            if relative <= self.config.valid_relative_std {
                *settled = Some(Known { value: 1.0 / compliance, std: relative / compliance });
            }
        }
    }

    /// Fresh readings contradict an earlier drive's numbers: another load or another sensor, perhaps. As
    /// if there were none.
    pub(super) fn start_afresh(&mut self) {
        let idle = (self.idle_s, self.seen);
        self.start_again();
        (self.idle_s, self.seen) = idle;
    }
}
