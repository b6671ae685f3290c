//! Batches of rows for any library that speaks Arrow: the capsules of its PyCapsule interface.

use std::sync::{Mutex, PoisonError};

use arrow_array::ffi::FFI_ArrowSchema;
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::{RecordBatch, RecordBatchIterator, RecordBatchReader};
use arrow_schema::SchemaRef;
use pyo3::prelude::*;
use pyo3::types::{PyAny, PyCapsule};

use crate::failure::{UsageError, WorkError};

/// Rows in batches. pyarrow (`pyarrow.table`), polars (`polars.DataFrame`), pandas (`DataFrame.from_arrow`) and all others that
/// know `__arrow_c_stream__` take them as they are.
#[pyclass(frozen, module = "gripd")]
pub struct Batches {
    schema: SchemaRef,
    source: Mutex<Source>,
}

enum Source {
    /// In memory: given out as often as anyone asks.
    Kept(Vec<RecordBatch>),
    /// Made while it is read, once.
    Live(Option<Box<dyn RecordBatchReader + Send>>),
}

impl Batches {
    /// Those that are there.
    pub fn kept(schema: SchemaRef, batches: Vec<RecordBatch>) -> Self {
        Self { schema, source: Mutex::new(Source::Kept(batches)) }
    }

    /// Those that will be made.
    pub fn live(reader: impl RecordBatchReader + Send + 'static) -> Self {
        Self { schema: reader.schema(), source: Mutex::new(Source::Live(Some(Box::new(reader)))) }
    }
}

#[pymethods]
impl Batches {
    /// The rows, for a library that reads them batch by batch.
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // A wish, which nobody has to fulfil.
        drop(requested_schema);
        let mut source = self.source.lock().unwrap_or_else(PoisonError::into_inner);
        let reader = match &mut *source {
            Source::Kept(batches) => {
                let batches = batches.clone().into_iter().map(Ok);
                Box::new(RecordBatchIterator::new(batches, self.schema.clone()))
            }
            Source::Live(reader) => reader.take().ok_or_else(|| {
                UsageError::new_err("this stream has been read; ask gripd.stream for another one")
            })?,
        };
        PyCapsule::new(py, FFI_ArrowArrayStream::new(reader), Some(c"arrow_array_stream".to_owned()))
    }

    /// The columns, for a library that asks before it reads.
    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        let schema = FFI_ArrowSchema::try_from(self.schema.as_ref())
            .map_err(|error| WorkError::new_err(error.to_string()))?;
        PyCapsule::new(py, schema, Some(c"arrow_schema".to_owned()))
    }

    /// Its batches as those of pyarrow.
    fn __iter__<'py>(slf: Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let reader = slf.py().import("pyarrow")?.getattr("RecordBatchReader")?;
        reader.call_method1("from_stream", (slf,))?.call_method0("__iter__")
    }
}
