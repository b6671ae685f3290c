"""Tire stiffness and tire-road friction from a vehicle's CAN bus.

The functions are the commands of ``gripd``: the same Rust code, the same numbers, the same words where something is wrong.
SI units, axes of ISO 8855 (x forward, y left, z up); times are the recording's own stamps in seconds. Rust works without
Python's lock, so threads run side by side; Ctrl-C is heard. What the commands tell on the standard error goes to
``logging.getLogger("gripd")``.

>>> import gripd
>>> gripd.simulate("scenario.toml", "drive.log")                # what was true, and a recording
>>> drive = gripd.replay("demo.toml", "drive.log")
>>> drive.estimates.to_pandas().plot("t", ["mu_max_low", "mu_max", "mu_max_high"])
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Union

import pyarrow as pa

from . import _gripd
from ._gripd import Batches, Error, UsageError, WorkError, __version__

__all__ = [
    "Batches",
    "BrokenRecording",
    "Error",
    "Replay",
    "UsageError",
    "WorkError",
    "__version__",
    "decode",
    "explain",
    "identify",
    "replay",
    "simulate",
    "stream",
]

PathLike = Union[str, "os.PathLike[str]"]
"""A file's name."""
Paths = Union[PathLike, Iterable[PathLike]]
"""One file or several."""
Moment = Union[float, int, str]
"""Seconds after a recording's first frame, or a time in UTC (``"2025-10-09T08:53:20.123Z"``)."""


class BrokenRecording(WorkError):
    """A recording could not be read to its end. What there was is worth its result, which is in ``result``."""

    result: Any
    """What the function would have returned, of what could be read."""

    def __init__(self, message: str, result: Any) -> None:
        super().__init__(message)
        self.result = result


@dataclass(frozen=True)
class Replay:
    """What the service makes of recordings."""

    estimates: pa.Table
    """A row for each sample (100 Hz), as ``gripd replay --estimates`` writes them: ``t`` (s), ``speed`` (m/s), slip slopes,
    cornering stiffness (1/rad), friction, … Each field's metadata have its ``unit``. Null where nothing is known."""
    samples: pa.Table
    """A row for each sample: the configured quantities as the estimators see them (``--samples``), SI."""
    published: pa.Table
    """A row for each published frame: ``t`` (s), ``id``, ``is_extended``, ``message`` (its name), ``data`` (bytes)."""
    stats: dict[str, Any]
    """Counts and speed, as ``--stats``."""


def replay(
    config: PathLike,
    recordings: Paths,
    *,
    start: Moment | None = None,
    end: Moment | None = None,
) -> Replay:
    """Runs the service's own engine over recordings, one after the other: ``gripd replay``.

    Args:
        config: Configuration of the car.
        recordings: Any format that ``gripd convert`` reads, packed or not.
        start: Only what is then or later (``--from``).
        end: Only what is then or earlier (``--to``).

    Raises:
        UsageError: The configuration or what is asked has to be changed.
        WorkError: Nothing could be estimated.
        BrokenRecording: A recording is damaged; what could be read is in its ``result``.
    """
    names = ["estimates", "samples", "published"]
    tables, stats, broken = _gripd.replay(config, _paths(recordings), names, _moment(start), _moment(end))
    estimates, samples, published = (pa.table(table) for table in tables)
    return _whole(Replay(estimates, samples, published, json.loads(stats)), broken)


def stream(
    config: PathLike,
    recordings: Paths,
    table: str = "estimates",
    *,
    rows: int = 1 << 15,
    start: Moment | None = None,
    end: Moment | None = None,
) -> Batches:
    """One of a replay's tables, made while it is read, for drives that are larger than the memory.

    Nothing is copied on the way: pyarrow (``pyarrow.RecordBatchReader.from_stream``), polars (``polars.DataFrame``), pandas
    (``pandas.DataFrame.from_arrow``), DuckDB and all others that know Arrow's PyCapsule interface take it, and
    ``for batch in gripd.stream(…)`` gives record batches of pyarrow. It can be read once.

    Args:
        config: Configuration of the car.
        recordings: As of :func:`replay`.
        table: ``"estimates"``, ``"samples"`` or ``"published"``.
        rows: Of a batch.
        start: Only what is then or later.
        end: Only what is then or earlier.

    Raises:
        UsageError: The configuration or what is asked has to be changed. What is wrong with a recording is found while
            it is read, and told as the reading library tells of it, behind all that could be read.
    """
    return _gripd.stream(config, _paths(recordings), table, rows, _moment(start), _moment(end))


def simulate(
    scenario: PathLike,
    out: PathLike,
    *,
    seed: int | None = None,
    config: PathLike | None = None,
) -> pa.Table:
    """Simulates a scenario to a recording: ``gripd simulate``. The same scenario and seed give the same bytes.

    Args:
        scenario: The scenario (TOML).
        out: The recording: candump, or the format that the name ends in.
        seed: Of everything random, instead of the scenario's.
        config: The car whose frames are written, instead of the demo car's.

    Returns:
        What was true, a row for each 10 ms, as ``--truth`` writes it: SI, null where something is not there.

    Raises:
        UsageError: The scenario, the configuration or what is asked has to be changed.
        WorkError: The recording cannot be written.
    """
    return pa.table(_gripd.simulate(_arguments([scenario], out=out, seed=seed, config=config)))


def identify(
    config: PathLike,
    recordings: Paths,
    *,
    parameters: Iterable[str] | None = None,
    method: str | None = None,
    drive: str | None = None,
    starts: int | None = None,
    holdout: Paths = (),
    start: Moment | None = None,
    end: Moment | None = None,
) -> dict[str, Any]:
    """The vehicle's parameters from recordings: ``gripd identify``. Seconds to minutes.

    Args:
        config: Configuration of the car; what its ``[vehicle]`` table calls uncertain is identified.
        recordings: Of one car, used together.
        parameters: These, by their names in ``[vehicle]``.
        method: ``"auto"``, ``"free_run"``, ``"segments"`` or ``"ordinary"``.
        drive: What the longitudinal forces come from: ``"torque"``, ``"wheel_speeds"``, ``"slips"`` or ``"speed"``.
        starts: Search from so many starts.
        holdout: Fit nothing to these recordings of the same car; how well they are predicted is in ``["fit"]["holdout"]``.
        start: Only what is then or later.
        end: Only what is then or earlier.

    Returns:
        What ``--json`` has.

    Raises:
        UsageError: The configuration or what is asked has to be changed.
        WorkError: Nothing could be identified.
        BrokenRecording: A recording is damaged; what could be read is in its ``result``.
    """
    names = None if parameters is None else ",".join(parameters)
    options = {"parameters": names, "method": method, "drive": drive, "starts": starts, "from": start, "to": end}
    arguments = _arguments(_paths(recordings), config=config, holdout=_paths(holdout), **options)
    return _found(_gripd.identify(arguments))


def explain(
    config: PathLike,
    recordings: Paths,
    *,
    holdout: Paths = (),
    reference: Paths = (),
    confirm: Paths = (),
    history: bool = False,
    simulation: PathLike | None = None,
    seed: int | None = None,
    start: Moment | None = None,
    end: Moment | None = None,
) -> dict[str, Any]:
    """Where simulation and recording differ, and why: ``gripd explain``. Seconds to minutes.

    Args:
        config: Configuration of the car.
        recordings: Drives of one car.
        holdout: Keep these for the proof, instead of every third 20 s.
        reference: Healthy drives of the same car: the answer is what the others have that they have not.
        confirm: Other drives of the same car: does what was found help there, too?
        history: The recordings are in time order: since which of them is something different?
        simulation: The output of your own simulation of the drive: the answer is what it leaves out.
        seed: Of what is drawn at random.
        start: Only what is then or later.
        end: Only what is then or earlier.

    Returns:
        What ``--json`` has: ``verdict``, ``findings``, ``ranking``, ``fit``, ``parameters``, …

    Raises:
        UsageError: The configuration or what is asked has to be changed.
        WorkError: There is nothing to explain.
        BrokenRecording: A recording is damaged; what could be read is in its ``result``.
    """
    options = {"simulation": simulation, "seed": seed, "from": start, "to": end}
    several = {"holdout": _paths(holdout), "reference": _paths(reference), "confirm": _paths(confirm)}
    arguments = _arguments(_paths(recordings), config=config, history=history, **options, **several)
    return _found(_gripd.explain(arguments))


def decode(
    dbc: Paths,
    recordings: Paths,
    *,
    messages: Iterable[str] | None = None,
    start: Moment | None = None,
    end: Moment | None = None,
) -> dict[str, pa.Table]:
    """What the signals of a DBC say in recordings.

    Args:
        dbc: One DBC file or several.
        recordings: One after the other, all buses of each.
        messages: These alone, by their names.
        start: Only what is then or later.
        end: Only what is then or earlier.

    Returns:
        By its name, of each message that is there: ``t`` (s), and a column for each signal: the physical number, in the DBC's
        unit (its field's metadata have the ``unit``), null where the signal is not in the frame. Codes for "not available"
        are numbers like others, as the DBC scales them.

    Raises:
        UsageError: A DBC cannot be read, or has no such message.
        WorkError: A recording cannot be read.
        BrokenRecording: A recording is damaged; what could be read is in its ``result``.
    """
    names = None if messages is None else list(messages)
    tables, broken = _gripd.decode(_paths(dbc), _paths(recordings), names, _moment(start), _moment(end))
    return _whole({name: pa.table(table) for name, table in tables}, broken)


def _paths(paths: Paths) -> list[PathLike]:
    return [paths] if isinstance(paths, (str, os.PathLike)) else list(paths)


def _moment(moment: Moment | None) -> str | None:
    return None if moment is None else str(moment)


def _arguments(positional: Iterable[PathLike], **options: Any) -> list[str]:
    """What would stand on the command line; options that are not given are left out."""
    arguments = []
    for name, value in options.items():
        for one in value if isinstance(value, list) else [value]:
            if one is True:
                arguments.append(f"--{name}")
            elif one is not None and one is not False:
                arguments.append(f"--{name}={os.fspath(one) if isinstance(one, os.PathLike) else one}")
    return [*arguments, "--", *map(os.fspath, positional)]


def _found(found: tuple[str, str | None]) -> dict[str, Any]:
    answer, broken = found
    return _whole(json.loads(answer), broken)


def _whole(result: Any, broken: str | None) -> Any:
    if broken is not None:
        raise BrokenRecording(broken, result)
    return result
