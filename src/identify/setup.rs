//! What a search needs before it begins: complete records, what is free, a first guess of the noise.

use std::borrow::Cow;

use super::braking;
use super::config::{self, IdentifyConfig};
use super::error::IdentifyError;
use super::fit::Noise;
use super::free::{Free, Tied};
use super::longitudinal_input::LongitudinalInput;
use super::parameter::Parameter;
use super::record::Record;
use super::slips;
use super::smooth::centred_mean;
use physics::model::Vehicle;
use physics::{Quantity, Wheel};

/// Records with what the sensors do not say themselves: where the car brakes, and how much its wheels slip.
pub(super) fn prepared<'a>(
    records: &'a [Record],
    vehicle: &Vehicle,
    drive: LongitudinalInput,
) -> Cow<'a, [Record]> {
    let mut records = Cow::Borrowed(records);
    for place in 0..records.len() {
        if !braking::is_told(&records[place]) {
            braking::recognize(&mut records.to_mut()[place], vehicle);
        }
        if drive == LongitudinalInput::Speed {
            prescribe_speed(&mut records.to_mut()[place], vehicle);
        }
        if drive == LongitudinalInput::Slips && !has_slips(&records[place]) {
            slips::fill(&mut records.to_mut()[place], vehicle);
        }
    }
    records
}

/// A prescribed speed is averaged over this time, s. Physical: its change is the acceleration, and cars do not change
/// that faster.
const SPEED_OVER_S: f64 = 0.2;

/// Makes the speed an input.
fn prescribe_speed(record: &mut Record, vehicle: &Vehicle) {
    let half = (0.5 * SPEED_OVER_S / record.period_s).round().max(1.0) as usize;
    let measured: Vec<f64> = record.rows.iter().map(|row| row.speed(vehicle)).collect();
    let smooth = centred_mean(&measured, half);
    for ((row, measured), smooth) in record.rows.iter_mut().zip(measured).zip(smooth) {
        row.vehicle_speed = if measured.is_finite() { smooth } else { f64::NAN };
    }
}

/// Whoever has measured slips by other means may bring them along.
pub(super) fn has_slips(record: &Record) -> bool {
    record.rows.iter().any(|row| row.slip.iter().all(|slip| slip.is_finite()))
}

/// What is free.
pub(super) fn free(
    vehicle: &Vehicle,
    config: &IdentifyConfig,
    has: impl Fn(Quantity) -> bool,
    drive: LongitudinalInput,
) -> Result<Vec<Free>, IdentifyError> {
    let chosen: Vec<Tied> = if config.parameters.is_empty() {
        Parameter::usual(vehicle, drive, &has).into_iter().map(Tied::One).collect()
    } else {
        config.parameters.iter().map(|name| config::named(name)).collect::<Result<_, _>>()?
    };
    let mut free: Vec<Free> = Vec::new();
    for parameters in chosen {
        let unusable =
            |reason: &str| IdentifyError::Unusable { name: parameters.name().into(), reason: reason.into() };
        let first = parameters.first();
        let prior = first.prior(vehicle);
        if !prior.value.is_finite() {
            return Err(unusable("the vehicle's table has no value to start from"));
        }
        if !first.is_used(vehicle, drive, &has) {
            return Err(unusable("with these tires, sensors and identify.drive the equations do not use it"));
        }
        let mean = parameters.coordinate(prior.value);
        let std = match prior.std {
            0.0 => f64::INFINITY,
            std if first.is_logarithmic() => std / prior.value,
            std => std / first.scale(),
        };
        free.push(Free { parameters, mean, std, bounds: first.bounds_in(vehicle) });
    }
    if free.len() > 29 {
        let value = free.len().to_string();
        return Err(IdentifyError::Setting { key: "parameters", value, reason: "at most 29 at once" });
    }
    Ok(free)
}

/// What is held because only some parameters were asked for.
pub(super) fn held(
    vehicle: &Vehicle,
    config: &IdentifyConfig,
    has: impl Fn(Quantity) -> bool,
    drive: LongitudinalInput,
    asked: &[Free],
) -> Vec<Free> {
    if config.parameters.is_empty() {
        return Vec::new();
    }
    let everything = IdentifyConfig { parameters: Vec::new(), ..config.clone() };
    let mut held = free(vehicle, &everything, has, drive).unwrap_or_default();
    held.retain(|free| !asked.iter().any(|asked| asked.parameters.overlaps(free.parameters)));
    held
}

/// Both axles' stiffnesses, each for itself; none where one alone could not be asked for.
pub(super) fn each_axle(
    vehicle: &Vehicle,
    config: &IdentifyConfig,
    has: impl Fn(Quantity) -> bool,
    drive: LongitudinalInput,
) -> Option<[Free; 2]> {
    let names =
        [Parameter::LateralFront, Parameter::LateralRear].map(|parameter| parameter.name().to_owned());
    let each = IdentifyConfig { parameters: names.to_vec(), ..config.clone() };
    free(vehicle, &each, has, drive).ok()?.try_into().ok()
}

/// What the sensors' data sheets say of their noise.
pub(super) fn first_noise(records: &[Record]) -> Noise {
    let std = |quantity: Quantity| {
        records.iter().map(|record| record.sensors.noise_std(quantity)).fold(0.0, f64::max).max(1e-6)
    };
    let wheel = |wheel: Wheel| std(Quantity::wheel_speed(wheel));
    [
        wheel(Wheel::Fl),
        wheel(Wheel::Fr),
        wheel(Wheel::Rl),
        wheel(Wheel::Rr),
        std(Quantity::YawRate),
        std(Quantity::LateralAcceleration),
        std(Quantity::LongitudinalAcceleration),
        0.3 * wheel(Wheel::Rl).max(wheel(Wheel::Fl)),
    ]
}
