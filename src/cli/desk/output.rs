//! Result files: complete under their name, or not there at all; `-` is the standard output.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::Failure;
use bus::new_file::NewFile;

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
        create().map_err(|e: io::Error| Failure::from(naming(path, e)))
    }

    /// Ends it: everything on the disk, under its own name.
    pub fn finish(mut self) -> Result<(), Failure> {
        self.flush()?;
        let path = self.path;
        self.file.map_or(Ok(()), NewFile::commit).map_err(|e| Failure::from(naming(&path, e)))
    }
}

/// The error with the name of the file it is about.
fn naming(path: &Path, error: io::Error) -> io::Error {
    let hint = match error.kind() {
        io::ErrorKind::NotFound => "; is there such a folder?",
        _ => "",
    };
    let name = if path.as_os_str() == "-" { "to the standard output".into() } else { path.to_string_lossy() };
    io::Error::new(error.kind(), format!("cannot write {name}: {error}{hint}"))
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = match &mut self.writer {
            Destination::File(writer) => writer.write(bytes),
            Destination::Stdout(writer) => writer.write(bytes),
        };
        written.map_err(|e| naming(&self.path, e))
    }

    fn flush(&mut self) -> io::Result<()> {
        let flushed = match &mut self.writer {
            Destination::File(writer) => writer.flush(),
            Destination::Stdout(writer) => writer.flush(),
        };
        flushed.map_err(|e| naming(&self.path, e))
    }
}

/// For formats that are written here and there: a plain file only.
impl Seek for Output {
    fn seek(&mut self, place: SeekFrom) -> io::Result<u64> {
        let sought = match &mut self.writer {
            Destination::File(writer) => writer.seek(place),
            Destination::Stdout(_) => Err(io::ErrorKind::NotSeekable.into()),
        };
        sought.map_err(|e| naming(&self.path, e))
    }
}

/// Do both names mean the same file (or both the standard output)?
fn same_file(one: &Path, other: &Path) -> bool {
    match (one.canonicalize(), other.canonicalize()) {
        (Ok(one), Ok(other)) => one == other,
        _ => one == other,
    }
}

/// An input is never overwritten by what is made of it, nor one result by another; and what cannot be written is
/// better known before the work than after it.
pub fn check_outputs<'p>(
    inputs: impl IntoIterator<Item = &'p PathBuf>,
    outputs: impl IntoIterator<Item = &'p PathBuf>,
) -> Result<(), Failure> {
    let inputs: Vec<_> = inputs.into_iter().filter(|path| path.as_os_str() != "-").collect();
    let outputs: Vec<_> = outputs.into_iter().collect();
    for (place, output) in outputs.iter().enumerate() {
        if inputs.iter().any(|input| same_file(input, output)) {
            return Err(Failure::usage(format_args!(
                "{} is read from and would be written to; give the result another name",
                output.display()
            )));
        }
        if outputs[..place].iter().any(|other| same_file(other, output)) {
            return Err(Failure::usage(format_args!("two results cannot both go to {}", output.display())));
        }
        // Opening a pipe would begin to write it.
        let is_plain = output.metadata().map_or(true, |there| there.is_file() || there.is_dir());
        if is_plain && output.as_os_str() != "-" {
            Output::create(output)?;
        }
    }
    Ok(())
}

/// Writes a text.
pub fn write_text(path: &Path, text: &str) -> Result<(), Failure> {
    let mut output = Output::create(path)?;
    output.write_all(text.as_bytes())?;
    output.finish()
}

/// Writes a value as indented JSON.
pub fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<(), Failure> {
    let mut output = Output::create(path)?;
    serde_json::to_writer_pretty(&mut output, value).map_err(io::Error::from)?;
    writeln!(output)?;
    output.finish()
}

/// A result for a program.
pub struct Told {
    /// What `--json` has.
    pub json: String,
    /// Why some recordings could not be read to their end: the result is of the rest.
    pub whole: Result<(), Failure>,
}

impl Told {
    /// # Errors
    /// If it cannot be written as JSON.
    pub fn new(value: &impl serde::Serialize, whole: Result<(), Failure>) -> Result<Self, Failure> {
        Ok(Self { json: serde_json::to_string(value).map_err(Failure::work)?, whole })
    }
}
