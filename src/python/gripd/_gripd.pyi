"""The native part: what the functions of ``gripd`` call. Use those."""

import os
from collections.abc import Iterator
from typing import Any, Union

import pyarrow as pa

PathLike = Union[str, "os.PathLike[str]"]

__version__: str

class Error(Exception):
    """gripd could not do what it was asked."""

class UsageError(Error):
    """What was asked, or the configuration, has to be changed (exit code 2)."""

class WorkError(Error):
    """The work failed (exit code 1)."""

class Batches:
    """Rows in batches, for every library that knows Arrow's PyCapsule interface."""

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any: ...
    def __arrow_c_schema__(self) -> Any: ...
    def __iter__(self) -> Iterator[pa.RecordBatch]: ...

def replay(
    config: PathLike,
    recordings: list[PathLike],
    tables: list[str],
    start: str | None,
    end: str | None,
) -> tuple[list[Batches], str, str | None]: ...
def stream(
    config: PathLike,
    recordings: list[PathLike],
    table: str,
    rows: int,
    start: str | None,
    end: str | None,
) -> Batches: ...
def simulate(arguments: list[str]) -> Batches: ...
def identify(arguments: list[str]) -> tuple[str, str | None]: ...
def explain(arguments: list[str]) -> tuple[str, str | None]: ...
def decode(
    databases: list[PathLike],
    recordings: list[PathLike],
    messages: list[str] | None,
    start: str | None,
    end: str | None,
) -> tuple[list[tuple[str, Batches]], str | None]: ...
