//! From the archive to a folder: the description, the resources and the library of this machine.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use zip::ZipArchive;

use super::ForeignError;
use super::description::Description;
use crate::Version;
use crate::export::MACHINE;

/// More than this no FMU unpacks to: 2 GiB. Archives of a few bytes can be made that fill every disk.
const MOST_BYTES: u64 = 2 << 30;
/// More files no FMU has.
const MOST_FILES: usize = 100_000;
/// A larger description is none.
const MOST_DESCRIPTION: u64 = 256 << 20;

/// An FMU in a folder.
#[derive(Clone, Debug, PartialEq)]
pub struct Unpacked {
    /// The archive that it was.
    pub archive: PathBuf,
    /// What it says of itself.
    pub description: Description,
    /// Its library.
    pub library: PathBuf,
    /// The folder of its resources, which is there even if it has none.
    pub resources: PathBuf,
}

impl Unpacked {
    /// Unpacks an archive into a folder that is there and empty.
    ///
    /// # Errors
    /// What is wrong with the archive or the description, or which library is missing.
    pub fn new(archive: &Path, folder: &Path) -> Result<Self, ForeignError> {
        let broken =
            |error: &dyn std::fmt::Display| ForeignError::Archive(archive.to_owned(), error.to_string());
        let file =
            File::open(archive).map_err(|error| ForeignError::Read(archive.to_owned(), error.to_string()))?;
        let mut zip = ZipArchive::new(file).map_err(|error| broken(&error))?;
        if zip.len() > MOST_FILES {
            return Err(broken(&format_args!("it has {} files; {MOST_FILES} are the most", zip.len())));
        }
        let description = described(archive, &mut zip)?;
        // A name that cannot be read is none of those that are needed.
        let names: Vec<String> = zip.file_names().flatten().map(Cow::into_owned).collect();
        let needed = library(archive, &description, &names)?;
        let wanted = [Path::new(&needed).parent().unwrap_or(Path::new("")), Path::new("resources")];
        let mut left = MOST_BYTES;
        for place in 0..zip.len() {
            let mut entry = zip.by_index(place).map_err(|error| broken(&error))?;
            let Some(name) = entry.enclosed_name() else {
                return Err(broken(&"it has a file whose name leads out of it"));
            };
            // Other machines' libraries, sources and documents are of no use here.
            let is_wanted = wanted.iter().any(|wanted| name.starts_with(wanted));
            if !is_wanted || entry.is_dir() || entry.is_symlink() {
                continue;
            }
            let written = put(&folder.join(name), &mut entry.by_ref().take(left + 1));
            let written = written.map_err(|error| broken(&error))?;
            left = left
                .checked_sub(written)
                .ok_or_else(|| broken(&format_args!("it unpacks to more than {MOST_BYTES} bytes")))?;
        }
        let resources = folder.join("resources");
        fs::create_dir_all(&resources).map_err(|error| broken(&error))?;
        Ok(Self { archive: archive.to_owned(), description, library: folder.join(&needed), resources })
    }
}

/// Writes a file, and the folders that it lies in: how many bytes it has.
fn put(path: &Path, content: &mut impl Read) -> io::Result<u64> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    io::copy(content, &mut File::create(path)?)
}

fn described(archive: &Path, zip: &mut ZipArchive<File>) -> Result<Description, ForeignError> {
    const NAME: &str = "modelDescription.xml";
    let wrong =
        |error: &dyn std::fmt::Display| ForeignError::Description(archive.to_owned(), error.to_string());
    let entry = zip.by_name(NAME).map_err(|error| match error {
        zip::result::ZipError::FileNotFound => wrong(&"there is none in the archive: is it an FMU?"),
        error => wrong(&error),
    })?;
    let mut text = String::new();
    let mut limited = entry.take(MOST_DESCRIPTION);
    limited.read_to_string(&mut text).map_err(|error| wrong(&error))?;
    Description::parse(&text).map_err(|error| wrong(&error))
}

/// The library's name in the archive.
fn library(archive: &Path, description: &Description, names: &[String]) -> Result<String, ForeignError> {
    let folder = match (description.version, MACHINE) {
        (Version::Two, "x86_64-linux") => "linux64",
        // FMI 2.0 has no name for other machines; some programs take that of FMI 3.0.
        (_, machine) => machine,
    };
    let needed = format!("binaries/{folder}/{}.so", description.identifier);
    if names.contains(&needed) {
        return Ok(needed);
    }
    let folders: BTreeSet<_> = names
        .iter()
        .filter_map(|name| name.strip_prefix("binaries/")?.split_once('/'))
        .map(|(f, _)| f)
        .collect();
    let there = if folders.is_empty() {
        "it has sources at most; compile it into an FMU with libraries".to_owned()
    } else {
        let folders = folders.into_iter().collect::<Vec<_>>().join(", ");
        format!("it has libraries in {folders}; export it for Linux, too")
    };
    Err(ForeignError::Machine { path: archive.to_owned(), needed, there })
}
