//! Which variable of an FMU is which quantity of a recording, and what it is driven with.

use physics::Quantity;

use super::ForeignError;
use super::config::{FmuConfig, Wire};
use super::description::{Description, Kind, Role, Scalar};
use super::job::{Course, Job, Line, Run, Value};
use super::parent::Rows;
use super::unpack::Unpacked;
use crate::Version;

/// What was recorded: times, s, and values, SI, of each quantity.
pub type Recorded = [Vec<(f64, f64)>; Quantity::COUNT];

/// From a unit to SI, of a quantity; or why the unit is none of it.
pub type ToSi<'a> = &'a dyn Fn(Quantity, &str) -> Result<f64, String>;

/// An FMU wired to a recording.
#[derive(Clone, Debug)]
pub struct Wiring {
    /// What is to be done; its runs have only what the configuration sets.
    pub job: Job,
    /// The recording's time at which it starts, s.
    pub from_s: f64,
    /// What the outputs of the job are, and their factors to SI.
    pub outputs: Vec<(Quantity, f64)>,
    /// What is to be tuned.
    pub tuned: Vec<Knob>,
    /// What was wired to what, in words.
    pub words: Vec<String>,
}

/// A parameter to be tuned.
#[derive(Clone, Debug, PartialEq)]
pub struct Knob {
    /// Its name.
    pub name: String,
    /// Its type and how it is called over the border.
    pub kind: Kind,
    /// How it is called over the border.
    pub reference: u32,
    /// Where it is without tuning, within the range.
    pub start: f64,
    /// Its range.
    pub range: [f64; 2],
}

/// Where the FMU leaves a choice, steps are this long at most, s.
const STEP_S: f64 = 0.01;

/// A simulation shorter than this can be compared with nothing, s.
const SHORTEST_S: f64 = 1.0;

/// The input of gripd's own FMUs that is a speed, the switch that makes it count, and the speed at the start.
const OWN: [&str; 3] = ["wanted_speed", "holds_speed", "initial_speed"];

/// The switch of gripd's own FMUs that makes inputs those of a step's end.
const OWN_ENDS: &str = "inputs_are_of_the_end";

impl Wiring {
    /// Wires an FMU.
    ///
    /// # Errors
    /// Variables that are not there or of no use, units that do not fit, or a recording without what is needed.
    pub fn new(
        fmu: &Unpacked,
        config: &FmuConfig,
        recorded: &Recorded,
        to_si: ToSi<'_>,
    ) -> Result<Self, ForeignError> {
        let wirer = Wirer { description: &fmu.description, config, recorded, to_si };
        let inputs = wirer.inputs()?;
        let outputs = wirer.outputs()?;
        let (from_s, to_s) = wirer.common(&inputs);
        let step_s = wirer.step();
        if to_s - from_s < SHORTEST_S {
            return Err(failed("", "what was recorded of the inputs has no second in common"));
        }
        let steps = ((to_s - from_s) / step_s) as usize;
        let mut set = wirer.set(&inputs, from_s)?;
        let tuned = wirer.tuned(&set)?;
        // What is tuned is set by each run.
        set.retain(|value| {
            tuned.iter().all(|knob| knob.reference != value.reference || knob.kind != value.kind)
        });
        let line = |wired: &Wired<'_>| Line {
            kind: wired.variable.kind,
            reference: wired.variable.reference,
            values: (0..=steps).map(|step| wired.given(recorded, from_s + step as f64 * step_s)).collect(),
        };
        let words = |wired: &Wired<'_>, arrow: &str| {
            format!("{} {arrow} {} [{}]", wired.quantity, wired.variable.name, wired.unit)
        };
        Ok(Self {
            job: Job {
                is_three: fmu.description.version == Version::Three,
                library: fmu.library.clone(),
                resources: fmu.resources.clone(),
                token: fmu.description.token.clone(),
                name: "gripd".into(),
                step_s,
                steps,
                course: wirer.course(),
                inputs: inputs.iter().map(line).collect(),
                outputs: outputs.iter().map(|of| (of.variable.kind, of.variable.reference)).collect(),
                runs: vec![Run { set }],
            },
            from_s,
            outputs: outputs.iter().map(|of| (of.quantity, of.to_si / of.gain)).collect(),
            tuned,
            words: (inputs.iter().map(|of| words(of, "→")))
                .chain(outputs.iter().map(|of| words(of, "←")))
                .collect(),
        })
    }

    /// The rows of a run as tracks, by the recording's time.
    pub fn tracks(&self, rows: &Rows) -> Recorded {
        let mut tracks = Recorded::default();
        for (step, row) in rows.iter().enumerate() {
            let t = self.from_s + step as f64 * self.job.step_s;
            for ((quantity, factor), value) in self.outputs.iter().zip(row) {
                tracks[*quantity as usize].push((t, value * factor));
            }
        }
        tracks
    }
}

fn failed(key: impl Into<String>, reason: impl Into<String>) -> ForeignError {
    ForeignError::Wiring { key: key.into(), reason: reason.into() }
}

/// A variable that is a quantity.
struct Wired<'d> {
    quantity: Quantity,
    variable: &'d Scalar,
    unit: String,
    to_si: f64,
    gain: f64,
}

impl Wired<'_> {
    /// What the variable gets at a time of the recording.
    fn given(&self, recorded: &Recorded, t: f64) -> f64 {
        self.gain * at(&recorded[self.quantity as usize], t) / self.to_si
    }
}

struct Wirer<'a> {
    description: &'a Description,
    config: &'a FmuConfig,
    recorded: &'a Recorded,
    to_si: ToSi<'a>,
}

impl<'a> Wirer<'a> {
    fn has(&self, quantity: Quantity) -> bool {
        self.recorded[quantity as usize].len() > 1
    }

    fn variable(&self, key: &str, name: &str, role: Role) -> Result<&'a Scalar, ForeignError> {
        self.description.named(name).ok_or_else(|| {
            let like = self.description.like(name, role);
            failed(key, format!("the FMU has no variable `{name}` that is a single number; {like}"))
        })
    }

    fn wired(
        &self,
        key: &str,
        quantity: Quantity,
        variable: &'a Scalar,
        unit: Option<&str>,
        gain: f64,
    ) -> Result<Wired<'a>, ForeignError> {
        let unit = unit.unwrap_or(&variable.unit).to_owned();
        // Without a unit it is SI: gripd's own and most others are.
        let is_plain = unit.is_empty() || unit == "1";
        let to_si = if is_plain { Ok(1.0) } else { (self.to_si)(quantity, &unit) };
        let to_si = to_si.map_err(|error| failed(key, format!("variable {}: {error}", variable.name)))?;
        let unit = if is_plain { quantity.unit().to_owned() } else { unit };
        Ok(Wired { quantity, variable, unit, to_si, gain })
    }

    /// Those of a table, by its quantities.
    fn of_table(
        &self,
        table: &'static str,
        wires: &'a std::collections::BTreeMap<String, Wire>,
        role: Role,
    ) -> Result<Vec<Wired<'a>>, ForeignError> {
        let wire = |(quantity, wire): (&String, &'a Wire)| {
            let key = format!(".{table}.{quantity}");
            let quantity: Quantity = quantity.parse().map_err(|error: String| failed(&key, error))?;
            let (name, unit, gain) = wire.parts();
            let variable = self.variable(&key, name, role)?;
            if role == Role::Input && variable.role != Role::Input {
                return Err(failed(&key, format!("the variable `{name}` is no input of the FMU")));
            }
            self.wired(&key, quantity, variable, unit, gain)
        };
        wires.iter().map(wire).collect()
    }

    fn inputs(&self) -> Result<Vec<Wired<'a>>, ForeignError> {
        let mut wired = self.of_table("inputs", &self.config.inputs, Role::Input)?;
        if wired.is_empty() {
            let inputs = || self.description.variables.iter().filter(|variable| variable.role == Role::Input);
            let holds_speed = self.holds_speed();
            for variable in inputs() {
                let own_speed = variable.name == OWN[0] && holds_speed;
                let quantity = if own_speed { Ok(Quantity::VehicleSpeed) } else { variable.name.parse() };
                let Ok(quantity) = quantity else { continue };
                // Who holds the speed needs no torques, and would only add to those recorded.
                let is_left = holds_speed && !own_speed && quantity != Quantity::SteeringWheelAngle;
                if self.has(quantity) && !is_left {
                    wired.push(self.wired(".inputs", quantity, variable, None, 1.0)?);
                }
            }
        }
        if wired.iter().all(|of| of.quantity != Quantity::SteeringWheelAngle) {
            let like = self.description.like("steer", Role::Input);
            return Err(failed(
                ".inputs",
                format!("which input is the steering? give steering_wheel_angle = \"its name\"; {like}"),
            ));
        }
        if let Some(of) = wired.iter().find(|of| !self.has(of.quantity)) {
            let quantity = of.quantity;
            return Err(failed(format!(".inputs.{quantity}"), "the recording has none of it; leave it out"));
        }
        Ok(wired)
    }

    /// Does one of gripd's own FMUs hold the recorded speed? It does unless the configuration says otherwise.
    fn holds_speed(&self) -> bool {
        let [speed, switch, _] = OWN;
        let has = |name| self.description.named(name).is_some();
        has(speed) && has(switch) && self.config.set.get(switch).is_none_or(|number| number.value() != 0.0)
    }

    fn outputs(&self) -> Result<Vec<Wired<'a>>, ForeignError> {
        let mut wired = self.of_table("outputs", &self.config.outputs, Role::Output)?;
        if wired.is_empty() {
            for quantity in Quantity::ALL {
                let names = [format!("measured.{quantity}"), quantity.name().to_owned()];
                let of_name = |name: &String| self.description.named(name);
                let given = names.iter().find_map(of_name).filter(|variable| variable.role == Role::Output);
                if let Some(variable) = given {
                    wired.push(self.wired(".outputs", quantity, variable, None, 1.0)?);
                }
            }
        }
        if wired.iter().all(|of| of.quantity != Quantity::YawRate) {
            let like = self.description.like("yaw", Role::Output);
            return Err(failed(
                ".outputs",
                format!("which output is the yaw rate? give yaw_rate = \"its name\"; {like}"),
            ));
        }
        Ok(wired)
    }

    /// From when until when there is everything that drives it, s.
    fn common(&self, inputs: &[Wired<'_>]) -> (f64, f64) {
        let of = |wired: &Wired<'_>| {
            let track = &self.recorded[wired.quantity as usize];
            (track.first().map_or(0.0, |(t, _)| *t), track.last().map_or(0.0, |(t, _)| *t))
        };
        inputs
            .iter()
            .map(of)
            .fold((0.0, f64::INFINITY), |(from, to), (first, last)| (from.max(first), to.min(last)))
    }

    /// Straight lines where the FMU takes them.
    fn course(&self) -> Course {
        let is_own = self.description.named(OWN_ENDS).is_some() && !self.config.set.contains_key(OWN_ENDS);
        match (self.description.takes_rates, is_own) {
            (true, _) => Course::Rates,
            (false, true) => Course::ToTheEnd,
            (false, false) => Course::Hold,
        }
    }

    fn step(&self) -> f64 {
        if let Some(step_ms) = self.config.step_ms {
            return 1e-3 * step_ms;
        }
        let own = self.description.step_s.unwrap_or(STEP_S);
        // A multiple of what it asks for.
        if own < STEP_S { own * (STEP_S / own + 1e-9).floor() } else { own.min(1.0) }
    }

    /// What is set before the start.
    fn set(&self, inputs: &[Wired<'_>], from_s: f64) -> Result<Vec<Value>, ForeignError> {
        let mut set = Vec::new();
        let mut add = |variable: &Scalar, value: f64| {
            set.push(Value { kind: variable.kind, reference: variable.reference, value });
        };
        for (name, number) in &self.config.set {
            let variable = self.variable(&format!(".set.{name}"), name, Role::Parameter)?;
            add(variable, number.value());
        }
        for (name, quantity) in &self.config.start {
            let key = format!(".start.{name}");
            let variable = self.variable(&key, name, Role::Parameter)?;
            let quantity: Quantity = quantity.parse().map_err(|error: String| failed(&key, error))?;
            if !self.has(quantity) {
                return Err(failed(key, format!("the recording has no {quantity}")));
            }
            add(variable, self.wired(&key, quantity, variable, None, 1.0)?.given(self.recorded, from_s));
        }
        let [_, switch, initial] = OWN;
        let is_free =
            |name: &str| !self.config.set.contains_key(name) && !self.config.start.contains_key(name);
        if is_free(initial)
            && self.has(Quantity::VehicleSpeed)
            && let Some(variable) = self.description.named(initial).filter(|of| of.role == Role::Parameter)
        {
            add(variable, at(&self.recorded[Quantity::VehicleSpeed as usize], from_s));
        }
        let follows = inputs.iter().any(|of| of.variable.name == OWN[0]);
        if follows
            && is_free(switch)
            && let Some(variable) = self.description.named(switch)
        {
            add(variable, 1.0);
        }
        if self.course() == Course::ToTheEnd
            && let Some(variable) = self.description.named(OWN_ENDS)
        {
            add(variable, 1.0);
        }
        Ok(set)
    }

    fn tuned(&self, set: &[Value]) -> Result<Vec<Knob>, ForeignError> {
        let knob = |(name, range): (&String, &[f64; 2])| {
            let key = format!(".tune.{name}");
            let variable = self.variable(&key, name, Role::Parameter)?;
            if variable.role != Role::Parameter || !matches!(variable.kind, Kind::Real | Kind::Single) {
                return Err(failed(key, "only parameters that are numbers can be tuned"));
            }
            let (least, most) = variable.range;
            if least.is_some_and(|least| range[0] < least) || most.is_some_and(|most| range[1] > most) {
                let text = |bound: Option<f64>| bound.map_or("…".to_owned(), |bound| bound.to_string());
                let reason = format!("the FMU takes {} to {} only", text(least), text(most));
                return Err(failed(key, reason));
            }
            let own = set.iter().find(|value| value.reference == variable.reference).map(|value| value.value);
            let start = own.or(variable.start).unwrap_or(0.5 * (range[0] + range[1]));
            Ok(Knob {
                name: name.clone(),
                kind: variable.kind,
                reference: variable.reference,
                start: start.clamp(range[0], range[1]),
                range: *range,
            })
        };
        self.config.tune.iter().map(knob).collect()
    }
}

/// A track at a time, in a straight line between readings; constant outside.
pub(super) fn at(track: &[(f64, f64)], t: f64) -> f64 {
    let after = track.partition_point(|(time, _)| *time <= t);
    match (after.checked_sub(1).and_then(|before| track.get(before)), track.get(after)) {
        (Some((t0, v0)), Some((t1, v1))) => v0 + (v1 - v0) * (t - t0) / (t1 - t0),
        (Some((_, value)), None) | (None, Some((_, value))) => *value,
        (None, None) => 0.0,
    }
}
