//! What one does at a desk: one file per subcommand.

mod applied;
mod calibrate;
mod check;
mod closing;
mod completions;
mod conceal;
mod convert;
mod demo;
mod demo_car;
mod explain;
mod export;
mod forecast;
mod identify;
mod interrupted;
pub mod library;
mod man;
mod map;
mod monitor;
mod output;
mod part;
mod player;
mod plot;
mod printable;
mod progress;
mod recordings;
mod replay;
mod reproduce;
mod samples;
mod setup;
mod simulate;
mod tables;
mod view;
mod watched;

use clap::Subcommand;

use super::{Arguments, Failure, configuration};

pub use monitor::stderr;
pub use simulate::SimulatedFrames;

/// Where this process was started to run somebody's FMU, it does that, and ends.
pub fn run_fmu_if_asked() {
    let mut arguments = std::env::args_os().skip(1);
    if arguments.next().is_some_and(|first| first == fmu::foreign::child::ARGUMENT)
        && let Some(folder) = arguments.next()
    {
        fmu::foreign::child::work(folder.as_ref());
    }
}

#[derive(Subcommand)]
pub enum Command {
    /// Simulate a drive over asphalt, gravel and ice, run the service on it, draw a page of plots.
    Demo(demo::Demo),
    /// Run the same pipeline over recordings.
    Replay(replay::Replay),
    /// Simulate a scenario to a recording.
    Simulate(simulate::Simulate),
    /// Identify the vehicle's parameters from recordings.
    Identify(identify::Identify),
    /// Where simulation and recording differ: locate it, name the missing physics, prove it on held-out data.
    Explain(Box<explain::Explain>),
    /// Put effects into a recording of a real car: what `explain` should find.
    Conceal(conceal::Conceal),
    /// Carry out the thesis's experiments again and tell which claims hold.
    Reproduce(reproduce::Reproduce),
    /// Find ABS brakings in recordings and map the slip slope to friction.
    Calibrate(calibrate::Calibrate),
    /// Check a configuration, and on recordings the measurement chain.
    Check(check::Check),
    /// From a DBC and recordings to a configuration that runs: signals found and put right, the car's numbers asked for.
    Setup(Box<setup::Setup>),
    /// Propose a configuration's signals for an unknown car, from its DBC and a recorded drive.
    Map(map::Map),
    /// Write a recording as a page to look into: signals, estimates, handling curve, g-g diagram, track.
    Plot(plot::Plot),
    /// Turn a recording of any format into one of another.
    Convert(convert::Convert),
    /// Write the car of a configuration for other programs: its tires (.tir), or all of it as an FMU.
    Export(export::Export),
    /// Watch a bus or a recording in the terminal: inputs, estimates, faults, frame rates.
    Monitor(monitor::Monitor),
    /// Watch a bus or a recording on a local web page with live plots.
    View(view::View),
    /// Write what a shell needs to complete the arguments.
    Completions(completions::Completions),
    /// Write manual pages.
    Man(man::Pages),
}

impl Command {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        // These two end in their own way.
        if !matches!(self, Self::Monitor(_) | Self::View(_)) {
            interrupted::tidies_up();
        }
        match self {
            Self::Demo(command) => command.run(),
            Self::Replay(command) => command.run(),
            Self::Simulate(command) => command.run(),
            Self::Identify(command) => command.run(),
            Self::Explain(command) => command.run(),
            Self::Conceal(command) => command.run(),
            Self::Reproduce(command) => command.run(),
            Self::Calibrate(command) => command.run(),
            Self::Check(command) => command.run(),
            Self::Setup(command) => command.run(),
            Self::Map(command) => command.run(),
            Self::Plot(command) => command.run(),
            Self::Convert(command) => command.run(),
            Self::Export(command) => command.run(),
            Self::Monitor(command) => command.run(),
            Self::View(command) => command.run(),
            Self::Completions(command) => command.run(),
            Self::Man(command) => command.run(),
        }
    }
}
