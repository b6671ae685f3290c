//! Along the road. The measured speed is an input of a free run, so that no force along the car is known. But what it tells of
//! each wheel and of the accelerometer can be compared; and what the accelerometer reads beyond the change of speed is gravity
//! on a slope.

use physics::model::GRAVITY;
use physics::model::effect::{Kind, named};
use physics::{Quantity, Wheel};
use predict::GriddedDrive;
use predict::car::Compute;

use super::beyond::clear_stretches;
use super::fit::FreeFit;
use super::grid::{STEP_S, interpolated, mean, slope};
use super::inputs::FreeDrive;
use super::numbers::placed;
use super::road::{LEAST_ROWS, NUMBERS, ROW_S, Road, Row, SCALE, Shape, Thought, price};
use super::run::{Predicted, later, run};
use super::scores::FreeTrace;
use crate::explain::exogenous::{CourseOf, follows_motion};
use crate::explain::proof::Sums;
use crate::explain::result::{ByChannel, CourseEstimate, Estimate, Finding, Parts, full_name};
use crate::explain::select::LEAST_EVIDENCE;
use crate::explain::smooth::Smoothed;

/// A row is a mean over so many grid points.
const EVERY: usize = (ROW_S / STEP_S) as usize;

/// What is thought of the sensor: a zero may be anything; a body that squats and dives tilts it by 2 to 6 % of the acceleration
/// (Gillespie 1992, chapter 7), and the scales of speed and acceleration in a DBC that somebody found out are off by some per
/// cent; what is late of it has been put right; and it sits ahead of the centre of gravity or behind it, to the left or to the
/// right, m.
const THOUGHT: Thought = [(0.0, 10.0), (0.03, 0.07), (0.0, 0.02), (0.0, 0.7), (0.0, 0.3)];

/// A road's grade changes over some tens of metres at least. Physical: 10 % within 30 m is a crest of 300 m radius, over which a
/// car at 50 km/h loses 0.65 m/s² of its weight.
const SHORTEST_M: f64 = 30.0;

/// Measured and predicted are compared each so many grid points.
const COMPARED_EVERY: usize = 10;

/// How late the accelerometer may be beside the speed, s, and in which steps that is tried. Numerical.
const DELAYS_S: [f64; 2] = [-0.2, 0.2];
const DELAY_STEP_S: f64 = 0.02;

/// Whether a course follows from how one drove is asked so often, s. Numerical: roads change more slowly.
const FOLLOWED_EVERY_S: f64 = 0.1;

/// Less is not told from how a body pitches and how wheels slip, rad. Tuned by recordings: what two drives of a TTS on a track
/// leave has courses of 0.008 and 0.010, without evidence (`explained::by_hand::real_drives`).
const LEAST_GRADE_RAD: f64 = 0.012;

/// A course of which more follows from how one drove is of the car. Drivers answer hills, so it is more than of the wind: of
/// the RAV4's it is 0.37, of the GTI's drives on a level lot, where there is none, 0.13 at most.
const MOST_FOLLOWING: f64 = 0.6;

/// A sensor whose scale is off by more deviations than this is not what it is called. Statistical: one in ten thousand.
const MOST_OFF: f64 = 4.0;

/// Of drives on which the accelerometer wanders so much, one in so many has a sensor whose zero does, and no hills: roads climb
/// by 2 to 6 % nearly everywhere, and zeros of such sensors move by some hundredths of m/s² in an hour.
const HILLS_PER_DRIFT: f64 = 50.0;

/// What the speed says along the road.
#[derive(Clone, Debug, Default)]
pub struct Along {
    sums: [Parts<Sums>; 2],
    /// Longitudinal acceleration, measured and predicted.
    pub traces: Vec<FreeTrace>,
    /// The road's grade, where it is clearly there.
    pub grade: Option<Finding>,
}

impl Along {
    /// Of drives along which a car was fitted. `gridded` tells of the same recording how it was driven.
    pub fn of(
        found: &FreeFit<'_>,
        drives: &[FreeDrive],
        gridded: &[GriddedDrive],
        kinds: &[&'static Kind],
    ) -> Self {
        let mut all = Self::default();
        let kind = named("road_grade").filter(|kind| kinds.contains(kind));
        for (number, drive) in drives.iter().enumerate() {
            let (model, sensing) = placed(&found.model, &found.free, &found.at, number);
            let said = run(drive, &model.car(), sensing, Compute::Readings);
            all.compare_wheels(drive, &said);
            let Some(felt) = Felt::of(drive, &said, |t| drive.driven(t, sensing.delay_s, sensing.scale))
            else {
                continue;
            };
            // A course is of one drive.
            let alone = kind.filter(|_| drives.len() == 1);
            let of_drive = gridded.iter().find(|gridded| gridded.name == drive.name);
            all.compare_acceleration(drive, &felt, alone.zip(of_drive));
        }
        all
    }

    /// Fits in %, without and with the road's grade.
    pub fn fits(&self) -> [Parts<ByChannel>; 2] {
        self.sums.each_ref().map(Parts::fits)
    }

    /// Root mean square errors likewise, SI.
    pub fn errors(&self) -> [Parts<ByChannel>; 2] {
        self.sums.each_ref().map(Parts::errors)
    }

    /// Each wheel beside what the measured speed says of it; its radius is what it is in the mean.
    fn compare_wheels(&mut self, drive: &FreeDrive, said: &Predicted) {
        for (wheel, (measured, said)) in Wheel::ALL.into_iter().zip(drive.wheels.iter().zip(&said.wheels)) {
            let Some(measured) = measured else { continue };
            let counts = |i: &usize| drive.counts[*i] && measured[*i].is_finite();
            let mean = |of: &[f64]| -> f64 {
                (0..drive.points()).filter(counts).filter(|i| !drive.held[*i]).map(|i| of[i]).sum()
            };
            let size = mean(measured) / mean(said);
            for sums in &mut self.sums {
                let rows = (0..drive.points()).filter(counts);
                let rows = rows.map(|i| (drive.held[i], measured[i], size * said[i]));
                sums.add(Quantity::wheel_speed(wheel), rows);
            }
        }
    }

    fn compare_acceleration(
        &mut self,
        drive: &FreeDrive,
        felt: &Felt,
        asked: Option<(&'static Kind, &GriddedDrive)>,
    ) {
        let trained = |row: usize| !felt.held[row];
        let (level, without) = Shape::of(&felt.rows, &trained, &THOUGHT, None);
        let plain = Road::of(&felt.rows, &trained, &THOUGHT, &level);
        let mut found = None;
        if let Some((kind, gridded)) = asked.filter(|_| felt.rows.len() >= LEAST_ROWS) {
            let (shape, with) = Shape::of(&felt.rows, &trained, &THOUGHT, Some(SHORTEST_M));
            let evidence = without - with - price(felt.rows.len());
            let between = Road::of(&felt.rows, &trained, &THOUGHT, &shape);
            let slope = Slope::of(felt, &shape, evidence);
            let share = 1.0 - felt.held_square(&between) / felt.held_square(&plain);
            let follows = slope.follows(gridded);
            let off = (slope.scale - THOUGHT[SCALE].0) / THOUGHT[SCALE].1;
            tracing::debug!(?shape, evidence, share, follows, off, rms = slope.rms(), "the road's grade");
            let is_told = evidence > LEAST_EVIDENCE
                && share > 0.0
                && slope.rms() > LEAST_GRADE_RAD
                && follows < MOST_FOLLOWING
                && off.abs() < MOST_OFF;
            if is_told {
                self.grade = Some(slope.finding(kind, drive, share));
                found = Some(between);
            }
        }
        let said = [&plain, found.as_ref().unwrap_or(&plain)].map(|road| felt.said(road));
        let points = &felt.points;
        for (sums, said) in self.sums.iter_mut().zip(&said) {
            let rows = points.iter().zip(said).map(|(point, said)| (point.held, point.measured, *said));
            sums.add(Quantity::LongitudinalAcceleration, rows);
        }
        let both = said[1].iter().zip(&said[0]);
        let rows =
            points.iter().zip(both).map(|(point, (found, plain))| [point.t, point.measured, *found, *plain]);
        let channel = Quantity::LongitudinalAcceleration;
        self.traces.push(FreeTrace { recording: drive.name.clone(), channel, rows: rows.collect() });
    }
}

/// The accelerometer along the car beside what the change of speed tells.
struct Felt {
    rows: Vec<Row>,
    /// Is a row held out?
    held: Vec<bool>,
    /// Where it is compared.
    points: Vec<Point>,
}

/// What it reads, and what the speed tells of that, m/s², as means over a row's length.
struct Point {
    t: f64,
    measured: f64,
    told: f64,
    held: bool,
}

impl Felt {
    /// None where there is no such sensor, or too little of it.
    fn of(drive: &FreeDrive, said: &Predicted, driven: impl Fn(f64) -> (f64, f64)) -> Option<Self> {
        let measured = mean(drive.longitudinal.as_ref()?, EVERY);
        let driven: Vec<(f64, f64)> = (0..drive.points()).map(|i| driven(drive.time(i))).collect();
        // v̇ₓ − r v_y (ISO 8855).
        let faster = |i: usize| {
            let (speed, faster) = driven[i];
            faster - said.yaw_rate[i] * speed * said.tan_sideslip[i]
        };
        let told: Vec<f64> = (0..drive.points()).map(faster).collect();
        let known = |every: usize| -> Vec<usize> {
            (EVERY..drive.points().saturating_sub(EVERY))
                .step_by(every)
                .filter(|i| drive.counts[*i] && measured[*i].is_finite() && told[*i].is_finite())
                .collect()
        };
        let (places, points) = (known(EVERY), known(COMPARED_EVERY));
        let trained = || places.iter().copied().filter(|i| !drive.held[*i]);
        if trained().count() < LEAST_ROWS / 2 {
            return None;
        }
        let late = |delay_s: f64| mean(&later(told.clone(), delay_s), EVERY);
        let unlike = |delay_s: f64| {
            let told = late(delay_s);
            spread(trained().map(|i| measured[i] - told[i]))
        };
        let steps = ((DELAYS_S[1] - DELAYS_S[0]) / DELAY_STEP_S).round() as usize;
        let delays = (0..=steps).map(|step| DELAYS_S[0] + step as f64 * DELAY_STEP_S);
        let delay_s = delays.min_by(|a, b| unlike(*a).total_cmp(&unlike(*b)))?;
        let late_told = late(delay_s);
        let mut way = vec![0.0; drive.points()];
        for i in 1..way.len() {
            way[i] = way[i - 1] + driven[i].0 * STEP_S;
        }
        let (faster, turning) = (slope(&late_told), slope(&mean(&said.yaw_rate, EVERY)));
        let row = |i: &usize| {
            let told = late_told[*i];
            let by: [f64; NUMBERS] = [1.0, told, -faster[*i], -said.yaw_rate[*i].powi(2), -turning[*i]];
            Row { t: drive.time(*i), way: way[*i], excess: measured[*i] - told, by }
        };
        let point = |i: &usize| Point {
            t: drive.time(*i),
            measured: measured[*i],
            told: late_told[*i],
            held: drive.held[*i],
        };
        Some(Self {
            rows: places.iter().map(row).collect(),
            held: places.iter().map(|i| drive.held[*i]).collect(),
            points: points.iter().map(point).collect(),
        })
    }

    /// What it should read at each point.
    fn said(&self, road: &Road) -> Vec<f64> {
        let excess = |row: usize| (self.rows[row].t, road.excess(row, &self.rows));
        let track: Vec<(f64, f64)> = (0..self.rows.len()).map(excess).collect();
        let mut cursor = 1;
        self.points.iter().map(|point| point.told + interpolated(&track, &mut cursor, point.t).0).collect()
    }

    fn held_square(&self, road: &Road) -> f64 {
        let held = (0..self.rows.len()).filter(|row| self.held[*row]);
        held.map(|row| (self.rows[row].excess - road.excess(row, &self.rows)).powi(2)).sum()
    }
}

/// Variance times count.
fn spread(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum, square) = values
        .fold((0.0, 0.0, 0.0), |(n, sum, square), value| (n + 1.0, sum + value, square + value * value));
    square - sum * sum / f64::max(count, 1.0)
}

/// The road's grade as all rows tell it.
struct Slope {
    t: Vec<f64>,
    /// rad, with its deviation.
    grade: Vec<(f64, f64)>,
    /// By what share the sensor reads too much.
    scale: f64,
    /// Time in which it changes, s.
    lasting_s: f64,
    /// So many stretches of the road say something of their own.
    stretches: f64,
    evidence: f64,
}

impl Slope {
    fn of(felt: &Felt, shape: &Shape, evidence: f64) -> Self {
        let rows = &felt.rows;
        let road = Road::of(rows, &|_| true, &THOUGHT, shape);
        let mean = road.slope.iter().map(|(slope, _)| slope).sum::<f64>() / rows.len().max(1) as f64;
        let grade = road
            .slope
            .iter()
            .map(|(slope, std)| (((slope - mean) / GRAVITY).clamp(-1.0, 1.0).asin(), std / GRAVITY));
        let (first, last) = (rows[0], rows[rows.len() - 1]);
        let (way, time) = (last.way - first.way, last.t - first.t);
        Self {
            t: rows.iter().map(|row| row.t).collect(),
            grade: grade.collect(),
            scale: road.sensor[SCALE].0,
            lasting_s: shape.length_m * time / way.max(1.0),
            stretches: (way / (2.0 * shape.length_m)).max(1.0),
            evidence,
        }
    }

    fn rms(&self) -> f64 {
        mean_square(self.grade.iter().map(|(grade, _)| *grade)).sqrt()
    }

    /// How much of it follows from how the car was driven: a brake that pitches the body is no hill.
    fn follows(&self, drive: &GriddedDrive) -> f64 {
        let track: Vec<(f64, f64)> =
            self.t.iter().copied().zip(self.grade.iter().map(|(grade, _)| *grade)).collect();
        let [from, to] =
            [self.t[0], self.t[self.t.len() - 1]].map(|t| (t / FOLLOWED_EVERY_S).ceil() as usize);
        let t: Vec<f64> = (from..to).map(|i| i as f64 * FOLLOWED_EVERY_S).collect();
        let mut cursor = 1;
        let value = t.iter().map(|t| interpolated(&track, &mut cursor, *t).0).collect();
        let course = Smoothed { std: vec![0.0; t.len()], value, t };
        follows_motion(drive, &course, self.lasting_s, CourseOf::Road)
    }

    fn finding(&self, kind: &'static Kind, drive: &FreeDrive, share: f64) -> Finding {
        let mut finding = Finding::of(kind, None);
        let accelerometer = Quantity::LongitudinalAcceleration.name();
        let drift = (-0.5 * self.evidence).exp() + HILLS_PER_DRIFT.recip();
        finding.probability = 1.0 / (1.0 + drift);
        finding.indistinguishable_from = vec![full_name("sensor_drift", Some(accelerometer))];
        finding.evidence = self.evidence;
        finding.explained_share = [(accelerometer.to_owned(), share)].into();
        finding.place.channels = vec![accelerometer.to_owned()];
        finding.place.recording.clone_from(&drive.name);
        let rms = kind.course.map(|course| course.rms_name.to_owned());
        let std = (mean_square(self.grade.iter().map(|(_, std)| *std)) / self.stretches).sqrt();
        finding.parameters.extend(rms.map(|name| (name, Estimate { value: self.rms(), std })));
        let (value, std) = self.grade.iter().copied().unzip();
        let course = CourseEstimate { t: self.t.clone(), value, std, unit: "rad".into() };
        finding.place.intervals = clear_stretches(&course);
        finding.series = Some(course);
        finding
    }
}

fn mean_square(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1) as f64;
    values.map(|value| value * value).sum::<f64>() / count
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use physics::model::effect::KINDS;

    use super::super::super::bench::{case, recorded};
    use super::*;
    use crate::explain::result::{Explanation, Verdict};

    /// What is said of the bench's drive with these effects, by a bus that has no torque.
    fn explained(effects: &str) -> Explanation {
        let (vehicle, mut recording) = recorded(effects);
        recording.tracks[Quantity::DriveTorque as usize].clear();
        recording.tracks[Quantity::BrakePressure as usize].clear();
        let recordings = [recording];
        let library: Vec<&'static Kind> =
            KINDS.iter().copied().filter(|kind| kind.name == "road_grade").collect();
        let mut case = case(&vehicle, &recordings);
        case.library = &library;
        case.explain(&|_, _| {}).explanation
    }

    /// GIVEN hills, and a bus without torque WHEN it is explained THEN they are named, with their course and with what else
    /// could be in the accelerometer, and held-out driving is predicted better.
    #[test]
    fn hills_are_in_the_accelerometer() {
        let truth = |t: f64| 0.04 * (t / 5.0).sin();
        let mut points = (String::new(), String::new());
        for t in 0..60 {
            write!(points.0, "{t}.0,").unwrap();
            write!(points.1, "{},", truth(f64::from(t))).unwrap();
        }
        let hills = format!(
            "[[effect]]\nkind = \"road_grade\"\nseries = {{ t = [{}], value = [{}] }}",
            points.0, points.1
        );
        let told = explained(&hills);
        assert_eq!(told.verdict, Verdict::MissingPhysics);
        let grade = &told.findings[0];
        assert_eq!(grade.effect, "road_grade");
        assert_eq!(grade.indistinguishable_from, ["sensor_drift:longitudinal_acceleration"]);
        let course = grade.series.as_ref().unwrap();
        let mean = course.t.iter().map(|t| truth(*t)).sum::<f64>() / course.t.len() as f64;
        let errors = course.t.iter().zip(&course.value).map(|(t, value)| value - (truth(*t) - mean));
        let error = mean_square(errors.collect::<Vec<_>>().into_iter()).sqrt();
        assert!(error < 0.01, "{error}");
        let [before, after] =
            [&told.fit.baseline, &told.fit.extended].map(|fit| fit.holdout["longitudinal_acceleration"]);
        assert!(after > 88.0 && after > before + 5.0, "{before} {after}");
    }

    /// GIVEN a level road THEN there are no hills, and the measured speed tells wheels and accelerometer.
    #[test]
    fn a_level_road_has_none_and_the_speed_tells_the_rest() {
        let told = explained("");
        assert!(told.findings.iter().all(|finding| finding.effect != "road_grade"), "{:?}", told.findings);
        for channel in ["longitudinal_acceleration", "wheel_speed_fl", "wheel_speed_rr"] {
            assert!(told.fit.baseline.holdout[channel] > 85.0, "{channel} {:?}", told.fit.baseline.holdout);
        }
    }
}
