//! The last minutes, ten rows a second.

use std::collections::VecDeque;

use super::Round;
use physics::{Faults, Micros, Quantity};

/// A column of the series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// One of what is published, by its name in `gripd replay --estimates`.
    Estimate(&'static str),
    /// One of what is measured.
    Input(Quantity),
}

const ESTIMATES: [&str; 32] = [
    "speed",
    "lateral_velocity",
    "sideslip",
    "slip_angle_front",
    "slip_angle_rear",
    "motion_valid",
    "slope_fl",
    "slope_fr",
    "slope_rl",
    "slope_rr",
    "slope_std",
    "slope_valid",
    "slip_offset_fl",
    "slip_offset_fr",
    "slip_offset_rl",
    "slip_offset_rr",
    "cornering_front",
    "cornering_rear",
    "cornering_front_std",
    "cornering_rear_std",
    "cornering_valid",
    "mu_max",
    "mu_max_low",
    "mu_max_high",
    "mu_used",
    "mu_valid",
    "mu_source",
    "state",
    "excitation_long",
    "excitation_lat",
    "surface_changes",
    "faults",
];

impl Column {
    /// How many there are.
    pub const COUNT: usize = ESTIMATES.len() + Quantity::COUNT;

    /// All, in the order of a row.
    pub fn all() -> impl Iterator<Item = Self> {
        ESTIMATES.into_iter().map(Self::Estimate).chain(Quantity::ALL.into_iter().map(Self::Input))
    }

    /// Its name. What is measured has that of `gripd replay --samples`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Estimate(name) => name,
            Self::Input(quantity) => quantity.name(),
        }
    }

    /// Its place in a row; `None` for a name that is no estimate's.
    pub fn place(self) -> Option<usize> {
        match self {
            Self::Estimate(name) => ESTIMATES.iter().position(|estimate| *estimate == name),
            Self::Input(quantity) => Some(ESTIMATES.len() + quantity as usize),
        }
    }
}

/// What was known at one moment. What was not is not a number.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// When.
    pub time: Micros,
    /// In the order of [`Column::all`], SI. A flag is 0 or 1; state, source and faults are the numbers of
    /// [`State`](physics::estimates::State), [`MuSource`](physics::estimates::MuSource) and the bits of [`Faults`].
    pub values: [f32; Column::COUNT],
}

impl Row {
    pub(super) fn new(
        time: Micros,
        round: &Round,
        faults: Faults,
        input: impl Fn(Quantity) -> Option<f64>,
    ) -> Self {
        let flag = |of: f64, flag: bool| if of.is_nan() { f64::NAN } else { f64::from(u8::from(flag)) };
        // Of the driven wheels; those of the others are never there.
        let any_slope = round.slope.into_iter().find(|slope| slope.is_finite()).unwrap_or(f64::NAN);
        let estimates: [f64; ESTIMATES.len()] = [
            round.speed,
            round.lateral_velocity,
            round.sideslip,
            round.slip_angle[0],
            round.slip_angle[1],
            flag(round.speed, round.motion_valid),
            round.slope[0],
            round.slope[1],
            round.slope[2],
            round.slope[3],
            round.slope_std,
            flag(any_slope, round.slope_valid),
            round.offset[0],
            round.offset[1],
            round.offset[2],
            round.offset[3],
            round.cornering[0],
            round.cornering[1],
            round.cornering_std[0],
            round.cornering_std[1],
            flag(round.cornering[0], round.cornering_valid),
            round.mu_max,
            round.mu_low,
            round.mu_high,
            round.mu_used,
            flag(round.mu_max, round.mu_valid),
            round.mu_source.map_or(f64::NAN, |source| source as u8 as f64),
            round.state.map_or(f64::NAN, |state| state as u8 as f64),
            round.excitation[0],
            round.excitation[1],
            f64::from(round.surface_changes),
            f64::from(faults.bits()),
        ];
        let mut values = [f32::NAN; Column::COUNT];
        let inputs = Quantity::ALL.map(|quantity| input(quantity).unwrap_or(f64::NAN));
        for (to, from) in values.iter_mut().zip(estimates.into_iter().chain(inputs)) {
            *to = from as f32;
        }
        Self { time, values }
    }

    /// One value.
    pub fn get(&self, column: Column) -> f32 {
        column.place().and_then(|place| self.values.get(place)).copied().unwrap_or(f32::NAN)
    }
}

/// Rows of the last minutes, oldest first.
#[derive(Clone, Debug, Default)]
pub struct Series {
    rows: VecDeque<Row>,
    next: Option<Micros>,
    /// How often it began anew.
    beginnings: u32,
    made: u64,
}

impl Series {
    /// Time between two rows.
    pub const STEP: Micros = Micros(100_000);
    /// Rows kept: ten minutes.
    pub const KEPT: usize = 6_000;
    /// A step of the clock by more than this, back, is another time altogether.
    const STEP_BACK: Micros = Micros(1_000_000);

    /// The rows there are.
    pub fn rows(&self) -> &VecDeque<Row> {
        &self.rows
    }

    /// How many were made since the start, those that are gone included.
    pub fn made(&self) -> u64 {
        self.made
    }

    /// How often a clock that was set back made it begin anew.
    pub fn beginnings(&self) -> u32 {
        self.beginnings
    }

    /// Those after the first `made`, as far as they are still there.
    pub fn since(&self, made: u64) -> impl Iterator<Item = &Row> {
        let new = usize::try_from(self.made.saturating_sub(made)).unwrap_or(usize::MAX);
        self.rows.iter().skip(self.rows.len().saturating_sub(new))
    }

    /// The time of the row that is due now, if one is. Of a pause there are no rows.
    pub(super) fn due(&mut self, now: Micros) -> Option<Micros> {
        let next = *self.next.get_or_insert(now.next_multiple_of(Self::STEP));
        if next - now > Self::STEP + Self::STEP_BACK {
            self.rows.clear();
            self.beginnings += 1;
            self.next = None;
            return None;
        }
        if now < next {
            return None;
        }
        let time = (now + Micros(1)).next_multiple_of(Self::STEP) - Self::STEP;
        self.next = Some(time + Self::STEP);
        Some(time)
    }

    pub(super) fn push(&mut self, row: Row) {
        if self.rows.len() == Self::KEPT {
            self.rows.pop_front();
        }
        self.rows.push_back(row);
        self.made += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use physics::estimates::MuSource;

    fn row(time: Micros) -> Row {
        Row::new(time, &Round::at(0.0), Faults::empty(), |_| None)
    }

    #[test]
    fn rows_are_on_the_grid_and_pauses_have_none() {
        let mut series = Series::default();
        let mut times = Vec::new();
        for now in [40_000, 90_000, 100_000, 150_000, 230_000, 930_000] {
            times.extend(series.due(Micros(now)));
        }
        assert_eq!(times, [Micros(100_000), Micros(200_000), Micros(900_000)]);
    }

    #[test]
    fn only_the_newest_are_kept_and_a_clock_set_back_begins_anew() {
        let mut series = Series::default();
        for step in 0..Series::KEPT as i64 + 10 {
            let time = series.due(Micros(step * 100_000)).unwrap();
            series.push(row(time));
        }
        assert_eq!(series.rows().len(), Series::KEPT);
        assert_eq!(series.rows()[0].time, Micros(1_000_000));
        let since: Vec<_> = series.since(series.made() - 2).map(|row| row.time).collect();
        assert_eq!(since, [Micros(600_800_000), Micros(600_900_000)]);
        assert_eq!(series.since(0).count(), Series::KEPT);
        assert_eq!(series.due(Micros(5_000_000)), None);
        assert_eq!((series.rows().len(), series.beginnings()), (0, 1));
    }

    #[test]
    fn every_column_has_its_place() {
        for (place, column) in Column::all().enumerate() {
            assert_eq!(column.place(), Some(place), "{}", column.name());
        }
        assert_eq!(Column::all().count(), Column::COUNT);
        let mut round = Round::at(0.0);
        round.mu_max = 0.5;
        round.mu_source = Some(MuSource::Brush);
        let row = Row::new(Micros(0), &round, Faults::RANGE, |q| (q == Quantity::AbsActive).then_some(1.0));
        let get = |name| row.get(Column::Estimate(name));
        assert_eq!((get("mu_max"), get("mu_source"), get("faults"), get("mu_valid")), (0.5, 3.0, 4.0, 0.0));
        assert!(get("slope_fl").is_nan() && get("slope_valid").is_nan() && get("nothing").is_nan());
        assert_eq!(row.get(Column::Input(Quantity::AbsActive)), 1.0);
    }
}
