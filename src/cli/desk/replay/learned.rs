//! What a replay has learned: each published number with its share of validity, its last value, and why it was not valid.

use super::super::closing::{Line, percent, table};
use identify::{AxleStiffness, CorneringStiffness};
use lab::report::{Page, escape, number};
use physics::estimate::EstimatorsConfig;
use physics::estimates::{Estimate, State};
use physics::model::DrivenAxle;
use physics::time::Clock;
use physics::{Estimates, Quantity, Sample, Wheel};

/// Why a number was not valid in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Why {
    /// What is required did not come.
    NoInput,
    /// The car stood, or the speed was not known.
    Standing,
    /// There was too little of what tells it.
    LittleUse,
    /// There was a value, and it was too uncertain.
    Unsure,
    /// There was one that was sure, and signals contradict each other, or it was too old.
    Doubted,
}

/// Head of the column with the reasons.
const WHY: &str = "why not valid, mostly";

/// So many reasons there are.
const REASONS: usize = 5;

/// What is published.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Published {
    Slope(usize),
    Offset(usize),
    Cornering(usize),
    Sideslip,
    Friction,
}

use Published::{Cornering, Friction, Offset, Sideslip, Slope};

/// In the order of the table.
const ALL: [Published; 12] = [
    Slope(0),
    Slope(1),
    Slope(2),
    Slope(3),
    Offset(0),
    Offset(1),
    Offset(2),
    Offset(3),
    Cornering(0),
    Cornering(1),
    Sideslip,
    Friction,
];

const WHEELS: [&str; 4] = ["front left", "front right", "rear left", "rear right"];

/// Below this excitation a number is not told for want of use. Tuned, no test on record.
const LITTLE: f64 = 0.5;

/// Of one published number.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    valid: u64,
    /// Value and standard deviation, if there is one; of the last row with a value.
    last: Option<(f64, Option<f64>)>,
    /// Rows by reason.
    why: [u64; REASONS],
}

/// Watches all rows.
#[derive(Debug)]
pub struct Learning {
    rows: u64,
    /// Of the recording.
    clock: Clock,
    driven: DrivenAxle,
    /// Quantities that had a value, as bits.
    present: u16,
    tallies: [Tally; ALL.len()],
    /// The highest use of the friction, when, s from the recording's start, and of which recording.
    used: Option<(f64, f64, Clock)>,
    /// The highest excitation along and across.
    excitation: [f64; 2],
}

impl Learning {
    /// Of a car that is driven by this axle.
    pub fn new(driven: DrivenAxle) -> Self {
        Self {
            rows: 0,
            clock: Clock::default(),
            driven,
            present: 0,
            tallies: Default::default(),
            used: None,
            excitation: [0.0; 2],
        }
    }

    /// Takes note of what a sample has.
    pub fn hear(&mut self, sample: &Sample) {
        self.present |= sample.present();
    }

    /// Has this ever had a value?
    pub const fn has(&self, quantity: Quantity) -> bool {
        self.present & quantity.bit() != 0
    }

    /// A recording begins; what comes next is of it.
    pub fn begin(&mut self, clock: Clock) {
        self.clock = clock;
    }

    /// Takes a row.
    pub fn take(&mut self, estimates: &Estimates, config: &EstimatorsConfig) {
        self.rows += 1;
        let excitation = [estimates.excitation_long, estimates.excitation_lat];
        for (highest, now) in self.excitation.iter_mut().zip(excitation) {
            *highest = highest.max(now);
        }
        if let Some(used) = estimates.friction.used
            && self.used.is_none_or(|(most, ..)| used > most)
        {
            self.used = Some((used, (estimates.time - self.clock.begins()).seconds(), self.clock));
        }
        for (published, tally) in ALL.into_iter().zip(&mut self.tallies) {
            let told = published.told(estimates);
            tally.last = told.or(tally.last);
            if published.is_valid(estimates) && told.is_some() {
                tally.valid += 1;
            } else {
                tally.why[published.why(estimates, config) as usize] += 1;
            }
        }
    }

    /// The table; nothing where there were no rows.
    pub fn text(&self, config: &EstimatorsConfig) -> String {
        if self.rows == 0 {
            return String::new();
        }
        table(&[("last value", Some(18)), (WHY, None)], &self.lines(config)) + &self.use_of_friction() + "\n"
    }

    /// The same as a part of a page.
    pub fn write(&self, page: &mut Page, config: &EstimatorsConfig) {
        page.section("learned", "What was learned", "");
        let row = |line: Line| {
            let mut row = vec![line.name, percent(line.valid)];
            row.extend(line.told);
            row
        };
        let rows: Vec<Vec<String>> = self.lines(config).into_iter().map(row).collect();
        page.table_of_words(&["", "valid", "last value", WHY], &rows);
        page.raw(&format!("<p class=\"aside\">{}.</p>", escape(&self.use_of_friction())));
    }

    fn lines(&self, config: &EstimatorsConfig) -> Vec<Line> {
        // Wheels that are not driven have no slope, and nobody misses it; where all are, one slope stands for all.
        let is_there = |(published, tally): &(Published, &Tally)| match *published {
            Slope(wheel) | Offset(wheel) => {
                tally.last.is_some()
                    || self.driven.drives(Wheel::ALL[wheel]) && (wheel < 2 || self.driven == DrivenAxle::Rear)
            }
            _ => true,
        };
        let line = |(published, tally): (Published, &Tally)| Line {
            name: published.name(),
            valid: tally.valid as f64 / self.rows.max(1) as f64,
            told: vec![published.shown(tally.last), self.why(published, tally, config)],
        };
        ALL.into_iter().zip(&self.tallies).filter(is_there).map(line).collect()
    }

    fn use_of_friction(&self) -> String {
        match self.used {
            Some((used, at, clock)) => {
                format!("highest use of the friction: {}, at {}", number(used, 2), clock.at(at))
            }
            None => {
                "the use of the friction is not known: no acceleration, and no speed to take it from".into()
            }
        }
    }

    /// The axles, as identify and explain tell them, at the end.
    pub fn cornering_stiffness(&self, config: &EstimatorsConfig) -> CorneringStiffness {
        let of = |axle: usize| {
            let published = Cornering(axle);
            let tally = ALL.iter().position(|it| *it == published).map(|place| &self.tallies[place])?;
            let (value, std) = tally.last?;
            let never = || Some(self.why(published, tally, config)).filter(|why| !why.is_empty());
            let against = if tally.valid == 0 { never() } else { None };
            Some(AxleStiffness::of((value, std.unwrap_or(f64::NAN)), against))
        };
        CorneringStiffness { front: of(0), rear: of(1) }
    }

    /// What it cannot be told without, and never came.
    fn missing(&self, published: Published) -> Option<Quantity> {
        let first_missing =
            |needed: &[Quantity]| needed.iter().copied().find(|quantity| !self.has(*quantity));
        match published {
            // By the speed that the accelerometer carries on.
            Slope(_) | Offset(_) if self.driven == DrivenAxle::All => {
                let wheels = Wheel::ALL.map(Quantity::wheel_speed);
                first_missing(&wheels).or_else(|| first_missing(&[Quantity::LongitudinalAcceleration]))
            }
            // Beside the wheel of the same side that rolls freely.
            Slope(wheel) | Offset(wheel) => {
                first_missing(&[wheel, (wheel + 2) % 4].map(|wheel| Quantity::wheel_speed(Wheel::ALL[wheel])))
            }
            Cornering(_) => first_missing(&[Quantity::LateralAcceleration]),
            Sideslip | Friction => None,
        }
    }

    /// The most frequent reason in words.
    fn why(&self, published: Published, tally: &Tally, config: &EstimatorsConfig) -> String {
        let all = [Why::NoInput, Why::Standing, Why::LittleUse, Why::Unsure, Why::Doubted];
        let most = all.into_iter().max_by_key(|why| (tally.why[*why as usize], std::cmp::Reverse(*why)));
        let Some(why) = most.filter(|why| tally.why[*why as usize] > 0) else { return String::new() };
        if tally.valid == 0
            && let Some(missing) = self.missing(published)
        {
            return format!("no {missing} in the recording, and without it there is none");
        }
        let excitation = |place: usize| format!("{} %", number(100.0 * self.excitation[place], 0));
        match (why, published) {
            (Why::NoInput, _) => "required signals are missing (gripd check)".into(),
            (Why::Standing, _) => "the car stood, or the speed is not known".into(),
            (Why::LittleUse, Slope(_) | Offset(_)) => {
                format!("too little force along, {} of enough", excitation(0))
            }
            (Why::LittleUse, Cornering(_) | Sideslip) => {
                format!("too few curves, {} of enough", excitation(1))
            }
            (Why::LittleUse, Friction) => "far from the limit: only a lower bound".into(),
            (Why::Unsure, Slope(_) | Offset(_)) => unsure(config.slope.valid_relative_std),
            (Why::Unsure, Cornering(_) | Sideslip) => unsure(config.cornering.valid_relative_std),
            (Why::Unsure, Friction) => "not near enough to the limit, or long ago".into(),
            (Why::Doubted, _) => "old, or signals contradict it (gripd check)".into(),
        }
    }
}

fn unsure(most: f64) -> String {
    format!("not sure enough: σ above {} % of it", number(100.0 * most, 0))
}

impl Published {
    fn name(self) -> String {
        match self {
            Slope(wheel) => format!("Slip slope, {}", WHEELS[wheel]),
            Offset(wheel) => format!("Slip offset, {}", WHEELS[wheel]),
            Cornering(0) => "Cornering stiffness, front".into(),
            Cornering(_) => "Cornering stiffness, rear".into(),
            Sideslip => "Sideslip".into(),
            Friction => "Friction available".into(),
        }
    }

    fn told(self, estimates: &Estimates) -> Option<(f64, Option<f64>)> {
        let of = |estimate: Option<Estimate>| estimate.map(|it| (it.value, Some(it.std)));
        match self {
            Slope(wheel) => of(estimates.slope[wheel]),
            Offset(wheel) => of(estimates.slip_offset[wheel]),
            Cornering(axle) => of(estimates.cornering[axle]),
            Sideslip => estimates.motion.sideslip.map(|angle| (angle.to_degrees(), None)),
            Friction => {
                let friction = &estimates.friction;
                let ends = friction.low.zip(friction.high);
                friction.max.map(|mu| (mu, ends.map(|(low, high)| (high - low) / (2.0 * 1.96))))
            }
        }
    }

    fn is_valid(self, estimates: &Estimates) -> bool {
        match self {
            Slope(_) | Offset(_) => estimates.slope_valid,
            Cornering(_) => estimates.cornering_valid,
            Sideslip => estimates.motion.valid,
            Friction => estimates.friction.valid,
        }
    }

    /// Of a row in which it is not valid.
    fn why(self, estimates: &Estimates, config: &EstimatorsConfig) -> Why {
        if matches!(estimates.state, State::Starting | State::NoInput) {
            return Why::NoInput;
        }
        if estimates.motion.speed.is_none_or(|speed| speed < config.minimum_speed_mps) {
            return if estimates.state == State::Degraded { Why::NoInput } else { Why::Standing };
        }
        let (known, excitation, most) = match self {
            Slope(wheel) | Offset(wheel) => {
                (estimates.slope[wheel], estimates.excitation_long, config.slope.valid_relative_std)
            }
            Cornering(axle) => {
                (estimates.cornering[axle], estimates.excitation_lat, config.cornering.valid_relative_std)
            }
            Sideslip => return Why::Doubted,
            Friction if estimates.friction.max.is_none() => return Why::LittleUse,
            Friction => return Why::Unsure,
        };
        match known {
            Some(known) if known.std <= most * known.value => Why::Doubted,
            Some(_) if excitation >= LITTLE => Why::Unsure,
            None if excitation >= LITTLE => Why::Unsure,
            _ => Why::LittleUse,
        }
    }

    /// Value ± standard deviation with its unit.
    fn shown(self, last: Option<(f64, Option<f64>)>) -> String {
        let Some((value, std)) = last else { return "–".into() };
        let (decimals, factor, unit) = match self {
            Slope(_) => (1, 1.0, ""),
            Offset(_) => (2, 100.0, " %"),
            Cornering(_) => (1, 1.0, "/rad"),
            Sideslip => (2, 1.0, "°"),
            Friction => (2, 1.0, ""),
        };
        let value = number(factor * value, decimals);
        std.map_or(format!("{value}{unit}"), |std| {
            format!("{value} ± {}{unit}", number(factor * std, decimals))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use physics::Micros;
    use physics::estimates::Motion;

    /// Of a car that sends all quantities.
    fn everything(driven: DrivenAxle) -> Learning {
        Learning { present: u16::MAX, ..Learning::new(driven) }
    }

    fn driving(time_s: f64) -> Estimates {
        let motion = Motion { speed: Some(20.0), ..Motion::default() };
        let time = Micros::from_seconds(time_s);
        Estimates { time, state: State::Running, motion, ..Estimates::default() }
    }

    #[test]
    fn a_drive_that_teaches_nothing_says_why() {
        let config = EstimatorsConfig::default();
        let mut learning = everything(DrivenAxle::Front);
        assert_eq!(learning.text(&config), "");
        for tick in 0..100 {
            let mut row = driving(0.01 * f64::from(tick));
            row.excitation_long = 0.03;
            row.friction.used = Some(0.002 * f64::from(tick));
            learning.take(&row, &config);
        }
        let text = learning.text(&config);
        let line = |name: &str| text.lines().find(|line| line.starts_with(name)).unwrap().to_owned();
        assert!(line("Slip slope, front left").contains("too little force along, 3 % of enough"), "{text}");
        assert!(line("Cornering stiffness, rear").contains("too few curves, 0 %"), "{text}");
        assert!(line("Friction").contains("0 %") && line("Friction").contains("lower bound"), "{text}");
        assert!(text.contains("highest use of the friction: 0.20, at 1.0 s\n"), "{text}");
        assert!(!text.contains("rear left"), "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    }

    #[test]
    fn what_is_valid_has_its_share_and_its_last_value() {
        let config = EstimatorsConfig::default();
        let mut learning = everything(DrivenAxle::Front);
        let estimate = Some(Estimate { value: 30.0, std: 2.0, age_s: 0.0 });
        for tick in 0..4 {
            let mut row = driving(f64::from(tick));
            row.slope[0] = estimate;
            row.slope_valid = tick > 0;
            row.cornering[0] = Some(Estimate { value: 12.0, std: 6.0, age_s: 0.0 });
            row.excitation_lat = 1.0;
            learning.take(&row, &config);
        }
        let text = learning.text(&config);
        let line = |name: &str| text.lines().find(|line| line.starts_with(name)).unwrap().to_owned();
        let slope = line("Slip slope, front left");
        assert!(slope.contains("75 %") && slope.contains("30.0 ± 2.0"), "{slope}");
        assert!(line("Cornering stiffness, front").contains("σ above 15 % of it"), "{text}");
    }

    #[test]
    fn what_never_came_is_the_reason() {
        let config = EstimatorsConfig::default();
        let line = |driven, missing: Quantity, name: &str| {
            let mut learning = everything(driven);
            learning.present &= !missing.bit();
            let mut row = driving(1.0);
            (row.excitation_long, row.excitation_lat) = (1.0, 1.0);
            learning.take(&row, &config);
            let text = learning.text(&config);
            text.lines().find(|line| line.starts_with(name)).unwrap_or_default().to_owned()
        };
        let lateral = line(DrivenAxle::Front, Quantity::LateralAcceleration, "Cornering stiffness, rear");
        assert!(lateral.contains("no lateral_acceleration in the recording"), "{lateral}");
        for driven in [DrivenAxle::Front, DrivenAxle::Rear, DrivenAxle::All] {
            let name =
                if driven == DrivenAxle::Rear { "Slip slope, rear left" } else { "Slip slope, front left" };
            let left = line(driven, Quantity::WheelSpeedRl, name);
            assert!(left.contains("no wheel_speed_rl in the recording"), "{left}");
        }
        let right = line(DrivenAxle::Front, Quantity::WheelSpeedRl, "Slip slope, front right");
        assert!(right.contains("σ above"), "{right}");
        assert_eq!(line(DrivenAxle::Rear, Quantity::WheelSpeedRl, "Slip slope, front"), "");
        let all = line(DrivenAxle::All, Quantity::LongitudinalAcceleration, "Slip slope, front left");
        assert!(all.contains("no longitudinal_acceleration"), "{all}");
    }
}
