//! Where recordings that are texts go: a file, packed if its name says so, that appears under its name only when it
//! is complete; or the standard output.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use flate2::write::GzEncoder;

use super::LogError;
use crate::new_file::NewFile;

/// A text being written.
///
/// A file is written aside, under a hidden name in the same folder, and takes its own name in
/// [`TextOutput::finish`]. Dropped before, it leaves whatever was there untouched.
pub(in crate::can) struct TextOutput {
    name: String,
    packer: Packer,
    file: Option<NewFile>,
}

type Output = BufWriter<Box<dyn Write + Send>>;

/// Where the text goes, perhaps packed.
enum Packer {
    Plain(Output),
    Gzip(GzEncoder<Output>),
    Zstd(zstd::Encoder<'static, Output>),
}

impl TextOutput {
    /// To anything; `name` stands in messages.
    pub fn to(output: Box<dyn Write + Send>, name: &str) -> Self {
        Self { name: name.to_owned(), packer: Packer::Plain(buffered(output)), file: None }
    }

    /// Creates a file; `-` is the standard output. A name in `.gz` or `.zst` is packed accordingly.
    ///
    /// What exists under that name and is no ordinary file (a pipe, a terminal) is written directly.
    ///
    /// # Errors
    /// If the file cannot be created in its folder.
    pub fn create(path: &Path) -> Result<Self, LogError> {
        if path.as_os_str() == "-" {
            return Ok(Self::to(Box::new(io::stdout()), "standard output"));
        }
        let name = path.display().to_string();
        Self::create_file(path, name.clone()).map_err(|source| LogError::Open { name, source })
    }

    fn create_file(path: &Path, name: String) -> io::Result<Self> {
        let file = NewFile::create(path)?;
        let output = buffered(Box::new(file.stream()?));
        let packer = match path.extension().and_then(|extension| extension.to_str()) {
            Some("gz") => Packer::Gzip(GzEncoder::new(output, flate2::Compression::default())),
            Some("zst") => Packer::Zstd(zstd::Encoder::new(output, zstd::DEFAULT_COMPRESSION_LEVEL)?),
            _ => Packer::Plain(output),
        };
        Ok(Self { name, packer, file: Some(file) })
    }

    /// Writes some of it.
    ///
    /// # Errors
    /// If the output fails.
    #[inline]
    pub fn write(&mut self, text: &[u8]) -> Result<(), LogError> {
        let result = match &mut self.packer {
            Packer::Plain(output) => output.write_all(text),
            packer => packer.as_write().write_all(text),
        };
        self.check(result)
    }

    /// Hands on what is still in the buffer.
    ///
    /// # Errors
    /// If the output fails.
    pub fn flush(&mut self) -> Result<(), LogError> {
        let result = self.packer.as_write().flush();
        self.check(result)
    }

    /// Writes the rest, makes sure it is on the disk, and gives the file its name.
    ///
    /// # Errors
    /// If any of this fails; then the file that was there before is still there.
    pub fn finish(self) -> Result<(), LogError> {
        let Self { name, packer, file } = self;
        packer
            .finish()
            .and_then(|()| file.map_or(Ok(()), NewFile::commit))
            .map_err(|source| LogError::Write { name, source })
    }

    #[inline]
    fn check(&self, result: io::Result<()>) -> Result<(), LogError> {
        result.map_err(|source| LogError::Write { name: self.name.clone(), source })
    }
}

fn buffered(output: Box<dyn Write + Send>) -> Output {
    BufWriter::with_capacity(1 << 16, output)
}

impl Packer {
    fn as_write(&mut self) -> &mut dyn Write {
        match self {
            Packer::Plain(output) => output,
            Packer::Gzip(encoder) => encoder,
            Packer::Zstd(encoder) => encoder,
        }
    }

    /// Ends the compressed stream and empties the buffer.
    fn finish(self) -> io::Result<()> {
        match self {
            Packer::Plain(output) => output,
            Packer::Gzip(encoder) => encoder.finish()?,
            Packer::Zstd(encoder) => encoder.finish()?,
        }
        .flush()
    }
}
