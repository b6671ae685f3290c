//! One segment: simulated from a start of its own, beside what was measured.

use super::car::{Car, Drive};
use super::motion::{Channel, Input, Outputs, State};
use super::record::Row;
use crate::Wheel;
use crate::model::{Dual, GRAVITY, Real, TireKind, Vehicle};

/// Where in a step each stage looks, and how much it counts.
const STAGES: [(f64, f64); 4] = [(0.0, 1.0 / 6.0), (0.5, 1.0 / 3.0), (0.5, 1.0 / 3.0), (1.0, 1.0 / 6.0)];

/// What was measured in a row, in the order of [`Channel::ALL`]; not-a-number where it does not count.
pub(super) type Measured = Outputs<f64>;

/// A piece of a recording.
#[derive(Clone, Debug)]
pub(super) struct Segment {
    /// Inputs at all rows, and at the first one of the next segment.
    pub(super) inputs: Vec<Input>,
    /// Measurements at the same rows; those of the last one belong to the next segment.
    pub(super) measured: Vec<Measured>,
    /// Seconds between rows.
    pub(super) period_s: f64,
    /// Runge–Kutta steps between rows.
    pub(super) substeps: u32,
    /// Time of the first row, s.
    pub(super) t: f64,
    /// The recording it is from.
    pub(super) record: usize,
    /// Does it go on where the segment before ended?
    pub(super) continues: bool,
    /// The state at its first row, as measured; lateral velocity unknown, taken as zero.
    pub(super) start: State<f64>,
}

/// Of the friction that the vehicle's table gives: beyond it the slip of a driven wheel is no function
/// of its torque any more.
const SLIDING: f64 = 0.85;

/// A measured row, given which channels are inputs.
pub(super) fn measured(row: &Row, drive: Drive, vehicle: &Vehicle) -> Measured {
    let driven = Wheel::ALL.map(|wheel| vehicle.driven_axle.drives(wheel));
    let radius = vehicle.wheel_radius_m.value;
    let used = row.lateral_acceleration.abs() / GRAVITY;
    let slides = vehicle.tire != TireKind::Linear && used > SLIDING * vehicle.friction.value;
    let [fl, fr, rl, rr] = std::array::from_fn(|i| match drive {
        Drive::Torque if slides && driven[i] => f64::NAN,
        Drive::Torque => row.wheel_speed[i],
        Drive::WheelSpeeds if !driven[i] => row.wheel_speed[i],
        Drive::WheelSpeeds | Drive::Slips => f64::NAN,
    });
    let undriven = row.wheel_speed.iter().zip(driven).filter(|(speed, driven)| speed.is_finite() && !driven);
    let (sum, count) = undriven.fold((0.0, 0.0), |(sum, n), (speed, _)| (sum + radius * speed, n + 1.0));
    let speed = match drive {
        // There the speed is that of the freely rolling wheels (thesis 4.4).
        Drive::Slips if count > 0.0 => sum / count,
        Drive::Slips => row.vehicle_speed,
        Drive::Torque | Drive::WheelSpeeds => f64::NAN,
    };
    let (r, ay, ax) = (row.yaw_rate, row.lateral_acceleration, row.longitudinal_acceleration);
    [fl, fr, rl, rr, r, ay, ax, speed]
}

/// What a segment says: normal equations of the residuals by parameters and start.
#[derive(Clone, Debug)]
pub(super) struct Evidence<const N: usize> {
    /// Σ (residual / noise)².
    pub(super) cost: f64,
    /// Σ residual × derivative / noise².
    pub(super) gradient: [f64; N],
    /// Σ derivative × derivativeᵀ / noise².
    pub(super) information: [[f64; N]; N],
    /// The state at its end.
    pub(super) end: State<Dual<N>>,
    /// Σ residual², by channel.
    pub(super) squares: [f64; Channel::COUNT],
}

impl Segment {
    /// How many rows count.
    pub(super) fn len(&self) -> usize {
        self.inputs.len().saturating_sub(1)
    }

    /// Simulates, and calls `take` at each row with state and outputs. Returns the state at the end.
    #[inline(always)]
    fn simulate<T: Real>(
        &self,
        car: &Car<T>,
        drive: Drive,
        start: State<T>,
        mut take: impl FnMut(usize, &Outputs<T>),
    ) -> State<T> {
        let h = self.period_s / f64::from(self.substeps);
        let share = 1.0 / f64::from(self.substeps);
        let mut state = start;
        for (place, pair) in self.inputs.windows(2).enumerate() {
            let (from, to) = (&pair[0], &pair[1]);
            for step in 0..self.substeps {
                let at = share * f64::from(step);
                let mut slope = [T::constant(0.0); 3];
                let mut probe = state;
                // Classical Runge–Kutta as a loop: the equations are long, one copy of them is enough.
                for (stage, (of_step, weight)) in STAGES.into_iter().enumerate() {
                    let now = car.instant(&probe, &from.towards(to, at + of_step * share), drive);
                    if stage == 0 && step == 0 {
                        take(place, &car.outputs(&state, &now));
                    }
                    let ahead = STAGES.get(stage + 1).map_or(0.0, |next| next.0 * h);
                    for i in 0..3 {
                        slope[i] += now.rate[i] * weight;
                        probe[i] = state[i] + now.rate[i] * ahead;
                    }
                }
                for i in 0..3 {
                    state[i] += slope[i] * h;
                }
            }
        }
        state
    }

    /// The outputs at each row.
    pub(super) fn outputs(&self, car: &Car<f64>, drive: Drive, start: State<f64>) -> Vec<Outputs<f64>> {
        let mut rows = Vec::with_capacity(self.len());
        self.simulate(car, drive, start, |_, outputs| rows.push(*outputs));
        rows
    }

    /// Simulated beside measured. `car` has derivatives by the parameters, `start` by itself in the
    /// places after them. `weight` is 1 / noise², by channel.
    #[inline(always)]
    pub(super) fn evidence<const N: usize>(
        &self,
        car: &Car<Dual<N>>,
        drive: Drive,
        start: State<Dual<N>>,
        weight: &[f64; Channel::COUNT],
    ) -> Evidence<N> {
        let zero = Dual::constant(0.0);
        let mut evidence = Evidence {
            cost: 0.0,
            gradient: [0.0; N],
            information: [[0.0; N]; N],
            end: [zero; 3],
            squares: [0.0; Channel::COUNT],
        };
        evidence.end = self.simulate(car, drive, start, |place, outputs| {
            for channel in 0..Channel::COUNT {
                let measured = self.measured[place][channel];
                if !measured.is_nan() && weight[channel] > 0.0 {
                    evidence.take(channel, measured, &outputs[channel], weight[channel]);
                }
            }
        });
        evidence
    }
}

impl<const N: usize> Evidence<N> {
    #[inline(always)]
    fn take(&mut self, channel: usize, measured: f64, output: &Dual<N>, weight: f64) {
        let residual = output.value - measured;
        self.squares[channel] += residual * residual;
        self.cost += weight * residual * residual;
        for (row, by) in self.information.iter_mut().zip(&output.by) {
            let scaled = weight * by;
            for (place, other) in row.iter_mut().zip(&output.by) {
                *place += scaled * other;
            }
        }
        for (place, by) in self.gradient.iter_mut().zip(&output.by) {
            *place += weight * residual * by;
        }
    }
}
