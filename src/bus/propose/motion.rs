//! What the car did, by its wheels: speed, its change, and how it turned.

use super::corners::Wheels;
use super::drive::Drive;
use super::regression::line;
use super::source::RADIUS_M;
use crate::dbc::Database;

/// Half the width of the running mean, bins.
const HALF: usize = 4;
/// Every so many bins there is a point for the regressions.
const EVERY: usize = 3;
/// A track that fits all cars to 15 %, m.
pub(super) const TRACK_M: f64 = 1.55;
/// Below this speed nothing is concluded from curves, m/s.
pub(super) const SLOW: f64 = 2.5;
/// Understeer of an ordinary car: the steering angle for a curve grows by this times the speed squared, s²/m².
const UNDERSTEER: f64 = 0.0015;

/// The three ways to halve four wheels, in the order of a group: front left, front right, rear left, rear right.
const WAYS: [[[usize; 2]; 2]; 3] = [[[0, 2], [1, 3]], [[0, 3], [1, 2]], [[0, 1], [2, 3]]];
/// Half of the time wheels that roll differ by less than this from the car, or from their side. Tuned: the recordings of
/// `tests/commands/map`.
const ALIKE: f64 = 0.06;
/// The same of both sides in circles of 5 m and more.
const APART: f64 = 0.2;
/// Correlations that differ by less tell nothing. Tuned: a race car whose rear axle is locked, `tests/commands/map`.
const AS_GOOD: f64 = 0.03;
/// An axle whose wheels differ by less than this share of what the other's do is locked. Physical: tracks differ by a tenth.
const LOCKED: f64 = 0.3;

/// Fewer points above walking pace say nothing: ten seconds.
pub(super) const FEWEST: usize = 30;

/// A drive, one point for every 0.3 s; not a number where a wheel is missing or the car is slow.
pub(super) struct Motion {
    /// Speed, m/s.
    pub(super) speed: Vec<f64>,
    /// Its change, m/s².
    pub(super) change: Vec<f64>,
    /// Wheels of the second side faster than those of the first by, m/s; mean of the axles.
    pub(super) difference: Vec<f64>,
    /// Yaw rate, rad/s, positive towards the first side; from the wheels until a sensor is known.
    pub(super) turn: Vec<f64>,
    /// The wheels of the first side, then those of the second: places in the group's order.
    pub(super) sides: [[usize; 2]; 2],
    /// The drive tells the sides apart.
    pub(super) turned: bool,
    /// The rotation that front wheels show beyond rear ones, within the sides.
    pub(super) front: Option<Front>,
    /// Where the wheels do not tell, what the yaw rate's sensor was confirmed by.
    pub(super) confirmed: Option<Confirmed>,
}

/// How well a sensor agrees with the others, where no wheels tell.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Confirmed {
    /// Correlation, 0 to 1.
    pub(super) correlation: f64,
    /// With what, in words.
    pub(super) with: &'static str,
}

/// Which wheels are in front, by the larger circles they run on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Front {
    /// The first of each side is in front of the second.
    pub(super) first: [bool; 2],
    /// How significant it is: the lesser of both sides.
    pub(super) significance: f64,
}

impl Motion {
    /// From a group of wheels; `None` if they do not behave like four wheels of a car.
    /// `turning` are the points of signals that are called sensors of turning.
    pub(super) fn of(
        database: &Database,
        drive: &Drive,
        wheels: &Wheels,
        turning: &[Vec<f64>],
    ) -> Option<Self> {
        let to_mps = RADIUS_M * wheels.unit.to_si()?;
        let raw: Vec<Vec<f64>> =
            wheels.places.iter().map(|place| drive.series(database, *place)).collect::<Option<_>>()?;
        let smooth: Vec<Vec<f64>> = raw.iter().map(|series| scaled(&points(series), to_mps)).collect();
        let mean: Vec<f64> =
            (0..smooth[0].len()).map(|i| smooth.iter().map(|wheel| wheel[i]).sum::<f64>() / 4.0).collect();
        agree(&smooth, &mean)?;
        let speed: Vec<f64> = mean.iter().map(|v| if *v > SLOW { *v } else { f64::NAN }).collect();
        let raw_mean: Vec<f64> =
            (0..raw[0].len()).map(|i| to_mps * raw.iter().map(|wheel| wheel[i]).sum::<f64>() / 4.0).collect();
        let change = derivative(&raw_mean);
        let (sides, turned) = sides(&smooth, &speed, &change, turning);
        let axles = open_axles(&smooth, &speed, sides);
        let difference: Vec<f64> = (0..mean.len())
            .map(|i| {
                let side = |wheels: [usize; 2]| {
                    let open = axles.iter().map(|axle| smooth[wheels[*axle]][i]);
                    open.sum::<f64>() / axles.len() as f64
                };
                if speed[i].is_nan() { f64::NAN } else { side(sides[1]) - side(sides[0]) }
            })
            .collect();
        let turn = scaled(&without_radii(&difference, &speed), 1.0 / TRACK_M);
        let mut motion =
            Self { speed, change, difference, turn, sides, turned, front: None, confirmed: None };
        // A locked axle says nothing of circles.
        motion.front = if axles.len() == 2 { motion.in_front(&smooth) } else { None };
        Some(motion)
    }

    /// Takes a sensor's yaw rate, rad/s and positive towards the first side, instead of the wheels'.
    pub(super) fn take_turn(&mut self, turn: Vec<f64>) {
        self.turn = turn;
    }

    /// Curvature, 1/m.
    pub(super) fn curvature(&self) -> Vec<f64> {
        self.turn.iter().zip(&self.speed).map(|(r, v)| if *v > 3.0 { r / v } else { f64::NAN }).collect()
    }

    /// What a steering angle follows, 1/m: curvature, more of it the faster the car is.
    pub(super) fn steering(&self) -> Vec<f64> {
        let curvature = self.curvature();
        curvature.iter().zip(&self.speed).map(|(k, v)| k * (1.0 + UNDERSTEER * v * v)).collect()
    }

    /// Speed times yaw rate, m/s².
    pub(super) fn lateral(&self) -> Vec<f64> {
        self.turn.iter().zip(&self.speed).map(|(r, v)| r * v).collect()
    }

    /// Seconds above walking pace.
    pub(super) fn moving_s(&self) -> f64 {
        self.speed.iter().filter(|v| v.is_finite()).count() as f64 * 0.1 * EVERY as f64
    }

    /// Standard deviation of the wheels' yaw rate, rad/s.
    pub(super) fn turning(&self) -> f64 {
        deviation(&self.turn)
    }

    /// Standard deviation of the change of speed, m/s².
    pub(super) fn changing(&self) -> f64 {
        deviation(&self.change)
    }

    /// Front wheels run on larger circles than rear ones, by half the wheelbase squared over the radius squared.
    fn in_front(&self, wheels: &[Vec<f64>]) -> Option<Front> {
        let curvature = self.curvature();
        let square: Vec<f64> = curvature.iter().map(|k| k * k).collect();
        let mut first = [true; 2];
        let mut significance = f64::INFINITY;
        for (side, order) in self.sides.iter().zip(&mut first) {
            let ahead: Vec<f64> = (0..self.speed.len())
                .map(|i| (wheels[side[0]][i] - wheels[side[1]][i]) / self.speed[i])
                .collect();
            let found = line(&ahead, &[&square, &curvature, &self.change])?;
            let half_square = *found.factors.first()?;
            // Wheelbases from 1.4 to 3.7 m.
            if !(1.0..7.0).contains(&half_square.abs()) {
                return None;
            }
            *order = half_square > 0.0;
            significance = significance.min(found.significance.abs());
        }
        (significance > 8.0).then_some(Front { first, significance })
    }
}

/// A signal's series at the points of a motion.
pub(super) fn points(series: &[f64]) -> Vec<f64> {
    let width = 2 * HALF + 1;
    (0..series.len())
        .step_by(EVERY)
        .map(|centre| {
            let window = series.get(centre.wrapping_sub(HALF)..=centre + HALF).unwrap_or_default();
            // One gap in it, and it is none: what is on both sides may be minutes apart.
            if window.len() < width { f64::NAN } else { window.iter().sum::<f64>() / width as f64 }
        })
        .collect()
}

/// The same for a change per second.
pub(super) fn derivative(series: &[f64]) -> Vec<f64> {
    (0..series.len())
        .step_by(EVERY)
        .map(|centre| {
            let window = series.get(centre.wrapping_sub(HALF)..=centre + HALF).unwrap_or_default();
            // The slope of the line through the window.
            let mut sum = 0.0;
            let mut weight = 0.0;
            for (place, value) in window.iter().enumerate() {
                let t = 0.1 * (place as f64 - HALF as f64);
                sum += t * value;
                weight += t * t;
            }
            if window.len() < 2 * HALF + 1 { f64::NAN } else { sum / weight }
        })
        .collect()
}

fn scaled(series: &[f64], factor: f64) -> Vec<f64> {
    series.iter().map(|value| factor * value).collect()
}

/// Four wheels of one car turn alike.
fn agree(wheels: &[Vec<f64>], mean: &[f64]) -> Option<()> {
    let moving: Vec<usize> = (0..mean.len()).filter(|i| mean[*i] > SLOW && mean[*i] < 120.0).collect();
    if moving.len() < FEWEST || mean.iter().any(|v| *v > 150.0) {
        return None;
    }
    let off = |wheel: usize, speed: &dyn Fn(usize) -> f64| -> f64 {
        let mut off: Vec<f64> = moving.iter().map(|i| (wheels[wheel][*i] / speed(*i) - 1.0).abs()).collect();
        off.sort_by(f64::total_cmp);
        off.get(off.len() / 2).copied().unwrap_or(f64::INFINITY)
    };
    let alike = (0..4).all(|wheel| off(wheel, &|i| mean[i]) <= ALIKE);
    // Going round in tight circles only, the wheels of one side agree, and both sides roughly.
    let circling = || {
        let of_a_side = |side: &[usize; 2]| {
            let speed = |i: usize| 0.5 * (wheels[side[0]][i] + wheels[side[1]][i]);
            side.iter().all(|wheel| off(*wheel, &speed) <= ALIKE && off(*wheel, &|i| mean[i]) <= APART)
        };
        WAYS.iter().any(|way| way.iter().all(of_a_side))
    };
    if !(alike || circling()) {
        return None;
    }
    // Copies of one signal are not four wheels.
    let apart =
        |a: usize, b: usize| moving.iter().any(|i| (wheels[a][*i] - wheels[b][*i]).abs() > 1e-6 * mean[*i]);
    let pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    let unlike = pairs.iter().filter(|(a, b)| apart(*a, *b)).count();
    (unlike >= 5 && deviation(mean) > 0.05).then_some(())
}

/// The axles whose wheels may turn unlike each other, as places in the sides: both, but where one is locked.
fn open_axles(wheels: &[Vec<f64>], speed: &[f64], sides: [[usize; 2]; 2]) -> Vec<usize> {
    let difference = |axle: usize| -> Vec<f64> {
        let pairs = wheels[sides[1][axle]].iter().zip(&wheels[sides[0][axle]]).zip(speed);
        pairs.map(|((right, left), v)| if v.is_nan() { f64::NAN } else { right - left }).collect()
    };
    let [first, second] = [0, 1].map(|axle| without_radii(&difference(axle), speed));
    let slope = |of: &[f64], against: &[f64]| {
        line(of, &[against]).and_then(|found| found.factors.first().copied()).unwrap_or(1.0)
    };
    // Of what hardly differs at all nothing is told.
    let differs = |axle: &[f64]| deviation(axle) > 0.03 * TRACK_M;
    if differs(&first) && slope(&second, &first).abs() < LOCKED {
        vec![0]
    } else if differs(&second) && slope(&first, &second).abs() < LOCKED {
        vec![1]
    } else {
        vec![0, 1]
    }
}

/// Which two wheels are on one side: of the three ways to halve the four, the one whose halves differ as a sensor of
/// turning says; or else, acceleration taken off, the one whose halves differ most.
fn sides(
    wheels: &[Vec<f64>],
    speed: &[f64],
    change: &[f64],
    turning: &[Vec<f64>],
) -> ([[usize; 2]; 2], bool) {
    let differences: Vec<Vec<f64>> = WAYS
        .iter()
        .map(|[one, other]| {
            (0..speed.len())
                .map(|i| {
                    0.5 * (wheels[other[0]][i] + wheels[other[1]][i] - wheels[one[0]][i] - wheels[one[1]][i])
                })
                .map(|d| if d.is_finite() { d } else { f64::NAN })
                .zip(speed)
                .map(|(d, v)| if v.is_nan() { f64::NAN } else { d })
                .collect()
        })
        .collect();
    let told = |difference: &Vec<f64>| -> f64 {
        let with = turning.iter().filter_map(|sensor| line(difference, &[sensor, speed, change]));
        with.map(|found| found.correlation.abs()).fold(0.0, f64::max)
    };
    let told: Vec<f64> = differences.iter().map(told).collect();
    let best = (0..3).max_by(|a, b| told[*a].total_cmp(&told[*b])).unwrap_or(0);
    // With an axle that is locked, halves with one of its wheels exchanged differ as much: then the names count.
    let way = if told[0] > told[best] - AS_GOOD { 0 } else { best };
    let sure = Some(way).filter(|way| told[*way] > 0.7);
    if let Some(way) = sure {
        return (WAYS[way], true);
    }
    let spread: Vec<f64> = differences
        .iter()
        .map(|difference| deviation(&without_traction(&without_radii(difference, speed), change)))
        .collect();
    let best = (0..3).max_by(|a, b| spread[*a].total_cmp(&spread[*b])).unwrap_or(0);
    let second = (0..3).filter(|way| *way != best).map(|way| spread[way]).fold(0.0, f64::max);
    let turned = spread[best] > 0.012 * TRACK_M && spread[best] > 1.6 * second;
    (if turned { WAYS[best] } else { WAYS[0] }, turned)
}

/// Takes off what tires of unlike size do: a difference in proportion to the speed.
fn without_radii(difference: &[f64], speed: &[f64]) -> Vec<f64> {
    let share = line(difference, &[speed]).map_or((0.0, 0.0), |found| {
        (found.factors.first().copied().unwrap_or(0.0), found.factors.last().copied().unwrap_or(0.0))
    });
    // More than a few per cent are no tires.
    let (slope, constant) = if share.0.abs() < 0.04 { share } else { (0.0, 0.0) };
    difference.iter().zip(speed).map(|(d, v)| d - slope * v - constant).collect()
}

/// Takes off what driven and braked wheels do: a difference in proportion to the acceleration.
fn without_traction(difference: &[f64], change: &[f64]) -> Vec<f64> {
    let slope = line(difference, &[change]).and_then(|found| found.factors.first().copied()).unwrap_or(0.0);
    difference.iter().zip(change).map(|(d, a)| d - slope * a).collect()
}

/// Standard deviation of what is a number.
pub(super) fn deviation(series: &[f64]) -> f64 {
    let values: Vec<f64> = series.iter().copied().filter(|value| value.is_finite()).collect();
    if values.len() < 2 {
        return 0.0;
    }
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64).sqrt()
}
