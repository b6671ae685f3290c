//! `--estimates` and `--samples`: one row per sample, SI units, empty where not available.
//!
//! The slopes are normalized by the static load of their wheel.

use std::io::{self, Write};

use crate::estimates::Estimate;
use crate::{Estimates, Quantity, Sample, Wheel};

/// Writes rows of numbers, empty where there is none.
pub struct Table<W> {
    output: W,
    row: String,
}

impl<W: Write> Table<W> {
    fn new(mut output: W, columns: &[String]) -> io::Result<Self> {
        writeln!(output, "{}", columns.join(","))?;
        Ok(Self { output, row: String::new() })
    }

    fn time(&mut self, sample: &Sample) {
        use std::fmt::Write;
        self.row.clear();
        // Writing to a string cannot fail.
        let _ = write!(self.row, "{}", sample.time);
    }

    fn number(&mut self, value: Option<f64>) {
        use std::fmt::Write;
        self.row.push(',');
        if let Some(value) = value.filter(|value| value.is_finite()) {
            let _ = write!(self.row, "{value}");
        }
    }

    fn flag(&mut self, value: bool) {
        self.row.push_str(if value { ",1" } else { ",0" });
    }

    fn end(&mut self) -> io::Result<()> {
        self.row.push('\n');
        self.output.write_all(self.row.as_bytes())
    }

    /// The output, flushed.
    pub fn into_inner(mut self) -> io::Result<W> {
        self.output.flush()?;
        Ok(self.output)
    }
}

/// The `--estimates` table.
pub struct EstimatesTable<W>(Table<W>);

impl<W: Write> EstimatesTable<W> {
    /// Writes the header.
    pub fn new(output: W) -> io::Result<Self> {
        Table::new(output, &Self::columns()).map(Self)
    }

    fn columns() -> Vec<String> {
        let mut columns: Vec<String> = vec!["t".into(), "speed".into()];
        for prefix in ["slope_{}", "slope_{}_std", "slip_offset_{}"] {
            columns.extend(Wheel::ALL.map(|wheel| prefix.replace("{}", wheel.name())));
        }
        let rest = "lateral_velocity sideslip slip_angle_front slip_angle_rear vy_zero vy_integration \
            vy_kinematic vy_bicycle vy_joint cornering_front cornering_front_std cornering_rear \
            cornering_rear_std cornering_regression_front cornering_regression_rear cornering_ekf \
            cornering_ekf_std mu_max mu_max_low mu_max_high mu_used mu_source mu_brush mu_dahl mu_abs mu_map \
            slope_valid cornering_valid mu_valid motion_valid surface_changes faults \
            slope_age cornering_age mu_age excitation_long excitation_lat road_angle_offset \
            lateral_acceleration_offset yaw_rate_offset mu_map_low mu_map_high mu_brush_std";
        columns.extend(rest.split_whitespace().map(str::to_owned));
        columns
    }

    /// Writes what is known after a sample.
    pub fn row(&mut self, sample: &Sample, now: &Estimates) -> io::Result<()> {
        let value = |estimate: Option<Estimate>| estimate.map(|e| e.value);
        let std = |estimate: Option<Estimate>| estimate.map(|e| e.std);
        let age = |estimate: Option<Estimate>| estimate.map(|e| e.age_s);
        let table = &mut self.0;
        table.time(sample);
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
        table.row.push(',');
        table.row.push_str(friction.source.name());
        for number in [friction.brush, friction.dahl, friction.abs, friction.map] {
            table.number(number);
        }
        for flag in [now.slope_valid, now.cornering_valid, friction.valid, now.motion.valid] {
            table.flag(flag);
        }
        table.number(Some(f64::from(now.surface_changes)));
        table.number(Some(f64::from(now.faults.bits())));
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
        ] {
            table.number(number);
        }
        table.end()
    }

    /// The output, flushed.
    pub fn into_inner(self) -> io::Result<W> {
        self.0.into_inner()
    }
}

/// The `--samples` table: the quantities that are configured.
pub struct SamplesTable<W> {
    table: Table<W>,
    quantities: Vec<Quantity>,
}

impl<W: Write> SamplesTable<W> {
    /// Writes the header.
    pub fn new(output: W, quantities: Vec<Quantity>) -> io::Result<Self> {
        let mut columns = vec!["t".to_owned()];
        columns.extend(quantities.iter().map(|quantity| quantity.name().to_owned()));
        Ok(Self { table: Table::new(output, &columns)?, quantities })
    }

    /// Writes a sample.
    pub fn row(&mut self, sample: &Sample) -> io::Result<()> {
        self.table.time(sample);
        for quantity in &self.quantities {
            self.table.number(sample.get(*quantity));
        }
        self.table.end()
    }

    /// The output, flushed.
    pub fn into_inner(self) -> io::Result<W> {
        self.table.into_inner()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Micros;

    #[test]
    fn every_row_has_as_many_fields_as_the_header() {
        let mut table = EstimatesTable::new(Vec::new()).unwrap();
        table.row(&Sample::empty(Micros(20_000), 0.01), &Estimates::default()).unwrap();
        let text = String::from_utf8(table.into_inner().unwrap()).unwrap();
        let fields: Vec<usize> = text.lines().map(|line| line.split(',').count()).collect();
        assert_eq!(fields[0], fields[1], "{text}");
        assert!(text.lines().nth(1).unwrap().starts_with("0.020000,,"));
    }
}
