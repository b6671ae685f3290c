//! Files that appear under their name only when they are complete.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use nix::fcntl::{PosixFadviseAdvice, posix_fadvise};

/// A file being written aside, under a hidden name in the same folder. [`NewFile::commit`] makes sure
/// that it is on the disk and gives it its name; dropped before that it goes away, and what was there
/// is untouched.
///
/// What exists under the name and is no ordinary file (a pipe, a terminal) is written directly.
#[derive(Debug)]
pub struct NewFile {
    file: File,
    aside: Option<Aside>,
}

impl NewFile {
    /// Creates it beside `path`, with the permissions of the file it is to replace.
    ///
    /// # Errors
    /// If the folder does not let us, or `path` is a folder.
    pub fn create(path: &Path) -> io::Result<Self> {
        match fs::metadata(path) {
            Ok(there) if there.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
            Ok(there) if !there.is_file() => {
                Ok(Self { file: OpenOptions::new().write(true).open(path)?, aside: None })
            }
            existing => {
                let (file, aside) = Aside::create(path)?;
                if let Ok(there) = existing {
                    file.set_permissions(there.permissions())?;
                }
                Ok(Self { file, aside: Some(aside) })
            }
        }
    }

    /// Where to write.
    ///
    /// # Errors
    /// If the process has no file descriptor left.
    pub fn writer(&self) -> io::Result<File> {
        self.file.try_clone()
    }

    /// Where to write what is written from its beginning to its end and not looked at meanwhile.
    ///
    /// # Errors
    /// If the process has no file descriptor left.
    pub fn stream(&self) -> io::Result<Stream> {
        Ok(Stream { file: self.writer()?, written: 0, handed_on: 0 })
    }

    /// The contents first, then the name: after a power cut there is the old file or the new one.
    ///
    /// # Errors
    /// If the disk is full or broken; then the old file is still there.
    pub fn commit(self) -> io::Result<()> {
        match self.aside {
            Some(aside) => aside.commit(&self.file),
            None => Ok(()),
        }
    }
}

/// What is written goes on to the disk while more is made: to wait for all of it at the end takes a tenth of the time
/// of a replay.
#[derive(Debug)]
pub struct Stream {
    file: File,
    written: u64,
    /// So much of it the kernel was asked to write.
    handed_on: u64,
}

impl Stream {
    /// So many bytes are handed on at a time.
    const STRETCH: u64 = 1 << 20;

    fn hand_on(&mut self) {
        let (start, length) = (self.handed_on as i64, (self.written - self.handed_on) as i64);
        // That nobody needs it in memory makes Linux begin to write it, and forget none of it before. An advice only:
        // a pipe has no use for it, and what was not written by then `commit` waits for.
        let _ = posix_fadvise(&self.file, start, length, PosixFadviseAdvice::POSIX_FADV_DONTNEED);
        self.handed_on = self.written;
    }
}

impl Write for Stream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.file.write(bytes)?;
        self.written += count as u64;
        if self.written - self.handed_on >= Self::STRETCH {
            self.hand_on();
        }
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// The hidden name and the one it is to become.
#[derive(Debug)]
struct Aside {
    temporary: PathBuf,
    target: PathBuf,
}

impl Aside {
    fn create(path: &Path) -> io::Result<(File, Self)> {
        // Through symbolic links: the file they point to is to be replaced, not the link.
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let temporary = temporary_name(&target).ok_or(io::ErrorKind::InvalidFilename)?;
        let file = OpenOptions::new().write(true).create_new(true).open(&temporary)?;
        begun().push(temporary.clone());
        Ok((file, Self { temporary, target }))
    }

    fn commit(mut self, file: &File) -> io::Result<()> {
        file.sync_all()?;
        fs::rename(&self.temporary, &self.target)?;
        self.forget();
        let folder = self.target.parent().filter(|folder| !folder.as_os_str().is_empty());
        File::open(folder.unwrap_or(Path::new(".")))?.sync_all()
    }

    /// There is nothing left under the hidden name.
    fn forget(&mut self) {
        let gone = std::mem::take(&mut self.temporary);
        begun().retain(|other| *other != gone);
    }
}

impl Drop for Aside {
    fn drop(&mut self) {
        if !self.temporary.as_os_str().is_empty() {
            // Nothing could be done about a failure here, and the name tells what it is.
            let _ = fs::remove_file(&self.temporary);
            self.forget();
        }
    }
}

/// What is being written, under its hidden names.
fn begun() -> MutexGuard<'static, Vec<PathBuf>> {
    static BEGUN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());
    BEGUN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all that is being written, for a process that is about to end.
pub fn abandon_all() {
    for temporary in begun().drain(..) {
        let _ = fs::remove_file(temporary);
    }
}

/// Removes what processes that were killed (or lost their power) while writing `path` left beside it. To be
/// called where nobody else writes that file.
///
/// # Errors
/// If the folder cannot be looked through.
pub fn remove_leftovers(path: &Path) -> io::Result<()> {
    let Some(name) = path.file_name() else { return Ok(()) };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if is_leftover(&entry.file_name(), name) {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

/// Is it `.NAME.PROCESS-COUNT.part`?
fn is_leftover(found: &OsStr, name: &OsStr) -> bool {
    let is_number = |digits: &[u8]| !digits.is_empty() && digits.iter().all(u8::is_ascii_digit);
    let between = || {
        let rest = found.as_bytes().strip_prefix(b".")?.strip_prefix(name.as_bytes())?;
        let numbers = rest.strip_prefix(b".")?.strip_suffix(b".part")?;
        let dash = numbers.iter().position(|byte| *byte == b'-')?;
        Some(is_number(&numbers[..dash]) && is_number(&numbers[dash + 1..]))
    };
    between().unwrap_or(false)
}

/// `.NAME.PROCESS-COUNT.part` beside the target; `None` if the path has no file name.
fn temporary_name(target: &Path) -> Option<PathBuf> {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let mut name = OsString::from(".");
    name.push(target.file_name()?);
    name.push(format!(".{}-{}.part", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed)));
    Some(target.with_file_name(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_leftovers_of_that_file_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state");
        // As if the power had gone.
        let (file, mut aside) = Aside::create(&path).unwrap();
        drop(file);
        aside.forget();
        let others =
            [".state.part", ".state.1-x.part", ".state.1-.part", ".other.1-2.part", "state.1-2.part"];
        for name in others {
            fs::write(folder.path().join(name), "").unwrap();
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 6);
        remove_leftovers(&path).unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 5);
        assert!(others.iter().all(|name| folder.path().join(name).exists()));
    }

    #[test]
    fn what_is_not_committed_leaves_the_old_file_and_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state");
        fs::write(&path, "old").unwrap();
        let new = NewFile::create(&path).unwrap();
        new.writer().unwrap().write_all(b"new").unwrap();
        drop(new);
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        let new = NewFile::create(&path).unwrap();
        new.writer().unwrap().write_all(b"new").unwrap();
        new.commit().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_stream_of_several_stretches_is_there_as_a_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("recording");
        let text: Vec<u8> = (0..3 * Stream::STRETCH + 5).map(|place| (place % 251) as u8).collect();
        let new = NewFile::create(&path).unwrap();
        let mut stream = new.stream().unwrap();
        text.chunks(100_000).for_each(|piece| stream.write_all(piece).unwrap());
        assert!(stream.handed_on >= 2 * Stream::STRETCH);
        new.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), text);
    }
}
