//! gripd for Python. What the functions take, give and mean stands in `gripd/__init__.py`, which is what users see; here is
//! what it calls: the commands, their answers as Arrow tables and JSON.

mod columns;
mod decode;
mod drive;
mod failure;
mod frames;
mod log;
mod search;
mod simulate;
mod stream;

use pyo3::prelude::*;

/// Native part of the package `gripd`.
#[pymodule]
mod _gripd {
    #[pymodule_export]
    use super::decode::decode;
    #[pymodule_export]
    use super::drive::{replay, stream};
    #[pymodule_export]
    use super::failure::{Error, UsageError, WorkError};
    #[pymodule_export]
    use super::search::{explain, identify};
    #[pymodule_export]
    use super::simulate::simulate;
    #[pymodule_export]
    use super::stream::Batches;

    use super::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        log::to_python();
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
