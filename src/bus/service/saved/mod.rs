//! Saved state: what the estimators learned, in a file, from one drive to the next.
//!
//! A file that is not wholly right is not used at all: not one that was cut short or changed, nor one of
//! another vehicle, of another mapping of its signals, or of a newer version. It is moved aside and not
//! overwritten, so that somebody can look at it, and the estimators start from what the drive before began with
//! (`NAME.before`) if the file was damaged, else from the data sheet.

mod file;
mod keeper;

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use nix::errno::Errno;
use nix::fcntl::{Flock, FlockArg};
use thiserror::Error;

use crate::Config;
use crate::new_file::{NewFile, remove_leftovers};
use crate::plain_file;
use physics::estimate::Learned;

pub use file::{fingerprint, parse, text};
pub use keeper::Keeper;

/// Why a file is not used.
#[derive(Debug, Error)]
pub enum Refusal {
    /// It cannot be read, or is no ordinary file.
    #[error("cannot be read: {0}")]
    Read(#[from] io::Error),
    /// Not a file of ours, or too damaged to tell.
    #[error("is no state of gripd, or too damaged to tell ({0})")]
    NotOurs(&'static str),
    /// Cut short or changed.
    #[error("is damaged or was changed by hand: its checksum is not that of its contents")]
    Checksum,
    /// Another version's.
    #[error("has version {found}; this gripd reads version {} only", file::VERSION)]
    Version {
        /// The file's.
        found: i64,
    },
    /// Learned on another car, or with other signals.
    #[error(
        "is of another vehicle: [vehicle] or the mapping of its [signals] is not the one it was learned with"
    )]
    OtherVehicle,
    /// Contents that this version does not write.
    #[error("has contents that no gripd writes: {0}")]
    Contents(String),
    /// A number that no car can have.
    #[error("says what no car can be: its {0} is not a number, or out of bounds")]
    Value(&'static str),
}

impl Refusal {
    /// Is it the file that is wrong? Otherwise it could not be looked at, and may be good.
    fn is_of_the_file(&self) -> bool {
        !matches!(self, Self::Read(_))
    }

    /// Was it a good file once?
    fn is_damage(&self) -> bool {
        matches!(self, Self::NotOurs(_) | Self::Checksum | Self::Contents(_) | Self::Value(_))
    }
}

/// What the service starts with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TakenUp {
    /// What was saved, if it can be used.
    pub learned: Option<Learned>,
    /// Nothing is lost when the file is written.
    pub may_write: bool,
    /// There is something in the file's place that cannot be used.
    pub refused: bool,
}

/// A part of what is learned that can be forgotten by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Slip slopes and cornering stiffnesses.
    Tires,
    /// Differences of the wheels' radii, and the error of the speed that comes of them.
    Radii,
    /// Offsets of the sensors, and the error of the steering ratio.
    Offsets,
}

impl Part {
    /// All that there is.
    pub const ALL: [Self; 3] = [Self::Tires, Self::Radii, Self::Offsets];
}

/// What is left when these parts are forgotten.
pub fn without(mut learned: Learned, parts: &[Part]) -> Learned {
    for part in parts {
        match part {
            Part::Tires => (learned.slope, learned.cornering) = ([None; 4], [None; 2]),
            Part::Radii => (learned.slip_offset, learned.speed_scale) = ([None; 4], None),
            Part::Offsets => {
                learned.yaw_rate_offset = None;
                learned.lateral_acceleration_offset = None;
                learned.road_angle_offset = None;
                learned.road_angle_scale = None;
            }
        }
    }
    learned
}

/// A file that says whose another one is; it goes with its owner.
#[derive(Debug)]
pub struct Lock {
    name: PathBuf,
    _file: Flock<File>,
}

impl Drop for Lock {
    fn drop(&mut self) {
        // While it is still locked: whoever waits for it looks whether it is still there.
        let _ = fs::remove_file(&self.name);
    }
}

/// Whose a file is.
#[derive(Debug)]
pub enum Claim {
    /// Ours, as long as this lives.
    Ours(Lock),
    /// Another process's.
    Taken,
    /// The folder, or its file system, allows no lock.
    Impossible,
}

/// The file and the car it has to be of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SavedState {
    path: PathBuf,
    fingerprint: String,
}

impl SavedState {
    /// Larger is none of ours, bytes.
    const LARGEST: u64 = 1 << 16;
    /// Name of the file in the folder that systemd gives.
    const NAME: &str = "learned.toml";

    /// The car of `config`, in the file `path`.
    pub fn new(path: &Path, config: &Config) -> Self {
        Self { path: path.to_owned(), fingerprint: fingerprint(config) }
    }

    /// The file of whatever car.
    ///
    /// # Errors
    /// Why it is none of ours.
    pub fn of_file(path: &Path) -> Result<Self, Refusal> {
        let mut bytes = Vec::new();
        plain_file::open(path)?.take(Self::LARGEST).read_to_end(&mut bytes)?;
        Ok(Self { path: path.to_owned(), fingerprint: file::fingerprint_in(&bytes)? })
    }

    /// Where the configuration wants it: `[service] state_file`, else in the first folder of systemd's
    /// `STATE_DIRECTORY`, else (or with an empty name) nowhere.
    pub fn of_service(config: &Config, state_directory: Option<&OsStr>) -> Option<Self> {
        let path = match &config.service.state_file {
            Some(path) => Some(path.clone()).filter(|path| !path.as_os_str().is_empty()),
            None => state_directory
                .and_then(|folders| std::env::split_paths(folders).next())
                .filter(|folder| folder.is_absolute())
                .map(|folder| folder.join(Self::NAME)),
        };
        path.map(|path| Self::new(&path, config))
    }

    /// The same in this process's environment.
    pub fn of_process(config: &Config) -> Option<Self> {
        Self::of_service(config, std::env::var_os("STATE_DIRECTORY").as_deref())
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What was saved; `None` if there is no file. Changes nothing.
    ///
    /// # Errors
    /// Why the file is not used.
    pub fn load(&self) -> Result<Option<Learned>, Refusal> {
        let file = match plain_file::open(&self.path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            file => file?,
        };
        if file.metadata()?.len() > Self::LARGEST {
            return Err(Refusal::NotOurs("too large"));
        }
        let mut bytes = Vec::new();
        file.take(Self::LARGEST).read_to_end(&mut bytes)?;
        file::parse(&bytes, &self.fingerprint).map(Some)
    }

    /// At the start of the service: what was saved, if it can be used, with a line in the log. A file that
    /// is refused is moved aside to `NAME.refused` (an earlier one of that name is given up). One that can
    /// be neither used nor moved is left alone: it must not be written.
    pub fn take_up(&self) -> TakenUp {
        let path = self.path.display();
        if let Err(error) = remove_leftovers(&self.path) {
            tracing::debug!("{path}: leftovers beside it were not looked for: {error}");
        }
        let refusal = match self.load() {
            Ok(learned) => {
                match &learned {
                    Some(learned) => {
                        tracing::info!(
                            "{path}: goes on from what {:.0} s of driving taught",
                            learned.driving_s
                        );
                        self.keep_as_before();
                    }
                    None => {
                        tracing::info!("{path}: nothing saved yet; the estimators start from [vehicle]");
                        // Somebody took the file away: what is older must not come back some day.
                        self.forget_before();
                    }
                }
                return TakenUp { learned, may_write: true, refused: false };
            }
            Err(refusal) => refusal,
        };
        if !refusal.is_of_the_file() {
            tracing::warn!(
                "{path} {refusal}; the estimators start from [vehicle] and nothing will be saved. Make it a \
                 file that this user may read and write, or name another one in [service] state_file"
            );
            return TakenUp { refused: true, ..TakenUp::default() };
        }
        let aside = self.aside();
        let before = self.before_if(refusal.is_damage());
        let start = match &before {
            Some(_) => self.before().display().to_string(),
            None => "[vehicle]".to_owned(),
        };
        match fs::rename(&self.path, &aside) {
            Ok(()) => tracing::warn!(
                "{path} {refusal}; the estimators start from {start}. The file is kept as {}: put it back \
                 where it belongs, or delete it",
                aside.display()
            ),
            Err(error) => {
                tracing::warn!(
                    "{path} {refusal}; the estimators start from [vehicle], and nothing will be saved, since \
                     the file cannot be moved aside ({error}): move or delete it, and restart"
                );
                return TakenUp { refused: true, ..TakenUp::default() };
            }
        }
        TakenUp { learned: before, may_write: true, refused: true }
    }

    /// What the last drive began with, if that is wanted and can be used.
    fn before_if(&self, wanted: bool) -> Option<Learned> {
        let before = Self { path: self.before(), fingerprint: self.fingerprint.clone() };
        before.load().ok().flatten().filter(|_| wanted)
    }

    /// What this drive begins with is kept under its other name while this drive writes. Without a moment in which there
    /// is no file under the first one; and only if the file system can give a file two names.
    fn keep_as_before(&self) {
        let kept = self.remove_before().and_then(|()| fs::hard_link(&self.path, self.before()));
        if let Err(error) = kept {
            tracing::debug!("{}: what the drive began with is not kept: {error}", self.path.display());
        }
    }

    /// It must not come back.
    fn forget_before(&self) {
        if let Err(error) = self.remove_before() {
            tracing::warn!("{}: cannot be taken away: {error}", self.before().display());
        }
    }

    fn remove_before(&self) -> io::Result<()> {
        remove_if_there(&self.before())
    }

    /// Makes it this process's own until what is returned is dropped; `None` if another process has it, or where such
    /// a claim cannot be made (then nothing could be written, either).
    ///
    /// It is not the file itself that is locked, which is another one with each writing, but `.NAME.lock` beside it.
    pub fn claim(&self) -> Claim {
        let mut name = OsString::from(".");
        name.push(self.path.file_name().unwrap_or_default());
        name.push(".lock");
        let name = self.path.with_file_name(name);
        let open = || {
            let file = OpenOptions::new().write(true).create(true).truncate(false).mode(0o600).open(&name)?;
            Ok::<_, io::Error>((file.metadata()?.ino(), file))
        };
        loop {
            let opened = open().inspect_err(|error| tracing::debug!("{}: {error}", name.display()));
            let Ok((number, file)) = opened else { return Claim::Impossible };
            match Flock::lock(file, FlockArg::LockExclusiveNonblock) {
                // Unless its owner has just taken it away.
                Ok(file) if fs::metadata(&name).is_ok_and(|there| there.ino() == number) => {
                    return Claim::Ours(Lock { name, _file: file });
                }
                Ok(_) => {}
                Err((_, Errno::EWOULDBLOCK)) => return Claim::Taken,
                Err(_) => return Claim::Impossible,
            }
        }
    }

    /// Where a refused file is moved to.
    pub fn aside(&self) -> PathBuf {
        self.beside(".refused")
    }

    /// Where that is kept with which the last drive began.
    pub fn before(&self) -> PathBuf {
        self.beside(".before")
    }

    fn beside(&self, ending: &str) -> PathBuf {
        let mut name = self.path.file_name().map_or_else(OsString::new, OsStr::to_owned);
        name.push(ending);
        self.path.with_file_name(name)
    }

    /// Takes the file away, if there is one, and what would be taken in its place.
    ///
    /// # Errors
    /// If the folder cannot be written.
    pub fn remove(&self) -> io::Result<()> {
        self.remove_before()?;
        remove_if_there(&self.path)
    }

    /// Writes what is left when something was forgotten, which must not come back from [`Self::before`], either.
    ///
    /// # Errors
    /// As [`Self::save`].
    pub fn save_forgotten(&self, learned: &Learned) -> io::Result<()> {
        self.remove_before()?;
        self.save(learned)
    }

    /// Writes it: aside, onto the disk, then under its name. After a power cut there is the old file or
    /// the new one.
    ///
    /// # Errors
    /// If the folder cannot be written, or the disk is full; then the old file is still there.
    pub fn save(&self, learned: &Learned) -> io::Result<()> {
        let new = NewFile::create_private(&self.path)?;
        new.writer()?.write_all(file::text(learned, &self.fingerprint)?.as_bytes())?;
        new.commit()
    }
}

fn remove_if_there(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
