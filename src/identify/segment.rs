//! One segment: simulated from a start of its own, beside what was measured.

use multiversion::multiversion;

use super::car::PlainCar;
use super::longitudinal_input::LongitudinalInput;
use super::motion::{Input, Outputs, State};
use super::record::Row;
use physics::Wheel;
use physics::model::{Dual, GRAVITY, Real, TireKind, Vehicle};

/// Where in a step each stage looks, and how much it counts.
const STAGES: [(f64, f64); 4] = [(0.0, 1.0 / 6.0), (0.5, 1.0 / 3.0), (0.5, 1.0 / 3.0), (1.0, 1.0 / 6.0)];

/// What was measured in a row, in the order of [`Output::ALL`]; not-a-number where it does not count.
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
pub(super) fn measured(row: &Row, drive: LongitudinalInput, vehicle: &Vehicle) -> Measured {
    let driven = Wheel::ALL.map(|wheel| vehicle.driven_axle.drives(wheel));
    let radius = vehicle.wheel_radius_m.value;
    let used = row.lateral_acceleration.abs() / GRAVITY;
    let slides = vehicle.tire != TireKind::Linear && used > SLIDING * vehicle.friction.value;
    let [fl, fr, rl, rr] = std::array::from_fn(|i| match drive {
        LongitudinalInput::Torque if slides && driven[i] => f64::NAN,
        LongitudinalInput::Torque => row.wheel_speed[i],
        LongitudinalInput::WheelSpeeds if !driven[i] => row.wheel_speed[i],
        LongitudinalInput::WheelSpeeds | LongitudinalInput::Slips | LongitudinalInput::Speed => f64::NAN,
    });
    let undriven = row.wheel_speed.iter().zip(driven).filter(|(speed, driven)| speed.is_finite() && !driven);
    let (sum, count) = undriven.fold((0.0, 0.0), |(sum, n), (speed, _)| (sum + radius * speed, n + 1.0));
    let speed = match drive {
        // There the speed is that of the freely rolling wheels (thesis 4.4).
        LongitudinalInput::Slips if count > 0.0 => sum / count,
        LongitudinalInput::Slips => row.vehicle_speed,
        // Where no wheel tells.
        LongitudinalInput::Torque if row.wheel_speed.iter().all(|speed| speed.is_nan()) => row.vehicle_speed,
        LongitudinalInput::Torque | LongitudinalInput::WheelSpeeds | LongitudinalInput::Speed => f64::NAN,
    };
    let (r, ay, ax) = (row.yaw_rate, row.lateral_acceleration, row.longitudinal_acceleration);
    [fl, fr, rl, rr, r, ay, ax, speed]
}

/// Derivatives are carried eight at a time: what the widest registers hold, and few enough that the
/// equations are compiled once.
pub(super) const LANES: usize = 8;

/// One simulation with derivatives by eight things.
#[derive(Clone, Debug)]
pub(super) struct Trace {
    /// Of each channel that counts: simulated less measured (zero where nothing was measured), by row.
    pub(super) residuals: Vec<Vec<f64>>,
    /// And its derivatives.
    pub(super) by: Vec<Vec<[f64; LANES]>>,
    /// The state at its end.
    pub(super) end: State<Dual<LANES>>,
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
        car: &PlainCar<T>,
        drive: LongitudinalInput,
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
    pub(super) fn outputs(
        &self,
        car: &PlainCar<f64>,
        drive: LongitudinalInput,
        start: State<f64>,
    ) -> Vec<Outputs<f64>> {
        let mut rows = Vec::with_capacity(self.len());
        self.simulate(car, drive, start, |_, outputs| rows.push(*outputs));
        rows
    }
}

/// Simulated beside measured, in the channels that count. The same on machines with wider registers.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
pub(super) fn trace(
    segment: &Segment,
    car: &PlainCar<Dual<LANES>>,
    drive: LongitudinalInput,
    start: State<Dual<LANES>>,
    channels: &[usize],
) -> Trace {
    let rows = segment.len();
    let mut residuals = vec![vec![0.0; rows]; channels.len()];
    let mut by = vec![vec![[0.0; LANES]; rows]; channels.len()];
    let end = segment.simulate(car, drive, start, |place, outputs| {
        for (number, channel) in channels.iter().enumerate() {
            let measured = segment.measured[place][*channel];
            if !measured.is_nan() {
                residuals[number][place] = outputs[*channel].value - measured;
                by[number][place] = outputs[*channel].by;
            }
        }
    });
    Trace { residuals, by, end }
}

/// Σ a bᵀ over rows.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
pub(super) fn products(a: &[[f64; LANES]], b: &[[f64; LANES]]) -> [[f64; LANES]; LANES] {
    let mut sum = [[0.0; LANES]; LANES];
    for (a, b) in a.iter().zip(b) {
        for (place, row) in sum.iter_mut().enumerate() {
            for (other, sum) in row.iter_mut().enumerate() {
                *sum += a[place] * b[other];
            }
        }
    }
    sum
}
