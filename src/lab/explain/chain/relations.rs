//! The equations between channels, each as a regression whose first coefficient is one if all is right
//! and whose second tells the delay.

use super::regression::{self, FREE, Fit, Prior, Row, fit};
use super::series::{Series, at};
use physics::Quantity;
use physics::model::DrivenAxle;

/// Rows are this far apart, s: smoothed series do not change faster. Numerical: less than half of the smoothing.
const STRIDE_S: f64 = 0.04;
/// Beyond this the tires are not linear any more, m/s². Physical: about half of the friction of a dry road.
const GENTLE: f64 = 4.5;
/// Beyond this it is no road car, but a unit that is wrong, m/s². Physical: one and a half times gravity.
const IMPOSSIBLE: f64 = 15.0;
/// Braking shifts the wheels' speed against the car's; weaker deceleration than this is coasting, m/s². Physical.
const COASTING: f64 = 0.8;
/// Nobody knows better where the accelerometer sits, m. Prior: standard deviation.
const ACCELEROMETER_PLACE_M: f64 = 0.15;
/// Zeros of yaw rate sensors, rad/s. Prior: standard deviation, as for the wheels.
const YAW_ZERO: f64 = 0.01;
/// Outer wheels, pressed down, roll on a smaller radius: difference of the two, relative, per lateral
/// acceleration, at most about this, s²/m. Physical.
pub(super) const LOADED_RADIUS: f64 = 8e-4;
/// Delays beyond this are longer than what tires and body make a relation look late by, s. Physical.
const EVIDENT_DELAY_S: f64 = 0.2;
/// Delays are looked for up to this, s. Physical: the bound of `sensor_delay`.
const LONGEST_DELAY_S: f64 = 0.5;

/// An equation between two channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Relation {
    /// Difference of the rear wheels, against the yaw rate.
    RearWheels,
    /// Difference of the front wheels, against the yaw rate.
    FrontWheels,
    /// Lateral acceleration, against speed times yaw rate.
    Lateral,
    /// Steering times speed, against the yaw rate.
    Steering,
    /// Longitudinal acceleration, against the change of the wheels' speed.
    Longitudinal,
}

impl Relation {
    pub(super) const ALL: [Self; 5] =
        [Self::RearWheels, Self::FrontWheels, Self::Lateral, Self::Steering, Self::Longitudinal];

    /// In words, response first.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::RearWheels => "rear wheel speed difference / yaw rate",
            Self::FrontWheels => "front wheel speed difference / yaw rate",
            Self::Lateral => "lateral acceleration / speed x yaw rate",
            Self::Steering => "steering x speed / yaw rate",
            Self::Longitudinal => "longitudinal acceleration / wheel acceleration",
        }
    }

    /// The channels beside a speed without which there is nothing to compare.
    pub(super) fn needs(self) -> Vec<Quantity> {
        use Quantity::{LateralAcceleration, LongitudinalAcceleration, SteeringWheelAngle, YawRate};
        match self {
            Self::RearWheels => vec![Quantity::WheelSpeedRl, Quantity::WheelSpeedRr, YawRate],
            Self::FrontWheels => vec![Quantity::WheelSpeedFl, Quantity::WheelSpeedFr, YawRate],
            Self::Lateral => vec![LateralAcceleration, YawRate],
            Self::Steering => vec![SteeringWheelAngle, YawRate],
            Self::Longitudinal => vec![LongitudinalAcceleration],
        }
    }

    /// Does it compare the wheels of an axle?
    pub(super) fn is_of_an_axle(self) -> bool {
        matches!(self, Self::RearWheels | Self::FrontWheels)
    }

    /// What to drive where it was not excited.
    pub(super) fn manoeuvre(self) -> &'static str {
        match self {
            Self::Longitudinal => "accelerate and coast, several times",
            _ => "drive curves to both sides, several of them briskly",
        }
    }
}

/// What a relation says.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    pub(super) relation: Relation,
    pub(super) gain: f64,
    pub(super) gain_std: f64,
    /// How far an error of the regressor, at most, has pressed the gain down (logarithmic): all that the relation leaves
    /// unexplained may be such an error (Frisch's bound: the slope the other way round).
    pub(super) pressed: f64,
    /// The share that the regressor explains by itself.
    alone: f64,
    /// How many blocks it rests on.
    pub(super) blocks: usize,
    /// The response is this much later than the regressor, s.
    pub(super) delay: f64,
    pub(super) delay_std: f64,
    pub(super) explained: f64,
    /// Sign of the plain correlation, all small terms left out.
    pub(super) is_negative: bool,
    /// Is that beyond doubt, and does it explain something?
    pub(super) is_clear: bool,
}

/// The gain, and the delay by shifting the response until none is left.
pub(super) fn link(series: &Series, relation: Relation) -> Option<Link> {
    let mut delay = 0.0;
    let mut link = evaluate(series, relation, delay)?;
    let undelayed = link.alone;
    for _ in 0..4 {
        let step = link.delay;
        if !link.is_clear || !step.is_finite() || (delay + step).abs() > LONGEST_DELAY_S {
            return Some(Link { delay: f64::NAN, ..link });
        }
        delay += step;
        link = evaluate(series, relation, delay)?;
        if step.abs() < 1e-4 {
            break;
        }
    }
    let whole = delay + link.delay;
    // A long delay shows without any small terms, too: put right, the two look more alike than before.
    let shows = whole.abs() < EVIDENT_DELAY_S || link.alone > undelayed;
    Some(Link { delay: if whole.abs() > LONGEST_DELAY_S || !shows { f64::NAN } else { whole }, ..link })
}

fn evaluate(series: &Series, relation: Relation, shift: f64) -> Option<Link> {
    match relation {
        Relation::RearWheels => axle(series, Quantity::WheelSpeedRl, Quantity::WheelSpeedRr, relation, shift),
        Relation::FrontWheels => {
            axle(series, Quantity::WheelSpeedFl, Quantity::WheelSpeedFr, relation, shift)
        }
        Relation::Lateral => lateral(series, shift),
        Relation::Steering => steering(series, shift),
        Relation::Longitudinal => longitudinal(series, shift),
    }
}

/// Rows of a regression: those where everything is known.
pub(super) fn rows<const K: usize>(
    series: &Series,
    y: &[f64],
    shift: f64,
    valid: impl Fn(usize) -> bool,
    x: impl Fn(usize) -> [f64; K],
) -> Vec<Row<K>> {
    let stride = (STRIDE_S / series.dt).round().max(1.0) as usize;
    let place = |row: usize| row as f64 + shift / series.dt;
    (0..series.len())
        .step_by(stride)
        .filter(|row| series.moves(*row) && valid(*row))
        .map(|row| Row { x: x(row), y: at(y, place(row)), block: series.block(row), place: row / stride })
        .filter(|row| row.y.is_finite() && row.x.iter().all(|x| x.is_finite()))
        .collect()
}

/// The least share of the variance that a relation must explain to be believed.
fn believable(relation: Relation) -> f64 {
    match relation {
        Relation::Lateral | Relation::Steering => 0.3,
        _ => 0.2,
    }
}

fn summary<const K: usize>(relation: Relation, fit: &Fit<K>, rows: &[Row<K>]) -> Option<Link> {
    let plain: Vec<Row<2>> = rows
        .iter()
        .map(|row| Row { x: [row.x[0], 1.0], y: row.y, block: row.block, place: row.place })
        .collect();
    let plain = regression::fit(&plain, [FREE; 2])?;
    let gain = fit.value[0];
    Some(Link {
        relation,
        gain,
        gain_std: fit.std[0],
        pressed: -fit.explained.clamp(1e-6, 1.0).ln(),
        alone: plain.explained,
        blocks: fit.blocks,
        delay: -fit.value[1] / gain,
        delay_std: fit.std[1] / gain.abs(),
        explained: fit.explained,
        is_negative: plain.value[0] < 0.0,
        is_clear: plain.is_significant(0) && plain.explained > believable(relation),
    })
}

impl Link {
    /// Standard deviations of few blocks are uncertain themselves: so much wider a normal distribution has to be for
    /// bounds of four of them to mean what Student's do.
    pub(super) fn widened(&self) -> f64 {
        regression::student(self.blocks) / regression::SIGNIFICANT
    }

    /// Is the magnitude of the gain known well enough to speak of a scale?
    pub(super) fn has_scale(&self) -> bool {
        self.is_clear && (self.gain < 0.0) == self.is_negative && self.gain_std < 0.3 * self.gain.abs()
    }
}

/// (ω_R − ω_L) r0 / track = r, with a share of the speed for unequal radii and a zero of the yaw rate.
fn axle(series: &Series, left: Quantity, right: Quantity, relation: Relation, shift: f64) -> Option<Link> {
    let vehicle = &series.vehicle;
    let front = relation == Relation::FrontWheels;
    let track = if front { vehicle.track_front_m } else { vehicle.track_rear_m }.value;
    let to_yaw = vehicle.wheel_radius_m.value / track;
    let (left, right) = (series.raw(left), series.raw(right));
    let y = series.smoothed(|row| (right[row] - left[row]) * to_yaw);
    let rows = rows(
        series,
        &y,
        shift,
        |row| gentle(series, row),
        |row| [series.r[row], series.r_dot[row], 1.0, series.v[row], series.v[row] * series.lateral(row)],
    );
    let fit = fit(&rows, [FREE, FREE, FREE, FREE, (0.0, LOADED_RADIUS / track)])?;
    summary(relation, &fit, &rows)
}

/// In units that may be wrong "gentle" is not known: so the bound only counts while the lateral
/// acceleration seems possible at all.
fn gentle(series: &Series, row: usize) -> bool {
    let a = series.vr[row].abs();
    !(GENTLE..=IMPOSSIBLE).contains(&a)
}

/// a_y = v r + b r' − κ d/dt[v (a_y − Jz/(m a) r')] + offset: exact for linear rear tires, whatever the
/// front axle does (the rear axle's force follows from a_y and r' alone).
fn lateral(series: &Series, shift: f64) -> Option<Link> {
    let vehicle = &series.vehicle;
    let y = series.smooth(Quantity::LateralAcceleration);
    let gain = rough_gain(series, &y);
    let inertia = gain * vehicle.yaw_inertia() / (vehicle.mass() * vehicle.a());
    // The delayed acceleration put back to its time, here too.
    let slip: Vec<f64> = (0..series.len())
        .map(|row| series.v[row] * (at(&y, row as f64 + shift / series.dt) - inertia * series.r_dot[row]))
        .collect();
    let q = series.derivative(&slip);
    let rows = rows(
        series,
        &y,
        shift,
        |row| gentle(series, row),
        |row| {
            let turning = [series.vr[row], series.vr_dot[row], series.r_dot[row]];
            [turning[0], turning[1], turning[2], -q[row], series.v[row], 1.0]
        },
    );
    let place = vehicle.cg_to_front_m.std.hypot(ACCELEROMETER_PLACE_M);
    // A zero of the yaw rate goes with the speed; left out, it would pass for a delay wherever the speed changes.
    let zero = (0.0, gain.abs() * YAW_ZERO);
    let priors = [FREE, FREE, (gain * vehicle.b(), gain.abs() * place), series.kappa(false), zero, FREE];
    let fit = fit(&rows, priors)?;
    summary(Relation::Lateral, &fit, &rows)
}

/// How many times too large the lateral acceleration is where its unit is wrong; one where it is not.
fn rough_gain(series: &Series, lateral_acceleration: &[f64]) -> f64 {
    let valid = (0..series.len())
        .filter(|row| series.moves(*row))
        .map(|row| (lateral_acceleration[row], series.vr[row]));
    let (sum_xy, sum_xx) = valid
        .filter(|(y, x)| y.is_finite() && x.is_finite())
        .fold((0.0, 0.0), |(xy, xx), (y, x)| (xy + x * y, xx + x * x));
    let slope: f64 = if sum_xx > 0.0 { sum_xy / sum_xx } else { 1.0 };
    if (0.5..2.0).contains(&slope) || slope == 0.0 { 1.0 } else { slope }
}

/// δ v/L = r + (κ_F − κ_R) v a_y/L + (κ_F Jz/(m b) + κ_R Jz/(m a)) v r'/L + offsets, δ the road wheel
/// angle: exact for linear tires at small angles.
fn steering(series: &Series, shift: f64) -> Option<Link> {
    let vehicle = &series.vehicle;
    let l = vehicle.wheelbase_m.value;
    let to_yaw = 1.0 / (vehicle.steering_ratio.value * l);
    let angle = series.raw(Quantity::SteeringWheelAngle);
    let y = series.smoothed(|row| angle[row] * series.speed(row) * to_yaw);
    // Where nobody feels it, what a steady curve has.
    let felt = series.has(Quantity::LateralAcceleration);
    let ay = if felt { series.smooth(Quantity::LateralAcceleration) } else { series.vr.clone() };
    let ay_gain = rough_gain(series, &ay);
    let rows = rows(
        series,
        &y,
        shift,
        |row| gentle(series, row),
        |row| {
            let (v, r_dot) = (series.v[row], series.r_dot[row]);
            [series.r[row], r_dot, v * ay[row] / ay_gain / l, v * r_dot / l, v, 1.0]
        },
    );
    let (sum_xy, sum_xx) = rows.iter().fold((0.0, 0.0), |(a, b), r| (a + r.x[0] * r.y, b + r.x[0] * r.x[0]));
    let slope = if sum_xx > 0.0 { sum_xy / sum_xx } else { 1.0 };
    let gain = if (0.3..4.0).contains(&slope) { 1.0 } else { slope };
    let ((front, front_std), (rear, rear_std)) = (series.kappa(true), series.kappa(false));
    // Both stiffnesses mostly change together: with the surface, the load, the temperature.
    let understeer = (front - rear, 0.5 * front_std.hypot(rear_std));
    let lever = vehicle.yaw_inertia() / vehicle.mass();
    let transient = (
        lever * (front / vehicle.b() + rear / vehicle.a()),
        lever * (front_std / vehicle.b() + rear_std / vehicle.a()),
    );
    let scaled = |(mean, std): Prior| (gain * mean, gain.abs() * std);
    let priors = [FREE, FREE, scaled(understeer), scaled(transient), FREE, FREE];
    let fit = fit(&rows, priors)?;
    summary(Relation::Steering, &fit, &rows)
}

/// Is the car coasting or being driven, now and a little before and after?
pub(super) fn not_braking(series: &Series) -> Vec<bool> {
    let pressure = series.smooth(Quantity::BrakePressure);
    let torque = series.smooth(Quantity::BrakeTorque);
    // What is not known is not above anything.
    let above = |value: f64, bound: f64| value.abs() > bound;
    let now =
        |row: usize| series.v_dot[row] > -COASTING && !above(pressure[row], 0.5) && !above(torque[row], 50.0);
    let reach = (0.3 / series.dt) as usize;
    let mut clear = vec![true; series.len()];
    for row in (0..series.len()).filter(|row| !now(*row)) {
        let to = (row + reach + 1).min(series.len());
        clear[row.saturating_sub(reach)..to].fill(false);
    }
    clear
}

/// a_x = v' − vy r, while the wheels roll freely; the grade, slow, is left in the residuals' average over
/// some seconds.
fn longitudinal(series: &Series, shift: f64) -> Option<Link> {
    let y = series.smooth(Quantity::LongitudinalAcceleration);
    let v_dot_dot = series.derivative(&series.v_dot);
    let free = not_braking(series);
    let mut rows = rows(
        series,
        &y,
        shift,
        |row| free[row] && gentle(series, row),
        |row| {
            let (v, r) = (series.v[row], series.r[row]);
            [series.v_dot[row], v_dot_dot[row], v * v_dot_dot[row], r * r, v * v * r * r]
        },
    );
    without_means(&mut rows);
    let vehicle = &series.vehicle;
    let slip = 1.0 / (vehicle.longitudinal_stiffness.value * physics::model::GRAVITY);
    let freely = if vehicle.driven_axle == DrivenAxle::All { 1.0 } else { 0.1 };
    let (kappa, kappa_std) = series.kappa(false);
    let priors = [FREE, FREE, (0.0, freely * slip), (-vehicle.b(), 0.5), (kappa, kappa_std)];
    let fit = fit(&rows, priors)?;
    summary(Relation::Longitudinal, &fit, &rows)
}

/// Takes each block's mean away: what changes more slowly than a block is not asked about.
pub(super) fn without_means<const K: usize>(rows: &mut [Row<K>]) {
    let mut from = 0;
    while from < rows.len() {
        let block = rows[from].block;
        let length = rows[from..].iter().take_while(|row| row.block == block).count();
        let part = &mut rows[from..from + length];
        let count = length as f64;
        let y = part.iter().map(|row| row.y).sum::<f64>() / count;
        let x: [f64; K] = std::array::from_fn(|i| part.iter().map(|row| row.x[i]).sum::<f64>() / count);
        for row in part {
            row.y -= y;
            row.x.iter_mut().zip(x).for_each(|(value, mean)| *value -= mean);
        }
        from += length;
    }
}
