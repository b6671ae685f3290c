//! One wheel at its limit, from points of its slip curve.

/// Tuned with the test `sim3`: over seeds, tires and surfaces, at the limit and far from it; what lies beyond it with the test
/// `campaign`.
struct Tuning {
    /// Fewest points of a flat stretch.
    fewest: usize,
    /// By so many times the slip must grow along the stretch.
    growth: f64,
    /// Of the points so many must lie in the middle half of the slips: a jump has none there, or one that the
    /// averaging put there.
    between: usize,
    /// The stretch is flat if its slope is, with 97.5 % confidence, below this share of force/slip. A brush tire is
    /// that flat from 97 % use on.
    flat: f64,
    /// Force/slip at its end against the tire's slope at most.
    secant: f64,
    /// … and below the slope of the softest surface that is driven on (loose snow): what could be another surface
    /// that begins gradually is no limit.
    softest: f64,
    /// The smallest slip at which a tire has its limit, and the smallest friction of a road.
    least: (f64, f64),
    /// The range of slips in standard deviations of their noise at least.
    clear: f64,
    /// The forces scatter about the stretch's line by this share of themselves at most.
    scatter: f64,
    /// Points this near to the largest force make the friction.
    top: f64,
    /// After so many points of running away the wheel spins.
    spinning: u32,
    /// Slip runs away with a step clear by so many deviations (by chance one in 370 at most), …
    clear_step: f64,
    /// … of which the line through the origin expects this share of the force, or more, …
    worth_a_look: f64,
    /// … and the force moves by less than this share of that.
    moved_without_force: f64,
    /// Beyond the limit, where force/slip is below this share of the tire's slope, it gives less.
    beyond: f64,
    /// A wheel spins, however long it has, with this slip or more beyond what turning may be, …
    spins: f64,
    /// … where force/slip is below this share of a tire's slope: on the softest surface half of it is left.
    spins_softly: f64,
}

const TUNING: Tuning = Tuning {
    fewest: 4,
    growth: 2.5,
    between: 2,
    flat: 0.25,
    secant: 0.5,
    softest: 12.0,
    least: (0.008, 0.04),
    clear: 8.0,
    scatter: 0.06,
    top: 0.97,
    spinning: 3,
    clear_step: 3.0,
    worth_a_look: 0.15,
    moved_without_force: 0.3,
    beyond: 0.15,
    spins: 0.05,
    spins_softly: 0.07,
};

/// A stretch of a wheel's slip curve at the limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtLimit {
    /// Longitudinal force / load of the wheel.
    pub mu: f64,
    /// Standard deviation of its noise.
    pub std: f64,
    /// Does the tire slip far beyond its limit, where it gives less?
    pub is_beyond: bool,
}

/// A point of a wheel's slip curve, driving positive, braking negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlipPoint {
    /// Slip, its offset taken off.
    pub slip: f64,
    /// Standard deviation of its noise and of the offset.
    pub slip_std: f64,
    /// Longitudinal force / load of the wheel.
    pub mu: f64,
    /// Standard deviation of its noise.
    pub mu_std: f64,
}

impl SlipPoint {
    /// The force, if the wheel spins: whatever came before, so much slip for so little force is beyond any limit. `measured` is the
    /// slip with its offset: while a wheel spins nobody learns that. `turning` is what there may be of slip without any force.
    pub(super) fn spins(&self, measured: f64, turning: f64, slope: f64) -> Option<AtLimit> {
        let (sign, mu) = (self.mu.signum(), self.mu.abs());
        let slip = (sign * measured).min(sign * self.slip - 2.0 * self.slip_std) - turning;
        let spins = slip > TUNING.spins && mu > TUNING.least.1 && mu < TUNING.spins_softly * slope * slip;
        spins.then_some(AtLimit { mu, std: self.mu_std, is_beyond: true })
    }
}

/// Watches one wheel for its limit.
#[derive(Clone, Debug)]
pub struct WheelSaturation {
    points: [SlipPoint; Self::LENGTH],
    count: usize,
    /// Successive points between which slip ran away from the force.
    running_away: u32,
}

impl WheelSaturation {
    /// Points that are looked at together. Tuned with the test `sim3`.
    const LENGTH: usize = 12;

    /// Nothing seen yet.
    pub const fn new() -> Self {
        let nothing = SlipPoint { slip: 0.0, slip_std: 0.0, mu: 0.0, mu_std: 0.0 };
        Self { points: [nothing; Self::LENGTH], count: 0, running_away: 0 }
    }

    /// Forgets what was seen: points before and after a gap do not belong together.
    pub fn reset(&mut self) {
        self.count = 0;
        self.running_away = 0;
    }

    /// The slip has been growing (or shrinking) for some points without the force: what a straight
    /// line through the slip curve must not be fitted to.
    pub fn is_spinning(&self) -> bool {
        self.running_away >= TUNING.spinning
    }

    /// Takes the next point; `slope` is the tire's, as far as it is known. Returns the force if the tire is at its limit.
    pub fn step(&mut self, point: SlipPoint, slope: f64) -> Option<AtLimit> {
        let sign = point.mu.signum();
        let point = SlipPoint { slip: sign * point.slip, mu: point.mu.abs(), ..point };
        if !(point.slip.is_finite() && point.mu.is_finite()) {
            self.reset();
            return None;
        }
        self.watch(&point);
        if self.count == Self::LENGTH {
            self.points.rotate_left(1);
            self.count -= 1;
        }
        self.points[self.count] = point;
        self.count += 1;
        let seen = &self.points[..self.count];
        // Of most drives this is all there is to do.
        if seen.iter().all(|point| point.slip < TUNING.least.0) {
            return None;
        }
        (TUNING.fewest..=self.count).rev().find_map(|length| Self::limit(&seen[self.count - length..], slope))
    }

    /// Does slip run away from the force between the last point and this one?
    fn watch(&mut self, point: &SlipPoint) {
        let Some(last) = self.count.checked_sub(1).and_then(|i| self.points.get(i)) else { return };
        let grown = point.slip - last.slip;
        let expected = (last.mu * grown / last.slip).abs();
        let clear = grown.abs() > TUNING.clear_step * (point.slip_std + last.slip_std) && last.slip > 0.0;
        let away = clear
            && expected > TUNING.worth_a_look * last.mu
            && (point.mu - last.mu).abs() < TUNING.moved_without_force * expected;
        self.running_away = if away { self.running_away.saturating_add(1) } else { 0 };
    }

    /// The force, if these points are a stretch at the limit.
    fn limit(points: &[SlipPoint], slope: f64) -> Option<AtLimit> {
        let n = points.len() as f64;
        let mean = |value: fn(&SlipPoint) -> f64| points.iter().map(value).sum::<f64>() / n;
        let (slip, mu) = (mean(|p| p.slip), mean(|p| p.mu));
        let least = points.iter().map(|p| p.slip).fold(f64::INFINITY, f64::min);
        let most = points.iter().map(|p| p.slip).fold(f64::NEG_INFINITY, f64::max);
        let range = most - least;
        let noise = mean(|p| p.slip_std);
        let grown = least > 0.0 && most > TUNING.growth * least && range > TUNING.clear * noise;
        if !grown
            || most < TUNING.least.0
            || mu < TUNING.least.1
            || mu > TUNING.softest.min(TUNING.secant * slope) * most
        {
            return None;
        }
        let inner = (least + 0.25 * range)..(most - 0.25 * range);
        if points.iter().filter(|p| inner.contains(&p.slip)).count() < TUNING.between {
            return None;
        }
        let spread: f64 = points.iter().map(|p| (p.slip - slip).powi(2)).sum();
        let tangent = points.iter().map(|p| (p.slip - slip) * (p.mu - mu)).sum::<f64>() / spread;
        let residual: f64 = points.iter().map(|p| (p.mu - mu - tangent * (p.slip - slip)).powi(2)).sum();
        let scatter = (residual / (n - 2.0)).sqrt().max(mean(|p| p.mu_std));
        let tangent_std = scatter / spread.sqrt();
        if scatter > TUNING.scatter * mu || tangent + 1.96 * tangent_std > TUNING.flat * mu / slip {
            return None;
        }
        let largest = points.iter().map(|p| p.mu).fold(0.0, f64::max);
        let top = points.iter().filter(|p| p.mu >= TUNING.top * largest);
        let (count, sum) = top.fold((0.0, 0.0), |(count, sum), p| (count + 1.0, sum + p.mu));
        let is_beyond = mu < TUNING.beyond * slope * least;
        Some(AtLimit { mu: sum / count, std: scatter / f64::sqrt(count), is_beyond })
    }
}

impl Default for WheelSaturation {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(slip: f64, mu: f64, slip_std: f64) -> SlipPoint {
        SlipPoint { slip, slip_std, mu, mu_std: 0.01 }
    }

    #[test]
    fn a_wheel_that_spins_is_beyond_its_limit_whatever_came_before() {
        let spins = |slip: f64, mu: f64| point(slip, mu, 0.001).spins(slip, 0.0, 90.0);
        let found = spins(0.3, 0.2).unwrap();
        assert!(found.is_beyond && found.mu == 0.2, "{found:?}");
        // Backwards, too.
        assert!(spins(-0.3, -0.2).is_some());
        // Loose snow gives way, and carries more the more it slips.
        assert_eq!(spins(0.045, 0.2), None);
        assert_eq!(spins(0.055, 0.4), None);
    }

    #[test]
    fn a_smaller_tire_does_not_spin() {
        // Its offset is known, or not yet; or what was learned of it was learned while it spun.
        assert_eq!(point(0.0, 0.05, 0.002).spins(0.07, 0.0, 90.0), None);
        assert_eq!(point(0.07, 0.05, 0.02).spins(0.07, 0.0, 90.0), None);
        assert_eq!(point(0.3, 0.05, 0.002).spins(0.0, 0.0, 90.0), None);
    }

    #[test]
    fn an_axle_that_is_locked_does_not_spin_in_a_tight_curve() {
        let wheel = point(0.09, 0.05, 0.002);
        assert!(wheel.spins(0.09, 0.0, 90.0).is_some());
        // Its track is 1.6 m, the radius of the curve 20 m.
        assert_eq!(wheel.spins(0.09, 0.08, 90.0), None);
    }
}
