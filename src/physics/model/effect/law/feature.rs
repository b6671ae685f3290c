//! What a law can follow: inputs and motion, their products and powers, and what is remembered of them.

use crate::model::effect::Now;

/// One of them, by its place among all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Feature(u8);

/// What a car does at one instant.
struct Motion {
    t: f64,
    v: f64,
    ax: f64,
    ay: f64,
    yaw_rate: f64,
    sideslip: f64,
    /// Of the road wheels, as the steering wheel turns them.
    delta: f64,
}

/// How a feature comes from that.
#[derive(Clone, Copy)]
enum Form {
    /// At once.
    Now(fn(&Motion) -> f64),
    /// As a mean that fades, over so many seconds.
    Memory(fn(&Motion) -> f64, f64),
    /// As what it moves on springs, at so many Hz, hardly damped.
    Resonance(fn(&Motion) -> f64, f64),
}

struct Described {
    name: &'static str,
    unit: &'static str,
    /// What it is in ordinary driving.
    size: f64,
    /// Does it change its sign in a mirror?
    has_side: bool,
    form: Form,
}

const fn one(name: &'static str, unit: &'static str, size: f64, has_side: bool, form: Form) -> Described {
    Described { name, unit, size, has_side, form }
}

/// Of a resonance: what hangs on a car or sloshes in it is hardly damped.
const DAMPING: f64 = 0.15;

/// What is remembered for longer, s, was nothing at the start.
const LONG_S: f64 = 5.0;

/// In parking, m/s, a curvature means nothing.
const SLOW: f64 = 2.0;

fn work(m: &Motion) -> f64 {
    m.v * m.ay.abs()
}

/// The grammar. Base quantities are what a bus has; powers to the third, products of two, one side of what has two, lags
/// and memories of tires, springs, drivers and heat, resonances of what hangs on a car.
static ALL: &[Described] = &[
    // Without a side.
    one("a_x", "m/s²", 1.5, false, Form::Now(|m| m.ax)),
    one("min(a_x, 0)", "m/s²", 1.0, false, Form::Now(|m| m.ax.min(0.0))),
    one("max(a_x, 0)", "m/s²", 1.0, false, Form::Now(|m| m.ax.max(0.0))),
    one("v", "m/s", 10.0, false, Form::Now(|m| m.v)),
    one("v^2", "m²/s²", 300.0, false, Form::Now(|m| m.v * m.v)),
    one("|a_y|", "m/s²", 2.0, false, Form::Now(|m| m.ay.abs())),
    one("a_y^2", "m²/s⁴", 6.0, false, Form::Now(|m| m.ay * m.ay)),
    one("|delta|", "rad", 0.05, false, Form::Now(|m| m.delta.abs())),
    one("t", "s", 60.0, false, Form::Now(|m| m.t)),
    one("memory(v*|a_y|, 10 s)", "m²/s³", 30.0, false, Form::Memory(work, 10.0)),
    one("memory(v*|a_y|, 30 s)", "m²/s³", 30.0, false, Form::Memory(work, 30.0)),
    one("memory(v*|a_y|, 90 s)", "m²/s³", 30.0, false, Form::Memory(work, 90.0)),
    one("memory(v*a_y^2, 30 s)", "m³/s⁵", 90.0, false, Form::Memory(|m| m.v * m.ay * m.ay, 30.0)),
    one("memory(v*a_y^2, 90 s)", "m³/s⁵", 90.0, false, Form::Memory(|m| m.v * m.ay * m.ay, 90.0)),
    one("memory(v*max(-a_x, 0), 30 s)", "m²/s³", 15.0, false, Form::Memory(|m| m.v * (-m.ax).max(0.0), 30.0)),
    // With a side.
    one("delta", "rad", 0.05, true, Form::Now(|m| m.delta)),
    one("delta*|delta|", "rad²", 0.003, true, Form::Now(|m| m.delta * m.delta.abs())),
    one("delta^3", "rad³", 2e-4, true, Form::Now(|m| m.delta.powi(3))),
    one("delta/v", "rad s/m", 0.004, true, Form::Now(|m| m.delta / m.v.max(SLOW))),
    one("delta*v", "rad m/s", 0.7, true, Form::Now(|m| m.delta * m.v)),
    one("delta*v^2", "rad m²/s²", 12.0, true, Form::Now(|m| m.delta * m.v * m.v)),
    one("delta*a_x", "rad m/s²", 0.05, true, Form::Now(|m| m.delta * m.ax)),
    one("r", "rad/s", 0.2, true, Form::Now(|m| m.yaw_rate)),
    one("r/v", "rad/m", 0.015, true, Form::Now(|m| m.yaw_rate / m.v.max(SLOW))),
    one("r*v", "rad m/s²", 2.0, true, Form::Now(|m| m.yaw_rate * m.v)),
    one("r*a_x", "rad m/s³", 0.2, true, Form::Now(|m| m.yaw_rate * m.ax)),
    one("a_y", "m/s²", 2.0, true, Form::Now(|m| m.ay)),
    one("a_y*|a_y|", "m²/s⁴", 6.0, true, Form::Now(|m| m.ay * m.ay.abs())),
    one("a_y^3", "m³/s⁶", 25.0, true, Form::Now(|m| m.ay.powi(3))),
    one("a_y*v", "m²/s³", 30.0, true, Form::Now(|m| m.ay * m.v)),
    one("a_y*a_x", "m²/s⁴", 2.0, true, Form::Now(|m| m.ay * m.ax)),
    one("a_y*min(a_x, 0)", "m²/s⁴", 1.5, true, Form::Now(|m| m.ay * m.ax.min(0.0))),
    one("beta", "rad", 0.02, true, Form::Now(|m| m.sideslip)),
    one("beta*|beta|", "rad²", 6e-4, true, Form::Now(|m| m.sideslip * m.sideslip.abs())),
    one("beta*v", "rad m/s", 0.3, true, Form::Now(|m| m.sideslip * m.v)),
    one("beta*v^2", "rad m²/s²", 5.0, true, Form::Now(|m| m.sideslip * m.v * m.v)),
    one("memory(delta, 0.3 s)", "rad", 0.05, true, Form::Memory(|m| m.delta, 0.3)),
    one("memory(delta, 1 s)", "rad", 0.05, true, Form::Memory(|m| m.delta, 1.0)),
    one("memory(a_y, 0.1 s)", "m/s²", 2.0, true, Form::Memory(|m| m.ay, 0.1)),
    one("memory(a_y, 0.3 s)", "m/s²", 2.0, true, Form::Memory(|m| m.ay, 0.3)),
    one("memory(a_y, 1 s)", "m/s²", 2.0, true, Form::Memory(|m| m.ay, 1.0)),
    one("memory(a_y, 8 s)", "m/s²", 1.0, true, Form::Memory(|m| m.ay, 8.0)),
    one("resonance(a_y, 0.4 Hz)", "m/s²", 2.0, true, Form::Resonance(|m| m.ay, 0.4)),
    one("resonance(a_y, 0.6 Hz)", "m/s²", 2.0, true, Form::Resonance(|m| m.ay, 0.6)),
    one("resonance(a_y, 0.9 Hz)", "m/s²", 2.0, true, Form::Resonance(|m| m.ay, 0.9)),
    one("resonance(a_y, 1.4 Hz)", "m/s²", 2.0, true, Form::Resonance(|m| m.ay, 1.4)),
];

impl Feature {
    /// All of them.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..ALL.len()).map(|place| Self(place as u8))
    }

    fn described(self) -> &'static Described {
        &ALL[usize::from(self.0)]
    }

    /// As it stands in expressions: a_x, a_y accelerations, v speed, r yaw rate, beta sideslip, delta the road wheels' angle
    /// as the steering wheel turns them, t time; `memory` a mean that fades, `resonance` what moves on springs.
    pub fn name(self) -> &'static str {
        self.described().name
    }

    /// Its unit.
    pub fn unit(self) -> &'static str {
        self.described().unit
    }

    pub(super) fn size(self) -> f64 {
        self.described().size
    }

    /// Does it change its sign in a mirror?
    pub fn has_side(self) -> bool {
        self.described().has_side
    }

    /// Could a single tire's radius follow it: its load, its speed, its heat, its air?
    pub(super) fn is_of_radii(self) -> bool {
        matches!(self.name(), "a_x" | "v^2" | "t" | "a_y" | "memory(v*|a_y|, 30 s)" | "memory(v*|a_y|, 90 s)")
    }

    /// Numbers that it remembers.
    pub(super) fn states(self) -> usize {
        match self.described().form {
            Form::Now(_) => 0,
            Form::Memory(..) => 1,
            Form::Resonance(..) => 2,
        }
    }

    pub(super) fn begin(self, now: &Now<'_>, states: &mut [f64]) {
        states.fill(0.0);
        let (Form::Memory(of, time) | Form::Resonance(of, time)) = self.described().form else { return };
        if let Some(first) = states.first_mut().filter(|_| time <= LONG_S) {
            *first = of(&Motion::of(now));
        }
    }

    pub(super) fn value(self, now: &Now<'_>, states: &[f64]) -> f64 {
        match self.described().form {
            Form::Now(of) => of(&Motion::of(now)),
            Form::Memory(..) | Form::Resonance(..) => states.first().copied().unwrap_or(0.0),
        }
    }

    pub(super) fn rates(self, now: &Now<'_>, states: &[f64], rates: &mut [f64]) {
        match (self.described().form, states, rates) {
            (Form::Memory(of, time), [state], [rate]) => *rate = (of(&Motion::of(now)) - *state) / time,
            (Form::Resonance(of, hz), [place, speed], [place_rate, speed_rate]) => {
                let omega = std::f64::consts::TAU * hz;
                *place_rate = *speed;
                *speed_rate =
                    omega * omega * (of(&Motion::of(now)) - *place) - 2.0 * DAMPING * omega * *speed;
            }
            _ => {}
        }
    }

    pub(super) fn fastest_rate(self) -> f64 {
        match self.described().form {
            Form::Now(_) => 0.0,
            Form::Memory(_, time) => time.recip(),
            Form::Resonance(_, hz) => std::f64::consts::TAU * hz,
        }
    }
}

impl Motion {
    fn of(now: &Now<'_>) -> Self {
        let v = now.velocity.vx;
        Self {
            t: now.t,
            v,
            ax: now.ax,
            ay: now.ay,
            yaw_rate: now.velocity.yaw_rate,
            sideslip: now.velocity.vy / v.max(SLOW),
            delta: now.steering_wheel / now.steering_ratio,
        }
    }
}
