"""A fleet's recordings on many machines: each one a task of Dask, its results Parquet that engines read as one table.

>>> from gripd import fleet
>>> report = fleet.replay("s3://fleet/car/car.toml", "s3://fleet/drives", "s3://fleet/out")
>>> polars.scan_parquet("s3://fleet/out/estimates/**/*.parquet", hive_partitioning=True)

or ``python -m gripd.fleet replay CONFIG RECORDINGS OUT``. Recordings, configuration and results may lie in any place that
fsspec knows: folders, S3, Azure, GCS, HTTP, SSH. Without a client of Dask's it runs on all processors of this machine.

Each recording has one file of results, with the recording's name, and a mark in ``OUT/marks`` which is written after it. What
was interrupted goes on with what has no mark; what has changed since (recording, configuration, version) is done again; a
task whose worker died is done by another. So nothing is lost, and nothing is there twice. Recordings that cannot be read are
in the report and in ``OUT/marks`` with the reason. Needs ``pip install gripd[fleet]``.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import hashlib
import json
import logging
import os
import posixpath
import re
import sys
import tempfile
import time
import uuid
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Union
from urllib.parse import quote

import distributed
import fsspec
import pyarrow as pa
import pyarrow.parquet as pq

import gripd

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["Outcome", "Report", "explain", "replay"]

Url = Union[str, "os.PathLike[str]"]
"""A place that fsspec knows: a path, ``s3://bucket/folder``, …"""

log = logging.getLogger("gripd.fleet")

FINDINGS = pa.schema([
    ("car", pa.string()),
    ("recording", pa.string()),
    ("begins_utc", pa.string()),
    ("verdict", pa.string()),
    ("kind", pa.string()),
    ("effect", pa.string()),
    ("channel", pa.string()),
    ("evidence", pa.float64()),
    ("parameter", pa.string()),
    ("value", pa.float64()),
    ("std", pa.float64()),
])
"""A row for each number of each finding; one with nulls of a recording in which nothing was found."""

CHANGES = pa.schema([
    ("car", pa.string()),
    ("drives", pa.int64()),
    ("effect", pa.string()),
    ("channel", pa.string()),
    ("parameter", pa.string()),
    ("unit", pa.string()),
    ("since", pa.string()),
    ("since_utc", pa.string()),
    ("grows", pa.bool_()),
    ("value", pa.float64()),
    ("std", pa.float64()),
])
"""A row for each thing that is another one since a drive of its car; value and std are the last drive's."""


@dataclass(frozen=True)
class Outcome:
    """What became of a task."""

    name: str
    """The recording, as it is called below the folder; of a car's drives together, the car."""
    problem: str | None
    """Why there is no result, or why it is of a part only."""
    has_result: bool
    """Are there results?"""
    seconds: float
    """What it took its worker."""
    worker: str
    """Who did it."""
    stats: dict[str, Any] = field(default_factory=dict)
    """As ``gripd replay --stats``."""


@dataclass(frozen=True)
class Report:
    """What became of a fleet."""

    done: list[Outcome]
    """With results, those of an earlier call included."""
    bad: list[Outcome]
    """Without, or with results of a part: damaged recordings, and such that are none."""
    new: int
    """So many of them this call did."""
    seconds: float
    """What it took."""


def replay(
    config: Url,
    recordings: Url | Sequence[Url],
    out: Url,
    *,
    tables: Sequence[str] = ("estimates",),
    client: distributed.Client | None = None,
    workers: int | None = None,
    retries: int = 2,
    progress: Callable[[int, int, int], None] | None = None,
) -> Report:
    """Replays every recording (:func:`gripd.replay`) to ``OUT/<table>/recording=<name>/0.parquet``.

    Args:
        config: Configuration of the car. The files that it names go with it.
        recordings: A folder, with all below it; a pattern (``s3://fleet/drives/**/*.blf``); or names.
        out: A folder; made if it is not there.
        tables: Of ``"estimates"``, ``"samples"`` and ``"published"``.
        client: Of a running cluster of Dask's. Without, one of this machine, for this call.
        workers: So many processes of this machine; without, as many as it has processors.
        retries: So often a task is tried again when its machine fails it: disk, network, memory.
        progress: Called with (done, bad, all) after each recording.

    Raises:
        gripd.UsageError: The configuration or what is asked has to be changed: it is the same for all.
    """
    task = _Replay(_url(config), _url(out), tuple(tables))
    found = _found(recordings)
    return _run([(name, [url]) for name, url in found], task, client, workers, retries, progress)


def explain(
    config: Url,
    recordings: Url | Sequence[Url],
    out: Url,
    *,
    history: bool = False,
    client: distributed.Client | None = None,
    workers: int | None = None,
    retries: int = 2,
    progress: Callable[[int, int, int], None] | None = None,
) -> Report:
    """Which causes, in which cars, and since when: :func:`gripd.explain` of every recording.

    The findings go to ``OUT/findings/recording=<name>/0.parquet`` (:data:`FINDINGS`). With ``history`` the drives of each car
    are asked together what has changed since when: ``OUT/changes/recording=<car>/0.parquet`` (:data:`CHANGES`). A car is the
    first folder below ``recordings``.

    Args:
        config: Configuration; ``{car}`` in it stands for the car: ``s3://fleet/cars/{car}/car.toml``.
        recordings: As of :func:`replay`.
        out: As of :func:`replay`.
        history: Ask the drives of each car together.
        client: As of :func:`replay`.
        workers: As of :func:`replay`.
        retries: As of :func:`replay`.
        progress: As of :func:`replay`.

    Raises:
        gripd.UsageError: As of :func:`replay`.
    """
    found = _found(recordings)
    if not history:
        jobs = [(name, [url]) for name, url in found]
    else:
        cars: dict[str, list[str]] = {}
        for name, url in found:
            cars.setdefault(_car(name), []).append(url)
        jobs = list(cars.items())
    return _run(jobs, _Explain(_url(config), _url(out), history), client, workers, retries, progress)


def _url(place: Url) -> str:
    """Workers may stand elsewhere: a path of this machine from its root on."""
    place = os.fspath(place)
    return place if "://" in place else os.path.abspath(place)


def _car(name: str) -> str:
    return name.split("/", 1)[0] if "/" in name else ""


def _found(recordings: Url | Sequence[Url]) -> list[tuple[str, str]]:
    """The recordings: what each is called below what all have in common, and where it is."""
    if not isinstance(recordings, (str, os.PathLike)):
        paths = {_url(one) for one in recordings}
        root = os.path.commonpath([path.split("://")[-1] for path in paths]) if len(paths) > 1 else None
        named = [(_below(path.split("://")[-1], root), path) for path in paths]
    else:
        fs, place = fsspec.core.url_to_fs(_url(recordings))
        fs.invalidate_cache()
        has_pattern = re.search(r"[*?\[]", place)
        root = place[: has_pattern.start()].rsplit("/", 1)[0] if has_pattern else place
        files = fs.glob(place) if has_pattern else fs.find(place)
        files = [file for file in files if not fs.isdir(file)] if has_pattern else files
        named = [(_below(file, root), fs.unstrip_protocol(file)) for file in files]
    return sorted(one for one in named if not one[0].rsplit("/", 1)[-1].startswith("."))


def _below(path: str, root: str | None) -> str:
    return os.path.relpath(path, root) if root else path.rsplit("/", 1)[-1]


def _files_of(config: str) -> tuple[fsspec.AbstractFileSystem, list[str]]:
    """A configuration and the files that it names (DBC, tires), the configuration first."""
    fs, path = fsspec.core.url_to_fs(config)
    fs.invalidate_cache()
    root = path.rsplit("/", 1)[0]
    try:
        waiting: list[Any] = [tomllib.loads(fs.cat_file(path).decode())]
    except FileNotFoundError:
        raise gripd.UsageError(f"{config}: there is no such file") from None
    except ValueError:
        waiting = []  # gripd says better what is wrong with it
    files = [path]
    while waiting:
        one = waiting.pop()
        if isinstance(one, (dict, list)):
            waiting.extend(one.values() if isinstance(one, dict) else one)
        elif isinstance(one, str) and one.endswith((".dbc", ".tir")):
            named = posixpath.normpath(posixpath.join(root, one))
            if fs.isfile(named):
                files.append(named)
    return fs, [path, *sorted(set(files[1:]))]


def _here(config: str) -> str:
    """A configuration as a file of this machine, with the files that it names where it looks for them."""
    fs, files = _files_of(config)
    return files[0] if "local" in _protocols(fs) else _fetched(config, tuple(_version(fs, file) for file in files))


@functools.lru_cache(maxsize=64)
def _fetched(config: str, _versions: tuple[str, ...]) -> str:
    fs, files = _files_of(config)
    folder = tempfile.mkdtemp(prefix="gripd-car-")
    root = posixpath.commonpath([posixpath.dirname(file) for file in files])
    here = [Path(folder, posixpath.relpath(file, root)) for file in files]
    for file, there in zip(files, here):
        there.parent.mkdir(parents=True, exist_ok=True)
        fs.get_file(file, str(there))
    return str(here[0])


def _protocols(fs: fsspec.AbstractFileSystem) -> tuple[str, ...]:
    return (fs.protocol,) if isinstance(fs.protocol, str) else tuple(fs.protocol)


@contextlib.contextmanager
def _local(url: str) -> Iterator[str]:
    """A recording as a file of this machine, as long as it is needed."""
    fs, path = fsspec.core.url_to_fs(url)
    if "local" in _protocols(fs):
        yield path
        return
    # By its own name: its ending may say what format it is.
    with tempfile.TemporaryDirectory(prefix="gripd-") as folder:
        file = os.path.join(folder, path.rsplit("/", 1)[-1])
        fs.get_file(path, file)
        yield file


def _put(data: bytes, url: str) -> None:
    """A file that is complete under its name, or not there."""
    fs, path = fsspec.core.url_to_fs(url)
    fs.makedirs(path.rsplit("/", 1)[0], exist_ok=True)
    if "local" not in _protocols(fs):
        fs.pipe_file(path, data)  # an object is there when all of it is
        return
    aside = f"{path}.{uuid.uuid4().hex}.part"
    with open(aside, "wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    os.replace(aside, path)


def _parquet(table: pa.Table) -> bytes:
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink, compression="zstd")
    return sink.getvalue().to_pybytes()


class _Identities:
    """What is the same as long as a task's result would be."""

    def __init__(self, task: _Task) -> None:
        self.task = task
        self.configs: dict[str, list[str]] = {}

    def of(self, name: str, urls: Sequence[str]) -> str:
        config = self.task.config_of(name)
        if config not in self.configs:
            fs, files = _files_of(config)
            self.configs[config] = [part for file in files for part in (file, _version(fs, file))]
        parts = [gripd.__version__, type(self.task).__name__, repr(self.task.asked()), *self.configs[config]]
        for url in urls:
            parts += [url, _version(*fsspec.core.url_to_fs(url))]
        return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def _version(fs: fsspec.AbstractFileSystem, path: str) -> str:
    """What tells one content of a file from another: its size, and what the store has of sum or date."""
    info = fs.info(path)
    of_store = ("ETag", "etag", "md5Hash", "mtime", "LastModified", "last_modified", "created")
    return f"{info['size']} {next((info[key] for key in of_store if info.get(key)), '')}"


@dataclass(frozen=True)
class _Task:
    """What is done with a recording, or with a car's recordings."""

    config: str
    out: str

    def asked(self) -> tuple[str, ...]:
        """The tables that are written; what the result depends on beside recordings, configuration and version."""
        raise NotImplementedError

    def work(self, config: str, name: str, recordings: dict[str, str]) -> dict[str, Any]:
        """Writes the results, and gives counts."""
        raise NotImplementedError

    def file(self, table: str, name: str) -> str:
        return f"{self.out}/{table}/recording={quote(name, safe='')}/0.parquet"

    def mark(self, name: str) -> str:
        return f"{self.out}/marks/{quote(name, safe='')}.json"

    def remove(self, name: str) -> None:
        """Results of a recording that was there under the same name."""
        for table in self.asked():
            fs, path = fsspec.core.url_to_fs(self.file(table, name))
            if fs.exists(path):
                fs.rm_file(path)

    def config_of(self, name: str) -> str:
        return self.config.replace("{car}", _car(name) or name)

    def __call__(self, name: str, urls: list[str], identity: str) -> Outcome:
        begin = time.monotonic()
        problem, stats, has_result = None, {}, True
        with contextlib.ExitStack() as stack:
            # As a file here, and what it is called for everybody else.
            recordings = {stack.enter_context(_local(url)): url for url in urls}
            try:
                stats = self.work(_here(self.config_of(name)), name, recordings)
            except gripd.BrokenRecording as broken:
                problem = _called(str(broken), recordings)
            except gripd.WorkError as error:
                problem, has_result = _called(str(error), recordings), False
                self.remove(name)
        worker = distributed.get_worker().address
        outcome = Outcome(name, problem, has_result, time.monotonic() - begin, worker, stats)
        _put(json.dumps({"identity": identity, **vars(outcome)}).encode(), self.mark(name))
        return outcome

    def earlier(self, name: str, identity: str) -> Outcome | None:
        """What an earlier call has done, if that is what this one would do."""
        fs, path = fsspec.core.url_to_fs(self.mark(name))
        try:
            mark = json.loads(fs.cat_file(path))
            return Outcome(**mark) if mark.pop("identity") == identity else None
        except (FileNotFoundError, ValueError, KeyError, TypeError):
            return None


@dataclass(frozen=True)
class _Replay(_Task):
    tables: tuple[str, ...]

    def asked(self) -> tuple[str, ...]:
        return self.tables

    def work(self, config: str, name: str, recordings: dict[str, str]) -> dict[str, Any]:
        broken = None
        try:
            result = gripd.replay(config, list(recordings))
        except gripd.BrokenRecording as error:
            broken, result = error, error.result
        for table in self.tables:
            _put(_parquet(getattr(result, table)), self.file(table, name))
        if broken is not None:
            raise broken
        return result.stats


@dataclass(frozen=True)
class _Explain(_Task):
    history: bool

    def asked(self) -> tuple[str, ...]:
        return ("changes",) if self.history else ("findings",)

    def work(self, config: str, name: str, recordings: dict[str, str]) -> dict[str, Any]:
        if self.history and len(recordings) < 2:
            raise gripd.WorkError("a car's only drive cannot be compared")
        broken = None
        try:
            answer = gripd.explain(config, list(recordings), history=self.history)
        except gripd.BrokenRecording as error:
            broken, answer = error, error.result
        if self.history:
            rows, schema, table = _changes(name, answer, recordings), CHANGES, "changes"
        else:
            rows, schema, table = _findings(name, answer), FINDINGS, "findings"
        _put(_parquet(pa.Table.from_pylist(rows, schema)), self.file(table, name))
        if broken is not None:
            raise broken
        return {"rows": len(rows)}


def _called(words: str, recordings: dict[str, str]) -> str:
    for here, url in recordings.items():
        words = words.replace(here, url)
    return words


def _findings(name: str, answer: dict[str, Any]) -> list[dict[str, Any]]:
    begins = answer.get("begins_utc")
    of = {"car": _car(name), "recording": name, "verdict": answer["verdict"]}
    of["begins_utc"] = next(iter(begins.values()), None) if isinstance(begins, dict) else begins
    rows = []
    for finding in answer["findings"]:
        told = {key: finding.get(key) for key in ("kind", "effect", "channel", "evidence")}
        for parameter, number in finding["parameters"].items():
            rows.append({**of, **told, "parameter": parameter, "value": number["value"], "std": number["std"]})
        if not finding["parameters"]:
            rows.append({**of, **told})
    return rows or [of]


def _changes(car: str, answer: dict[str, Any], called: dict[str, str]) -> list[dict[str, Any]]:
    begins = {drive["log"]: drive.get("begins_utc") for drive in answer["history"]["drives"]}
    keys = ("effect", "channel", "parameter", "unit", "grows")
    rows = []
    for change in answer["history"]["changes"]:
        last, since = change["values"][-1], change["since"]
        row = {"car": car, "drives": len(begins), **{key: change[key] for key in keys}}
        row |= {"since": called.get(since, since), "since_utc": begins.get(since)}
        rows.append({**row, "value": last["value"], "std": last["std"]})
    return rows


def _run(
    jobs: Sequence[tuple[str, list[str]]],
    task: _Task,
    client: distributed.Client | None,
    workers: int | None,
    retries: int,
    progress: Callable[[int, int, int], None] | None,
) -> Report:
    begin = time.monotonic()
    identities = _Identities(task)
    outcomes, waiting = [], []
    for name, urls in jobs:
        identity = identities.of(name, urls)
        if earlier := task.earlier(name, identity):
            outcomes.append(earlier)
        else:
            waiting.append((name, urls, identity))
    log.info("%d of %d are there already", len(outcomes), len(jobs))
    with contextlib.ExitStack() as stack:
        if waiting:
            client = client or stack.enter_context(_this_machine(workers))
            for outcome in stack.enter_context(contextlib.closing(_computed(client, task, waiting, retries))):
                outcomes.append(outcome)
                if progress:
                    progress(len(outcomes), sum(1 for outcome in outcomes if outcome.problem), len(jobs))
    outcomes.sort(key=lambda outcome: outcome.name)
    done = [outcome for outcome in outcomes if outcome.has_result]
    bad = [outcome for outcome in outcomes if outcome.problem]
    return Report(done, bad, len(waiting), time.monotonic() - begin)


def _computed(
    client: distributed.Client, task: _Task, jobs: Sequence[tuple[str, list[str], str]], retries: int
) -> Iterator[Outcome]:
    """What becomes of each, as they end."""
    futures = {
        client.submit(task, *job, key=f"gripd-{job[0]}-{uuid.uuid4().hex}", retries=retries): job[0] for job in jobs
    }
    try:
        for future in distributed.as_completed(list(futures)):
            error = future.exception()
            if isinstance(error, gripd.UsageError):
                raise error
            yield future.result() if error is None else _given_up(futures[future], error)
            future.release()
    finally:
        # Whoever has enough of it does not leave work behind in a cluster of others.
        client.cancel(list(futures))


def _given_up(name: str, error: BaseException) -> Outcome:
    """No mark: the next call tries again."""
    if isinstance(error, distributed.KilledWorker):
        words = "each worker that had it died: too little memory?"
    else:
        words = f"{type(error).__name__}: {error}"
    return Outcome(name, words, False, 0.0, "")


@contextlib.contextmanager
def _this_machine(workers: int | None) -> Iterator[distributed.Client]:
    # A process has one task at a time; what it computes in shall not be shared out again.
    count = workers or len(os.sched_getaffinity(0))
    before = os.environ.get("RAYON_NUM_THREADS")
    os.environ["RAYON_NUM_THREADS"] = str(max(1, len(os.sched_getaffinity(0)) // count))
    try:
        with (
            distributed.LocalCluster(
                n_workers=count, threads_per_worker=1, dashboard_address=None, silence_logs=logging.ERROR
            ) as cluster,
            distributed.Client(cluster) as client,
        ):
            yield client
    finally:
        if before is None:
            del os.environ["RAYON_NUM_THREADS"]
        else:
            os.environ["RAYON_NUM_THREADS"] = before


def _line(begin: float) -> Callable[[int, int, int], None]:
    """Progress as a line that is written over."""

    def show(done: int, bad: int, count: int) -> None:
        left = (time.monotonic() - begin) / done * (count - done)
        print(f"\r{done} of {count}, {bad} bad, {left:.0f} s left   ", end="", file=sys.stderr, flush=True)

    return show


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m gripd.fleet", description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=["replay", "explain"])
    parser.add_argument("config", help="configuration of the car; {car} in it stands for the car (explain)")
    parser.add_argument("recordings", help="a folder or pattern of recordings")
    parser.add_argument("out", help="a folder for the results")
    parser.add_argument("--history", action="store_true", help="explain: ask the drives of each car together")
    parser.add_argument("--scheduler", help="of a running cluster (tcp://…); without, this machine")
    parser.add_argument("--workers", type=int, help="processes of this machine")
    asked = parser.parse_args()
    client = distributed.Client(asked.scheduler) if asked.scheduler else None
    common = {"client": client, "workers": asked.workers}
    if sys.stderr.isatty():
        common["progress"] = _line(time.monotonic())
    try:
        if asked.what == "replay":
            report = replay(asked.config, asked.recordings, asked.out, **common)
        else:
            report = explain(asked.config, asked.recordings, asked.out, history=asked.history, **common)
    except gripd.UsageError as error:
        print(f"gripd.fleet: {error}", file=sys.stderr)
        return 2
    for outcome in report.bad:
        print(f"gripd.fleet: {outcome.name}: {outcome.problem}", file=sys.stderr)
    print(f"{len(report.done)} done, {report.new} of this call, {len(report.bad)} bad, {report.seconds:.1f} s")
    return 1 if report.bad else 0


if __name__ == "__main__":
    sys.exit(main())
