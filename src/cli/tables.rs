//! `--estimates` and `--samples`: one row per sample, SI units, empty where not available. CSV, or Parquet or MF4
//! where the file's name ends so.
//!
//! The slopes are normalized by the static load of their wheel.

mod csv;
mod mf4;
mod parquet;

use std::io::{self, Seek, Write};
use std::path::Path;

use self::csv::Csv;
use self::mf4::Mf4;
use self::parquet::Parquet;
use super::Failure;
use physics::estimates::Estimate;
use physics::{Estimates, Micros, Quantity, Sample, Wheel};

/// A column.
pub struct Column {
    name: String,
    /// SI; `1` for pure numbers, nothing for words and flags.
    unit: &'static str,
    kind: Kind,
}

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
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
    fn new(name: impl Into<String>, unit: &'static str, kind: Kind) -> Self {
        Self { name: name.into(), unit, kind }
    }

    fn real(name: impl Into<String>, unit: &'static str) -> Self {
        Self::new(name, unit, Kind::Real)
    }
}

/// How a table is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableFormat {
    /// Comma-separated values.
    Csv,
    /// Apache Parquet.
    Parquet,
    /// ASAM MF4: signals.
    Mf4,
}

impl TableFormat {
    /// By the extension of a file's name; CSV where that says nothing.
    pub fn of(path: &Path) -> Result<Self, Failure> {
        let ends_in = |what: &&str| path.extension().is_some_and(|end| end.eq_ignore_ascii_case(what));
        match ["parquet", "mf4", "gz", "zst"].iter().find(|what| ends_in(what)) {
            Some(&"parquet") => Ok(Self::Parquet),
            Some(&"mf4") => Ok(Self::Mf4),
            Some(packed) => Err(Failure::usage(format_args!(
                "{}: tables are not written as .{packed}; Parquet is packed (.parquet)",
                path.display()
            ))),
            None => Ok(Self::Csv),
        }
    }
}

/// Takes rows, value by value.
enum Table<W: Write + Seek + Send> {
    Csv(Csv<W>),
    Parquet(Box<Parquet<W>>),
    Mf4(Box<Mf4<W>>),
}

impl<W: Write + Seek + Send> Table<W> {
    fn new(output: W, format: TableFormat, title: &str, columns: &[Column]) -> io::Result<Self> {
        Ok(match format {
            TableFormat::Csv => Self::Csv(Csv::new(output, columns)?),
            TableFormat::Parquet => Self::Parquet(Box::new(Parquet::new(output, title, columns)?)),
            TableFormat::Mf4 => Self::Mf4(Box::new(Mf4::new(output, title, columns)?)),
        })
    }

    /// Begins a row.
    fn time(&mut self, time: Micros) {
        match self {
            Self::Csv(table) => table.time(time),
            Self::Parquet(table) => table.time(time),
            Self::Mf4(table) => table.time(time),
        }
    }

    fn number(&mut self, value: Option<f64>) {
        let value = value.filter(|value| value.is_finite());
        match self {
            Self::Csv(table) => table.number(value),
            Self::Parquet(table) => table.number(value),
            Self::Mf4(table) => table.number(value),
        }
    }

    fn count(&mut self, value: u32) {
        match self {
            Self::Csv(table) => table.count(value),
            Self::Parquet(table) => table.count(value),
            Self::Mf4(table) => table.count(value),
        }
    }

    fn flag(&mut self, value: bool) {
        match self {
            Self::Csv(table) => table.flag(value),
            Self::Parquet(table) => table.flag(value),
            Self::Mf4(table) => table.flag(value),
        }
    }

    fn word(&mut self, word: &'static str) {
        match self {
            Self::Csv(table) => table.word(word),
            Self::Parquet(table) => table.word(word),
            Self::Mf4(table) => table.word(word),
        }
    }

    /// Ends a row.
    fn end(&mut self) -> io::Result<()> {
        match self {
            Self::Csv(table) => table.end(),
            Self::Parquet(table) => table.end(),
            Self::Mf4(table) => table.end(),
        }
    }

    /// The output, with everything in it.
    fn into_inner(self) -> io::Result<W> {
        match self {
            Self::Csv(table) => table.into_inner(),
            Self::Parquet(table) => table.into_inner(),
            Self::Mf4(table) => table.into_inner(),
        }
    }
}

/// The `--estimates` table.
pub struct EstimatesTable<W: Write + Seek + Send>(Table<W>);

impl<W: Write + Seek + Send> EstimatesTable<W> {
    /// Writes the header.
    pub fn new(output: W, format: TableFormat) -> io::Result<Self> {
        Table::new(output, format, "estimates", &Self::columns()).map(Self)
    }

    fn columns() -> Vec<Column> {
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

    /// Writes what is known after a sample.
    pub fn row(&mut self, sample: &Sample, now: &Estimates) -> io::Result<()> {
        let value = |estimate: Option<Estimate>| estimate.map(|e| e.value);
        let std = |estimate: Option<Estimate>| estimate.map(|e| e.std);
        let age = |estimate: Option<Estimate>| estimate.map(|e| e.age_s);
        let table = &mut self.0;
        table.time(sample.time);
        table.number(now.motion.speed);
        now.slope.iter().for_each(|slope| table.number(value(*slope)));
        now.slope.iter().for_each(|slope| table.number(std(*slope)));
        now.slip_offset.iter().for_each(|offset| table.number(value(*offset)));
        let velocities = &now.lateral_velocities;
        let [front, rear] = now.cornering;
        let friction = &now.friction;
        for number in [
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
            value(now.cornering_regression[0]),
            value(now.cornering_regression[1]),
            value(now.cornering_ekf),
            std(now.cornering_ekf),
            friction.max,
            friction.low,
            friction.high,
            friction.used,
        ] {
            table.number(number);
        }
        table.word(friction.source.name());
        for number in [friction.brush, friction.dahl, friction.abs, friction.map] {
            table.number(number);
        }
        for flag in [now.slope_valid, now.cornering_valid, friction.valid, now.motion.valid] {
            table.flag(flag);
        }
        table.count(now.surface_changes);
        table.count(now.faults.bits());
        let slope_age = now.slope.iter().flatten().map(|slope| slope.age_s).reduce(f64::max);
        for number in [
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
            table.number(number);
        }
        table.end()
    }

    /// The output, with everything in it.
    pub fn into_inner(self) -> io::Result<W> {
        self.0.into_inner()
    }
}

/// The `--samples` table: the quantities that are configured.
pub struct SamplesTable<W: Write + Seek + Send> {
    table: Table<W>,
    quantities: Vec<Quantity>,
}

impl<W: Write + Seek + Send> SamplesTable<W> {
    /// Writes the header.
    pub fn new(output: W, format: TableFormat, quantities: Vec<Quantity>) -> io::Result<Self> {
        let mut columns = vec![Column::real("t", "s")];
        columns.extend(quantities.iter().map(|quantity| Column::real(quantity.name(), quantity.unit())));
        Ok(Self { table: Table::new(output, format, "samples", &columns)?, quantities })
    }

    /// Writes a sample.
    pub fn row(&mut self, sample: &Sample) -> io::Result<()> {
        self.table.time(sample.time);
        for quantity in &self.quantities {
            self.table.number(sample.get(*quantity));
        }
        self.table.end()
    }

    /// The output, with everything in it.
    pub fn into_inner(self) -> io::Result<W> {
        self.table.into_inner()
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use physics::Micros;

    #[test]
    fn every_row_has_as_many_fields_as_the_header() {
        let mut table = EstimatesTable::new(Cursor::new(Vec::new()), TableFormat::Csv).unwrap();
        table.row(&Sample::empty(Micros(20_000), 0.01), &Estimates::default()).unwrap();
        let text = String::from_utf8(table.into_inner().unwrap().into_inner()).unwrap();
        let fields: Vec<usize> = text.lines().map(|line| line.split(',').count()).collect();
        assert_eq!(fields[0], fields[1], "{text}");
        assert!(text.lines().nth(1).unwrap().starts_with("0.020000,,"));
    }
}
