//! What can go wrong in a vehicle, and what the service makes of it: one file per group of faults.

mod case;
mod flood;
mod listed;
mod output;
mod process;
mod reload;
mod service;
