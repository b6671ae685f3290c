//! What stands in the `--estimates` and `--samples` tables, whoever writes them down: one row per sample, SI units, nothing
//! where it is not available.
//!
//! The slopes are normalized by the static load of their wheel.

use std::borrow::Cow;
use std::io;

use physics::estimates::Estimate;
use physics::{Estimates, Micros, Quantity, Sample, Wheel};

/// A column.
pub struct Column {
    /// As it stands in the header.
    pub name: String,
    /// SI; `1` for pure numbers, nothing for words and flags.
    pub unit: Cow<'static, str>,
    /// What it holds.
    pub kind: Kind,
}

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Numbers, or none.
    Real,
    /// Whole numbers.
    Count,
    /// Yes or no.
    Flag,
    /// One of a few words.
    Word,
}

impl Column {
    /// One that holds that.
    pub fn new(name: impl Into<String>, unit: impl Into<Cow<'static, str>>, kind: Kind) -> Self {
        Self { name: name.into(), unit: unit.into(), kind }
    }

    fn real(name: impl Into<String>, unit: &'static str) -> Self {
        Self::new(name, unit, Kind::Real)
    }
}

/// Takes rows, value by value in the order of the columns.
pub trait Rows {
    /// Begins a row with its time.
    fn time(&mut self, time: Micros);
    /// A number, which is finite, or none.
    fn number(&mut self, value: Option<f64>);
    /// A whole number.
    fn count(&mut self, value: u32);
    /// Yes or no.
    fn flag(&mut self, value: bool);
    /// One of a few words.
    fn word(&mut self, word: &'static str);
    /// Ends a row.
    ///
    /// # Errors
    /// If it cannot be written, or does not have the values of its columns.
    fn end(&mut self) -> io::Result<()>;
}

/// A number that may be none.
fn number(rows: &mut (impl Rows + ?Sized), value: Option<f64>) {
    rows.number(value.filter(|value| value.is_finite()));
}

/// Of the `--estimates` table.
pub fn estimates_columns() -> Vec<Column> {
    let mut columns = vec![Column::real("t", "s"), Column::real("speed", "m/s")];
    for prefix in ["slope_{}", "slope_{}_std", "slip_offset_{}"] {
        columns.extend(Wheel::ALL.map(|wheel| Column::real(prefix.replace("{}", wheel.name()), "1")));
    }
    for (names, unit, kind) in [
        ("lateral_velocity", "m/s", Kind::Real),
        ("sideslip slip_angle_front slip_angle_rear", "rad", Kind::Real),
        ("vy_zero vy_integration vy_kinematic vy_bicycle vy_joint", "m/s", Kind::Real),
        (
            "cornering_front cornering_front_std cornering_rear cornering_rear_std \
             cornering_regression_front cornering_regression_rear cornering_ekf cornering_ekf_std",
            "1/rad",
            Kind::Real,
        ),
        ("mu_max mu_max_low mu_max_high mu_used", "1", Kind::Real),
        ("mu_source", "", Kind::Word),
        ("mu_brush mu_dahl mu_abs mu_map", "1", Kind::Real),
        ("slope_valid cornering_valid mu_valid motion_valid", "", Kind::Flag),
        ("surface_changes faults", "1", Kind::Count),
        ("slope_age cornering_age mu_age", "s", Kind::Real),
        ("excitation_long excitation_lat", "1", Kind::Real),
        ("road_angle_offset", "rad", Kind::Real),
        ("lateral_acceleration_offset", "m/s²", Kind::Real),
        ("yaw_rate_offset", "rad/s", Kind::Real),
        ("mu_map_low mu_map_high mu_brush_std", "1", Kind::Real),
        ("roughness roughness_std", "m/s", Kind::Real),
    ] {
        columns.extend(names.split_whitespace().map(|name| Column::new(name, unit, kind)));
    }
    columns
}

/// What is known after a sample.
///
/// # Errors
/// Those of [`Rows::end`].
pub fn estimates_row(rows: &mut (impl Rows + ?Sized), sample: &Sample, now: &Estimates) -> io::Result<()> {
    let value = |estimate: Option<Estimate>| estimate.map(|e| e.value);
    let std = |estimate: Option<Estimate>| estimate.map(|e| e.std);
    let age = |estimate: Option<Estimate>| estimate.map(|e| e.age_s);
    rows.time(sample.time);
    number(rows, now.motion.speed);
    now.slope.iter().for_each(|slope| number(rows, value(*slope)));
    now.slope.iter().for_each(|slope| number(rows, std(*slope)));
    now.slip_offset.iter().for_each(|offset| number(rows, value(*offset)));
    let thesis = &now.thesis;
    let velocities = &thesis.lateral_velocities;
    let [front, rear] = now.cornering;
    let friction = &now.friction;
    for value in [
        now.motion.lateral_velocity,
        now.motion.sideslip,
        now.motion.slip_angle_front,
        now.motion.slip_angle_rear,
        velocities.zero,
        velocities.integration,
        velocities.kinematic,
        velocities.bicycle,
        velocities.joint,
        value(front),
        std(front),
        value(rear),
        std(rear),
        value(thesis.cornering_regression[0]),
        value(thesis.cornering_regression[1]),
        value(thesis.cornering_ekf),
        std(thesis.cornering_ekf),
        friction.max,
        friction.low,
        friction.high,
        friction.used,
    ] {
        number(rows, value);
    }
    rows.word(friction.source.name());
    for value in [friction.brush, thesis.friction_dahl, friction.abs, friction.map] {
        number(rows, value);
    }
    for flag in [now.slope_valid, now.cornering_valid, friction.valid, now.motion.valid] {
        rows.flag(flag);
    }
    rows.count(now.surface_changes);
    rows.count(now.faults.bits());
    let slope_age = now.slope.iter().flatten().map(|slope| slope.age_s).reduce(f64::max);
    for value in [
        slope_age,
        age(front),
        friction.age_s,
        Some(now.excitation_long),
        Some(now.excitation_lat),
        value(now.offsets.road_angle),
        value(now.offsets.lateral_acceleration),
        value(now.offsets.yaw_rate),
        friction.map_interval.map(|(low, _)| low),
        friction.map_interval.map(|(_, high)| high),
        friction.brush_std,
        value(now.roughness),
        std(now.roughness),
    ] {
        number(rows, value);
    }
    rows.end()
}

/// Of the `--samples` table: the quantities that are configured.
pub fn samples_columns(quantities: &[Quantity]) -> Vec<Column> {
    let mut columns = vec![Column::real("t", "s")];
    columns.extend(quantities.iter().map(|quantity| Column::real(quantity.name(), quantity.unit())));
    columns
}

/// A sample.
///
/// # Errors
/// Those of [`Rows::end`].
pub fn samples_row(
    rows: &mut (impl Rows + ?Sized),
    sample: &Sample,
    quantities: &[Quantity],
) -> io::Result<()> {
    rows.time(sample.time);
    for quantity in quantities {
        number(rows, sample.get(*quantity));
    }
    rows.end()
}
