//! What is published as friction (thesis ch. 9): what is used, a lower bound from it, and a value of
//! mu_max only where something measured it.
//!
//! A slip curve leaves its tangent noticeably above about half of mu_max. Below that mu_max is not
//! observable: only the bound is known, and that is what is said.
//!
//! The bound ages. Friction used T seconds ago was there then; since then the surface may have become
//! another one, unseen. With surfaces that last T₀ on average and frictions equally likely from 0 to 1,
//! friction is below L by now with probability (1 − exp(−T/T₀)) L: the bound that holds with 95 % is
//! the largest of min(used, 0.05 T₀/T) over the time passed.

use super::abs_braking::AbsFriction;
use super::brush::BrushFriction;
use super::mapping::MappedFriction;
use super::saturation::LimitFriction;
use super::{Car, FrictionConfig, Kinematics};
use crate::estimates::{Friction, MuSource};
use crate::model::{DrivenAxle, GRAVITY};

/// Keeps the recent use of friction.
#[derive(Clone, Debug)]
pub struct FrictionMonitor {
    car: Car,
    config: FrictionConfig,
    /// Normalized forces, smoothed: longitudinal and lateral.
    smoothed: Option<[f64; 2]>,
    recent: RecentMaximum,
    /// Of the longitudinal use alone, which is what the brush regression sees.
    recent_longitudinal: RecentMaximum,
    /// Seconds since the surface changed, as far as that was noticed: evidence that is older is of
    /// another surface.
    since_change_s: f64,
}

/// Other estimators' evidence of mu_max.
#[derive(Clone, Copy, Debug, Default)]
pub struct Evidence {
    /// The brush regression's.
    pub brush: Option<BrushFriction>,
    /// The last ABS braking's.
    pub abs: Option<AbsFriction>,
    /// That of the driven wheels at their limit.
    pub limit: Option<LimitFriction>,
    /// The slope's, by a calibrated mapping.
    pub map: Option<MappedFriction>,
}

impl FrictionMonitor {
    /// Time constant of the smoothing, s: shorter than a manoeuvre, longer than a bump.
    const SMOOTHING_S: f64 = 0.15;
    /// By so much a_y may exceed v r while the car begins to turn, m/s².
    const LATERAL_TRANSIENT: f64 = 0.5;
    /// The bound keeps this clear of the smoothed use, for noise and sensor offsets, …
    const MARGIN: f64 = 0.02;
    /// … and so much of the use itself: while driving in a curve the axles share their work unevenly.
    const SHARING: f64 = 0.05;
    /// Deviation of an ABS measurement: the ABS does not hold the peak all the time.
    const ABS_STD: f64 = 0.04;
    /// By which the interval of a measurement at the limit grows, 1/s: the car moves on.
    const ABS_STD_GROWTH: f64 = 0.02;
    /// Share of the time in which the bound may be above the friction.
    const RISK: f64 = 0.05;
    /// Model error of a brush at no use of friction, relative; it falls to zero at full use. A brush
    /// fitted to a real tire's curve at 60 % use is off by half.
    const BRUSH_MODEL_ERROR: f64 = 1.2;

    /// For this car.
    pub fn new(car: &Car, config: &FrictionConfig) -> Self {
        Self {
            recent: RecentMaximum::new(config.memory_s, Self::RISK * config.surface_lasts_s),
            recent_longitudinal: RecentMaximum::new(config.memory_s, f64::INFINITY),
            since_change_s: f64::INFINITY,
            car: car.clone(),
            config: config.clone(),
            smoothed: None,
        }
    }

    /// The surface changed: what was used before says nothing of this one.
    pub fn surface_changed(&mut self) {
        self.recent.clear();
        self.recent_longitudinal.clear();
        self.since_change_s = 0.0;
    }

    /// Takes a sample; `acceleration` is the longitudinal one, measured or from the wheels.
    pub fn step(&mut self, now: &Kinematics, acceleration: Option<f64>, evidence: Evidence) -> Friction {
        self.since_change_s += now.elapsed_s;
        let used = self.used(now, acceleration);
        let limit = evidence.limit.filter(|limit| limit.age_s <= self.since_change_s);
        let abs = evidence.abs.filter(|abs| abs.age_s <= self.since_change_s);
        let longitudinal = self.smoothed.map(|[x, _]| x.abs());
        for (recent, used) in [(&mut self.recent, used), (&mut self.recent_longitudinal, longitudinal)] {
            recent.step(now.elapsed_s, used.map(Self::surely));
        }
        if let Some(limit) = limit.filter(|limit| limit.age_s == 0.0) {
            // More was used before: that was another surface.
            self.recent.cap(limit.mu);
        }
        let low = self.recent.maximum().filter(|low| *low > 0.0);
        let mut friction = Friction {
            used,
            low,
            source: if low.is_some() { MuSource::LowerBound } else { MuSource::None },
            age_s: low.map(|_| self.recent.age_s()),
            brush: evidence.brush.map(|b| b.mu),
            brush_std: evidence.brush.map(|b| b.std),
            abs: evidence.abs.map(|a| a.mu),
            map: evidence.map.map(|m| m.mu),
            map_interval: evidence.map.map(|m| (m.low, m.high)),
            ..Friction::default()
        };
        self.add_brush(&mut friction, evidence.brush);
        let newer = |limit: LimitFriction| abs.is_none_or(|abs| limit.age_s <= abs.age_s);
        match limit.filter(|limit| newer(*limit)) {
            Some(limit) => self.add_limit(&mut friction, limit),
            None => self.add_abs(&mut friction, abs),
        }
        if friction.max.is_none() {
            self.add_map(&mut friction, evidence.map);
        }
        friction
    }

    /// What of the use is surely one.
    fn surely(used: f64) -> f64 {
        ((1.0 - Self::SHARING) * used - Self::MARGIN).max(0.0)
    }

    /// Use of friction of the axle that works harder: √(μ_x² + μ_y²).
    fn used(&mut self, now: &Kinematics, acceleration: Option<f64>) -> Option<f64> {
        let (Some(ay), Some(ax), Some(speed)) = (now.lateral_acceleration, acceleration, now.speed) else {
            self.smoothed = None;
            return None;
        };
        let mean = (ax + self.car.drag * speed * speed / self.car.mass) / GRAVITY;
        // Driving forces act at the driven axle alone; braking forces at both.
        let driven_share = match self.car.driven_axle {
            DrivenAxle::Front => self.car.b / self.car.wheelbase(),
            DrivenAxle::Rear => self.car.a / self.car.wheelbase(),
            DrivenAxle::All => 1.0,
        };
        let longitudinal = if mean > 0.0 { mean / driven_share } else { mean };
        // An accelerometer's offset or a bank is no use of friction: in a curve the yaw rate agrees.
        let turning = now.yaw_rate.map_or(0.0, |r| (speed * r).abs()) + Self::LATERAL_TRANSIENT;
        let target = [longitudinal, ay.clamp(-turning, turning) / GRAVITY];
        let smoothed = self.smoothed.get_or_insert(target);
        let weight = 1.0 - (-now.elapsed_s / Self::SMOOTHING_S).exp();
        for (value, target) in smoothed.iter_mut().zip(target) {
            *value += weight * (target - *value);
        }
        Some(smoothed[0].hypot(smoothed[1]))
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

    fn add_brush(&self, friction: &mut Friction, brush: Option<BrushFriction>) {
        let (Some(brush), Some(low)) = (brush, friction.low) else { return };
        let using = (self.recent_longitudinal.maximum().unwrap_or(0.0) / brush.mu).min(1.0);
        // Using more than the curve allows, in whatever direction, refutes it.
        if using < self.config.brush_from_use || low > brush.mu + 1.96 * brush.std {
            return;
        }
        let model_std = Self::BRUSH_MODEL_ERROR * (1.0 - using) * brush.mu;
        self.publish(friction, brush.mu, brush.std.hypot(model_std), MuSource::Brush);
        friction.valid = using >= self.config.valid_from_use && self.is_narrow(friction);
    }

    fn add_abs(&self, friction: &mut Friction, abs: Option<AbsFriction>) {
        let Some(abs) = abs.filter(|abs| abs.age_s <= self.config.abs_memory_s) else { return };
        let measured = abs.std.max(Self::ABS_STD);
        let std = measured + Self::ABS_STD_GROWTH * abs.age_s;
        self.publish(friction, abs.mu, std, MuSource::Abs);
        friction.age_s = Some(abs.age_s);
        friction.valid =
            abs.age_s <= self.config.abs_valid_s && 1.96 * measured <= self.config.valid_half_width;
    }

    fn add_limit(&self, friction: &mut Friction, limit: LimitFriction) {
        if limit.age_s > self.config.abs_memory_s {
            return;
        }
        let std = limit.std + Self::ABS_STD_GROWTH * limit.age_s;
        self.publish(friction, limit.mu, std, MuSource::Limit);
        friction.age_s = Some(limit.age_s);
        friction.valid =
            limit.age_s <= self.config.abs_valid_s && 1.96 * limit.std <= self.config.valid_half_width;
    }

    fn publish(&self, friction: &mut Friction, mu: f64, std: f64, source: MuSource) {
        let low = (mu - 1.96 * std).max(friction.low.unwrap_or(0.0));
        friction.max = Some(mu.max(low));
        friction.low = Some(low);
        friction.high = Some((mu + 1.96 * std).max(low));
        friction.source = source;
    }

    fn is_narrow(&self, friction: &Friction) -> bool {
        match (friction.low, friction.high) {
            (Some(low), Some(high)) => 0.5 * (high - low) <= self.config.valid_half_width,
            _ => false,
        }
    }
}

/// The largest value of the last few seconds, in slots: old ones count less and fall out slot by slot.
#[derive(Clone, Debug)]
struct RecentMaximum {
    slot_s: f64,
    /// A value of an age counts at most as this / age, s.
    decay_s: f64,
    slots: [Option<f64>; Self::SLOTS],
    current: usize,
    elapsed_s: f64,
}

impl RecentMaximum {
    const SLOTS: usize = 20;

    fn new(memory_s: f64, decay_s: f64) -> Self {
        let slot_s = (memory_s / Self::SLOTS as f64).max(1e-3);
        Self { slot_s, decay_s, slots: [None; Self::SLOTS], current: 0, elapsed_s: 0.0 }
    }

    fn clear(&mut self) {
        self.slots = [None; Self::SLOTS];
    }

    fn step(&mut self, elapsed_s: f64, value: Option<f64>) {
        self.elapsed_s += elapsed_s;
        let mut turned = 0;
        while self.elapsed_s >= self.slot_s && turned < Self::SLOTS {
            self.elapsed_s -= self.slot_s;
            self.current = (self.current + 1) % Self::SLOTS;
            self.slots[self.current] = None;
            turned += 1;
        }
        if turned == Self::SLOTS {
            self.elapsed_s = 0.0;
        }
        if let Some(value) = value {
            let slot = &mut self.slots[self.current];
            *slot = Some(slot.map_or(value, |largest| largest.max(value)));
        }
    }

    /// Nothing counts more than this.
    fn cap(&mut self, most: f64) {
        for value in self.slots.iter_mut().flatten() {
            *value = value.min(most);
        }
    }

    /// What the value of a slot counts today, and its age, s; the newest first.
    fn counting(&self) -> impl Iterator<Item = (f64, f64)> {
        (0..Self::SLOTS).filter_map(|ago| {
            let value = self.slots[(self.current + Self::SLOTS - ago) % Self::SLOTS]?;
            let age_s = ago as f64 * self.slot_s;
            Some((value.min(self.decay_s / age_s), age_s))
        })
    }

    fn maximum(&self) -> Option<f64> {
        self.counting().map(|(value, _)| value).reduce(f64::max)
    }

    /// Age of the slot that holds the maximum, s.
    fn age_s(&self) -> f64 {
        let newest = |best: (f64, f64), other: (f64, f64)| if other.0 > best.0 { other } else { best };
        self.counting().reduce(newest).map_or(0.0, |(_, age_s)| age_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Vehicle;

    fn sample(ax: f64, ay: f64) -> Kinematics {
        Kinematics {
            elapsed_s: 0.01,
            speed: Some(20.0),
            wheels: Some([20.0; 4]),
            yaw_rate: Some(ay / 20.0),
            lateral_acceleration: Some(ay),
            longitudinal_acceleration: Some(ax),
            road_angle: Some(0.0),
            axle_torque: None,
            braking: None,
            abs: None,
        }
    }

    #[test]
    fn gentle_driving_gives_a_bound_and_no_value() {
        let car = Car::new(&Vehicle::thesis());
        let mut monitor = FrictionMonitor::new(&car, &FrictionConfig::default());
        let brush = Some(BrushFriction { mu: 0.9, std: 0.01 });
        let mut friction = Friction::default();
        for _ in 0..200 {
            friction = monitor.step(&sample(0.0, 2.0), Some(0.0), Evidence { brush, ..Evidence::default() });
        }
        assert_eq!(friction.source, MuSource::LowerBound);
        assert_eq!((friction.max, friction.high, friction.valid), (None, None, false));
        assert!((friction.low.unwrap() - 0.174).abs() < 0.01, "{friction:?}");
    }

    #[test]
    fn an_offset_of_the_accelerometer_is_no_use_of_friction() {
        let car = Car::new(&Vehicle::thesis());
        let mut monitor = FrictionMonitor::new(&car, &FrictionConfig::default());
        let straight = Kinematics { yaw_rate: Some(0.0), ..sample(0.0, -5.1) };
        let mut friction = Friction::default();
        for _ in 0..200 {
            friction = monitor.step(&straight, Some(0.0), Evidence::default());
        }
        assert!(friction.low.is_none_or(|low| low < 0.05), "{friction:?}");
    }

    #[test]
    fn the_bound_is_forgotten_after_a_while_and_at_a_change_of_surface() {
        let car = Car::new(&Vehicle::thesis());
        let mut monitor = FrictionMonitor::new(&car, &FrictionConfig::default());
        for _ in 0..200 {
            monitor.step(&sample(0.0, 6.0), Some(0.0), Evidence::default());
        }
        let mut later = Friction::default();
        for _ in 0..600 {
            later = monitor.step(&sample(0.0, 0.0), Some(0.0), Evidence::default());
        }
        assert!(later.low.is_none_or(|low| low < 0.05), "{later:?}");
        for _ in 0..200 {
            monitor.step(&sample(0.0, 6.0), Some(0.0), Evidence::default());
        }
        monitor.surface_changed();
        let low = monitor.step(&sample(0.0, 0.0), Some(0.0), Evidence::default()).low;
        assert!(low.is_none_or(|low| low < 0.6));
    }

    #[test]
    fn a_mapping_is_published_with_its_interval_and_never_as_certain() {
        let car = Car::new(&Vehicle::thesis());
        let mut monitor = FrictionMonitor::new(&car, &FrictionConfig::default());
        let map = Some(MappedFriction { mu: 0.5, low: 0.35, high: 0.65 });
        let evidence = Evidence { map, ..Evidence::default() };
        let friction = monitor.step(&sample(0.0, 0.0), Some(0.0), evidence);
        assert_eq!((friction.source, friction.valid), (MuSource::SlopeMap, false));
        assert_eq!((friction.max, friction.low, friction.high), (Some(0.5), Some(0.35), Some(0.65)));
        let measured = Evidence { abs: Some(AbsFriction { mu: 0.8, std: 0.02, age_s: 0.0 }), ..evidence };
        assert_eq!(monitor.step(&sample(0.0, 0.0), Some(0.0), measured).source, MuSource::Abs);
        // Using more than it allows refutes it.
        let mut braking = Friction::default();
        for _ in 0..200 {
            braking = monitor.step(&sample(0.0, 8.0), Some(0.0), evidence);
        }
        assert_eq!((braking.source, braking.max), (MuSource::LowerBound, None));
    }

    #[test]
    fn an_abs_braking_is_believed_for_a_while_and_then_widens() {
        let car = Car::new(&Vehicle::thesis());
        let mut monitor = FrictionMonitor::new(&car, &FrictionConfig::default());
        let mut after = |age_s| {
            let abs = Some(AbsFriction { mu: 0.4, std: 0.02, age_s });
            monitor.step(&sample(0.0, 0.0), Some(0.0), Evidence { abs, ..Evidence::default() })
        };
        let (fresh, old, gone) = (after(0.1), after(10.0), after(30.0));
        assert!(fresh.valid && fresh.source == MuSource::Abs);
        assert!(!old.valid && old.high > fresh.high);
        assert_eq!(gone.max, None);
    }
}
