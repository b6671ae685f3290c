//! What each effect does to a simulated drive, in the signals as they are recorded; and what an `[[effect]]`
//! table may say.

mod car;
mod road;
mod sensors;
mod support;
mod tables;
mod taken_out;
mod together;
