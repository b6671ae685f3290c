//! What `[vehicle] tire_file` names, put into the table: what it gives itself stays.

use std::path::Path;

use super::{Config, ConfigError};
use crate::tire_file::{AtLoad, TireFile};
use physics::model::{DrivenAxle, GRAVITY, TireKind, Uncertain};

/// Relative standard deviations of a tire's stiffnesses on a car, of which a test rig knows nothing: axles give way, and
/// roads are no sandpaper. Those of the class of car, as the defaults of the keys have them.
const LATERAL_STD: f64 = 1.0 / 3.0;
const LONGITUDINAL_STD: f64 = 0.5;
/// Numbers of both axles that should be one differ by this share before it is worth a word: beyond it they are hardly the
/// same tire at another load.
const WORTH_A_WORD: f64 = 0.1;

impl Config {
    /// Notes which keys of `[vehicle]` are given, and reads the tire files that it names.
    ///
    /// # Errors
    /// If a file cannot be used, or the table contradicts that there are any.
    pub(super) fn take_tire_files(&mut self, text: &str, path: &Path) -> Result<(), ConfigError> {
        let table: toml::Table = text.parse().map_err(|error: toml::de::Error| ConfigError::Parse {
            path: path.to_owned(),
            message: error.to_string(),
        })?;
        let vehicle = table.get("vehicle").and_then(toml::Value::as_table);
        self.given = vehicle.into_iter().flatten().map(|(key, _)| key.clone()).collect();
        let Some(files) = self.vehicle.tire_file.take() else { return Ok(()) };
        if self.is_given("tire") && self.vehicle.tire != TireKind::MagicFormula {
            return Err(ConfigError::Value {
                path: path.to_owned(),
                key: "vehicle.tire".into(),
                reason: "contradicts vehicle.tire_file, which gives a magic formula; leave one of them out"
                    .into(),
            });
        }
        // Its loads are needed.
        self.validate_vehicle(path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let axles = files.axles().map(|file| folder.join(file));
        let wrong = |source| ConfigError::TireFile { path: path.to_owned(), source };
        let front = TireFile::load(&axles[0]).map_err(wrong)?;
        let rear = if axles[0] == axles[1] { None } else { Some(TireFile::load(&axles[1]).map_err(wrong)?) };
        let loads = [true, false].map(|front| self.vehicle.static_wheel_load(front));
        let on_rear = rear.as_ref().unwrap_or(&front);
        let tires = [front.at(loads[0]).map_err(wrong)?, on_rear.at(loads[1]).map_err(wrong)?];
        for file in [Some(&front), rear.as_ref()].into_iter().flatten() {
            let (used, others) = file.counts();
            tracing::info!("{}: {used} lines used, {others} of no use here", file.name());
        }
        for (file, load) in [&front, on_rear].into_iter().zip(loads) {
            if !file.covers(load) {
                let [least, most] = file.loads();
                tracing::warn!(
                    "{}: is for loads of {least:.0} N to {most:.0} N, and a wheel of this car carries {load:.0} N",
                    file.name()
                );
            }
        }
        self.put_tires(tires, loads, path);
        self.tire_files = if rear.is_some() { axles.into() } else { vec![axles[0].clone()] };
        Ok(())
    }

    /// What the table does not give itself.
    fn put_tires(&mut self, [front, rear]: [AtLoad; 2], loads: [f64; 2], path: &Path) {
        let is_given = |key: &str| self.given.contains(key);
        let vehicle = &mut self.vehicle;
        vehicle.tire = TireKind::MagicFormula;
        let mut put = Vec::new();
        for (key, number, [front, rear]) in [
            ("magic_formula_shape", &mut vehicle.magic_formula_shape, [front.shape, rear.shape]),
            (
                "magic_formula_curvature",
                &mut vehicle.magic_formula_curvature,
                [front.curvature, rear.curvature],
            ),
            ("friction", &mut vehicle.friction, [front.friction, rear.friction]),
        ] {
            if is_given(key) {
                continue;
            }
            // The plain car has one curve for all its wheels.
            *number = Uncertain::known(0.5 * (front + rear));
            put.push(key);
            if (front - rear).abs() > WORTH_A_WORD * 0.5 * (front.abs() + rear.abs()) {
                tracing::warn!(
                    "{}: vehicle.{key} is the mean of {front:.3} in front and {rear:.3} behind: there is one for all wheels",
                    path.display()
                );
            }
        }
        for (key, number, tire) in [
            ("lateral_stiffness_front", &mut vehicle.lateral_stiffness_front, front),
            ("lateral_stiffness_rear", &mut vehicle.lateral_stiffness_rear, rear),
        ] {
            if !is_given(key) {
                *number = uncertain(tire.lateral_stiffness, LATERAL_STD);
                put.push(key);
            }
        }
        // Of one wheel, N per unit slip: what drives tells of slip.
        let [of_front, of_rear] = [(front, loads[0]), (rear, loads[1])]
            .map(|(tire, load)| tire.longitudinal_stiffness.map(|k| k * load));
        let stiffness = match vehicle.driven_axle {
            DrivenAxle::Front => of_front,
            DrivenAxle::Rear => of_rear,
            DrivenAxle::All => of_front.zip(of_rear).map(|(front, rear)| 0.5 * (front + rear)),
        };
        if let (Some(stiffness), false) = (stiffness, is_given("longitudinal_stiffness")) {
            let mean_load = 0.25 * vehicle.mass() * GRAVITY;
            vehicle.longitudinal_stiffness = uncertain(stiffness / mean_load, LONGITUDINAL_STD);
            put.push("longitudinal_stiffness");
        }
        self.given.extend(put.into_iter().map(str::to_owned));
    }
}

fn uncertain(value: f64, relative: f64) -> Uncertain {
    Uncertain { value, std: relative * value }
}
