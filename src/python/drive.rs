//! `replay`: the service's engine over recordings, its tables kept or made while they are read.

use std::path::PathBuf;

use arrow_array::{RecordBatch, RecordBatchReader};
use arrow_schema::{ArrowError, SchemaRef};
use bus::Config;
use bus::can::Frame;
use bus::service::{Engine, Sink};
use gripd::cli::Failure;
use gripd::cli::library::rows::{estimates_columns, estimates_row, samples_columns, samples_row};
use gripd::cli::library::{Drive, Listener, Part, for_the_service};
use physics::{Estimates, Quantity, Sample};
use pyo3::prelude::*;

use crate::columns::Columns;
use crate::failure::{UsageError, exception, words};
use crate::frames::Frames;
use crate::stream::Batches;

/// Rows of a batch that is kept: 15 MB of estimates.
const ROWS: usize = 1 << 15;
/// Frames between two looks whether somebody has pressed Ctrl-C: some milliseconds.
const FRAMES: usize = 1 << 14;

/// One of a replay's tables.
enum Table {
    Estimates(Columns),
    Samples(Columns, Vec<Quantity>),
    Published(Box<Frames>),
}

impl Table {
    const NAMES: [&str; 3] = ["estimates", "samples", "published"];

    fn new(name: &str, config: &Config) -> Result<Self, Failure> {
        match name {
            "estimates" => Ok(Self::Estimates(Columns::new(name, &estimates_columns()))),
            "samples" => {
                let quantities: Vec<_> = config.signals.quantities.keys().copied().collect();
                Ok(Self::Samples(Columns::new(name, &samples_columns(&quantities)), quantities))
            }
            "published" => Ok(Self::Published(Box::new(Frames::new(config.output_database()?)))),
            _ => Err(Failure::usage(format_args!(
                "there is no table {name:?}; ask for one of {}",
                Self::NAMES.join(", ")
            ))),
        }
    }

    fn schema(&self) -> SchemaRef {
        match self {
            Self::Estimates(columns) | Self::Samples(columns, _) => columns.schema(),
            Self::Published(frames) => frames.schema(),
        }
    }

    fn rows(&self) -> usize {
        match self {
            Self::Estimates(columns) | Self::Samples(columns, _) => columns.rows(),
            Self::Published(frames) => frames.rows(),
        }
    }

    fn take(&mut self) -> Result<RecordBatch, ArrowError> {
        match self {
            Self::Estimates(columns) | Self::Samples(columns, _) => columns.take(),
            Self::Published(frames) => frames.take(),
        }
    }
}

/// Fills tables with what an engine makes. The first row that does not fit is kept, and ends it.
struct Filler {
    tables: Vec<Table>,
    failure: Option<std::io::Error>,
}

impl Listener for Filler {}

impl Sink for Filler {
    fn estimates(&mut self, sample: &Sample, estimates: &Estimates) {
        for table in &mut self.tables {
            let row = match table {
                Table::Estimates(columns) => estimates_row(columns, sample, estimates),
                Table::Samples(columns, quantities) => samples_row(columns, sample, quantities),
                Table::Published(_) => Ok(()),
            };
            if let Err(error) = row {
                self.failure.get_or_insert(error);
            }
        }
    }

    fn publish(&mut self, frame: &Frame) {
        for table in &mut self.tables {
            if let Table::Published(frames) = table {
                frames.push(frame);
            }
        }
    }
}

/// A drive that fills tables.
struct Filling {
    drive: Option<Drive>,
    filler: Filler,
}

impl Filling {
    fn new(config: PathBuf, logs: &[PathBuf], part: &Part, tables: &[String]) -> Result<Self, Failure> {
        if logs.is_empty() {
            return Err(Failure::usage("name a recording, or several"));
        }
        let config = for_the_service(&config)?;
        let tables: Vec<Table> =
            tables.iter().map(|name| Table::new(name, &config)).collect::<Result<_, _>>()?;
        let mut engine = Engine::new(&config)?;
        if tables.iter().any(|table| matches!(table, Table::Estimates(_))) {
            engine = engine.with_thesis();
        }
        let drive = Some(Drive::new(engine, &config, logs, part));
        Ok(Self { drive, filler: Filler { tables, failure: None } })
    }

    /// So many frames further, or until a table has so many rows. False where nothing is left to drive.
    fn advance(&mut self, frames: usize, rows: usize) -> Result<bool, Failure> {
        let Some(drive) = &mut self.drive else { return Ok(false) };
        for _ in 0..frames {
            if !drive.advance(&mut self.filler)? {
                return Ok(false);
            }
            if let Some(error) = self.filler.failure.take() {
                return Err(Failure::work(error));
            }
            if self.filler.tables.iter().any(|table| table.rows() >= rows) {
                break;
            }
        }
        Ok(true)
    }
}

/// What a replay comes to: tables in the order in which they were asked for, counts and speed as JSON, and why a recording
/// could not be read to its end.
type Replayed = (Vec<Batches>, String, Option<String>);

/// All tables that are asked for, kept.
#[pyfunction]
#[pyo3(signature = (config, recordings, tables, start, end))]
pub fn replay(
    py: Python<'_>,
    config: PathBuf,
    recordings: Vec<PathBuf>,
    tables: Vec<String>,
    start: Option<&str>,
    end: Option<&str>,
) -> PyResult<Replayed> {
    let part = Part::new(start, end);
    let mut filling = py.detach(|| Filling::new(config, &recordings, &part, &tables)).map_err(exception)?;
    let mut kept: Vec<Vec<RecordBatch>> = tables.iter().map(|_| Vec::new()).collect();
    let keep = |filling: &mut Filling, kept: &mut Vec<Vec<RecordBatch>>, rows: usize| {
        for (table, kept) in filling.filler.tables.iter_mut().zip(kept) {
            if table.rows() >= rows {
                kept.push(table.take().map_err(Failure::work)?);
            }
        }
        Ok(())
    };
    loop {
        let goes_on = py.detach(|| {
            let goes_on = filling.advance(FRAMES, ROWS)?;
            keep(&mut filling, &mut kept, ROWS)?;
            Ok(goes_on)
        });
        py.check_signals()?;
        if !goes_on.map_err(exception)? {
            break;
        }
    }
    let drive = filling.drive.take();
    let Some(driven) = py.detach(|| drive.map(|drive| drive.end(&mut filling.filler))) else {
        return Err(exception(Failure::work("the drive has ended before")));
    };
    keep(&mut filling, &mut kept, 1).map_err(exception)?;
    if driven.stats.samples == 0 {
        driven.whole().map_err(exception)?;
    }
    let tables = filling.filler.tables.iter().zip(kept);
    let tables = tables.map(|(table, batches)| Batches::kept(table.schema(), batches)).collect();
    let stats = serde_json::to_string(&driven.stats).map_err(|error| exception(Failure::work(error)))?;
    Ok((tables, stats, driven.whole().err().map(words)))
}

/// One table, made while it is read, in batches of so many rows.
#[pyfunction]
#[pyo3(signature = (config, recordings, table, rows, start, end))]
pub fn stream(
    py: Python<'_>,
    config: PathBuf,
    recordings: Vec<PathBuf>,
    table: String,
    rows: usize,
    start: Option<&str>,
    end: Option<&str>,
) -> PyResult<Batches> {
    if rows == 0 {
        return Err(UsageError::new_err("batches of no rows have no end; ask for 1 or more"));
    }
    let part = Part::new(start, end);
    let filling = py.detach(|| Filling::new(config, &recordings, &part, &[table])).map_err(exception)?;
    Ok(Batches::live(Live { filling, rows, broken: None }))
}

/// Batches made while they are read. What could not be read is told behind the last of them.
struct Live {
    filling: Filling,
    rows: usize,
    broken: Option<String>,
}

impl Live {
    fn batch(&mut self) -> Result<Option<RecordBatch>, ArrowError> {
        let told = |why: String| ArrowError::ExternalError(why.into());
        loop {
            let filling = &mut self.filling;
            let rows = filling.filler.tables[0].rows();
            if rows >= self.rows || (filling.drive.is_none() && rows > 0) {
                return filling.filler.tables[0].take().map(Some);
            }
            match filling.advance(FRAMES, self.rows) {
                Ok(true) => {}
                Ok(false) => {
                    let Some(drive) = filling.drive.take() else {
                        return self.broken.take().map_or(Ok(None), |why| Err(told(why)));
                    };
                    self.broken = drive.end(&mut filling.filler).whole().err().map(words);
                }
                Err(failure) => {
                    filling.drive = None;
                    return Err(told(words(failure)));
                }
            }
        }
    }
}

impl Iterator for Live {
    type Item = Result<RecordBatch, ArrowError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.batch().transpose()
    }
}

impl RecordBatchReader for Live {
    fn schema(&self) -> SchemaRef {
        self.filling.filler.tables[0].schema()
    }
}
