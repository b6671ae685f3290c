//! `gripd demo`: the service on a simulated car, and a page that tells how it did.

mod drive;
mod findings;
mod link;
mod page;
mod recorder;
mod row;
mod terminal;

use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

use self::drive::Drive;
use self::findings::Findings;
use self::link::{Ends, SimulatedTimeLink};
use self::page::Story;
use self::recorder::{Recorder, Show};
use super::output::Output;
use super::{Failure, demo_car};
use bus::can::CanId;
use bus::can::candump::Writer;
use bus::service::{self, Engine, Service};
use bus::signals::Outputs;
use bus::signals::publish::built_in_database;
use physics::model::Scenario;

const SCENARIO: &str = include_str!("../../../config/scenarios/demo.toml");

/// Needs no files, no root, and no CAN in the kernel: it runs on vcan0 if there is one, else on a bus in
/// memory, and finds the same on both. The same seed draws the same page.
#[derive(Args)]
pub struct Demo {
    /// The page.
    #[arg(short, long, value_name = "HTML", default_value = "gripd-demo.html")]
    out: PathBuf,
    /// Seed of everything random, instead of the scenario's.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Another drive than the built-in one.
    #[arg(long, value_name = "TOML")]
    scenario: Option<PathBuf>,
    /// Run on this virtual CAN interface.
    #[arg(short, long, value_name = "IF", conflicts_with = "memory")]
    interface: Option<String>,
    /// Run in memory even if there is a vcan0.
    #[arg(long)]
    memory: bool,
    /// Keep what travelled on the bus, the car's frames and the published ones (candump; .gz and .zst are
    /// packed).
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
    /// Print every published frame as a candump line; the summary goes to the standard error then.
    #[arg(long)]
    all: bool,
}

impl Demo {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        let started = Instant::now();
        let scenario = self.scenario()?;
        let seed = self.seed.unwrap_or(scenario.seed);
        let (config, input) = demo_car::configuration()?;
        let output = built_in_database().map_err(Failure::work)?;
        let engine = Engine::with_databases(&config, &input, &output)?.with_thesis();
        // The car's own control units know the data sheet's radius, too.
        let radius = config.vehicle.wheel_radius_m.value;
        let frames = Outputs::compile(&config.signals, &input, radius).map_err(Failure::usage)?;
        let drive = Drive::new(&scenario, seed, frames).map_err(Failure::usage)?;

        let interface = self.chosen_interface();
        let shown = interface.unwrap_or(link::USUAL);
        let log =
            self.log.as_ref().map(|path| Writer::create(path, shown)).transpose().map_err(Failure::work)?;
        let show = if self.all { Show::Frames } else { Show::Seconds };
        let mut recorder = Recorder::new(engine.publisher().incoming(&output), show, shown);
        let ran = run(engine, drive, interface, log, &mut recorder)?;
        let (rows, published) = recorder
            .finish()
            .map_err(|e| Failure::work(format_args!("cannot write to the standard output: {e}")))?;

        let findings = Findings::new(&scenario, &ran.truth, &rows, &config.estimators);
        let story = Story { scenario: &scenario, seed, truth: &ran.truth, rows: &rows, findings: &findings };
        let html = story.html().map_err(Failure::work)?;
        let mut page = Output::create(&self.out)?;
        page.write_all(html.as_bytes()).map_err(Failure::work)?;
        page.finish()?;
        self.say(&format!(
            "{}\nThe page with plots: {}\n",
            terminal::summary(&findings, published),
            self.out.display()
        ))?;
        tracing::info!(
            "{} s on {} in {:.1} s, {} frames lost",
            scenario.duration_s,
            interface.unwrap_or("a bus in memory"),
            started.elapsed().as_secs_f64(),
            ran.lost
        );
        Ok(())
    }

    fn scenario(&self) -> Result<Scenario, Failure> {
        let Some(path) = &self.scenario else { return Scenario::parse(SCENARIO).map_err(Failure::work) };
        let shown = path.display();
        let text = std::fs::read_to_string(path)
            .map_err(|e| Failure::usage(format_args!("cannot read the scenario {shown}: {e}")))?;
        Scenario::parse(&text).map_err(|e| Failure::usage(format_args!("{shown}: {e}")))
    }

    /// `None`: in memory.
    fn chosen_interface(&self) -> Option<&str> {
        let usual = || (link::is_up(link::USUAL) && !link::is_real(link::USUAL)).then_some(link::USUAL);
        if self.memory { None } else { self.interface.as_deref().or_else(usual) }
    }

    fn say(&self, text: &str) -> Result<(), Failure> {
        let written = if self.all {
            std::io::stderr().write_all(text.as_bytes())
        } else {
            std::io::stdout().write_all(text.as_bytes())
        };
        recorder::unless_pipe_closed(written).map_err(Failure::work)
    }
}

/// What a drive left behind.
struct Ran {
    truth: Vec<physics::model::Truth>,
    lost: u64,
}

/// The drive, with the service's own loop.
fn run(
    engine: Engine,
    drive: Drive,
    interface: Option<&str>,
    log: Option<Writer>,
    recorder: &mut Recorder,
) -> Result<Ran, Failure> {
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(Failure::work)?;
    runtime.block_on(async {
        let ids: Vec<CanId> = engine.ids().to_vec();
        let ends = match interface {
            Some(name) => Ends::on_interface(name, &ids)?,
            None => Ends::in_memory(),
        };
        let mut link = SimulatedTimeLink::new(ends, drive, log);
        let over = link.over();
        service::serve(Service::new(engine, &mut link), recorder, over).await;
        let (drive, lost) = link.finish()?;
        Ok(Ran { truth: drive.into_truth(), lost })
    })
}
