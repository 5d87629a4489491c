"""Many recordings.

The tracks of `track` to the bit, wherever they are made, and no failure loses the others.
"""

import functools
import os
import sys
import threading
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

from footnav import Config, Recording, read, simulate, track, track_many
from footnav.detectors import Shoe
from footnav.errors import DataError
from footnav.simulation import Gait, Route, SensorErrors


@pytest.fixture(scope="module")
def walks():
    """Simulate six short walks."""
    gait, sensor = Gait.preset("walk"), SensorErrors.preset("mpu6050")
    return [
        simulate(Route.straight(3.0), gait, sensor, seed=seed, rate_hz=100.0)[0]
        for seed in range(6)
    ]


@pytest.fixture(scope="module")
def files(walks, tmp_path_factory):
    """Write them as files."""
    folder = tmp_path_factory.mktemp("walks")
    paths = [folder / f"walk{k}.csv" for k in range(len(walks))]
    for walk, path in zip(walks, paths, strict=True):
        walk.save(path)
    return paths


def assert_tracks(results, recordings, config=None):
    assert [result.index for result in results] == list(range(len(recordings)))
    for result, recording in zip(results, recordings, strict=True):
        np.testing.assert_array_equal(result.trajectory.position, track(recording, config).position)
        np.testing.assert_array_equal(
            result.trajectory.position_std, track(recording, config).position_std
        )


def test_the_tracks_are_those_of_one_after_the_other(walks):
    for config in (None, Config(detector=Shoe())):
        assert_tracks(list(track_many(walks, config)), walks, config)


def test_paths_are_read_where_they_are_tracked(files):
    results = list(track_many(files))
    assert [result.name for result in results] == [path.stem for path in files]
    assert_tracks(results, [read(path) for path in files])


def test_a_reader_with_options(files):
    reader = functools.partial(read, accel_range=16, gyro_range=2000)
    assert_tracks(list(track_many(files, reader=reader)), [reader(path) for path in files])


@pytest.mark.parametrize("ordered", [True, False])
def test_any_executor_will_do(ordered, files):
    with ThreadPoolExecutor(3) as threads:
        results = list(track_many(files, executor=threads, ordered=ordered))
        assert threads.submit(int).result() == 0
    assert_tracks(sorted(results, key=lambda result: result.index), [read(path) for path in files])


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="the start of a process is slow there")
def test_processes(files):
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as processes:
        assert_tracks(list(track_many(files, executor=processes)), [read(path) for path in files])


@pytest.mark.slow
def test_a_cluster(files):
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        assert_tracks(
            list(track_many(files, executor=client.get_executor())), [read(path) for path in files]
        )


def test_one_that_fails_does_not_lose_the_others(files, tmp_path):
    broken = tmp_path / "broken.csv"
    broken.write_text("t,ax,ay,az,gx,gy,gz\n0.0,1,2\n")
    sources = [files[0], broken, tmp_path / "absent.csv", files[1]]
    results = list(track_many(sources))
    assert [result.error is None for result in results] == [True, False, False, True]
    with pytest.raises(DataError, match=r"broken.csv"):
        _ = results[1].trajectory
    with pytest.raises(DataError, match=r"absent.csv does not exist"):
        _ = results[2].trajectory
    assert_tracks([results[0]], [read(files[0])])


def test_an_exception_of_a_reader_affects_one_recording(files):
    def reader(path):
        if path == files[2]:
            raise KeyError("no such column")
        return read(path)

    results = list(track_many(files, reader=reader))
    assert [result.index for result in results if result.error is not None] == [2]
    assert isinstance(results[2].error, KeyError)


def test_a_run_resumes_an_earlier_one(files, tmp_path):
    folder = tmp_path / "tracks"
    some = track_many(files, folder=folder)
    next(some)
    next(some)
    some.close()
    started = len(list(folder.glob("*.npz")))
    assert started >= 2
    results = list(track_many(files, folder=folder))
    assert sum(result.resumed for result in results) >= started
    assert_tracks(results, [read(path) for path in files])
    assert all(result.resumed for result in track_many(files, folder=folder))


def test_other_settings_samples_or_readers_are_tracked_again(walks, files, tmp_path):
    def resumed(*arguments, **options):
        return [
            result.resumed
            for result in track_many(*arguments, folder=tmp_path / "tracks", **options)
        ]

    assert not any(resumed(files[:2]) + resumed(walks[:2]))
    assert all(resumed(files[:2]) + resumed(walks[:2]))
    assert not any(resumed(files[:2], Config(detector=Shoe())))
    assert not any(resumed(files[:2], reader=functools.partial(read, accel_range=16)))
    assert all(resumed(files[:2], reader=functools.partial(read, accel_range=16)))
    os.utime(files[0], ns=(1, 1))
    assert resumed(files[:2]) == [False, True]
    first = walks[0]
    ranged = Recording(first.t, first.accel, first.gyro, name=first.name, accel_range=300.0)
    assert resumed([ranged, first]) == [False, True]


def test_recordings_are_taken_as_workers_become_free(walks):
    taken = []

    def endless():
        while True:
            taken.append(len(taken))
            yield walks[0]

    results = track_many(endless())
    next(results)
    assert len(taken) <= 2 * (os.cpu_count() or 1) + 2
    results.close()


def test_no_thread_is_left(walks):
    before = set(threading.enumerate())
    list(track_many(walks[:2]))
    assert set(threading.enumerate()) <= before


def test_a_folder_that_cannot_be_made(tmp_path, walks):
    (tmp_path / "file").write_text("")
    with pytest.raises(DataError, match=r"file.*cannot be created"):
        next(track_many(walks, folder=tmp_path / "file"))
