//! The Dahl model (thesis 3.1).

use super::{DynamicFriction, sign};

/// dF/dx = σ0 |1 − F sgn(v)/F_C|^α sgn(1 − F sgn(v)/F_C): a spring that yields as it nears Coulomb
/// friction. With α = 1 this is ż = v − σ0 |v| z/F_C, F = σ0 z.
///
/// The force depends on the way only, not on how fast it is gone (rate independence); there is no
/// stiction and no viscous part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dahl {
    /// σ0: force per m of deflection at no force.
    pub stiffness: f64,
    /// F_C: the force of steady sliding.
    pub sliding: f64,
    /// α: 1 as a rule; below 1 sliding is reached after a finite way (brittle), above 1 later (ductile).
    pub exponent: f64,
}

impl Dahl {
    /// With α = 1.
    pub fn new(stiffness: f64, sliding: f64) -> Self {
        Self { stiffness, sliding, exponent: 1.0 }
    }

    /// 1 − F sgn(v)/F_C: 1 without force, 0 in steady sliding, 2 just after it turned round.
    #[inline]
    fn reserve(&self, deflection: f64, direction: f64) -> f64 {
        1.0 - self.stiffness * deflection * direction / self.sliding
    }

    /// What is left of the reserve after a way, m.
    #[inline]
    fn reserve_after(&self, reserve: f64, way: f64) -> f64 {
        let yielded = self.stiffness * way / self.sliding;
        if self.exponent == 1.0 {
            return reserve * (-yielded).exp();
        }
        // du/dq = −|u|^α sgn u: |u|^(1−α) is linear in q.
        let power = 1.0 - self.exponent;
        let left = reserve.abs().powf(power) - power * yielded;
        if left > 0.0 && reserve != 0.0 { left.powf(power.recip()) * sign(reserve) } else { 0.0 }
    }
}

impl DynamicFriction for Dahl {
    #[inline]
    fn rate(&self, deflection: f64, velocity: f64) -> f64 {
        let reserve = self.reserve(deflection, sign(velocity));
        let yielding = if self.exponent == 1.0 { reserve.abs() } else { reserve.abs().powf(self.exponent) };
        velocity * yielding * sign(reserve)
    }

    #[inline]
    fn force(&self, deflection: f64, _velocity: f64) -> f64 {
        self.stiffness * deflection
    }

    fn steady_deflection(&self, velocity: f64) -> f64 {
        sign(velocity) * self.sliding / self.stiffness
    }

    #[inline]
    fn advance(&self, deflection: f64, velocity: f64, step: f64) -> f64 {
        let direction = sign(velocity);
        if direction == 0.0 {
            return deflection;
        }
        let reserve = self.reserve_after(self.reserve(deflection, direction), velocity.abs() * step);
        (1.0 - reserve) * direction * self.sliding / self.stiffness
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXPONENTS: [f64; 4] = [0.5, 1.0, 1.5, 2.0];

    fn model(exponent: f64) -> Dahl {
        Dahl { stiffness: 2e5, sliding: 3000.0, exponent }
    }

    #[test]
    fn it_starts_as_a_spring_and_ends_as_coulomb_friction_at_any_velocity() {
        for exponent in EXPONENTS {
            let dahl = model(exponent);
            let z = dahl.advance(0.0, 1e-3, 1e-4);
            assert!((dahl.force(z, 1e-3) / 1e-7 / 2e5 - 1.0).abs() < 1e-4, "pre-sliding stiffness");
            for velocity in [-20.0, -1e-3, 1e-3, 20.0] {
                let z = dahl.advance(0.01, velocity, 1e7);
                let force = dahl.force(z, velocity) / dahl.sliding;
                assert!((force - sign(velocity)).abs() < 1e-4, "{exponent} {velocity}: {force}");
                assert!((dahl.steady(velocity) / dahl.sliding - sign(velocity)).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn the_closed_form_solves_the_differential_equation() {
        for exponent in EXPONENTS {
            let dahl = model(exponent);
            for (start, velocity) in [(0.0, 0.5), (0.012, -0.5), (-0.014, 2.0), (0.02, 1.0)] {
                let mut z = start;
                let (steps, h) = (20_000, 1e-6);
                for _ in 0..steps {
                    let k1 = dahl.rate(z, velocity);
                    let k2 = dahl.rate(z + 0.5 * h * k1, velocity);
                    z += h * k2;
                }
                let exact = dahl.advance(start, velocity, f64::from(steps) * h);
                assert!((z - exact).abs() < 1e-8, "{exponent} from {start}: {z} {exact}");
            }
        }
    }

    /// One step of a second or a thousand of a millisecond: the same, and stable where 1 − σ0|v|h/F_C
    /// would be −1e6.
    #[test]
    fn no_step_is_too_long() {
        let stiff = Dahl::new(1e9, 1000.0);
        assert!((stiff.force(stiff.advance(0.0, 1.0, 1.0), 1.0) - 1000.0).abs() < 1e-9);
        for exponent in EXPONENTS {
            let dahl = model(exponent);
            let many = (0..1000).fold(-0.01, |z, _| dahl.advance(z, 0.02, 1e-3));
            assert!((many - dahl.advance(-0.01, 0.02, 1.0)).abs() < 1e-12);
        }
    }

    /// Runs a way to and fro; gives (way, force) at every step.
    fn loop_of(dahl: &Dahl, amplitude: f64, speed_up: f64) -> Vec<(f64, f64)> {
        let (mut z, mut x, mut path) = (0.0, 0.0, Vec::new());
        let steps = 4000;
        for i in 0..5 * steps {
            // A sine's way, gone through at any pace.
            let next = amplitude * (std::f64::consts::TAU * f64::from(i + 1) / f64::from(steps)).sin();
            let h = 1e-3 / speed_up;
            z = dahl.advance(z, (next - x) / h, h);
            x = next;
            path.push((x, dahl.force(z, 0.0)));
        }
        path
    }

    #[test]
    fn the_force_depends_on_the_way_not_on_its_pace() {
        for exponent in EXPONENTS {
            let (slow, fast) =
                (loop_of(&model(exponent), 0.02, 1.0), loop_of(&model(exponent), 0.02, 1000.0));
            for (one, other) in slow.iter().zip(&fast) {
                assert!((one.1 - other.1).abs() < 1e-6, "{exponent}: {one:?} {other:?}");
            }
        }
    }

    #[test]
    fn a_loop_takes_energy_and_long_ones_take_that_of_coulomb_friction() {
        let work = |path: &[(f64, f64)]| -> f64 {
            path.windows(2).map(|pair| 0.5 * (pair[0].1 + pair[1].1) * (pair[1].0 - pair[0].0)).sum()
        };
        let loss = |amplitude: f64| {
            let path = loop_of(&model(1.0), amplitude, 1.0);
            // The last of five: the loop is closed by then.
            work(&path[4 * 4000 - 1..])
        };
        assert!(loss(1e-3) > 0.0);
        let (long, coulomb) = (loss(1.0), 4.0 * 1.0 * 3000.0);
        assert!(long < coulomb && long > 0.95 * coulomb, "{long}");
        // Small loops lose with the third power of the amplitude: F_C X³ (σ0/F_C)² 2/3 · …
        let order = (loss(2e-4) / loss(1e-4)).log2();
        assert!((order - 3.0).abs() < 0.05, "{order}");
    }

    /// Energy stored, σ0 z²/2, grows by no more than the work put in.
    #[test]
    fn it_is_passive() {
        let dahl = model(1.0);
        let mut z = 0.0;
        let mut state = 1_u32;
        for _ in 0..100_000 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let velocity = f64::from(state >> 8) / f64::from(1 << 24) - 0.5;
            let (force, stored) = (dahl.force(z, velocity), dahl.stiffness * z * dahl.rate(z, velocity));
            assert!(stored <= force * velocity + 1e-9);
            z = dahl.advance(z, velocity, 0.01);
            assert!(dahl.force(z, velocity).abs() <= dahl.sliding * (1.0 + 1e-12), "never above F_C");
        }
    }
}
