//! One wheel that carries its share of the car, on a Dahl tire (thesis 8.6; methods.md §8).

use super::tire::DahlTire;

/// m v̇ = F, J ω̇ = τ − r0 F, F = F_N σ0 z, with the deflection z of [`DahlTire`].
///
/// The thesis's (8.6) leaves the normal load out of the limit of z and has σ0 in N/m; here σ0 and μ are
/// both per normal load ([`DahlTire::stiffness`]), so that its σ0 is `load * tire.stiffness`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneWheel {
    /// The tire.
    pub tire: DahlTire,
    /// Mass of the vehicle per driven wheel, kg.
    pub mass: f64,
    /// Normal load of the wheel, N.
    pub load: f64,
    /// Inertia of the wheel, kg m².
    pub inertia: f64,
    /// Rolling radius, m.
    pub radius: f64,
}

/// What the equations integrate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OneWheelState {
    /// z, m.
    pub deflection: f64,
    /// v, m/s.
    pub speed: f64,
    /// ω, rad/s.
    pub wheel_speed: f64,
}

impl OneWheelState {
    #[inline]
    fn advanced(&self, rate: &Self, h: f64) -> Self {
        Self {
            deflection: self.deflection + h * rate.deflection,
            speed: self.speed + h * rate.speed,
            wheel_speed: self.wheel_speed + h * rate.wheel_speed,
        }
    }
}

impl OneWheel {
    /// Fastest rate times substep: the swing is hardly damped, so this keeps its amplitude to 1e-6 each.
    const RATE_TIMES_STEP: f64 = 0.2;

    /// Free rolling at `speed`, m/s.
    pub fn rolling(&self, speed: f64) -> OneWheelState {
        OneWheelState { deflection: 0.0, speed, wheel_speed: speed / self.radius }
    }

    /// Derivative of the state under `torque`, N m, on a surface of this friction.
    #[inline]
    pub fn rate(&self, state: &OneWheelState, torque: f64, friction: f64) -> OneWheelState {
        let force = self.load * self.tire.force(state.deflection);
        OneWheelState {
            deflection: self.tire.rate(
                friction,
                state.deflection,
                self.radius * state.wheel_speed,
                state.speed,
            ),
            speed: force / self.mass,
            wheel_speed: (torque - self.radius * force) / self.inertia,
        }
    }

    /// A bound of the fastest rate, 1/s: the tire's forgetting, and wheel and car swinging against each
    /// other on its spring, √(F_N σ0 (r0²/J + 1/m)).
    pub fn fastest_rate(&self, state: &OneWheelState, friction: f64) -> f64 {
        let swing =
            self.load * self.tire.stiffness * (self.radius * self.radius / self.inertia + self.mass.recip());
        self.tire.decay(friction, self.radius * state.wheel_speed, state.speed) + swing.sqrt()
    }

    /// The state after `step` seconds of constant torque: RK4, in substeps that the fastest rate allows
    /// (at most one hundred thousand, where a spinning wheel asks for more it is less exact).
    pub fn advance(&self, state: &OneWheelState, torque: f64, friction: f64, step: f64) -> OneWheelState {
        let wanted = self.fastest_rate(state, friction) * step / Self::RATE_TIMES_STEP;
        let substeps = (wanted.ceil() as u32).clamp(1, 100_000);
        let h = step / f64::from(substeps);
        (0..substeps).fold(*state, |state, _| {
            let k1 = self.rate(&state, torque, friction);
            let k2 = self.rate(&state.advanced(&k1, 0.5 * h), torque, friction);
            let k3 = self.rate(&state.advanced(&k2, 0.5 * h), torque, friction);
            let k4 = self.rate(&state.advanced(&k3, h), torque, friction);
            state.advanced(&k1, h / 6.0).advanced(&k2, h / 3.0).advanced(&k3, h / 3.0).advanced(&k4, h / 6.0)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plant(tire: DahlTire) -> OneWheel {
        OneWheel { tire, mass: 850.0, load: 4170.0, inertia: 2.65, radius: 0.31 }
    }

    fn drive(plant: &OneWheel, torque: f64, friction: f64, seconds: f64) -> OneWheelState {
        let steps = (seconds / 0.01).round() as u32;
        (0..steps).fold(plant.rolling(10.0), |state, _| plant.advance(&state, torque, friction, 0.01))
    }

    #[test]
    fn torque_accelerates_mass_and_wheel_together() {
        for tire in [DahlTire::dragged(250.0), DahlTire::rolling(50.0, 0.2)] {
            let plant = plant(tire);
            let end = drive(&plant, 200.0, 1.0, 10.0);
            let force = 200.0 / (plant.radius + plant.inertia / (plant.mass * plant.radius));
            let gained = force / plant.mass * 10.0;
            assert!((end.speed - 10.0 - gained).abs() < 0.01 * gained, "{tire:?}: {end:?}");
        }
    }

    #[test]
    fn too_much_torque_spins_the_wheel_and_pushes_with_mu() {
        let plant = plant(DahlTire::dragged(250.0));
        let end = drive(&plant, 600.0, 0.3, 3.0);
        assert!(plant.radius * end.wheel_speed > 1.5 * end.speed, "{end:?}");
        let acceleration = (end.speed - 10.0) / 3.0;
        assert!((acceleration - 0.3 * plant.load / plant.mass).abs() < 0.02, "{acceleration}");
    }

    /// The thesis's tire reaches a slip of its own only by creeping: whatever the friction, the force
    /// is that of the torque and the steady slip is none. This is why (8.6) cannot show its friction.
    #[test]
    fn dragged_its_slip_dies_out_and_tells_nothing() {
        let slip = |friction: f64| {
            let plant = plant(DahlTire::dragged(250.0));
            let state = drive(&plant, 200.0, friction, 60.0);
            (plant.radius * state.wheel_speed - state.speed) / state.speed
        };
        let (low, high) = (slip(0.5), slip(1.0));
        assert!(low.abs() < 1e-4 && high.abs() < 1e-4, "{low} {high}");
    }

    #[test]
    fn coarse_steps_are_as_good_as_fine_ones() {
        let plant = plant(DahlTire::rolling(50.0, 0.2));
        let start = plant.rolling(10.0);
        let reference = (0..10_000).fold(start, |state, _| plant.advance(&state, 300.0, 0.8, 1e-5));
        let coarse = (0..10).fold(start, |state, _| plant.advance(&state, 300.0, 0.8, 0.01));
        assert!((coarse.deflection - reference.deflection).abs() < 1e-7, "{coarse:?} {reference:?}");
        assert!((coarse.wheel_speed - reference.wheel_speed).abs() < 1e-4, "{coarse:?} {reference:?}");
    }
}
