//! The folder with the recordings: their names, and how much there may be of them.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// `gripd-NUMBER-SECONDS-CAUSE.log.gz`, and `….state.toml` beside it. The number counts on, whatever the clock says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Folder {
    path: PathBuf,
    limits: Limits,
}

/// How much there may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Limits {
    pub files: u64,
    pub bytes: u64,
}

/// The recording's name and that of the state beside it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Names {
    pub recording: PathBuf,
    pub state: PathBuf,
}

impl Folder {
    const PREFIX: &str = "gripd-";
    const RECORDING: &str = ".log.gz";
    const STATE: &str = ".state.toml";
    /// What is being written is written each second: what was not for so long was left by a process that was killed.
    const ABANDONED: Duration = Duration::from_secs(600);

    pub fn new(path: &Path, limits: Limits) -> Self {
        Self { path: path.to_owned(), limits }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn limits(&self) -> Limits {
        self.limits
    }

    /// Names for the next recording. The folder is made if only it itself is missing.
    ///
    /// # Errors
    /// If the folder can be neither looked through nor made.
    pub fn next(&self, seconds: i64, cause: &str) -> io::Result<Names> {
        if let Err(error) = fs::create_dir(&self.path)
            && error.kind() != io::ErrorKind::AlreadyExists
        {
            return Err(error);
        }
        let number = self.contents()?.last_key_value().map_or(1, |(number, _)| number.saturating_add(1));
        let name = format!("{}{number:06}-{seconds}-{cause}", Self::PREFIX);
        Ok(Names {
            recording: self.path.join(format!("{name}{}", Self::RECORDING)),
            state: self.path.join(format!("{name}{}", Self::STATE)),
        })
    }

    /// The oldest go until there is room for another one of so many bytes.
    ///
    /// # Errors
    /// If the folder cannot be looked through, or a file not be taken away.
    pub fn make_room(&self, bytes: u64) -> io::Result<()> {
        let contents = self.contents()?;
        let mut files = contents.len() as u64 + 1;
        let mut sum = contents.values().map(|recording| recording.bytes).fold(bytes, u64::saturating_add);
        for recording in contents.into_values() {
            if files <= self.limits.files && sum <= self.limits.bytes {
                return Ok(());
            }
            recording.files.iter().try_for_each(fs::remove_file)?;
            files -= 1;
            sum = sum.saturating_sub(recording.bytes);
        }
        Ok(())
    }

    /// What is there by number, the oldest first. What a killed process left is taken away.
    fn contents(&self) -> io::Result<BTreeMap<u64, Recording>> {
        let mut contents = BTreeMap::<u64, Recording>::new();
        for entry in fs::read_dir(&self.path)? {
            let entry = entry?;
            let name = entry.file_name();
            // Gone meanwhile: somebody tidies up.
            let Ok(about) = entry.metadata() else { continue };
            if let Some(number) = number(&name).filter(|_| about.is_file()) {
                let recording = contents.entry(number).or_default();
                recording.bytes = recording.bytes.saturating_add(about.len());
                recording.files.push(entry.path());
            } else if is_unfinished(&name)
                && about
                    .modified()
                    .ok()
                    .and_then(|at| at.elapsed().ok())
                    .is_some_and(|age| age > Self::ABANDONED)
            {
                fs::remove_file(entry.path())?;
            }
        }
        Ok(contents)
    }
}

/// A recording with its state.
#[derive(Debug, Default)]
struct Recording {
    bytes: u64,
    files: Vec<PathBuf>,
}

/// The number in a name of ours.
fn number(name: &OsStr) -> Option<u64> {
    let name = name.to_str()?;
    let is_ours = name.ends_with(Folder::RECORDING) || name.ends_with(Folder::STATE);
    let digits = name.strip_prefix(Folder::PREFIX).filter(|_| is_ours)?.split('-').next()?;
    digits.parse().ok().filter(|_| digits.len() >= 6)
}

/// Is it one of ours under the hidden name that it has until it is complete?
fn is_unfinished(name: &OsStr) -> bool {
    let name = name.to_str().unwrap_or_default();
    name.strip_prefix('.').is_some_and(|name| name.starts_with(Folder::PREFIX)) && name.ends_with(".part")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn write(folder: &Folder, seconds: i64, bytes: usize) {
        folder.make_room(bytes as u64).unwrap();
        let names = folder.next(seconds, "timeout").unwrap();
        fs::write(names.recording, vec![0; bytes - 10]).unwrap();
        fs::write(names.state, vec![0; 10]).unwrap();
    }

    /// GIVEN more recordings than there may be THEN the oldest go, by their number and not by any clock, each with its
    /// state; AND nothing that is not ours.
    #[test]
    fn the_oldest_go_first() {
        let above = tempfile::tempdir().unwrap();
        let path = above.path().join("faults");
        let folder = Folder::new(&path, Limits { files: 3, bytes: 1000 });
        folder.next(5, "timeout").unwrap();
        for other in ["gripd.toml", "gripd-000001.log", "notes.log.gz", "gripd-12-x.log.gz"] {
            fs::write(path.join(other), vec![0; 5000]).unwrap();
        }
        for seconds in [1_795_320_000, 1_795_320_060, 5, 65, 125] {
            write(&folder, seconds, 300);
        }
        let left = names(&path);
        assert_eq!(left.len(), 4 + 3 * 2, "{left:?}");
        assert!(left.contains(&"gripd-000003-5-timeout.log.gz".to_owned()), "{left:?}");
        assert!(left.contains(&"gripd-000005-125-timeout.state.toml".to_owned()), "{left:?}");
        // By bytes: one large one takes the place of all.
        write(&folder, 200, 900);
        assert_eq!(names(&path).iter().filter(|name| name.contains("-timeout.log.gz")).count(), 1);
        // And what is larger than everything may be leaves nothing beside it.
        folder.make_room(2000).unwrap();
        assert_eq!(names(&path).len(), 4);
    }

    #[test]
    fn only_old_leftovers_are_taken_away() {
        let above = tempfile::tempdir().unwrap();
        let folder = Folder::new(above.path(), Limits { files: 3, bytes: 1000 });
        let old = fs::FileTimes::new().set_modified(std::time::SystemTime::now() - 2 * Folder::ABANDONED);
        for (name, age) in [
            (".gripd-000001-1-timeout.log.gz.1-0.part", Some(old)),
            (".gripd-000002-1-timeout.log.gz.2-0.part", None),
            (".other.part", Some(old)),
        ] {
            let file = fs::File::create(above.path().join(name)).unwrap();
            if let Some(age) = age {
                file.set_times(age).unwrap();
            }
        }
        folder.make_room(0).unwrap();
        assert_eq!(names(above.path()), [".gripd-000002-1-timeout.log.gz.2-0.part", ".other.part"]);
    }

    #[test]
    fn a_folder_that_cannot_be_is_an_error_each_time() {
        let above = tempfile::tempdir().unwrap();
        let limits = Limits { files: 1, bytes: 1 };
        let nowhere = Folder::new(&above.path().join("no/such"), limits);
        assert_eq!(nowhere.next(1, "x").unwrap_err().kind(), io::ErrorKind::NotFound);
        fs::write(above.path().join("file"), "").unwrap();
        assert!(Folder::new(&above.path().join("file"), limits).next(1, "x").is_err());
    }
}
