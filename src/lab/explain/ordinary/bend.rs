//! How the tires of an ordinary car bend, whatever the table says of them.

use physics::model::{TireKind, Uncertain, Vehicle};

/// The magic formula's shape for lateral force where no table has it: 1.3 (Bakker, Nyborg & Pacejka 1987), and what cars
/// differ by.
const SHAPE: Uncertain = Uncertain { value: 1.3, std: 0.15 };

/// Friction where the table has tires without a limit: of dry asphalt 0.8 to 1.2 (Reimpell, The Automotive Chassis, ch. 2), of
/// a race car's tires to 1.7.
const FRICTION: Uncertain = Uncertain { value: 1.0, std: 0.3 };

/// Every tire bends before its limit; with a shape of its own the curve is between a line and a brush.
pub fn with_bend(vehicle: &Vehicle) -> Vehicle {
    let mut own = with_limit(vehicle);
    if own.tire != TireKind::MagicFormula {
        own.tire = TireKind::MagicFormula;
        own.magic_formula_shape = SHAPE;
        own.magic_formula_curvature = Uncertain::known(0.0);
    }
    own
}

/// A table of tires without a limit says nothing of it.
fn with_limit(vehicle: &Vehicle) -> Vehicle {
    let mut own = vehicle.clone();
    if own.tire == TireKind::Linear {
        own.friction = FRICTION;
    }
    own
}

/// A vehicle with tires that bend before their limit. How is seen in most drives as a number of the tire at best; where the noise
/// is small it is seen that a brush's stiffness falls in proportion to the force, that of the magic formula with its square.
pub struct Bent {
    /// [`with_bend`].
    pub(in crate::explain) smooth: Vehicle,
    /// None where the table itself has a magic formula.
    pub(in crate::explain) brush: Option<Vehicle>,
}

impl Bent {
    /// Of this vehicle.
    pub fn of(vehicle: &Vehicle) -> Self {
        let is_told = vehicle.tire == TireKind::MagicFormula;
        let brush = (!is_told).then(|| Vehicle { tire: TireKind::Brush, ..with_limit(vehicle) });
        Self { smooth: with_bend(vehicle), brush }
    }
}
