//! `gripd simulate`: a scenario to a recording, and what was true beside it.

use std::io;
use std::path::PathBuf;

use clap::Args;

use super::Failure;
use super::demo_car;
use super::output::{Output, check_outputs};
use super::tables::TableFormat;
use bus::can::Frame;
use bus::can::recording::{Format, Writer};
use bus::signals::Outputs;
use physics::model::{Scenario, Simulation, Tick, TruthWriter};
use physics::{Quantity, Sample};

/// The same scenario and seed give the same recording to the last bit.
#[derive(Args)]
pub struct Simulate {
    /// The scenario.
    scenario: PathBuf,
    /// The recording (candump, or the format that the name ends in; `.gz` and `.zst` are packed; `-` is the standard
    /// output).
    #[arg(short, long)]
    out: PathBuf,
    /// Write what was true, as CSV with a row for each 10 ms.
    #[arg(long, value_name = "CSV")]
    truth: Option<PathBuf>,
    /// Seed of everything random, instead of the scenario's.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Write frames as this car's configuration maps them, instead of the demo car's.
    #[arg(short, long)]
    config: Option<PathBuf>,
}

impl Simulate {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        if let Some(path) = &self.truth
            && TableFormat::of(path)? != TableFormat::Csv
        {
            return Err(Failure::usage(format_args!(
                "{}: the truth is written as CSV; give it a name that ends in .csv",
                path.display()
            )));
        }
        let mut simulated = self.begin()?;
        let mut truth = match &self.truth {
            Some(path) => {
                let columns = simulated.effect_columns();
                Some(TruthWriter::with_effects(Output::create(path)?, columns).map_err(Failure::work)?)
            }
            None => None,
        };
        while let Some(tick) = simulated.advance()? {
            if let Some(truth) = &mut truth {
                let row = truth.write_with(tick.truth, tick.effects);
                row.map_err(|error| Failure::from(io::Error::from(error)))?;
            }
        }
        simulated.end()?;
        match truth {
            Some(truth) => truth.into_inner().map_err(Failure::work)?.finish(),
            None => Ok(()),
        }
    }

    /// The scenario at its beginning; nothing is recorded yet.
    pub fn begin(&self) -> Result<Simulated, Failure> {
        let outputs = || [&self.out].into_iter().chain(&self.truth);
        check_outputs([&self.scenario].into_iter().chain(&self.config), outputs())?;
        let path = self.scenario.display();
        let text = std::fs::read_to_string(&self.scenario)
            .map_err(|e| Failure::usage(format_args!("cannot read the scenario {path}: {e}")))?;
        let scenario = Scenario::parse(&text).map_err(|e| Failure::usage(format_args!("{path}: {e}")))?;
        let seed = self.seed.unwrap_or(scenario.seed);
        let simulation = Simulation::new(&scenario, seed).map_err(Failure::usage)?;
        let (config, database) = match &self.config {
            Some(path) => {
                let config = super::configuration::load(path)?;
                check_outputs(config.files(), outputs())?;
                let database = config.input_database()?;
                (config, database)
            }
            None => demo_car::configuration()?,
        };
        // Speeds in km/h are made with the radius they will be read with.
        let radius = config.vehicle.wheel_radius_m.value;
        let outputs = Outputs::compile(&config.signals, &database, radius).map_err(Failure::usage)?;
        let format = super::recordings::format_of(&self.out, "")?;
        let log = Writer::create(&self.out, format, &config.bus.interface)?;
        Ok(Simulated {
            simulation,
            frames: SimulatedFrames::new(outputs),
            path: self.out.clone(),
            format,
            log,
        })
    }
}

/// A scenario that is driven and recorded, step by step.
pub struct Simulated {
    simulation: Simulation,
    frames: SimulatedFrames,
    path: PathBuf,
    format: Format,
    log: Writer,
}

impl Simulated {
    /// Columns that the scenario's effects add to the truth.
    pub fn effect_columns(&self) -> &[String] {
        self.simulation.effect_columns()
    }

    /// One step further, its frames recorded: what was true then, nothing at the end.
    pub fn advance(&mut self) -> Result<Option<Tick<'_>>, Failure> {
        let Some(tick) = self.simulation.next_tick() else { return Ok(None) };
        let mut written = Ok(());
        self.frames.take(tick.readings, &mut |frame| {
            if written.is_ok() {
                written = self.log.write(frame);
            }
        });
        written?;
        Ok(Some(tick))
    }

    /// The recording gets its name.
    pub fn end(self) -> Result<(), Failure> {
        super::recordings::tell_losses(&self.path, self.format, &self.log.finish()?);
        Ok(())
    }
}

/// Puts sensor readings into the frames that carry them, at the readings' own times.
pub struct SimulatedFrames {
    outputs: Outputs,
    /// The latest reading of each quantity.
    values: Sample,
    /// Quantities that were read at the values' time.
    updated: Vec<Quantity>,
}

impl SimulatedFrames {
    /// For a compiled mapping.
    pub fn new(outputs: Outputs) -> Self {
        let values = Sample::empty(physics::Micros(0), 0.0);
        Self { outputs, values, updated: Vec::with_capacity(Quantity::COUNT) }
    }

    /// Takes readings in order of time. Readings of one instant share their frames.
    pub fn take(&mut self, readings: &[physics::model::Reading], emit: &mut impl FnMut(&Frame)) {
        for reading in readings {
            if reading.time != self.values.time {
                self.flush(emit);
                self.values.time = reading.time;
            }
            self.values.set(reading.quantity, reading.value);
            self.updated.push(reading.quantity);
        }
        self.flush(emit);
    }

    fn flush(&mut self, emit: &mut impl FnMut(&Frame)) {
        self.outputs.send_updated(&self.updated, &self.values, emit);
        self.updated.clear();
    }
}
