//! Result files: complete under their name, or not there at all; `-` is the standard output.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::Failure;
use crate::new_file::NewFile;

/// A result being written.
pub struct Output {
    path: PathBuf,
    writer: Destination,
    file: Option<NewFile>,
}

enum Destination {
    File(BufWriter<File>),
    Stdout(BufWriter<io::Stdout>),
}

impl Output {
    /// Starts it.
    pub fn create(path: &Path) -> Result<Self, Failure> {
        let name = path.to_owned();
        if path.as_os_str() == "-" {
            let writer = Destination::Stdout(BufWriter::new(io::stdout()));
            return Ok(Self { path: name, writer, file: None });
        }
        let create = || {
            let file = NewFile::create(path)?;
            let writer = Destination::File(BufWriter::with_capacity(1 << 16, file.writer()?));
            Ok(Self { path: name, writer, file: Some(file) })
        };
        create().map_err(|e: io::Error| Failure::work(format_args!("cannot write {}: {e}", path.display())))
    }

    /// Ends it: everything on the disk, under its own name.
    pub fn finish(mut self) -> Result<(), Failure> {
        let path = self.path.clone();
        self.flush()
            .and_then(|()| self.file.map_or(Ok(()), NewFile::commit))
            .map_err(|e| Failure::work(format_args!("cannot write {}: {e}", path.display())))
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.writer {
            Destination::File(writer) => writer.write(bytes),
            Destination::Stdout(writer) => writer.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.writer {
            Destination::File(writer) => writer.flush(),
            Destination::Stdout(writer) => writer.flush(),
        }
    }
}

/// Do both names mean the same file (or both the standard output)?
pub fn same_file(one: &Path, other: &Path) -> bool {
    match (one.canonicalize(), other.canonicalize()) {
        (Ok(one), Ok(other)) => one == other,
        _ => one == other,
    }
}

/// Writes a value as indented JSON.
pub fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<(), Failure> {
    let mut output = Output::create(path)?;
    serde_json::to_writer_pretty(&mut output, value).map_err(Failure::work)?;
    writeln!(output).map_err(Failure::work)?;
    output.finish()
}
