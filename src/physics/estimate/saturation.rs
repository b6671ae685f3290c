//! Friction from a tire at its limit: slip grows while the force does not (thesis ch. 9 turned round).
//!
//! Whatever the curve below it, at the limit the force is μ F_z and no longer depends on the slip.
//! Where a stretch of the slip curve is seen along which the slip grows by a multiple and the force
//! stays, its force is the friction: no model of the tire is needed, and none is assumed.
//!
//! Two things must be told apart from it. On a softer surface the slip jumps at constant force: there are no points
//! between, it stays, and force/slip remains that of a surface. And a spinning wheel takes part of the torque itself:
//! F_x = (τ − J ω̇)/r.
//!
//! [`WheelSaturation`] takes points of the slip curve of either sign, so that braking can use it where
//! the brake torque of a wheel and the car's speed are known; [`SaturationDetector`] feeds it with the
//! driven wheels.

mod wheel;

pub use self::wheel::{AtLimit, SlipPoint, WheelSaturation};
use super::block::{Block, BlockBuilder};
use super::config::SlopeConfig;
use super::kinematics::{Car, Kinematics};
use super::traction::Traction;
use crate::estimates::Estimate;
use crate::model::{DrivenAxle, GRAVITY};
use crate::{Quantity, Sensors, Wheel};

/// Tuned with the test `sim3`: over seeds, tires and surfaces, at the limit and far from it; what lies beyond it with the test
/// `campaign`.
struct Tuning {
    /// Samples are averaged over this time, s: a wheel spins up and is caught within half a second.
    block_s: f64,
    /// A sample that comes later than this after the last one comes after a gap, s.
    gap_s: f64,
    /// All wheels of the axle are at their limits if they were within this time, s.
    together_s: f64,
    /// Beyond its peak a tire gives less: for this time the largest force counts, s, …
    peak_held_s: f64,
    /// … unless it has fallen by more than a tire's does: then the surface is another one.
    peak_lost: f64,
    /// Between the flat stretch's force and the peak of the curve, relative.
    curve_std: f64,
    /// Far beyond its limit a tire gives this share of the friction, …
    given: f64,
    /// … with these deviations, relative, downwards and upwards: a magic formula of shape 1.6 gives 0.6 of it, a brush all.
    given_std: [f64; 2],
    /// Of the wheel's inertia, relative, where the data sheet does not say.
    inertia_std: f64,
    /// Share of the load transfer (left out of the loads) that counts as uncertainty.
    load_transfer_std: f64,
    /// A spin disturbs the straight line through the slip curve for so long, s.
    after_spin_s: f64,
}

const TUNING: Tuning = Tuning {
    block_s: 0.1,
    gap_s: 0.05,
    together_s: 0.5,
    peak_held_s: 3.0,
    peak_lost: 0.8,
    curve_std: 0.02,
    given: 0.8,
    given_std: [0.16, 0.17],
    inertia_std: 0.1,
    load_transfer_std: 0.5,
    after_spin_s: 0.5,
};

/// Friction, as the limit of the force showed it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitFriction {
    /// Friction.
    pub mu: f64,
    /// Its standard deviations downwards and upwards, the data sheet's part included.
    pub std: [f64; 2],
    /// Does the tire slip far beyond its limit, where it gives less?
    pub is_beyond: bool,
    /// Was it seen of one wheel alone? Then the other side may give more.
    pub is_one_sided: bool,
    /// Seconds since it was last seen.
    pub age_s: f64,
}

impl LimitFriction {
    /// Is another friction within its 95 % interval?
    fn holds(&self, mu: f64) -> bool {
        let [down, up] = self.std;
        (self.mu - 1.96 * down..=self.mu + 1.96 * up).contains(&mu)
    }
}

/// Watches the driven axle.
#[derive(Clone, Debug)]
pub struct SaturationDetector {
    blocks: BlockBuilder,
    wheels: [WheelSaturation; 4],
    /// What each wheel showed last, and the age of the force it stands on, s.
    seen: [Option<(LimitFriction, f64)>; 4],
    /// Of the axle.
    friction: Option<LimitFriction>,
    since_spinning_s: f64,
    car: Car,
    /// Relative standard deviation of all forces: the data sheet's.
    force_scale_std: f64,
    with_torque: bool,
}

impl SaturationDetector {
    /// For this car and these sensors.
    pub fn new(car: &Car, sensors: &Sensors) -> Self {
        let with_torque = sensors.has(Quantity::DriveTorque);
        Self {
            blocks: BlockBuilder::new(TUNING.block_s),
            wheels: Default::default(),
            seen: [None; 4],
            friction: None,
            since_spinning_s: f64::INFINITY,
            car: car.clone(),
            force_scale_std: if with_torque { car.torque_scale_std } else { car.acceleration_scale_std },
            with_torque,
        }
    }

    /// Takes a sample. `offsets` and `slopes` are the slip curve's of each wheel, as far as known.
    pub fn step(
        &mut self,
        now: &Kinematics,
        traction: &Traction,
        offsets: &[Option<Estimate>; 4],
        slopes: &[Option<Estimate>; 4],
        config: &SlopeConfig,
    ) {
        for (seen, peak_age) in self.seen.iter_mut().flatten() {
            seen.age_s += now.elapsed_s;
            *peak_age += now.elapsed_s;
        }
        if let Some(friction) = &mut self.friction {
            friction.age_s += now.elapsed_s;
        }
        self.since_spinning_s += now.elapsed_s;
        if now.elapsed_s > TUNING.gap_s {
            // Points before and after a gap are not one stretch.
            self.wheels.iter_mut().for_each(WheelSaturation::reset);
        }
        let Some(block) = self.blocks.step(now) else { return };
        let points = traction.points(&block);
        for wheel in Wheel::ALL.into_iter().filter(|&wheel| self.car.driven_axle.drives(wheel)) {
            let i = wheel as usize;
            let Some(measured) = points[i] else {
                self.wheels[i].reset();
                continue;
            };
            let (offset, offset_std) =
                offsets[i].map_or((0.0, config.initial_offset_std), |o| (o.value, o.std));
            let prior = self.car.slope_prior[usize::from(!wheel.is_front())].0;
            let (force, force_std) = traction.force(&block, wheel);
            let load = self.car.load(wheel);
            let along = force / load;
            let point = SlipPoint {
                slip: measured.slip - offset,
                slip_std: measured.slip_std.hypot(offset_std),
                mu: along,
                mu_std: force_std / load,
            };
            let slope = slopes[i].map_or(prior, |slope| slope.value);
            let at_limit = self.wheels[i].step(point, slope);
            let spins = point.spins(measured.slip, self.turning(&block), prior);
            if spins.is_some() {
                self.since_spinning_s = 0.0;
            }
            let Some(AtLimit { mu, std: noise, is_beyond }) = at_limit.or(spins) else {
                continue;
            };
            let spin_up = block.wheel_acceleration[i] / self.car.radius;
            let inertia_std = if self.with_torque {
                TUNING.inertia_std * self.car.wheel_inertia * spin_up / self.car.radius / load
            } else {
                0.0
            };
            let transfer =
                TUNING.load_transfer_std * self.car.load_transfer(wheel) * block.acceleration / GRAVITY;
            let relative = self.force_scale_std.hypot(TUNING.curve_std).hypot(transfer);
            let sideways = block.lateral_acceleration / GRAVITY;
            let (used, std) = (mu.hypot(sideways), noise.hypot(inertia_std).hypot(relative * mu));
            let (mu, std) = if is_beyond {
                let mu = used / TUNING.given;
                (mu, TUNING.given_std.map(|relative| std.hypot(relative * mu)))
            } else {
                (used, [std; 2])
            };
            let found = LimitFriction { mu, std, is_beyond, is_one_sided: true, age_s: 0.0 };
            self.seen[i] = Some(Self::with_peak(self.seen[i], found));
        }
        if self.wheels.iter().any(WheelSaturation::is_spinning) {
            self.since_spinning_s = 0.0;
        }
        self.combine();
    }

    /// The last one, if any: of the whole axle where its wheels were at their limits together, else of one side.
    pub fn friction(&self) -> Option<LimitFriction> {
        self.friction
    }

    /// A driven wheel spins, or did just now: slips are no points of a straight line.
    pub fn is_spinning(&self) -> bool {
        self.since_spinning_s < TUNING.after_spin_s
    }

    /// Slip of a wheel that turns as fast as its neighbour: a locked axle, as race cars have one. And an angle of the steering that
    /// belongs to something else tells another way of the front wheels.
    fn turning(&self, block: &Block) -> f64 {
        let track = self.car.track[usize::from(self.car.driven_axle == DrivenAxle::Rear)];
        track * (block.yaw_rate / block.speed).abs() + 1.0 - block.road_angle.cos()
    }

    fn with_peak(before: Option<(LimitFriction, f64)>, found: LimitFriction) -> (LimitFriction, f64) {
        match before {
            // What was seen at the limit itself says more.
            Some((peak, age))
                if age < TUNING.peak_held_s
                    && if found.is_beyond == peak.is_beyond {
                        (TUNING.peak_lost * peak.mu..peak.mu).contains(&found.mu)
                    } else {
                        found.is_beyond && found.holds(peak.mu)
                    } =>
            {
                (LimitFriction { age_s: 0.0, ..peak }, age)
            }
            _ => (found, 0.0),
        }
    }

    fn combine(&mut self) {
        let driven = Wheel::ALL.into_iter().filter(|&wheel| self.car.driven_axle.drives(wheel)).count();
        let mut count = 0;
        let mut all: Option<LimitFriction> = None;
        for (seen, _) in self.seen.into_iter().flatten().filter(|(seen, _)| seen.age_s < TUNING.together_s) {
            count += 1;
            all = Some(match all {
                Some(other) => LimitFriction {
                    mu: 0.5 * (other.mu + seen.mu),
                    // The wheels share most of their errors; their difference counts as a further one.
                    std: [0, 1]
                        .map(|way| other.std[way].max(seen.std[way]).hypot(0.5 * (other.mu - seen.mu))),
                    is_beyond: other.is_beyond || seen.is_beyond,
                    is_one_sided: true,
                    age_s: other.age_s.min(seen.age_s),
                },
                None => seen,
            });
        }
        // One wheel whose slip grows a little for nothing may have any reason; one that spins has one.
        if let Some(friction) = all.filter(|friction| count == driven || friction.is_beyond) {
            self.friction = Some(LimitFriction { is_one_sided: count < driven, ..friction });
        }
    }
}
