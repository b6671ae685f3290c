//! What `monitor` and `view` look at: the same arguments for both.

use std::path::PathBuf;

use clap::Args;

use super::Failure;
use bus::Config;
use bus::service::SavedState;
use bus::watch::{Estimator, Listener, Pace, Playback, Source, Watch};
use physics::Wheel;

/// A bus, or a recording.
#[derive(Args)]
pub struct Watched {
    /// Configuration of the car.
    #[arg(short, long)]
    config: PathBuf,
    /// The CAN interface, instead of the configuration's. It need not exist yet.
    #[arg(short, long, value_name = "IF", conflicts_with = "recording")]
    interface: Option<String>,
    /// A recording to play instead (any format `replay` takes; `-`: standard input). The estimators run on it here.
    recording: Option<PathBuf>,
    /// Play the recording X times as fast.
    #[arg(long, value_name = "X", requires = "recording")]
    speed: Option<f64>,
    /// Run the estimators here, on the bus's own inputs, instead of reading what a gripd publishes there. They go on from
    /// the service's `state_file`, if the configuration names one, and leave it as it is. Nothing is sent either way.
    #[arg(long, conflicts_with = "recording")]
    estimate: bool,
}

/// What is looked at, ready to be opened.
pub struct Subject {
    /// As the service takes it.
    pub config: Config,
    /// Knows nothing yet.
    pub watch: Watch,
    /// What people call it: the interface, or the recording's name.
    pub name: String,
    interface: Option<String>,
    recording: Option<(PathBuf, Pace)>,
}

impl Watched {
    /// Reads the configuration.
    pub fn prepare(self) -> Result<Subject, Failure> {
        if let Some(speed) = self.speed.filter(|speed| !(speed.is_finite() && *speed > 0.0)) {
            return Err(Failure::usage(format_args!("--speed {speed}: must be a positive number")));
        }
        let config = super::configuration::for_the_service(&self.config)?;
        let own = self.estimate || self.recording.is_some();
        let mut watch = Watch::new(&config, if own { Estimator::Own } else { Estimator::Bus })?;
        let name = match &self.recording {
            Some(path) if path.as_os_str() == "-" => "standard input".to_owned(),
            Some(path) => path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
            None => self.interface.clone().unwrap_or_else(|| config.bus.interface.clone()),
        };
        // A recording may be older than what was learned, or of it: it starts from the data sheet, as a replay does.
        if self.recording.is_none()
            && let Some(state) = SavedState::of_service(&config, None)
        {
            take_up(&state, &mut watch);
        }
        let pace = Pace::Times(self.speed.unwrap_or(1.0));
        let recording = self.recording.map(|path| (path, pace));
        Ok(Subject { config, watch, name, interface: self.interface, recording })
    }
}

/// What the service saved, where it can be used; the file is only read.
fn take_up(state: &SavedState, watch: &mut Watch) {
    let path = state.path().display();
    match state.load() {
        Ok(Some(learned)) => {
            tracing::info!("{path}: goes on from what {:.0} s of driving taught", learned.driving_s);
            watch.restore(&learned);
        }
        Ok(None) => tracing::debug!("{path}: nothing saved yet"),
        Err(refusal) => {
            tracing::warn!(
                "{path} {refusal}; the estimators here start from [vehicle], and the file is left alone"
            );
        }
    }
}

impl Subject {
    /// Is it a recording?
    pub fn is_recording(&self) -> bool {
        self.recording.is_some()
    }

    /// The recording as fast as it can be read, whatever was asked.
    pub fn at_once(&mut self) {
        if let Some((_, pace)) = &mut self.recording {
            *pace = Pace::AtOnce;
        }
    }

    /// Opens it. A socket is only listened to.
    pub fn open(&self) -> Result<Source, Failure> {
        if let Some((path, pace)) = &self.recording {
            let playback = Playback::open(path.clone(), *pace).map_err(Failure::work)?;
            return Ok(Source::Recording(Box::new(playback)));
        }
        use bus::can::OpenError;
        let opened = Listener::open(&self.config, self.interface.as_deref(), &self.watch.ids());
        opened.map(Source::Live).map_err(|error| match error {
            OpenError::BadName(_) | OpenError::NotCan(_) => Failure::usage(error),
            other => Failure::work(other),
        })
    }

    /// The wheels whose slip slope can be told: the driven ones.
    pub fn driven(&self) -> Vec<Wheel> {
        let axle = self.config.vehicle.driven_axle;
        Wheel::ALL.into_iter().filter(|wheel| axle.drives(*wheel)).collect()
    }
}
