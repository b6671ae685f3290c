//! `gripd map`: the right signals of unknown cars, with the right signs and units, and none where there are none.

pub mod car;
mod command;
mod real;
mod simulated;

use std::path::{Path, PathBuf};
use std::process::Output;

use gripd::Quantity;
use gripd::can::recording::Reader;
use gripd::dbc::Database;
use gripd::propose::{Confidence, Drive, Mapped, Proposal, propose};

use car::Car;
use testing::program;

fn gripd(arguments: &[&dyn AsRef<std::ffi::OsStr>]) -> Output {
    program::gripd().arg("-q").args(arguments.iter().map(|a| a.as_ref())).output().unwrap()
}

fn of_files(dbc: &Path, logs: &[PathBuf]) -> Proposal {
    let database = Database::load(dbc).unwrap();
    if logs.is_empty() {
        return propose(&database, None);
    }
    let mut drive = Drive::new(&database);
    for log in logs {
        let mut reader = Reader::open(log).unwrap();
        while let Some(frame) = reader.next_frame().unwrap() {
            drive.frame(&frame);
        }
        drive.end_of_recording();
    }
    propose(&database, Some(&drive))
}

/// The entry that is proposed, if one is.
fn live(proposal: &Proposal, quantity: Quantity) -> Option<&Mapped> {
    let choice = proposal.choice(quantity).unwrap();
    choice.mapping.as_ref().filter(|_| choice.confidence > Confidence::NotFound)
}

fn tell(proposal: &Proposal) {
    for choice in &proposal.quantities {
        println!("{}: {:?}: {} {:?}", choice.quantity, choice.confidence, choice.why, choice.mapping);
    }
    println!("{:?}", proposal.notes);
}

/// Everything of a car is found, where it is, with its sign and unit.
#[track_caller]
fn all_right(car: &Car, proposal: &Proposal) {
    tell(proposal);
    for line in &car.lines {
        let quantity = line.quantity;
        let Some(mapped) = live(proposal, quantity) else { panic!("{quantity} is not found") };
        assert_eq!(mapped.signals, [car.place(quantity)], "{quantity}");
        assert_eq!(mapped.gain.unwrap_or(1.0), line.gain, "the sign of {quantity}");
        assert_eq!(mapped.unit.as_deref(), line.truth, "the unit of {quantity}");
        assert_eq!(mapped.offset, None, "{quantity}");
    }
}
