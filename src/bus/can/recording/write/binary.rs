//! A file that is written here and there, and appears under its name only when it is complete.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use crate::can::recording::LogError;
use crate::new_file::NewFile;

/// Where to write, and what it becomes.
pub struct BinaryFile {
    name: String,
    file: NewFile,
}

impl BinaryFile {
    /// Creates it.
    pub fn create(path: &Path) -> Result<(Self, BufWriter<File>), LogError> {
        let name = path.display().to_string();
        let create = || {
            let file = NewFile::create(path)?;
            let writer = BufWriter::with_capacity(1 << 16, file.writer()?);
            Ok((file, writer))
        };
        match create() {
            Ok((file, writer)) => Ok((Self { name, file }, writer)),
            Err(source) => Err(LogError::Open { name, source }),
        }
    }

    /// The error of what was done, with the file's name.
    pub fn check<T>(&self, result: io::Result<T>) -> Result<T, LogError> {
        result.map_err(|source| LogError::Write { name: self.name.clone(), source })
    }

    /// Onto the disk and under its name, if what was done last was done.
    pub fn commit(self, result: io::Result<()>) -> Result<(), LogError> {
        let Self { name, file } = self;
        result.and_then(|()| file.commit()).map_err(|source| LogError::Write { name, source })
    }
}
