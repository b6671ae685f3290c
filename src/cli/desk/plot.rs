//! `gripd plot`: a recording as a page to look into.

use std::path::PathBuf;

use clap::Args;

use super::output::{check_outputs, write_text};
use super::part::Part;
use super::progress::Progress;
use super::{Failure, configuration, recordings};
use bus::can::Frame;
use bus::can::recording::{LogError, Reader};
use bus::service::{Engine, Sink};
use lab::pages::plot::{self, Drive};
use physics::{Estimates, Sample};

/// One file that needs no network: what was measured and what gripd makes of it over time, with one zoom and one
/// cursor for all panels; handling curve with the understeer gradient, g-g diagram, track. With --from and --to the
/// estimators learn from what comes before the part, too.
#[derive(Args)]
pub struct Plot {
    /// Configuration of the car.
    #[arg(short, long)]
    config: PathBuf,
    /// Recordings of one car, in any format that `gripd convert` reads (`-` is the standard input), one after the other.
    #[arg(required = true)]
    logs: Vec<PathBuf>,
    /// Write the page (`-`: to the standard output).
    #[arg(long, value_name = "HTML")]
    html: PathBuf,
    #[command(flatten)]
    part: Part,
}

impl Plot {
    /// Runs it.
    pub fn run(self) -> Result<(), Failure> {
        let ends = self.part.ends(&self.logs[0])?;
        let config = configuration::for_the_service(&self.config)?;
        check_outputs(self.logs.iter().chain([&self.config]).chain(config.files()), [&self.html])?;
        let mut engine = Engine::new(&config)?;
        let quantities = config.signals.quantities.keys().copied().collect();
        let mut kept = Kept(Drive::new(quantities, [ends.from, ends.to]));
        let mut broken = Vec::new();
        let progress = Progress::of_files(&self.logs);
        for path in &self.logs {
            let mut reader = Reader::open(path).map_err(Failure::work)?;
            // What could be read before the damage is still worth a page.
            if let Err(error) = play(&mut reader, &mut engine, &mut kept, &progress) {
                broken.push(error.to_string());
            }
            recordings::warn(&reader);
        }
        engine.finish(&mut kept);
        progress.finish();
        let drive = kept.0;
        if drive.is_empty() {
            return Err(nothing(&drive, &engine, broken));
        }
        let page = plot::page(&drive, &config.vehicle, |_| {}).html();
        write_text(&self.html, &page)?;
        tracing::info!("{}: {:.1} MB", self.html.display(), page.len() as f64 / 1e6);
        if broken.is_empty() { Ok(()) } else { Err(Failure::Work(broken.join("; "))) }
    }
}

/// One recording through the engine, as far as it is asked for.
fn play(
    reader: &mut Reader,
    engine: &mut Engine,
    kept: &mut Kept,
    progress: &Progress,
) -> Result<(), LogError> {
    let mut is_first = true;
    while let Some(frame) = reader.next_frame()? {
        if is_first {
            kept.0.begin(reader.name(), frame.time);
            is_first = false;
        }
        engine.frame(&frame, kept);
        progress.advance(reader.stats().lines);
        if kept.0.is_over() {
            break;
        }
    }
    Ok(())
}

/// Why there is nothing to plot.
fn nothing(drive: &Drive, engine: &Engine, broken: Vec<String>) -> Failure {
    if !broken.is_empty() {
        return Failure::Work(broken.join("; "));
    }
    if drive.seconds() > 0.0 {
        return Failure::usage(format_args!(
            "nothing is between --from and --to: the recordings are of {}",
            drive.span()
        ));
    }
    let ids: Vec<_> = engine.ids().iter().map(ToString::to_string).collect();
    Failure::work(format_args!(
        "nothing to plot: none of the needed identifiers ({}) is in the recording; is it of this car and bus? \
         `gripd check` tells more",
        ids.join(", ")
    ))
}

/// Keeps what the engine makes; nothing is published.
struct Kept(Drive);

impl Sink for Kept {
    fn estimates(&mut self, sample: &Sample, estimates: &Estimates) {
        self.0.push(sample, estimates);
    }

    fn publish(&mut self, _frame: &Frame) {}
}
