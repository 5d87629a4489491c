"""Batch processing of many recordings in parallel; a failure affects one recording only."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from concurrent.futures import TimeoutError as FutureTimeout
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

from footnav._core import __version__
from footnav.config import DEFAULTS, Config
from footnav.errors import DataError
from footnav.io import read
from footnav.recording import Recording
from footnav.tracking import track_quietly
from footnav.trajectory import Trajectory, load_trajectory

Source: TypeAlias = "Recording | str | os.PathLike[str]"
Reader: TypeAlias = "Callable[[Path], Recording]"

POLL_INTERVAL = 0.5
"""s between two checks for interrupts; without a time limit, an interrupt just before the wait
would not end it.
"""


@dataclass(frozen=True, slots=True, eq=False)
class TrackResult:
    """Result of one recording.

    Attributes
    ----------
    index : int
        Index among the recordings, from 0.
    name : str
        Name of the recording or of the file.
    error : Exception or None
        The error of the recording.
    resumed : bool
        Whether the track is that of an earlier run.
    """

    index: int
    name: str
    error: Exception | None
    resumed: bool
    _track: Trajectory | Path | None

    @property
    def trajectory(self) -> Trajectory:
        """The track; read from the folder if there is one.

        Raises
        ------
        Exception
            The error of the recording.
        """
        if self.error is not None:
            raise self.error
        assert self._track is not None
        if isinstance(self._track, Path):
            return load_trajectory(self._track)
        return self._track


def track_many(
    recordings: Iterable[Source],
    config: Config | None = None,
    *,
    executor: Executor | None = None,
    reader: Reader = read,
    folder: str | os.PathLike[str] | None = None,
    ordered: bool = True,
) -> Iterator[TrackResult]:
    """Track many recordings in parallel.

    Parameters
    ----------
    recordings : iterable of Recording or path
        They are taken as workers become free, so a generator may have any length.  A path is read
        by the worker, so that paths and not samples are sent to other processes and machines.
    config : Config, optional
        Settings for all of them; the defaults need no tuning.
    executor : concurrent.futures.Executor, optional
        Workers: threads of this process unless given, one for each core, since the core releases
        the interpreter's lock while it tracks.  A ``ProcessPoolExecutor`` also reads files in
        parallel, and dask's ``Client.get_executor()`` does so on a cluster.  It is not shut down.
    reader : callable
        Reads a path, such as ``functools.partial(footnav.read, format="mpu6050", accel_range=8,
        gyro_range=1000)``.
    folder : path, optional
        Folder for the tracks as ``.npz``.  A run with the same folder, settings and version of
        footnav resumes an earlier one: recordings with the same samples, or files with the same
        size and modification time, are not tracked again.  Workers on other machines need access to
        the folder.
    ordered : bool
        Whether the results are in the order of the recordings, or in the order of completion.

    Yields
    ------
    TrackResult
        One for each recording; a failure is stored as `error` and does not affect the others.

    Raises
    ------
    DataError
        The folder cannot be created.

    Notes
    -----
    The tracks are those of :func:`footnav.track`, to the bit.  Its warnings are flags in the
    `health` of each track.

    An interrupt from the keyboard, or the end of the iteration, stops the threads at their next
    block of samples.  In an executor of the caller the pending recordings are cancelled; running
    ones complete.

    Examples
    --------
    >>> for result in track_many(Path("walks").glob("*.csv")):  # doctest: +SKIP
    ...     print(result.name, result.error or result.trajectory.summary())
    """
    job = Job(config or DEFAULTS, reader, _created(folder))
    if executor is not None:
        yield from _results(recordings, job, executor, ordered)
        return
    threads, cancelled = ThreadPoolExecutor(os.cpu_count()), threading.Event()
    try:
        yield from _results(
            recordings, replace(job, progress=_cancelled_by(cancelled)), threads, ordered
        )
        threads.shutdown()
    finally:
        cancelled.set()
        threads.shutdown(wait=False, cancel_futures=True)


def _cancelled_by(cancelled: threading.Event) -> Callable[[float], None]:
    """Return a progress callback that cancels a thread, which interrupts do not reach."""

    def progress(_: float) -> None:
        if cancelled.is_set():
            raise CancelledError

    return progress


@dataclass(frozen=True, slots=True)
class Job:
    """Task of a worker for every recording."""

    config: Config
    reader: Reader
    folder: Path | None
    progress: Callable[[float], None] | None = None

    def run(self, index: int, source: Source) -> TrackResult:
        """Track one recording; an error becomes part of the result."""
        name = _name(source)
        try:
            cached = self._cache_file(source, name)
            if cached is not None and cached.exists():
                return TrackResult(index, name, None, resumed=True, _track=cached)
            return TrackResult(index, name, None, resumed=False, _track=self._track(source, cached))
        except (
            Exception
        ) as error:  # A reader of the caller may raise anything, and the other recordings continue.
            return TrackResult(index, name, error, resumed=False, _track=None)

    def _cache_file(self, source: Source, name: str) -> Path | None:
        """Return the file of the track."""
        if self.folder is None:
            return None
        return self.folder / f"{Path(name).name or 'track'}-{self._digest(source)}.npz"

    def _track(self, source: Source, cached: Path | None) -> Trajectory | Path:
        recording = source if isinstance(source, Recording) else self.reader(Path(source))
        trajectory = track_quietly(recording, self.config, progress=self.progress)
        if cached is None:
            return trajectory
        trajectory.save(cached)
        return cached

    def _digest(self, source: Source) -> str:
        """Hash everything that affects the track."""
        digest = hashlib.sha256(
            f"{__version__}\n{_describe(self.reader)}\n".encode() + self.config.to_json()
        )
        if isinstance(source, Recording):
            ranges = f"{source.accel_range} {source.gyro_range}"
            digest.update(ranges.encode())
            mag = source.mag if self.config.magnetometer.heading else None
            for samples in (source.t, source.accel, source.gyro, mag):
                digest.update(b"" if samples is None else samples.tobytes())
        else:
            path = Path(source)
            status = path.stat() if path.exists() else None
            about = None if status is None else (status.st_size, status.st_mtime_ns)
            digest.update(f"{path.resolve()}\n{about}".encode())
        return digest.hexdigest()[:16]


def _results(
    recordings: Iterable[Source], job: Job, executor: Executor, ordered: bool
) -> Iterator[TrackResult]:
    """Keep the workers busy with a short queue."""
    ahead = 2 * (os.cpu_count() or 1) + 2
    waiting: deque[Future[TrackResult]] = deque()
    try:
        for index, source in enumerate(recordings):
            waiting.append(executor.submit(job.run, index, source))
            if len(waiting) >= ahead:
                yield _next(waiting, ordered)
        while waiting:
            yield _next(waiting, ordered)
    finally:
        for future in waiting:
            future.cancel()


def _next(waiting: deque[Future[TrackResult]], ordered: bool) -> TrackResult:
    """Take the oldest result, or the first that is done."""
    future = _oldest(waiting) if ordered else _any(waiting)
    waiting.remove(future)
    return future.result()


def _oldest(waiting: deque[Future[TrackResult]]) -> Future[TrackResult]:
    """Wait for the oldest alone: `wait` for many takes half as much processor time again."""
    oldest = waiting[0]
    while not oldest.done():
        with contextlib.suppress(FutureTimeout):
            oldest.exception(POLL_INTERVAL)
    return oldest


def _any(waiting: deque[Future[TrackResult]]) -> Future[TrackResult]:
    done: set[Future[TrackResult]] = set()
    while not done:
        done = wait(waiting, POLL_INTERVAL, FIRST_COMPLETED).done
    return next(iter(done))


def _name(source: Source) -> str:
    return source.name if isinstance(source, Recording) else Path(source).stem


def _describe(reader: Reader) -> str:
    """Return a name of a reader and its options that is the same in every run."""
    if isinstance(reader, functools.partial):
        return f"{_describe(reader.func)} {reader.args} {sorted(reader.keywords.items())}"
    return f"{reader.__module__}.{getattr(reader, '__qualname__', type(reader).__qualname__)}"


def _created(folder: str | os.PathLike[str] | None) -> Path | None:
    if folder is None:
        return None
    path = Path(folder)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DataError(f"{path}: cannot be created: {error.strerror or error}") from error
    return path
