//! What is published as friction (thesis ch. 9): what is used, a lower bound from it, and a value of
//! mu_max only where something measured it.
//!
//! A slip curve leaves its tangent noticeably above about half of mu_max. Below that mu_max is not observable: only
//! the lower bound is known and published.
//!
//! All evidence goes into one [`Belief`], which ages: if surfaces last T₀ on average, the surface of T seconds ago is
//! gone with probability 1 − exp(−T/T₀).

use super::abs_braking::AbsFriction;
use super::belief::{Belief, HIGHEST, Use};
use super::brush::BrushFriction;
use super::config::FrictionConfig;
use super::kinematics::{Car, Kinematics};
use super::mapping::MappedFriction;
use super::saturating::Likelihood;
use super::saturation::LimitFriction;
use super::skid::Skid;
use crate::estimates::{Friction, MuSource};
use crate::filter::Fading;
use crate::model::GRAVITY;

/// Tuned with the test `campaign`, what concerns bounds with `sim3`, too.
struct Tuning {
    /// Time constant of the smoothing, s: shorter than a manoeuvre, longer than a bump.
    smoothing_s: f64,
    /// By so much a_y may exceed v r while the car begins to turn, m/s².
    lateral_transient: f64,
    /// The interval is published so much wider on either side: half a cell of the belief, which is what an accelerometer's
    /// offset and the slope of a road make, too.
    told_to: f64,
    /// The bound keeps this clear of the smoothed use, for noise and sensor offsets, …
    margin: f64,
    /// … and so much of the use itself: while driving in a curve the axles share their work unevenly.
    sharing: f64,
    /// Deviation of an ABS measurement: the ABS does not hold the peak all the time.
    abs_std: f64,
    /// What the other wheels may have in reserve when the ABS works in a curve, relative.
    abs_reserve: f64,
    /// So long it takes until brakes have built up what the tires can take, s.
    abs_builds_up_s: f64,
    /// While the ABS works, what is used has settled when it is this near, relative, to what it was before.
    abs_settled: f64,
    /// What was used within so many seconds, s, …
    abs_recent_s: f64,
    /// … or is known to be there, is not used up when the ABS has less than this share of it. Its flag stays on while
    /// the driver lets the brakes go.
    abs_kept: f64,
    /// Another road shows by wheels that stay at their limit for so long, s.
    abs_shows_s: f64,
    /// On a road more slippery than this one wheel speaks for all.
    abs_slippery: f64,
    /// A braking that ended counts for so long, s.
    abs_told_s: f64,
    /// The car spins if a_y and v r differ by more than this, m/s².
    spinning: f64,
    /// Up to this lateral share of the longitudinal force the slip curve is that of driving straight on.
    straight: f64,
    /// Older evidence of the curve may be of another surface, s.
    brush_lasts_s: f64,
    /// Model error of a brush at no use of friction, relative; it falls to zero at full use. A brush fitted to a
    /// real tire's curve at 60 % use is off by half.
    brush_model_error: f64,
    /// What is used rises while a manoeuvre begins: a brush is fitted to what was, and may lack this many times what has come since, …
    brush_lags: f64,
    /// … that is since what is used had settled, s. The same is "before" where the ABS works.
    settles_s: f64,
}

const TUNING: Tuning = Tuning {
    smoothing_s: 0.15,
    lateral_transient: 0.5,
    told_to: 0.01,
    margin: 0.02,
    sharing: 0.05,
    abs_std: 0.04,
    abs_reserve: 0.3,
    abs_builds_up_s: 0.3,
    abs_settled: 0.03,
    abs_recent_s: 5.0,
    abs_kept: 0.9,
    abs_shows_s: 0.7,
    abs_slippery: 0.25,
    abs_told_s: 0.5,
    spinning: 1.5,
    straight: 0.4,
    brush_lasts_s: 0.3,
    brush_model_error: 1.2,
    brush_lags: 2.0,
    settles_s: 0.3,
};

/// Keeps what is believed of friction.
#[derive(Clone, Debug)]
pub struct FrictionMonitor {
    car: Car,
    config: FrictionConfig,
    /// Normalized forces, smoothed: longitudinal and lateral.
    smoothed: Option<[f64; 2]>,
    smoothing: Fading,
    /// What is used, smoothed further.
    settled: f64,
    settling: Fading,
    surface: Fading,
    belief: Belief,
    skid: Skid,
    /// What was measured last.
    measured: Option<Measured>,
    /// Seconds since the use of friction last reached the bound.
    bound_age_s: f64,
    /// What is used while the ABS works, smoothed further.
    abs_used: f64,
    /// The most that was used lately, and how fast that is forgotten.
    recent: f64,
    recently: Fading,
    /// For how long the front wheels have been at their limit with less than was used before, s.
    at_limit_s: f64,
}

/// A measurement of mu_max.
#[derive(Clone, Copy, Debug)]
struct Measured {
    mu: f64,
    source: MuSource,
    age_s: f64,
    /// Good enough to act upon, as long as the interval is narrow.
    is_sure: bool,
}

/// Other estimators' evidence of mu_max.
#[derive(Clone, Copy, Debug, Default)]
pub struct Evidence {
    /// The brush regression's.
    pub brush: Option<BrushFriction>,
    /// The last ABS braking's.
    pub abs: Option<AbsFriction>,
    /// For how long the ABS has been working, pauses included, s.
    pub abs_working_s: Option<f64>,
    /// Are the front wheels at their limit while braking, as far as that is known?
    pub brakes_at_limit: Option<bool>,
    /// That of the driven wheels at their limit.
    pub limit: Option<LimitFriction>,
    /// What the tires' curves leave of each friction.
    pub curve: Option<Likelihood>,
    /// The slope's, by a calibrated mapping.
    pub map: Option<MappedFriction>,
}

impl FrictionMonitor {
    /// For this car.
    pub fn new(car: &Car, config: &FrictionConfig) -> Self {
        Self {
            belief: Belief::UNKNOWN,
            skid: Skid::new(car),
            measured: None,
            bound_age_s: 0.0,
            abs_used: 0.0,
            car: car.clone(),
            config: config.clone(),
            smoothed: None,
            smoothing: Fading::over(TUNING.smoothing_s),
            settled: 0.0,
            settling: Fading::over(TUNING.settles_s),
            surface: Fading::over(config.surface_lasts_s),
            recent: 0.0,
            recently: Fading::over(TUNING.abs_recent_s),
            at_limit_s: 0.0,
        }
    }

    /// The surface changed: what was used before says nothing of this one.
    pub fn surface_changed(&mut self) {
        self.belief = Belief::UNKNOWN;
        self.measured = None;
        self.recent = 0.0;
    }

    /// Takes a sample; `acceleration` is the longitudinal one, measured or from the wheels.
    pub fn step(&mut self, now: &Kinematics, acceleration: Option<f64>, evidence: Evidence) -> Friction {
        self.belief.forget(1.0 - self.surface.left(now.elapsed_s));
        self.bound_age_s += now.elapsed_s;
        if let Some(measured) = &mut self.measured {
            measured.age_s += now.elapsed_s;
        }
        let used = self.used(now, acceleration);
        if let Some(used) = used.map(Self::surely).filter(|used| *used > 0.0) {
            self.learn_used(used);
        }
        let used_now = used.unwrap_or(self.settled);
        self.settling.smooth(&mut self.settled, used_now, now.elapsed_s);
        self.learn_brush(evidence.brush, (used_now - self.settled).max(0.0));
        self.learn_abs(now, used, &evidence);
        if let Some(skid) = self.skid.step(now) {
            self.learn_measured(skid.mu, skid.std, MuSource::Limit, true);
        }
        if let Some(limit) = evidence.limit.filter(|limit| limit.age_s == 0.0) {
            self.learn_limit(&limit);
        }
        if let Some(curve) = evidence.curve {
            self.learn_curve(&curve);
        }
        let mut friction = Friction {
            used,
            brush: evidence.brush.map(|b| b.mu),
            brush_std: evidence.brush.map(|b| b.std),
            abs: evidence.abs.map(|a| a.mu),
            map: evidence.map.map(|m| m.mu),
            map_interval: evidence.map.map(|m| (m.low, m.high)),
            ..Friction::default()
        };
        self.publish(&mut friction);
        if friction.max.is_none() {
            self.add_map(&mut friction, evidence.map);
        }
        friction
    }

    /// The part of a use that is certain.
    fn surely(used: f64) -> f64 {
        ((1.0 - TUNING.sharing) * used - TUNING.margin).max(0.0)
    }

    /// Use of friction of the axle that works harder: √(μ_x² + μ_y²).
    fn used(&mut self, now: &Kinematics, acceleration: Option<f64>) -> Option<f64> {
        let (Some(ay), Some(ax), Some(speed)) = (now.lateral_acceleration, acceleration, now.speed) else {
            self.smoothed = None;
            return None;
        };
        let [front, rear] = self.car.axle_forces(self.car.longitudinal_force(ax, speed));
        let longitudinal = if front.abs() > rear.abs() { front } else { rear };
        // An accelerometer's offset or a bank is no use of friction: in a curve the yaw rate agrees.
        let turning = now.yaw_rate.map_or(0.0, |r| (speed * r).abs()) + TUNING.lateral_transient;
        let target = [longitudinal, ay.clamp(-turning, turning) / GRAVITY];
        let smoothed = self.smoothed.get_or_insert(target);
        for (value, target) in smoothed.iter_mut().zip(target) {
            self.smoothing.smooth(value, target, now.elapsed_s);
        }
        Some((smoothed[0] * smoothed[0] + smoothed[1] * smoothed[1]).sqrt())
    }

    fn learn_used(&mut self, used: f64) {
        let news = self.belief.learn_used(used);
        if news != Use::Known {
            self.bound_age_s = 0.0;
        }
        if news == Use::Another {
            // It was measured on another surface.
            self.measured = None;
        }
    }

    fn learn_brush(&mut self, brush: Option<BrushFriction>, risen: f64) {
        let brush =
            brush.filter(|brush| !brush.is_bound && !brush.is_doubted && brush.age_s < TUNING.brush_lasts_s);
        let (Some(brush), Some([along, across])) = (brush, self.smoothed) else { return };
        let using = (Self::surely(along.abs()) / brush.mu).min(1.0);
        // Lateral force takes from the longitudinal one, which looks like a curve that bends early.
        let is_straight = across.abs() < TUNING.straight * along.abs();
        // Using more than the curve allows, in whatever direction, refutes it.
        let is_refuted = || self.belief.interval().0 > brush.mu + 1.96 * brush.std;
        if using < self.config.brush_from_use || !is_straight || is_refuted() {
            return;
        }
        let model_std = TUNING.brush_model_error * (1.0 - using) * brush.mu;
        let is_sure = using >= self.config.valid_from_use;
        let std = brush.std.hypot(model_std);
        self.learn_measured(brush.mu, [std, std.hypot(TUNING.brush_lags * risen)], MuSource::Brush, is_sure);
    }

    /// Where the ABS works, a wheel is at its limit; it may be one alone.
    fn learn_abs(&mut self, now: &Kinematics, used: Option<f64>, evidence: &Evidence) {
        let (Some([along, across]), Some(used)) = (self.smoothed, used) else {
            // Nobody measures the deceleration while it goes on.
            if let Some(abs) = evidence.abs.filter(|abs| abs.age_s <= TUNING.abs_told_s) {
                self.learn_measured(abs.mu, [abs.std.max(TUNING.abs_std); 2], MuSource::Abs, true);
            }
            return;
        };
        self.recent = used.max(self.recent * self.recently.left(now.elapsed_s));
        let is_less = used < TUNING.abs_kept * self.recent.max(self.belief.interval().0);
        let is_at_limit = is_less && evidence.brakes_at_limit == Some(true);
        self.at_limit_s = if is_at_limit { self.at_limit_s + now.elapsed_s } else { 0.0 };
        let Some(working_s) = evidence.abs_working_s else {
            self.abs_used = used;
            return;
        };
        self.settling.smooth(&mut self.abs_used, used, now.elapsed_s);
        // While the brake pressure builds up not all tires are at their limit.
        let is_settled = used - self.abs_used < TUNING.abs_settled * used;
        let is_braking = now.abs == Some(true) && working_s > TUNING.abs_builds_up_s && along < 0.0;
        if !is_braking || !is_settled || Self::is_spinning(now) {
            return;
        }
        if is_less && self.at_limit_s < TUNING.abs_shows_s {
            return;
        }
        let reserve = match evidence.brakes_at_limit {
            Some(false) => return,
            // On a slippery road wheels slip too little to tell.
            None if used > TUNING.abs_slippery => {
                self.learn_one_sided(used, [TUNING.abs_std; 2], MuSource::Abs);
                return;
            }
            _ if across.abs() > TUNING.straight * along.abs() => TUNING.abs_reserve * used,
            _ => 0.0,
        };
        self.learn_measured(used, [TUNING.abs_std, TUNING.abs_std.hypot(reserve)], MuSource::Abs, true);
    }

    /// Driven wheels at their limit, or one of them.
    fn learn_limit(&mut self, limit: &LimitFriction) {
        if limit.is_one_sided {
            self.learn_one_sided(limit.mu, limit.std, MuSource::Limit);
        } else {
            self.learn_measured(limit.mu, limit.std, MuSource::Limit, true);
        }
    }

    /// A wheel is at its limit, and nobody knows of the others.
    fn learn_one_sided(&mut self, mu: f64, std: [f64; 2], source: MuSource) {
        let before = self.belief.interval();
        let is_another = self.belief.learn_one_sided(mu, std);
        self.take_mean(source, false, is_another, before);
    }

    /// Tires that bend, or do not, at the force in use.
    fn learn_curve(&mut self, likelihood: &Likelihood) {
        let before = self.belief.interval();
        let alone = Belief::of(likelihood);
        let is_another = self.belief.learn_belief(&alone);
        if alone.interval().1 <= MOST_TOLD {
            self.take_mean(MuSource::Joint, true, is_another, before);
        }
    }

    /// Takes the mean of what is believed now for a measurement, after evidence that has no value of its own; `before`: the interval
    /// without it.
    fn take_mean(&mut self, source: MuSource, is_sure: bool, is_another: bool, before: (f64, f64)) {
        let (low, high) = self.belief.interval();
        let says_more = high - low < before.1 - before.0;
        self.take(Measured { mu: self.belief.mean(), source, age_s: 0.0, is_sure }, is_another || says_more);
    }

    /// Do yaw rate and curvature of the path disagree? Then the wheels pull in different directions.
    fn is_spinning(now: &Kinematics) -> bool {
        let turning = now.speed.zip(now.yaw_rate).map_or(0.0, |(speed, yaw_rate)| speed * yaw_rate);
        (turning - now.lateral_acceleration.unwrap_or(0.0)).abs() > TUNING.spinning
    }

    fn learn_measured(&mut self, mu: f64, std: [f64; 2], source: MuSource, is_sure: bool) {
        let (low, high) = self.belief.interval();
        let is_another = self.belief.learn_measured(mu, std);
        let says_more = 1.96 * (std[0] + std[1]) < high - low;
        self.take(Measured { mu, source, age_s: 0.0, is_sure }, is_another || says_more);
    }

    /// A measurement wider than the belief changes the belief but not the published value, nor does one that nobody would act upon.
    fn take(&mut self, measured: Measured, says_more: bool) {
        let may_follow =
            |before: Measured| before.source == measured.source && (measured.is_sure || !before.is_sure);
        if says_more || self.measured.is_none_or(may_follow) {
            self.measured = Some(measured);
        }
    }

    /// What is believed.
    pub fn belief(&self) -> &Belief {
        &self.belief
    }

    /// The belief in few numbers.
    fn publish(&self, friction: &mut Friction) {
        let (low, high) = self.belief.interval();
        let is_bounded = high < MOST_TOLD;
        let (low, high) = (low - TUNING.told_to, high + TUNING.told_to);
        let measured =
            self.measured.filter(|measured| is_bounded && measured.age_s <= self.config.abs_memory_s);
        friction.low = Some(low).filter(|low| *low > LEAST_TOLD);
        match measured {
            Some(measured) => {
                let (low, high) = (low.min(measured.mu), high.max(measured.mu));
                (friction.low, friction.max, friction.high) = (Some(low), Some(measured.mu), Some(high));
                friction.source = measured.source;
                friction.age_s = Some(measured.age_s);
                let is_narrow = 0.5 * (high - low) <= self.config.valid_half_width;
                friction.valid = measured.is_sure && is_narrow && measured.age_s <= self.config.abs_valid_s;
            }
            None if friction.low.is_some() => {
                friction.source = MuSource::LowerBound;
                friction.age_s = Some(self.bound_age_s);
            }
            None => friction.source = MuSource::None,
        }
    }

    /// A mapping is a statement about roads like those of its calibration: published where nothing
    /// measures friction, with its wide interval, and never as something to act upon.
    fn add_map(&self, friction: &mut Friction, map: Option<MappedFriction>) {
        let Some(map) = map else { return };
        let low = friction.low.unwrap_or(0.0);
        // More is in use than the mapping allows: this road is not like those.
        if low > map.high {
            return;
        }
        friction.max = Some(map.mu.max(low));
        friction.low = Some(map.low.max(low));
        friction.high = Some(map.high);
        friction.source = MuSource::SlopeMap;
    }
}

/// No bound below this says anything. Statistical: within two cells of the end nothing can be beyond it.
const LEAST_TOLD: f64 = 0.04;
/// No bound above this says anything.
const MOST_TOLD: f64 = HIGHEST - 0.04;

#[cfg(test)]
mod tests;
