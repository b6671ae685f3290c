//! What can be identified: the vehicle's named numbers, and the offsets of its sensors.

use super::longitudinal_input::LongitudinalInput;
use physics::model::{DrivenAxle, TireKind, Uncertain, Vehicle};
use physics::{Quantity, Wheel};

/// A number of the car's equations. The first ones are the `[vehicle]` table's keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[allow(missing_docs, reason = "each is explained by its name, see Parameter::name and Parameter::unit")]
#[repr(u8)]
pub enum Parameter {
    Mass,
    Wheelbase,
    CgToFront,
    YawInertia,
    TrackFront,
    TrackRear,
    WheelRadius,
    WheelInertia,
    SteeringRatio,
    DriveTorqueRatio,
    BrakePerBarFront,
    BrakePerBarRear,
    Drag,
    RollingResistance,
    Friction,
    MagicShape,
    MagicCurvature,
    LateralFront,
    LateralRear,
    Longitudinal,
    YawRateOffset,
    LateralAccelerationOffset,
    LongitudinalAccelerationOffset,
    SteeringOffset,
    SlipOffsetFl,
    SlipOffsetFr,
    SlipOffsetRl,
    SlipOffsetRr,
}

impl Parameter {
    /// How many there are.
    pub const COUNT: usize = 28;

    /// All of them, in the order of their places in [`Values`].
    pub const ALL: [Parameter; Self::COUNT] = [
        Self::Mass,
        Self::Wheelbase,
        Self::CgToFront,
        Self::YawInertia,
        Self::TrackFront,
        Self::TrackRear,
        Self::WheelRadius,
        Self::WheelInertia,
        Self::SteeringRatio,
        Self::DriveTorqueRatio,
        Self::BrakePerBarFront,
        Self::BrakePerBarRear,
        Self::Drag,
        Self::RollingResistance,
        Self::Friction,
        Self::MagicShape,
        Self::MagicCurvature,
        Self::LateralFront,
        Self::LateralRear,
        Self::Longitudinal,
        Self::YawRateOffset,
        Self::LateralAccelerationOffset,
        Self::LongitudinalAccelerationOffset,
        Self::SteeringOffset,
        Self::SlipOffsetFl,
        Self::SlipOffsetFr,
        Self::SlipOffsetRl,
        Self::SlipOffsetRr,
    ];

    /// Its name: of the vehicle's numbers the key in `[vehicle]`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mass => "mass_kg",
            Self::Wheelbase => "wheelbase_m",
            Self::CgToFront => "cg_to_front_m",
            Self::YawInertia => "yaw_inertia_kgm2",
            Self::TrackFront => "track_front_m",
            Self::TrackRear => "track_rear_m",
            Self::WheelRadius => "wheel_radius_m",
            Self::WheelInertia => "wheel_inertia_kgm2",
            Self::SteeringRatio => "steering_ratio",
            Self::DriveTorqueRatio => "drive_torque_ratio",
            Self::BrakePerBarFront => "brake_torque_per_bar_front_nm",
            Self::BrakePerBarRear => "brake_torque_per_bar_rear_nm",
            Self::Drag => "drag_coefficient_kg_per_m",
            Self::RollingResistance => "rolling_resistance",
            Self::Friction => "friction",
            Self::MagicShape => "magic_formula_shape",
            Self::MagicCurvature => "magic_formula_curvature",
            Self::LateralFront => "lateral_stiffness_front",
            Self::LateralRear => "lateral_stiffness_rear",
            Self::Longitudinal => "longitudinal_stiffness",
            Self::YawRateOffset => "yaw_rate_offset",
            Self::LateralAccelerationOffset => "lateral_acceleration_offset",
            Self::LongitudinalAccelerationOffset => "longitudinal_acceleration_offset",
            Self::SteeringOffset => "steering_wheel_angle_offset",
            Self::SlipOffsetFl => "slip_offset_fl",
            Self::SlipOffsetFr => "slip_offset_fr",
            Self::SlipOffsetRl => "slip_offset_rl",
            Self::SlipOffsetRr => "slip_offset_rr",
        }
    }

    /// Its unit; 1 for ratios.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Mass => "kg",
            Self::Wheelbase | Self::CgToFront | Self::TrackFront | Self::TrackRear | Self::WheelRadius => "m",
            Self::YawInertia | Self::WheelInertia => "kg m²",
            Self::BrakePerBarFront | Self::BrakePerBarRear => "N m/bar",
            Self::Drag => "kg/m",
            Self::LateralFront | Self::LateralRear => "1/rad",
            Self::YawRateOffset => "rad/s",
            Self::LateralAccelerationOffset | Self::LongitudinalAccelerationOffset => "m/s²",
            Self::SteeringOffset => "rad",
            Self::SteeringRatio
            | Self::DriveTorqueRatio
            | Self::RollingResistance
            | Self::Friction
            | Self::MagicShape
            | Self::MagicCurvature
            | Self::Longitudinal
            | Self::SlipOffsetFl
            | Self::SlipOffsetFr
            | Self::SlipOffsetRl
            | Self::SlipOffsetRr => "1",
        }
    }

    /// The parameter of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|parameter| parameter.name() == name)
    }

    /// Is it of a sensor rather than of the vehicle?
    pub const fn is_offset(self) -> bool {
        self as u8 >= Self::YawRateOffset as u8
    }

    /// Is its logarithm what is searched for? So a search from far away cannot leave the possible, and
    /// a step means the same at 10⁴ and at 10⁶.
    pub(super) const fn is_logarithmic(self) -> bool {
        !self.is_offset()
            && !matches!(
                self,
                Self::DriveTorqueRatio | Self::Drag | Self::RollingResistance | Self::MagicCurvature
            )
    }

    /// The step by which a search would first try it, in its unit (linear ones only).
    pub(super) const fn scale(self) -> f64 {
        match self {
            Self::DriveTorqueRatio | Self::Drag => 0.1,
            Self::RollingResistance => 0.005,
            Self::MagicCurvature => 0.5,
            Self::YawRateOffset => 0.01,
            Self::LateralAccelerationOffset | Self::LongitudinalAccelerationOffset => 0.2,
            Self::SteeringOffset => 0.05,
            Self::SlipOffsetFl | Self::SlipOffsetFr | Self::SlipOffsetRl | Self::SlipOffsetRr => 0.01,
            _ => 1.0,
        }
    }

    /// What it can be at all.
    pub const fn bounds(self) -> (f64, f64) {
        match self {
            Self::Mass => (100.0, 60_000.0),
            Self::Wheelbase => (0.8, 12.0),
            Self::CgToFront => (0.2, 10.0),
            Self::YawInertia => (50.0, 500_000.0),
            Self::TrackFront | Self::TrackRear => (0.5, 3.0),
            Self::WheelRadius => (0.1, 0.8),
            Self::WheelInertia => (0.05, 50.0),
            Self::SteeringRatio => (0.5, 60.0),
            Self::DriveTorqueRatio => (-1e3, 1e3),
            Self::BrakePerBarFront | Self::BrakePerBarRear => (0.5, 500.0),
            Self::Drag => (0.0, 10.0),
            Self::RollingResistance => (0.0, 0.2),
            Self::Friction => (0.02, 3.0),
            Self::MagicShape => (0.5, 2.0),
            Self::MagicCurvature => (-20.0, 1.0),
            Self::LateralFront | Self::LateralRear => (0.5, 100.0),
            Self::Longitudinal => (2.0, 1000.0),
            Self::YawRateOffset => (-0.5, 0.5),
            Self::LateralAccelerationOffset | Self::LongitudinalAccelerationOffset => (-6.0, 6.0),
            Self::SteeringOffset => (-3.0, 3.0),
            Self::SlipOffsetFl | Self::SlipOffsetFr | Self::SlipOffsetRl | Self::SlipOffsetRr => (-0.2, 0.2),
        }
    }

    /// What it can be in a car of the table's size and mass (L: wheelbase); the table's own value is never outside.
    /// Masses lie between a car's bumpers, 1.7 L apart: spread evenly they make a yaw inertia of 0.24 m L², spread between
    /// the axles only 0.08, all of them at the bumpers 0.72, which 0.5 is well on the way to. An axle that carries less than
    /// a quarter of the car hardly steers or drives it. A cornering stiffness of 60 gives 1 g at one degree of slip angle,
    /// which the tires of race cars do not reach.
    pub fn bounds_in(self, vehicle: &Vehicle) -> (f64, f64) {
        let (low, high) = self.bounds();
        let length = vehicle.wheelbase_m.value;
        let (least, most) = match self {
            Self::CgToFront => (0.25 * length, 0.75 * length),
            Self::YawInertia => {
                let all_at_one = vehicle.mass_kg.value * length * length;
                (0.08 * all_at_one, 0.5 * all_at_one)
            }
            Self::LateralFront | Self::LateralRear => (low, 60.0),
            _ => return (low, high),
        };
        let table = self.prior(vehicle);
        let (from, to) = (table.value - table.std, table.value + table.std);
        (least.min(from).max(low), most.max(to).min(high))
    }

    /// What may be behind a number that is far from its table's.
    pub const fn what_else(self) -> &'static str {
        match self {
            Self::CgToFront
            | Self::YawInertia
            | Self::LateralFront
            | Self::LateralRear
            | Self::SteeringRatio => {
                "a table that is of another car; scale, delay or steps of steering angle or yaw rate (`gripd check`); a drive \
                 with hardly any curves; or physics that these equations lack (`gripd explain`)"
            }
            Self::Friction | Self::MagicShape | Self::MagicCurvature => {
                "a drive that never comes near the limit, or physics that these equations lack (`gripd explain`)"
            }
            Self::Wheelbase | Self::TrackFront | Self::TrackRear | Self::WheelRadius | Self::WheelInertia => {
                "a table that is of another car, or the scale of wheel speeds or yaw rate (`gripd check`)"
            }
            Self::YawRateOffset
            | Self::LateralAccelerationOffset
            | Self::LongitudinalAccelerationOffset
            | Self::SteeringOffset
            | Self::SlipOffsetFl
            | Self::SlipOffsetFr
            | Self::SlipOffsetRl
            | Self::SlipOffsetRr => "a wrong unit, sign or offset of the sensor (`gripd check`)",
            _ => {
                "a table that is of another car or another load; the scale of torque, pressure or acceleration (`gripd \
                 check`); or hills, which these equations do not know (`gripd explain`)"
            }
        }
    }

    /// What the vehicle's table says of it; offsets are near zero, as far as sensors go.
    pub fn prior(self, vehicle: &Vehicle) -> Uncertain {
        let own = |value: Option<Uncertain>| value.unwrap_or(Uncertain::known(f64::NAN));
        match self {
            Self::Mass => vehicle.mass_kg,
            Self::Wheelbase => vehicle.wheelbase_m,
            Self::CgToFront => vehicle.cg_to_front_m,
            // Not given, it is m a b, and as uncertain as that rule is.
            Self::YawInertia => vehicle
                .yaw_inertia_kgm2
                .unwrap_or(Uncertain { value: vehicle.yaw_inertia(), std: 0.15 * vehicle.yaw_inertia() }),
            Self::TrackFront => vehicle.track_front_m,
            Self::TrackRear => vehicle.track_rear_m,
            Self::WheelRadius => vehicle.wheel_radius_m,
            Self::WheelInertia => vehicle.wheel_inertia_kgm2,
            Self::SteeringRatio => vehicle.steering_ratio,
            Self::DriveTorqueRatio => vehicle.drive_torque_ratio,
            Self::BrakePerBarFront => own(vehicle.brake_torque_per_bar_front_nm),
            Self::BrakePerBarRear => own(vehicle.brake_torque_per_bar_rear_nm),
            Self::Drag => vehicle.drag_coefficient_kg_per_m,
            Self::RollingResistance => vehicle.rolling_resistance,
            Self::Friction => vehicle.friction,
            Self::MagicShape => vehicle.magic_formula_shape,
            Self::MagicCurvature => vehicle.magic_formula_curvature,
            Self::LateralFront => vehicle.lateral_stiffness_front,
            Self::LateralRear => vehicle.lateral_stiffness_rear,
            Self::Longitudinal => vehicle.longitudinal_stiffness,
            Self::YawRateOffset => Uncertain { value: 0.0, std: 0.02 },
            Self::LateralAccelerationOffset | Self::LongitudinalAccelerationOffset => {
                Uncertain { value: 0.0, std: 0.4 }
            }
            Self::SteeringOffset => Uncertain { value: 0.0, std: 0.1 },
            Self::SlipOffsetFl | Self::SlipOffsetFr | Self::SlipOffsetRl | Self::SlipOffsetRr => {
                Uncertain { value: 0.0, std: 0.015 }
            }
        }
    }

    /// Do the equations use it, and do the sensors see it?
    pub fn is_used(
        self,
        vehicle: &Vehicle,
        drive: LongitudinalInput,
        has: impl Fn(Quantity) -> bool,
    ) -> bool {
        let moves_as_measured = drive == LongitudinalInput::Speed;
        match self {
            Self::MagicShape | Self::MagicCurvature => vehicle.tire == TireKind::MagicFormula,
            Self::Friction => vehicle.tire != TireKind::Linear,
            Self::DriveTorqueRatio => drive == LongitudinalInput::Torque,
            Self::BrakePerBarFront | Self::BrakePerBarRear => {
                drive == LongitudinalInput::Torque && has(Quantity::BrakePressure)
            }
            Self::YawRateOffset => has(Quantity::YawRate),
            Self::LateralAccelerationOffset => has(Quantity::LateralAcceleration),
            Self::LongitudinalAccelerationOffset => {
                !drive.prescribes_acceleration() && has(Quantity::LongitudinalAcceleration)
            }
            Self::SteeringOffset => has(Quantity::SteeringWheelAngle),
            Self::Longitudinal | Self::Drag | Self::RollingResistance => !moves_as_measured,
            Self::WheelRadius | Self::WheelInertia => !moves_as_measured,
            Self::SlipOffsetFl | Self::SlipOffsetFr | Self::SlipOffsetRl | Self::SlipOffsetRr => {
                let is_there = Wheel::ALL
                    .into_iter()
                    .any(|wheel| Self::slip_offset(wheel) == self && has(Quantity::wheel_speed(wheel)));
                is_there && !moves_as_measured
            }
            _ => true,
        }
    }

    /// What is free where nobody says otherwise: all that the vehicle's table calls uncertain and the
    /// equations use, and the offsets of the sensors there are.
    pub fn usual(vehicle: &Vehicle, drive: LongitudinalInput, has: impl Fn(Quantity) -> bool) -> Vec<Self> {
        let is_free = |parameter: &Self| {
            // One radius is the nominal one; the undriven wheels (rear, where all are driven) set it.
            let sets_the_radius = match parameter {
                Self::SlipOffsetFl | Self::SlipOffsetFr => vehicle.driven_axle == DrivenAxle::Rear,
                Self::SlipOffsetRl | Self::SlipOffsetRr => vehicle.driven_axle != DrivenAxle::Rear,
                _ => false,
            };
            let is_uncertain = parameter.prior(vehicle).std > 0.0;
            is_uncertain && !sets_the_radius && parameter.is_used(vehicle, drive, &has)
        };
        Self::ALL.into_iter().filter(is_free).collect()
    }

    /// The slip offset of a wheel.
    pub const fn slip_offset(wheel: Wheel) -> Self {
        match wheel {
            Wheel::Fl => Self::SlipOffsetFl,
            Wheel::Fr => Self::SlipOffsetFr,
            Wheel::Rl => Self::SlipOffsetRl,
            Wheel::Rr => Self::SlipOffsetRr,
        }
    }
}

/// A number for each parameter, in its unit.
#[derive(Clone, Debug)]
pub struct Values(pub [f64; Parameter::COUNT]);

/// What neither knows (not-a-number) is the same.
impl PartialEq for Values {
    fn eq(&self, other: &Self) -> bool {
        self.0.iter().zip(&other.0).all(|(one, another)| one == another || one.is_nan() && another.is_nan())
    }
}

impl Values {
    /// What the vehicle's table says; no offsets.
    pub fn of(vehicle: &Vehicle) -> Self {
        Self(Parameter::ALL.map(|parameter| parameter.prior(vehicle).value))
    }

    /// One of them.
    pub fn get(&self, parameter: Parameter) -> f64 {
        self.0[parameter as usize]
    }

    /// Sets one of them.
    pub fn set(&mut self, parameter: Parameter, value: f64) {
        self.0[parameter as usize] = value;
    }

    /// The vehicle with these numbers; their standard deviations stay.
    pub fn apply_to(&self, vehicle: &Vehicle) -> Vehicle {
        let mut vehicle = vehicle.clone();
        let put = |place: &mut Uncertain, parameter| place.value = self.get(parameter);
        put(&mut vehicle.mass_kg, Parameter::Mass);
        put(&mut vehicle.wheelbase_m, Parameter::Wheelbase);
        put(&mut vehicle.cg_to_front_m, Parameter::CgToFront);
        let std = vehicle.yaw_inertia_kgm2.map_or(0.0, |inertia| inertia.std);
        vehicle.yaw_inertia_kgm2 = Some(Uncertain { value: self.get(Parameter::YawInertia), std });
        put(&mut vehicle.track_front_m, Parameter::TrackFront);
        put(&mut vehicle.track_rear_m, Parameter::TrackRear);
        put(&mut vehicle.wheel_radius_m, Parameter::WheelRadius);
        put(&mut vehicle.wheel_inertia_kgm2, Parameter::WheelInertia);
        put(&mut vehicle.steering_ratio, Parameter::SteeringRatio);
        put(&mut vehicle.drive_torque_ratio, Parameter::DriveTorqueRatio);
        for (place, parameter) in [
            (&mut vehicle.brake_torque_per_bar_front_nm, Parameter::BrakePerBarFront),
            (&mut vehicle.brake_torque_per_bar_rear_nm, Parameter::BrakePerBarRear),
        ] {
            if let Some(place) = place {
                place.value = self.get(parameter);
            }
        }
        put(&mut vehicle.drag_coefficient_kg_per_m, Parameter::Drag);
        put(&mut vehicle.rolling_resistance, Parameter::RollingResistance);
        put(&mut vehicle.friction, Parameter::Friction);
        put(&mut vehicle.magic_formula_shape, Parameter::MagicShape);
        put(&mut vehicle.magic_formula_curvature, Parameter::MagicCurvature);
        put(&mut vehicle.lateral_stiffness_front, Parameter::LateralFront);
        put(&mut vehicle.lateral_stiffness_rear, Parameter::LateralRear);
        put(&mut vehicle.longitudinal_stiffness, Parameter::Longitudinal);
        vehicle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_names_agree() {
        for (place, parameter) in Parameter::ALL.into_iter().enumerate() {
            assert_eq!(parameter as usize, place);
            assert_eq!(Parameter::named(parameter.name()), Some(parameter));
        }
        let vehicle = Vehicle::thesis();
        for (name, value) in vehicle.parameters() {
            // The height of the centre of gravity is no number of the planar car's equations.
            let Some(parameter) = Parameter::named(name) else {
                assert_eq!(name, "cg_height_m");
                continue;
            };
            assert_eq!(parameter.prior(&vehicle), value);
        }
    }

    #[test]
    fn values_go_into_a_vehicle_and_come_back() {
        let mut values = Values::of(&Vehicle::thesis());
        for parameter in Parameter::ALL.into_iter().filter(|parameter| !parameter.is_offset()) {
            let value = values.get(parameter);
            values.set(parameter, 1.01 * value);
        }
        let again = Values::of(&values.apply_to(&Vehicle::thesis()));
        for parameter in Parameter::ALL.into_iter().filter(|parameter| !parameter.is_offset()) {
            let (a, b) = (again.get(parameter), values.get(parameter));
            assert!(a == b || (a.is_nan() && b.is_nan()), "{}", parameter.name());
        }
    }
}
