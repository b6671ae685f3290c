//! A sample in the car's own terms: metres per second at the wheels, the angle of the road wheels.

use crate::model::{Bicycle, DrivenAxle, GRAVITY, Uncertain, Vehicle};
use crate::{Quantity, Sample, Wheel};

/// The vehicle's numbers that the estimators use, worked out once.
#[derive(Clone, Debug)]
pub struct Car {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of gravity to front axle, m.
    pub a: f64,
    /// Centre of gravity to rear axle, m.
    pub b: f64,
    /// Height of the centre of gravity, m.
    pub cg_height: f64,
    /// Yaw inertia, kg m², that of the spinning wheels included.
    pub yaw_inertia: f64,
    /// Nominal wheel radius, m.
    pub radius: f64,
    /// Wheel inertia, kg m².
    pub wheel_inertia: f64,
    /// Steering wheel angle per road wheel angle.
    pub steering_ratio: f64,
    /// Relative standard deviation of the steering ratio.
    pub steering_ratio_relative_std: f64,
    /// Relative standard deviation of the wheel radius.
    pub radius_relative_std: f64,
    /// Relative standard deviation of normalized forces from the drive torque: mass, radius, torque
    /// ratio and the driven wheels' share of the load.
    pub torque_scale_std: f64,
    /// … and from the acceleration, where the mass cancels out.
    pub acceleration_scale_std: f64,
    /// Relative standard deviation that the data sheet leaves to the cornering stiffnesses front and
    /// rear: the axles' share of the load, and a quarter of the yaw inertia's, which only counts while
    /// the yaw rate changes.
    pub cornering_scale_std: [f64; 2],
    /// Track widths front and rear, m.
    pub track: [f64; 2],
    /// Static load of one front and one rear wheel, N.
    pub wheel_load: [f64; 2],
    /// Which wheels are driven.
    pub driven_axle: DrivenAxle,
    /// Axle torque per unit of the `drive_torque` signal.
    pub drive_torque_ratio: f64,
    /// Air drag, kg/m.
    pub drag: f64,
    /// Rolling resistance, force per load.
    pub rolling_resistance: f64,
    /// Prior of the normalized cornering stiffness front and rear, 1/rad: value and std.
    pub cornering_prior: [(f64, f64); 2],
    /// Prior of the slope normalized by the wheel's own static load, front and rear: value and std.
    pub slope_prior: [(f64, f64); 2],
}

impl Car {
    /// Relative standard deviation of a yaw inertia that was not given. Tuned, no test on record.
    const GUESSED_INERTIA_STD: f64 = 0.1;

    /// From the configuration's `[vehicle]`.
    pub fn new(vehicle: &Vehicle) -> Self {
        let wheel_load = [vehicle.static_wheel_load(true), vehicle.static_wheel_load(false)];
        let slope_prior = wheel_load.map(|load| {
            let scale = 0.25 * vehicle.mass() * GRAVITY / load;
            let prior = vehicle.longitudinal_stiffness;
            (prior.value * scale, prior.std * scale)
        });
        let lateral = [vehicle.lateral_stiffness_front, vehicle.lateral_stiffness_rear];
        let relative = |u: Uncertain| u.std / u.value.abs();
        let lever = if vehicle.driven_axle == DrivenAxle::Front { vehicle.b() } else { vehicle.a() };
        let inertia = vehicle.yaw_inertia_kgm2.map_or(Self::GUESSED_INERTIA_STD, relative);
        let load_share = vehicle.cg_to_front_m.std / lever;
        let torque = relative(vehicle.mass_kg)
            .hypot(relative(vehicle.wheel_radius_m))
            .hypot(relative(vehicle.drive_torque_ratio));
        Self {
            cornering_scale_std: [vehicle.b(), vehicle.a()]
                .map(|lever| (vehicle.cg_to_front_m.std / lever).hypot(0.25 * inertia)),
            torque_scale_std: torque.hypot(load_share),
            acceleration_scale_std: load_share,
            mass: vehicle.mass(),
            a: vehicle.a(),
            b: vehicle.b(),
            cg_height: vehicle.cg_height_m.value,
            // When the car turns faster, the outer wheels must spin faster, too: their inertia adds to the
            // car's as if it sat at the contact points (3.6 % for the thesis's car).
            yaw_inertia: vehicle.yaw_inertia() + vehicle.spinning_inertia(),
            radius: vehicle.wheel_radius_m.value,
            wheel_inertia: vehicle.wheel_inertia_kgm2.value,
            steering_ratio: vehicle.steering_ratio.value,
            steering_ratio_relative_std: relative(vehicle.steering_ratio),
            radius_relative_std: relative(vehicle.wheel_radius_m),
            track: [vehicle.track_front_m.value, vehicle.track_rear_m.value],
            wheel_load,
            driven_axle: vehicle.driven_axle,
            drive_torque_ratio: vehicle.drive_torque_ratio.value,
            drag: vehicle.drag_coefficient_kg_per_m.value,
            rolling_resistance: vehicle.rolling_resistance.value,
            cornering_prior: lateral.map(|u| (u.value, u.std)),
            slope_prior,
        }
    }

    /// Relative standard deviation that all slopes of the car have in common: of the forces from the
    /// drive torque or from the acceleration.
    pub fn slope_scale_std(&self, forces_from_torque: bool) -> f64 {
        if forces_from_torque { self.torque_scale_std } else { self.acceleration_scale_std }
    }

    /// Force of all tires along the car over their load, from its acceleration (m/s²) and speed.
    pub fn longitudinal_force(&self, acceleration: f64, speed: f64) -> f64 {
        (acceleration + self.drag * speed * speed / self.mass) / GRAVITY
    }

    /// What each axle has of it, over its own load: drive forces act at the driven axle alone; brakes are laid out
    /// after the loads.
    pub fn axle_forces(&self, longitudinal: f64) -> [f64; 2] {
        match self.driven_axle {
            DrivenAxle::Front if longitudinal > 0.0 => [longitudinal * self.wheelbase() / self.b, 0.0],
            DrivenAxle::Rear if longitudinal > 0.0 => [0.0, longitudinal * self.wheelbase() / self.a],
            _ => [longitudinal; 2],
        }
    }

    /// Wheelbase, m.
    pub fn wheelbase(&self) -> f64 {
        self.a + self.b
    }

    /// The linear bicycle with these normalized cornering stiffnesses (1/rad).
    pub fn bicycle(&self, front: f64, rear: f64) -> Bicycle {
        Bicycle {
            mass: self.mass,
            yaw_inertia: self.yaw_inertia,
            a: self.a,
            b: self.b,
            front: 2.0 * front * self.wheel_load[0],
            rear: 2.0 * rear * self.wheel_load[1],
        }
    }

    /// Slip angles front and rear, rad, positive when they give a positive force (thesis 5.9); `angles` are those of the
    /// wheels of both axles, rad.
    pub fn slip_angles(&self, speed: f64, vy: f64, yaw_rate: f64, angles: [f64; 2]) -> [f64; 2] {
        let [front, rear] =
            [vy + self.a * yaw_rate, vy - self.b * yaw_rate].map(|across| (across / speed).atan());
        [angles[0] - front, angles[1] - rear]
    }

    /// Static load of a wheel, N.
    pub fn load(&self, wheel: Wheel) -> f64 {
        self.wheel_load[usize::from(!wheel.is_front())]
    }

    /// Share of its static load that a wheel loses (front) or gains (rear) per g of acceleration.
    pub fn load_transfer(&self, wheel: Wheel) -> f64 {
        self.cg_height / if wheel.is_front() { self.b } else { self.a }
    }

    /// Lateral position of a wheel, m, positive to the left.
    pub fn lateral_position(&self, wheel: Wheel) -> f64 {
        let half = 0.5 * self.track[usize::from(!wheel.is_front())];
        if wheel.is_left() { half } else { -half }
    }

    /// Lateral velocity at the centre of gravity in steady cornering, m/s: the rear tires' slip
    /// angle carries their share of the lateral acceleration.
    pub fn steady_lateral_velocity(&self, speed: f64, yaw_rate: f64, lateral_acceleration: f64) -> f64 {
        self.b * yaw_rate - speed * lateral_acceleration / (GRAVITY * self.cornering_prior[1].0)
    }

    /// Velocity along the wheel plane at `wheel`, m/s, from that of the centre of gravity.
    pub fn wheel_plane_speed(&self, wheel: Wheel, vx: f64, vy: f64, yaw_rate: f64, road_angle: f64) -> f64 {
        let vx_wheel = vx - yaw_rate * self.lateral_position(wheel);
        if wheel.is_front() {
            vx_wheel * road_angle.cos() + (vy + self.a * yaw_rate) * road_angle.sin()
        } else {
            vx_wheel
        }
    }

    /// The inverse of [`Self::wheel_plane_speed`] for a freely rolling wheel.
    pub fn forward_speed(
        &self,
        wheel: Wheel,
        plane_speed: f64,
        vy: f64,
        yaw_rate: f64,
        road_angle: f64,
    ) -> f64 {
        let vx_wheel = if wheel.is_front() {
            (plane_speed - (vy + self.a * yaw_rate) * road_angle.sin()) / road_angle.cos()
        } else {
            plane_speed
        };
        vx_wheel + yaw_rate * self.lateral_position(wheel)
    }
}

/// One sample in the car's terms. Absent inputs are absent here, too.
#[derive(Clone, Copy, Debug)]
pub struct Kinematics {
    /// Seconds since the sample before.
    pub elapsed_s: f64,
    /// Forward speed of the centre of gravity, m/s, from the wheels that are not driven.
    pub speed: Option<f64>,
    /// Circumferential speed of each wheel at nominal radius, m/s.
    pub wheels: Option<[f64; 4]>,
    /// Yaw rate, rad/s.
    pub yaw_rate: Option<f64>,
    /// Lateral acceleration, m/s².
    pub lateral_acceleration: Option<f64>,
    /// Longitudinal acceleration, m/s², where the bus has it.
    pub longitudinal_acceleration: Option<f64>,
    /// Angle of the road wheels, rad.
    pub road_angle: Option<f64>,
    /// Angle of the rear wheels, rad, where effects turn them.
    pub rear_angle: f64,
    /// Torque at the driven axle (or both), N m, where the bus has it.
    pub axle_torque: Option<f64>,
    /// Is the driver braking? `None` where the bus does not tell.
    pub braking: Option<bool>,
    /// Is the ABS intervening? `None` where the bus does not tell.
    pub abs: Option<bool>,
}

/// What every lateral estimator needs of a sample, all of it there and the car moving.
#[derive(Clone, Copy, Debug)]
pub struct Cornering {
    /// Forward speed, m/s.
    pub speed: f64,
    /// Yaw rate, rad/s.
    pub yaw_rate: f64,
    /// Lateral acceleration, m/s².
    pub lateral_acceleration: f64,
    /// Angle of the road wheels, rad.
    pub road_angle: f64,
}

/// What tells how a car turns: it need not have an accelerometer.
#[derive(Clone, Copy, Debug)]
pub struct Turning {
    /// Forward speed, m/s.
    pub speed: f64,
    /// Yaw rate, rad/s.
    pub yaw_rate: f64,
    /// Angle of the road wheels, rad.
    pub road_angle: f64,
    /// Lateral acceleration, m/s², where it is measured.
    pub lateral_acceleration: Option<f64>,
}

impl Kinematics {
    /// The turning as measured; `None` below `minimum_speed` (m/s) or if more than the acceleration is missing.
    pub fn turning(&self, minimum_speed: f64) -> Option<Turning> {
        Some(Turning {
            speed: self.speed.filter(|speed| *speed >= minimum_speed)?,
            yaw_rate: self.yaw_rate?,
            road_angle: self.road_angle?,
            lateral_acceleration: self.lateral_acceleration,
        })
    }

    /// The lateral motion as measured; `None` below `minimum_speed` (m/s) or if an input is missing.
    pub fn cornering(&self, minimum_speed: f64) -> Option<Cornering> {
        Some(Cornering {
            speed: self.speed.filter(|speed| *speed >= minimum_speed)?,
            yaw_rate: self.yaw_rate?,
            lateral_acceleration: self.lateral_acceleration?,
            road_angle: self.road_angle?,
        })
    }

    /// Brake pressure that counts as braking, bar. Tuned, no test on record: above the offset of a pressure sensor.
    const BRAKING_PRESSURE: f64 = 1.0;
    /// Brake torque (all wheels) that counts as braking, N m. Tuned, no test on record.
    const BRAKING_TORQUE: f64 = 40.0;

    /// Translates a sample of a car that has every sensor.
    pub fn new(sample: &Sample, car: &Car) -> Self {
        Self::of(sample, car, Heard::EVERYTHING)
    }

    /// Translates a sample. Driven wheels slip: they tell the speed only where nothing else does.
    pub fn of(sample: &Sample, car: &Car, heard: Heard) -> Self {
        let wheels = sample.wheel_speeds().map(|speeds| speeds.map(|omega| omega * car.radius));
        let yaw_rate = sample.get(Quantity::YawRate);
        let lateral_acceleration = sample.get(Quantity::LateralAcceleration);
        let road_angle = sample.get(Quantity::SteeringWheelAngle).map(|angle| angle / car.steering_ratio);
        Self {
            elapsed_s: sample.elapsed_s,
            speed: forward_speed(sample, car, heard, yaw_rate.unwrap_or(0.0), road_angle.unwrap_or(0.0)),
            wheels,
            yaw_rate,
            lateral_acceleration,
            longitudinal_acceleration: sample.get(Quantity::LongitudinalAcceleration),
            road_angle,
            rear_angle: 0.0,
            axle_torque: sample.get(Quantity::DriveTorque).map(|torque| torque * car.drive_torque_ratio),
            braking: Self::braking(sample),
            abs: sample.get(Quantity::AbsActive).map(|flag| flag > 0.5),
        }
    }

    /// The same for slip along the car, which does not need every sensor: wheels that the car does not tell of are
    /// not-a-number, and how sharp a curve is, speed times yaw rate tells where there is no lateral acceleration.
    #[must_use]
    pub fn along(&self, sample: &Sample, car: &Car, heard: Heard) -> Self {
        let of_wheel = |wheel: Wheel| {
            let quantity = Quantity::wheel_speed(wheel);
            let speed = sample.get(quantity).map(|omega| omega * car.radius);
            speed.or((!heard.has(quantity)).then_some(f64::NAN))
        };
        let some = || {
            let [fl, fr, rl, rr] = Wheel::ALL.map(of_wheel);
            Some([fl?, fr?, rl?, rr?])
        };
        Self { wheels: self.wheels.or_else(some), ..self.turned(heard) }
    }

    /// The same with speed times yaw rate for a lateral acceleration that the car does not have.
    #[must_use]
    pub fn turned(&self, heard: Heard) -> Self {
        let turning = || {
            if heard.has(Quantity::LateralAcceleration) { None } else { Some(self.speed? * self.yaw_rate?) }
        };
        Self { lateral_acceleration: self.lateral_acceleration.or_else(turning), ..*self }
    }

    fn braking(sample: &Sample) -> Option<bool> {
        let signs = [
            sample.get(Quantity::BrakeActive).map(|flag| flag > 0.5),
            sample.get(Quantity::BrakePressure).map(|bar| bar > Self::BRAKING_PRESSURE),
            sample.get(Quantity::BrakeTorque).map(|torque| torque.abs() > Self::BRAKING_TORQUE),
        ];
        signs.into_iter().flatten().reduce(|a, b| a || b)
    }
}

/// Mean over the wheels that roll freely, as far as their sensors speak; with all-wheel drive that of the slower
/// axle, which slips least when driving. Else as another unit computed it.
fn forward_speed(sample: &Sample, car: &Car, heard: Heard, yaw_rate: f64, road_angle: f64) -> Option<f64> {
    let vy = car.b * yaw_rate;
    let at = |wheel: Wheel| {
        let plane_speed = sample.get(Quantity::wheel_speed(wheel))? * car.radius;
        Some(car.forward_speed(wheel, plane_speed, vy, yaw_rate, road_angle))
    };
    let mean = |left: Wheel, right: Wheel| match (at(left), at(right)) {
        (Some(left), Some(right)) => Some(0.5 * (left + right)),
        (one, other) => one.or(other),
    };
    let (front, rear) = (|| mean(Wheel::Fl, Wheel::Fr), || mean(Wheel::Rl, Wheel::Rr));
    let heard_of =
        |left, right| heard.has(Quantity::wheel_speed(left)) || heard.has(Quantity::wheel_speed(right));
    let (has_front, has_rear) = (heard_of(Wheel::Fl, Wheel::Fr), heard_of(Wheel::Rl, Wheel::Rr));
    let rolling = match car.driven_axle {
        DrivenAxle::Front => rear(),
        DrivenAxle::Rear => front(),
        DrivenAxle::All if has_front && has_rear => front().zip(rear()).map(|(front, rear)| front.min(rear)),
        DrivenAxle::All => front().or_else(rear),
    };
    let last_resort = || match car.driven_axle {
        _ if heard.has(Quantity::VehicleSpeed) => None,
        DrivenAxle::Front if !has_rear => front(),
        DrivenAxle::Rear if !has_front => rear(),
        _ => None,
    };
    rolling.or(sample.get(Quantity::VehicleSpeed)).or_else(last_resort)
}

/// What has had a value since the start. A sensor that never had one, configured or not, is none that is late: the car
/// does not have it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Heard(u16);

impl Heard {
    /// Of a car that has every sensor.
    pub const EVERYTHING: Self = Self(u16::MAX);

    /// Takes note of what a sample has.
    #[inline]
    pub fn hear(&mut self, sample: &Sample) {
        self.0 |= sample.present();
    }

    /// As if this had never had one: nobody believes its sensor.
    #[must_use]
    pub const fn without(self, quantity: Quantity) -> Self {
        Self(self.0 & !quantity.bit())
    }

    /// Has it ever had a value?
    #[inline]
    pub const fn has(self, quantity: Quantity) -> bool {
        self.0 & quantity.bit() != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Micros;

    #[test]
    fn wheel_plane_speed_and_forward_speed_are_inverse() {
        let car = Car::new(&Vehicle::thesis());
        for wheel in Wheel::ALL {
            let plane = car.wheel_plane_speed(wheel, 20.0, -0.3, 0.4, 0.1);
            assert!((car.forward_speed(wheel, plane, -0.3, 0.4, 0.1) - 20.0).abs() < 1e-12);
        }
    }

    #[test]
    fn one_lost_wheel_leaves_the_speed() {
        let car = Car::new(&Vehicle { driven_axle: DrivenAxle::Rear, ..Vehicle::thesis() });
        let mut sample = Sample::empty(Micros(0), 0.01);
        sample.set(Quantity::YawRate, 0.3);
        for wheel in Wheel::ALL {
            let plane_speed = car.wheel_plane_speed(wheel, 20.0, car.b * 0.3, 0.3, 0.0);
            sample.set(Quantity::wheel_speed(wheel), plane_speed / car.radius);
        }
        let speed = |sample: &Sample| Kinematics::new(sample, &car).speed;
        assert!((speed(&sample).unwrap() - 20.0).abs() < 1e-9);
        sample.clear(Quantity::wheel_speed(Wheel::Fl));
        sample.clear(Quantity::wheel_speed(Wheel::Rr));
        assert!((speed(&sample).unwrap() - 20.0).abs() < 1e-9);
        // The rear wheels are driven: they tell no speed.
        sample.clear(Quantity::wheel_speed(Wheel::Fr));
        assert_eq!(speed(&sample), None);
    }

    #[test]
    fn what_the_car_has_tells_the_speed() {
        let car = Car::new(&Vehicle { driven_axle: DrivenAxle::Front, ..Vehicle::thesis() });
        let speed = |there: &[(Quantity, f64)]| {
            let mut sample = Sample::empty(Micros(0), 0.01);
            there.iter().for_each(|(quantity, value)| sample.set(*quantity, *value));
            let mut heard = Heard::default();
            heard.hear(&sample);
            Kinematics::of(&sample, &car, heard).speed
        };
        let (driven, free) =
            ((Quantity::WheelSpeedFl, 21.0 / car.radius), (Quantity::WheelSpeedRr, 20.0 / car.radius));
        let other = (Quantity::VehicleSpeed, 20.5);
        assert_eq!(speed(&[]), None);
        assert!((speed(&[driven, free, other]).unwrap() - 20.0).abs() < 1e-9);
        assert_eq!(speed(&[driven, other]), Some(20.5));
        assert!((speed(&[driven]).unwrap() - 21.0).abs() < 1e-9);
    }

    #[test]
    fn brakes_are_on_if_any_signal_says_so_and_unknown_without_one() {
        let car = Car::new(&Vehicle::thesis());
        let mut sample = Sample::empty(Micros(0), 0.01);
        assert_eq!(Kinematics::new(&sample, &car).braking, None);
        sample.set(Quantity::BrakeActive, 0.0);
        assert_eq!(Kinematics::new(&sample, &car).braking, Some(false));
        sample.set(Quantity::BrakePressure, 20.0);
        assert_eq!(Kinematics::new(&sample, &car).braking, Some(true));
    }
}
