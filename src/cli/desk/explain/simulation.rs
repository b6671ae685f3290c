//! The output of somebody's simulation: a table of the program that made it, or a recording of the car's own bus.

use std::path::Path;

use bus::Config;
use bus::signals::to_si;
use physics::Quantity;

use super::recordings;
use crate::cli::Failure;
use crate::cli::desk::part::Part;
use lab::explain::Recording;

/// Names of the column of time, in seconds.
const TIMES: [&str; 5] = ["t", "t_s", "time", "time_s", "timestamp"];

/// Reads it. A CSV file with a column of time and one of yaw rate is a table; everything else is read as a recording is, by
/// the configuration's `[signals]`.
///
/// # Errors
/// What is wrong with it, where, and what to do.
pub fn read(path: &Path, config: &Config) -> Result<Recording, Failure> {
    if let Some(table) = Table::open(path)? {
        return table.read(config.vehicle.wheel_radius_m.value);
    }
    let mut read = recordings::read(&[path.to_owned()], |_| Part::default(), config)?;
    read.whole()?;
    Ok(read.recordings.remove(0))
}

/// A table that has begun.
struct Table<'p> {
    path: &'p Path,
    rows: csv::Reader<std::fs::File>,
    /// The column of time.
    time: usize,
    /// Column, quantity, unit as written.
    columns: Vec<(usize, Quantity, String)>,
}

impl<'p> Table<'p> {
    /// None where it is not such a table.
    fn open(path: &'p Path) -> Result<Option<Self>, Failure> {
        let is_csv = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("csv"));
        if !is_csv {
            return Ok(None);
        }
        let cannot = |error: &dyn std::fmt::Display| {
            Failure::work(format_args!("cannot read the simulation {}: {error}", path.display()))
        };
        let file = std::fs::File::open(path).map_err(|error| cannot(&error))?;
        let mut rows = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(file);
        let header = rows.headers().map_err(|error| cannot(&error))?.clone();
        let mut time = None;
        let mut columns: Vec<(usize, Quantity, String)> = Vec::new();
        for (place, cell) in header.iter().enumerate() {
            let (name, unit) = named(cell);
            if TIMES.contains(&name.as_str()) && matches!(unit, "" | "s") {
                time = time.or(Some(place));
            } else if let Ok(quantity) = name.parse::<Quantity>() {
                if columns.iter().any(|(_, other, _)| *other == quantity) {
                    return Err(cannot(&format_args!(
                        "two columns are called {quantity}; leave one of them out"
                    )));
                }
                columns.push((place, quantity, unit.to_owned()));
            }
        }
        match time {
            _ if columns.iter().all(|(_, quantity, _)| *quantity != Quantity::YawRate) => Ok(None),
            None => {
                Err(cannot(&format_args!("no column of time; call it `t [s]` (seconds, from any beginning)")))
            }
            Some(time) => Ok(Some(Self { path, rows, time, columns })),
        }
    }

    /// All of it, in SI.
    fn read(mut self, wheel_radius_m: f64) -> Result<Recording, Failure> {
        let mut recording = Recording { name: self.path.display().to_string(), ..Recording::default() };
        let factors: Vec<f64> = self
            .columns
            .iter()
            .map(|column| factor(column, wheel_radius_m, self.path))
            .collect::<Result<_, _>>()?;
        let at = |row: &csv::StringRecord| {
            row.position().map_or_else(String::new, |position| format!(", line {}", position.line()))
        };
        let path = self.path;
        let mut first = None;
        let mut last = f64::NEG_INFINITY;
        for row in self.rows.records() {
            let row = row.map_err(|error| Failure::work(format_args!("{}: {error}", path.display())))?;
            let number = |place: usize| row.get(place).unwrap_or_default().parse::<f64>();
            let t = number(self.time).ok().filter(|t| t.is_finite()).ok_or_else(|| {
                Failure::work(format_args!(
                    "{}{}: the time is `{}`; a number of seconds is needed",
                    path.display(),
                    at(&row),
                    row.get(self.time).unwrap_or_default()
                ))
            })?;
            if t <= last {
                return Err(Failure::work(format_args!(
                    "{}{}: the time goes from {last} s to {t} s; rows must follow each other in time",
                    path.display(),
                    at(&row)
                )));
            }
            last = t;
            let start = *first.get_or_insert(t);
            for ((place, quantity, _), factor) in self.columns.iter().zip(&factors) {
                let cell = row.get(*place).unwrap_or_default();
                let value = match cell.to_ascii_lowercase().as_str() {
                    // Nothing is said at this moment.
                    "" | "nan" => continue,
                    _ => number(*place).ok().filter(|value| value.is_finite()),
                };
                let value = value.ok_or_else(|| {
                    Failure::work(format_args!(
                        "{}{}: {quantity} is `{cell}`; a number is needed, or nothing",
                        path.display(),
                        at(&row)
                    ))
                })?;
                recording.tracks[*quantity as usize].push((t - start, value * factor));
            }
        }
        if recording.seconds() == 0.0 {
            return Err(Failure::work(format_args!("{}: there are no rows in it", path.display())));
        }
        Ok(recording)
    }
}

/// Name and unit of a column: `yaw_rate [deg/s]`, `yaw_rate (deg/s)`, or the name alone.
fn named(cell: &str) -> (String, &str) {
    let (name, unit) = cell.split_once(['[', '(']).unwrap_or((cell, ""));
    let unit = unit.trim_end().trim_end_matches([']', ')']).trim();
    (name.trim().to_ascii_lowercase().replace([' ', '-'], "_"), unit)
}

/// From the column's unit to SI. A name alone is in SI, as `gripd simulate --truth` writes it.
fn factor(
    (_, quantity, unit): &(usize, Quantity, String),
    wheel_radius_m: f64,
    path: &Path,
) -> Result<f64, Failure> {
    if unit.is_empty() {
        return Ok(1.0);
    }
    to_si(*quantity, unit, wheel_radius_m).map_err(|error| {
        Failure::work(format_args!("{}: column {quantity}: {error}, or convert the column", path.display()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_is_called_by_its_name_and_unit() {
        assert_eq!(named("yaw_rate [deg/s]"), ("yaw_rate".into(), "deg/s"));
        assert_eq!(named(" Yaw rate (rad/s) "), ("yaw_rate".into(), "rad/s"));
        assert_eq!(named("t"), ("t".into(), ""));
    }
}
