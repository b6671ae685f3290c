//! `simulate`: a scenario to a recording, and what was true beside it.

use std::ffi::OsString;

use gripd::cli::Failure;
use gripd::cli::library::rows::{Column, Kind};
use gripd::cli::library::{Simulate, options};
use physics::model::Truth;
use pyo3::prelude::*;

use crate::columns::Columns;
use crate::failure::exception;
use crate::stream::Batches;

/// Steps of 10 ms between two looks whether somebody has pressed Ctrl-C.
const STEPS: usize = 1000;

/// Writes the recording; gives the truth.
#[pyfunction]
pub fn simulate(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<Batches> {
    let begin = || options::<Simulate>("gripd simulate", arguments)?.begin();
    let mut simulated = py.detach(begin).map_err(exception)?;
    let names = Truth::columns().into_iter().chain(simulated.effect_columns().iter().cloned());
    let columns: Vec<_> = names.map(|name| Column::new(name, "", Kind::Real)).collect();
    let mut truth = Columns::new("truth", &columns);
    loop {
        let goes_on = py.detach(|| -> Result<bool, Failure> {
            for _ in 0..STEPS {
                let Some(tick) = simulated.advance()? else { return Ok(false) };
                let values = tick.truth.values().into_iter().chain(tick.effects.iter().copied());
                truth.numbers(values.map(Truth::written)).map_err(Failure::work)?;
            }
            Ok(true)
        });
        py.check_signals()?;
        if !goes_on.map_err(exception)? {
            break;
        }
    }
    py.detach(|| simulated.end()).map_err(exception)?;
    let rows = truth.take().map_err(|error| exception(Failure::work(error)))?;
    Ok(Batches::kept(truth.schema(), vec![rows]))
}
