//! Files that appear under their name only when they are complete.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, OpenOptions, Permissions};
use std::io::{self, Write};
use std::os::fd::AsRawFd;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt, fchown};
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
    /// Creates it beside `path`, with the permissions (and, where that is allowed, the owner) of the file it is to
    /// replace.
    ///
    /// # Errors
    /// If the folder does not let us, `path` is a folder, or the kernel would not let us write the file that is there:
    /// a read-only one, or one behind another user's symbolic link in a folder for all (`fs.protected_symlinks`).
    pub fn create(path: &Path) -> io::Result<Self> {
        match fs::metadata(path) {
            Ok(there) if there.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
            Ok(there) if !there.is_file() => {
                Ok(Self { file: OpenOptions::new().write(true).open(path)?, aside: None })
            }
            Ok(_) => {
                // Asks the kernel, which follows links by its own rules; changes nothing. With `create`, for it has
                // rules of its own for what is there already (`fs.protected_regular`).
                let old = OpenOptions::new().write(true).create(true).truncate(false).open(path)?;
                let (file, aside) = Aside::create(&name_of(&old, path), 0o600)?;
                let there = old.metadata()?;
                let own = file.metadata()?;
                if (there.uid(), there.gid()) != (own.uid(), own.gid()) {
                    // Only root may give files away.
                    let _ = fchown(&file, Some(there.uid()), Some(there.gid()));
                }
                file.set_permissions(there.permissions())?;
                Ok(Self { file, aside: Some(aside) })
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let (file, aside) = Aside::create(path, 0o666)?;
                Ok(Self { file, aside: Some(aside) })
            }
            // Who may not look at it may not replace it.
            Err(error) => Err(error),
        }
    }

    /// The same, for the eyes of its user only, whatever was there before.
    ///
    /// # Errors
    /// As [`Self::create`].
    pub fn create_private(path: &Path) -> io::Result<Self> {
        let new = Self::create(path)?;
        if new.aside.is_some() {
            new.file.set_permissions(Permissions::from_mode(0o600))?;
        }
        Ok(new)
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

    /// Bytes so far.
    pub fn written(&self) -> u64 {
        self.written
    }

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
    fn create(target: &Path, mode: u32) -> io::Result<(File, Self)> {
        let target = target.to_owned();
        let temporary = temporary_name(&target).ok_or(io::ErrorKind::InvalidFilename)?;
        // Until it is known, no signal may end the program.
        let mut begun = begun();
        let file = OpenOptions::new().write(true).create_new(true).mode(mode).open(&temporary)?;
        begun.push(temporary.clone());
        drop(begun);
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

/// The name of an open file behind all symbolic links: it is to be replaced, not the link. As the kernel has it: a
/// link could be another one by now.
fn name_of(file: &File, path: &Path) -> PathBuf {
    let name = fs::read_link(format!("/proc/self/fd/{}", file.as_raw_fd()));
    name.or_else(|_| fs::canonicalize(path)).unwrap_or_else(|_| path.to_owned())
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
        let (file, mut aside) = Aside::create(&path, 0o666).unwrap();
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

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).unwrap().permissions().mode() & 0o777
    }

    fn write(new: NewFile, text: &[u8]) {
        new.writer().unwrap().write_all(text).unwrap();
        new.commit().unwrap();
    }

    #[test]
    fn modes_are_kept_through_links_and_a_private_file_is_private() {
        let folder = tempfile::tempdir().unwrap();
        let [path, link] = ["file", "link"].map(|name| folder.path().join(name));
        std::os::unix::fs::symlink(&path, &link).unwrap();
        for of_file in [0o600, 0o640, 0o644] {
            fs::write(&path, "old").unwrap();
            fs::set_permissions(&path, Permissions::from_mode(of_file)).unwrap();
            write(NewFile::create(&link).unwrap(), b"new");
            assert_eq!((mode(&path), fs::read(&path).unwrap()), (of_file, b"new".to_vec()));
            assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        }
        write(NewFile::create_private(&path).unwrap(), b"state");
        assert_eq!(mode(&path), 0o600);
        fs::remove_file(&path).unwrap();
        write(NewFile::create_private(&path).unwrap(), b"state");
        assert_eq!(mode(&path), 0o600);
    }

    /// GIVEN a folder for all with a link of somebody else's, to a file that only we can reach, THEN what the kernel
    /// refuses a shell is refused, and the file stays as it is.
    #[test]
    fn another_users_link_in_a_folder_for_all_is_not_followed() {
        let folder = tempfile::tempdir().unwrap();
        let (all, own) = (folder.path().join("all"), folder.path().join("own"));
        fs::create_dir(&all).unwrap();
        fs::create_dir(&own).unwrap();
        fs::set_permissions(folder.path(), Permissions::from_mode(0o755)).unwrap();
        fs::set_permissions(&all, Permissions::from_mode(0o1777)).unwrap();
        fs::set_permissions(&own, Permissions::from_mode(0o700)).unwrap();
        let (target, link) = (own.join("file"), all.join("link"));
        fs::write(&target, "mine").unwrap();
        fs::set_permissions(&target, Permissions::from_mode(0o600)).unwrap();
        for there in [true, false] {
            std::os::unix::fs::symlink(&target, &link).unwrap();
            if std::os::unix::fs::lchown(&link, Some(12_345), None).is_err() {
                return println!("skipped: only root can make another user's link");
            }
            let shell = OpenOptions::new().write(true).create(true).truncate(false).open(&link);
            let Err(refused) = shell else {
                return println!("skipped: fs.protected_symlinks is 0, or not of this file system");
            };
            let error = NewFile::create(&link).map(drop).unwrap_err();
            assert_eq!(error.kind(), refused.kind());
            assert_eq!(fs::read_dir(&all).unwrap().count(), 1);
            if there {
                assert_eq!((mode(&target), fs::read(&target).unwrap()), (0o600, b"mine".to_vec()));
                fs::remove_file(&target).unwrap();
            }
            assert!(there || !target.exists(), "made through a link that leads nowhere");
            fs::remove_file(&link).unwrap();
        }
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
