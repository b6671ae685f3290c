//! What outlives a drive: the numbers of sensors and tires that the next drive may start with.
//!
//! Friction and its bounds are not among them: they belong to the road, and the next drive may begin on another one.
//! Nobody knows how long the car stood, whether it was loaded, or whether its tires were changed. So each estimator
//! widens the restored deviations, always beyond what counts as valid, and the numbers are on trial: the first
//! readings that contradict them take them back ([`Trial`]).

use nalgebra::SMatrix;

use crate::filter::{Gaussian, Innovation};
use crate::{Micros, Wheel};

/// A number and its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// Best value.
    pub value: f64,
    /// Standard deviation, in the value's unit.
    pub std: f64,
}

/// What was learned of a car. Absent is what nothing was learned of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Learned {
    /// Time of the last sample.
    pub time: Micros,
    /// Seconds that the car moved, those of the drives before included.
    pub driving_s: f64,
    /// Slip slope per driven wheel, normalized by the static wheel load, when last known well.
    pub slope: [Option<Known>; 4],
    /// Slip at zero force per driven wheel: by how much its radius differs from the reference wheel's.
    pub slip_offset: [Option<Known>; 4],
    /// Cornering stiffness front and rear, normalized by the axle load, 1/rad, when last known well.
    pub cornering: [Option<Known>; 2],
    /// Offset of the yaw rate, rad/s.
    pub yaw_rate_offset: Option<Known>,
    /// Offset of the lateral acceleration, m/s².
    pub lateral_acceleration_offset: Option<Known>,
    /// Offset of the road wheel angle, rad.
    pub road_angle_offset: Option<Known>,
    /// Relative error of the speed from the wheels: of their nominal radius.
    pub speed_scale: Option<Known>,
    /// Relative error of the road wheel angle: of the steering ratio.
    pub road_angle_scale: Option<Known>,
    /// Correlations of the errors above: what is known of a gyro's offset and an accelerometer's is mostly
    /// their sum. The upper triangle, row by row, in the order of [`Learned::errors`].
    pub error_correlations: [f64; 10],
}

/// How many errors of sensors there are.
pub(super) const ERRORS: usize = 5;

/// Bounds outside of which a number is none of a car's: values, and the largest standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bounds {
    low: f64,
    high: f64,
    std: f64,
}

impl Bounds {
    const fn new(low: f64, high: f64, std: f64) -> Self {
        Self { low, high, std }
    }

    fn hold(&self, known: &Known) -> bool {
        (self.low..=self.high).contains(&known.value) && known.std > 0.0 && known.std <= self.std
    }
}

impl Learned {
    /// Rubber on ice to a racing tire on a drum. Physical.
    const SLOPE: Bounds = Bounds::new(1.0, 1000.0, 500.0);
    /// A spare wheel is a tenth smaller. Physical.
    const SLIP_OFFSET: Bounds = Bounds::new(-0.2, 0.2, 0.1);
    /// The cornering filter's own limits, 1/rad.
    const CORNERING: Bounds = Bounds::new(1.0, 80.0, 40.0);
    /// A gyro beyond 11 °/s is broken, rad/s. Physical.
    const YAW_RATE: Bounds = Bounds::new(-0.2, 0.2, 0.1);
    /// A third of g is no mounting, m/s². Physical.
    const LATERAL_ACCELERATION: Bounds = Bounds::new(-3.0, 3.0, 1.5);
    /// A tenth of a radian is 90° at the steering wheel, rad. Physical.
    const ROAD_ANGLE: Bounds = Bounds::new(-0.1, 0.1, 0.1);
    /// A correlation of one may be rounded to a little more.
    const ROUNDING: f64 = 1e-9;
    /// Relative errors of radius and steering ratio. Physical: a tire or a steering gear that is off by a third is
    /// another one.
    const SCALE: Bounds = Bounds::new(-0.3, 0.3, 0.3);

    /// Every number with its name and its bounds.
    fn entries(&mut self) -> [(&'static str, &mut Option<Known>, Bounds); 15] {
        let [slope_fl, slope_fr, slope_rl, slope_rr] = &mut self.slope;
        let [offset_fl, offset_fr, offset_rl, offset_rr] = &mut self.slip_offset;
        let [front, rear] = &mut self.cornering;
        [
            ("slope fl", slope_fl, Self::SLOPE),
            ("slope fr", slope_fr, Self::SLOPE),
            ("slope rl", slope_rl, Self::SLOPE),
            ("slope rr", slope_rr, Self::SLOPE),
            ("slip offset fl", offset_fl, Self::SLIP_OFFSET),
            ("slip offset fr", offset_fr, Self::SLIP_OFFSET),
            ("slip offset rl", offset_rl, Self::SLIP_OFFSET),
            ("slip offset rr", offset_rr, Self::SLIP_OFFSET),
            ("cornering stiffness front", front, Self::CORNERING),
            ("cornering stiffness rear", rear, Self::CORNERING),
            ("yaw rate offset", &mut self.yaw_rate_offset, Self::YAW_RATE),
            (
                "lateral acceleration offset",
                &mut self.lateral_acceleration_offset,
                Self::LATERAL_ACCELERATION,
            ),
            ("road angle offset", &mut self.road_angle_offset, Self::ROAD_ANGLE),
            ("speed scale", &mut self.speed_scale, Self::SCALE),
            ("road angle scale", &mut self.road_angle_scale, Self::SCALE),
        ]
    }

    /// The errors of the sensors: offsets of road wheel angle, lateral acceleration and yaw rate, scales of
    /// speed and road wheel angle.
    pub fn errors(&self) -> [Option<Known>; ERRORS] {
        [
            self.road_angle_offset,
            self.lateral_acceleration_offset,
            self.yaw_rate_offset,
            self.speed_scale,
            self.road_angle_scale,
        ]
    }

    /// Their correlations as a matrix; those of a number that is absent are zero.
    pub(super) fn correlation(&self) -> SMatrix<f64, ERRORS, ERRORS> {
        let known = self.errors();
        let mut matrix = SMatrix::identity();
        let mut triangle = self.error_correlations.iter();
        for i in 0..ERRORS {
            for (j, correlation) in (i + 1..ERRORS).zip(&mut triangle) {
                if known[i].is_some() && known[j].is_some() {
                    matrix[(i, j)] = *correlation;
                    matrix[(j, i)] = *correlation;
                }
            }
        }
        matrix
    }

    /// Are they correlations that numbers can have?
    fn is_correlation(&self) -> bool {
        let almost = SMatrix::<f64, ERRORS, ERRORS>::identity() * Self::ROUNDING;
        self.error_correlations.iter().all(|c| c.abs() <= 1.0 + Self::ROUNDING)
            && (self.correlation() + almost).cholesky().is_some()
    }

    /// The first number that no car can have, by name: not finite, out of bounds, or without a standard
    /// deviation.
    pub fn problem(&self) -> Option<&'static str> {
        if !(self.driving_s.is_finite() && self.driving_s >= 0.0) {
            return Some("seconds of driving");
        }
        let mut copy = *self;
        let wrong = |(_, known, bounds): &(&str, &mut Option<Known>, Bounds)| {
            known.is_some_and(|known| !bounds.hold(&known))
        };
        let number = copy.entries().into_iter().find(wrong).map(|(name, ..)| name);
        number.or_else(|| (!self.is_correlation()).then_some("correlation of the sensors' errors"))
    }

    /// The same without the numbers that no car can have.
    pub fn plausible(mut self) -> Self {
        for (_, known, bounds) in self.entries() {
            *known = known.filter(|known| bounds.hold(known));
        }
        if !self.is_correlation() {
            self.error_correlations = [0.0; 10];
        }
        self
    }

    /// Is there anything in it?
    pub fn is_empty(&self) -> bool {
        let mut copy = *self;
        copy.entries().iter().all(|(_, known, _)| known.is_none())
    }

    /// Slope and slip offset of a wheel.
    pub(super) fn of_wheel(&self, wheel: Wheel) -> (Option<Known>, Option<Known>) {
        (self.slope[wheel as usize], self.slip_offset[wheel as usize])
    }
}

/// What was taken up again, until the first readings have agreed with it.
#[derive(Clone, Debug)]
pub(super) struct Trial<const N: usize> {
    /// The start without it.
    pub fresh: Gaussian<N>,
    /// Readings until it is over.
    left: u32,
}

impl<const N: usize> Trial<N> {
    /// A reading this many standard deviations off contradicts. Statistical: by chance one reading in 150,000, and
    /// one trial of 80 readings in 2,000.
    const CONTRADICTION: f64 = 4.5;
    /// It does so only if at least this share of the innovation's variance is the state's: a bump on the road says
    /// nothing of the state. Tuned with the test `learned`.
    const SHARE: f64 = 0.5;

    /// For so many readings.
    pub fn new(fresh: Gaussian<N>, readings: u32) -> Self {
        Self { fresh, left: readings }
    }

    /// Does a reading, whose own noise has the variance `noise`, contradict? `None`: the trial is over.
    pub fn step(&mut self, expected: &Innovation, noise: f64) -> Option<bool> {
        self.left = self.left.checked_sub(1)?;
        let from_state = expected.variance - noise > Self::SHARE * expected.variance;
        Some(from_state && expected.normalized().abs() > Self::CONTRADICTION)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_car_can_have_is_found_and_left_out() {
        let good = Known { value: 0.01, std: 0.001 };
        let mut learned = Learned { yaw_rate_offset: Some(good), ..Learned::default() };
        assert_eq!(learned.problem(), None);
        for (value, std) in [
            (f64::NAN, 0.1),
            (0.3, 0.01),
            (f64::NEG_INFINITY, 0.01),
            (0.0, f64::NAN),
            (0.0, 0.0),
            (0.0, -1.0),
            (0.0, f64::INFINITY),
        ] {
            learned.slip_offset[2] = Some(Known { value, std });
            assert_eq!(learned.problem(), Some("slip offset rl"), "{value} {std}");
            let plausible = learned.plausible();
            assert_eq!((plausible.slip_offset[2], plausible.yaw_rate_offset), (None, Some(good)));
        }
        learned.slip_offset[2] = None;
        learned.speed_scale = Some(good);
        for (correlation, is_one) in [(0.99, true), (1.0, true), (1.1, false), (f64::NAN, false)] {
            learned.error_correlations[7] = correlation;
            assert_eq!(learned.problem().is_none(), is_one, "{correlation}");
        }
        assert_eq!(learned.plausible().error_correlations, [0.0; 10]);
        // Each one can be, all three cannot.
        learned.road_angle_offset = Some(good);
        learned.error_correlations = [0.0, 0.9, -0.9, 0.0, 0.0, 0.0, 0.0, 0.9, 0.0, 0.0];
        assert!(learned.problem().is_some());
        learned.error_correlations = [0.0; 10];
        learned.driving_s = f64::NAN;
        assert_eq!(learned.problem(), Some("seconds of driving"));
    }

    #[test]
    fn a_reading_contradicts_by_what_the_state_made_expect() {
        let mut trial = Trial::new(Gaussian::new([0.0], [1.0]), 3);
        let expected = |residual, variance| Innovation { residual, variance };
        assert_eq!(trial.step(&expected(4.0, 1.0), 0.1), Some(false));
        assert_eq!(trial.step(&expected(5.0, 1.0), 0.1), Some(true));
        assert_eq!(trial.step(&expected(5.0, 1.0), 0.9), Some(false), "noise");
        assert_eq!(trial.step(&expected(5.0, 1.0), 0.1), None, "over");
    }
}
