//! Numbers of the car, and of how its speed is measured, that are others than in references or in somebody's simulation.

use super::super::fit::FreeFit;
use super::super::numbers::{DELAY, Free, Number, Scope};
use super::trial::What;
use crate::explain::model::Place;
use identify::Parameter;
use physics::Quantity;

/// Numbers of a car that wear, load and repair change, and by what share they may. Its mass is the payload's, its centre of
/// gravity moves with that, a changed friction is the road's, and a changed ratio of the steering is the scale of its
/// sensor.
const CHANGING: [(Parameter, f64); 3] =
    [(Parameter::LateralFront, 0.2), (Parameter::LateralRear, 0.2), (Parameter::SteeringRatio, 0.1)];

/// A number of the car as one that could have changed.
pub fn changed(found: &FreeFit<'_>, (free, at): (&Free, f64), of: Scope) -> Option<What> {
    let Number::Of(place) = free.number else { return None };
    if free.of != Scope::Car {
        return None;
    }
    let std = match place {
        // The search is for its logarithm.
        Place::Ordinary(parameter) => match CHANGING.iter().find(|(of, _)| *of == parameter) {
            Some((_, std)) => *std,
            // Of somebody's simulation any number may be wrong.
            None if of == Scope::Since(0) => free.prior.1,
            None => return None,
        },
        // What breaks or is replaced may be further off than cars of the class are from each other.
        Place::Effect(..) => 2.0 * free.prior.1,
        Place::Delay(_) | Place::BendAlong | Place::Course(..) => return None,
    };
    let name = match place {
        Place::Ordinary(Parameter::SteeringRatio) => format!("sensor_scale:{}", Quantity::SteeringWheelAngle),
        _ => free.named(&found.model, free.prior.0).0,
    };
    let mut bounds = (-MOST_CHANGE * std, MOST_CHANGE * std);
    // A simulation may have none of what every car has, and no car has less than none.
    if of == Scope::Since(0) && matches!(place, Place::Effect(..)) {
        bounds = (bounds.0.max(free.bounds.0 - at).min(0.0), bounds.1.min(free.bounds.1 - at).max(0.0));
    }
    let change = Free { number: Number::Change(place), of, prior: (0.0, std), bounds, step: free.step };
    Some(What::Number { name, change })
}

/// Is a changed number named as what a sensor does?
pub fn is_of_sensor(name: &str) -> bool {
    name.contains(':')
}

/// A tire's radius loses 2 % over its life.
const WEAR: f64 = 0.015;

/// All radii, or the message of the speed.
pub fn speed_changed(of: Scope) -> [What; 2] {
    let speed = Quantity::VehicleSpeed;
    let scale = (Number::SpeedScaleChange, format!("sensor_scale:{speed}"), WEAR);
    let delay = (Number::SpeedDelayChange, format!("sensor_delay:{speed}"), DELAY.1);
    [scale, delay].map(|(number, name, std)| {
        let bounds = (-MOST_CHANGE * std, MOST_CHANGE * std);
        What::Number { name, change: Free { number, of, prior: (0.0, std), bounds, step: 1e-3 } }
    })
}

/// No number changes by more of its deviations. Numerical.
const MOST_CHANGE: f64 = 5.0;
