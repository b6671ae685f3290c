//! FMUs: the car as one, and those of other programs.

mod archives;
mod export;
mod import;
