"""The serial source.

On a pseudo-terminal and with a scripted port, including its faults.
"""

import itertools
import os
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import footnav
from footnav.capture import Block, LossCounters, SerialSource, Setup, record, track_live
from footnav.capture.clock import HostedClock
from footnav.errors import ConfigError, DataError
from stream_lines import AT_REST, fault_line, header_line, sample_line, stream

INTERVAL = 0.005


@dataclass
class Script:
    """A port that has given pieces at given times, and the clock of the host."""

    pieces: list[tuple[float, bytes]]
    now: float = 0.0
    waiting: bytes = b""
    closed: bool = False
    timeout: float = field(default=0.05)

    def clock(self) -> float:
        return self.now

    @property
    def in_waiting(self) -> int:
        return len(self.waiting)

    def read(self, size: int = 1) -> bytes:
        end = self.now + (self.timeout if size else 0)
        while len(self.waiting) < size and self.pieces and self.pieces[0][0] <= end:
            when, piece = self.pieces.pop(0)
            self.now = max(self.now, when)
            self.waiting += piece
        if len(self.waiting) < size:
            self.now = end
        data, self.waiting = self.waiting[:size], self.waiting[size:]
        return data

    def close(self) -> None:
        self.closed = True


def source_of(*pieces: tuple[float, bytes]) -> SerialSource:
    script = Script(list(pieces))
    return SerialSource(script, "ttyTEST", script.clock)


def read_samples(source: SerialSource, n: int) -> list[Block]:
    """Read until there are `n` samples."""
    blocks: list[Block] = []
    while sum(map(len, blocks)) < n:
        blocks += source.read()
    return blocks


@pytest.fixture
def terminal() -> Iterator[tuple[int, str]]:
    """Open a pseudo-terminal: its master, and the name of the port at its other end."""
    master, slave = os.openpty()
    yield master, os.ttyname(slave)
    os.close(slave)
    os.close(master)


def send(master: int, data: bytes) -> threading.Thread:
    """Let a thread be the board."""

    def write() -> None:
        rest = memoryview(data)
        while rest:
            rest = rest[os.write(master, rest[:512]) :]

    thread = threading.Thread(target=write, daemon=True)
    thread.start()
    return thread


# On a pseudo-terminal


def test_a_walk_comes_through_a_port(terminal):
    master, port = terminal
    walk = [(k, -k, 2048, -2160, 1, 2, 3) for k in range(600)]
    lines = stream(walk, stamp=2**32 - 1_000_000)
    lines[100] = b"S garbled\n"
    with SerialSource.open(port) as source:
        board = send(master, b"".join(lines))
        recording = record(source, 2.9)
        board.join()
        assert source.device == 1
        assert source.losses == LossCounters(missing=1, broken=1)
    kept = np.array(walk)[np.arange(600) != 99][: len(recording)]
    assert recording.name == port
    assert recording.accel_range == pytest.approx(16 * 9.80665)
    np.testing.assert_allclose(recording.accel, kept[:, :3] * 16 * 9.80665 / 32768)
    np.testing.assert_allclose(recording.gyro, np.radians(kept[:, 4:] * 2000 / 32768))
    np.testing.assert_allclose(recording.temperature, -2160 / 340 + 36.53)
    # Three seconds of stamps arrived at once: the host's clock does not affect them.
    np.testing.assert_allclose(np.diff(recording.t)[:98], INTERVAL, rtol=1e-9)
    assert recording.t[99] - recording.t[98] == pytest.approx(2 * INTERVAL)


def test_a_port_that_is_not_there_names_those_that_are():
    with pytest.raises(
        DataError, match=r"/dev/absent cannot be opened: No such file or directory; th.* ports? "
    ):
        SerialSource.open("/dev/absent")


def test_without_pyserial_the_error_has_the_command_that_installs_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(ConfigError, match="serial is missing: pip install pyserial"):
        SerialSource.open("/dev/ttyUSB0")


def test_a_port_that_disappears_is_reported():
    def fail(*_: object) -> bytes:
        raise OSError(5, "Input/output error")

    script = Script([])
    script.read = fail
    with pytest.raises(
        DataError, match=r"ttyTEST disappeared: Input/output error; was it unplugged\?"
    ):
        SerialSource(script, "ttyTEST", script.clock).read()


# When nothing good comes


@pytest.mark.parametrize(
    ("pieces", "message"),
    [
        ([], "no bytes arrive"),
        (
            [(0.1, b"\xff\x00\n" * 99)],
            "297 bytes arrived, but no line of the sketch: do the baud rates agree",
        ),
        ([(0.1, sample_line(0, 0) * 2)], "never the header with their full scale"),
        ([(0.1, header_line() + sample_line(0, 0))], "the board stopped sending"),
        (
            [(0.1, header_line() + sample_line(0, 0)), (2.0, fault_line(3))],
            "check the wire from INT",
        ),
    ],
)
def test_silence_names_the_likely_cause(pieces, message):
    source = source_of(*pieces)
    with pytest.raises(DataError, match=r"ttyTEST: no sample for 5 s; .*" + message):
        read_samples(source, 99)


def test_a_fault_before_the_first_sample_is_reported_at_once():
    source = source_of((0.01, fault_line(2, 0x71)))
    with pytest.raises(DataError, match="ttyTEST: WHO_AM_I of the sensor reads 0x71, an MPU9250"):
        source.read()


def test_a_fault_that_passes_is_only_counted():
    lines = [
        (0.1, b"".join(stream([AT_REST] * 3))),
        (1.0, fault_line(4)),
        (2.0, b"".join(stream([AT_REST] * 3))),
    ]
    source = source_of(*lines)
    assert sum(map(len, read_samples(source, 6))) == 6
    assert source.losses == LossCounters(restarts=1)


def test_the_port_is_closed_at_the_end():
    script = Script([])
    with SerialSource(script, "ttyTEST", script.clock):
        pass
    assert script.closed


# Time


def real_time_lines(
    samples: int,
    rate: float = 1.0,
    late: Callable[[int], float] = lambda _: 0.0,
    stamp: int = 0,
    at: float = 0.0,
) -> list[tuple[float, bytes]]:
    """Lines of a board whose clock runs at `rate`, in pieces of four, in real time and late."""
    header, *lines = stream([AT_REST] * samples, stamp, interval=round(5000 * rate))
    pieces = [
        (at + INTERVAL * (k + 3) + late(k), b"".join(lines[k : k + 4]))
        for k in range(0, samples, 4)
    ]
    return [(at, header), *pieces]


@pytest.mark.slow
@pytest.mark.parametrize("rate", [0.996, 1.0, 1.004])
def test_the_host_disciplines_a_cheap_clock(rate):
    rng = np.random.default_rng(3)
    delays = rng.uniform(0.001, 0.017, 4000)
    source = source_of(*real_time_lines(4000, rate, lambda k: delays[k]))
    t = np.concatenate([block.t for block in read_samples(source, 4000)])
    assert (t[-1] - t[2000]) / (INTERVAL * 1999) == pytest.approx(1, abs=3e-4)
    # The arrival time of a piece does not change an interval.
    np.testing.assert_allclose(np.diff(t), INTERVAL, rtol=0.01)


def test_a_host_that_is_busy_for_a_while_does_not_bend_time():
    source = source_of(*real_time_lines(4000, late=lambda k: 0.5 if 2000 <= k < 2100 else 0.004))
    t = np.concatenate([block.t for block in read_samples(source, 4000)])
    np.testing.assert_allclose(np.diff(t), INTERVAL, rtol=1e-3)


def test_the_host_clock_gives_the_duration_of_a_restart():
    source = source_of(
        *real_time_lines(200, stamp=7_000_000), *real_time_lines(200, stamp=100_000, at=3.0)
    )
    blocks = read_samples(source, 400)
    t = np.concatenate([block.t for block in blocks])
    assert source.losses == LossCounters(restarts=1)
    assert t[200] - t[0] == pytest.approx(3.0, abs=0.01)
    assert np.diff(t).min() > 0


@given(
    st.floats(0.98, 1.02), st.lists(st.floats(0, 0.02), min_size=3, max_size=30), st.integers(1, 9)
)
def test_stamps_never_go_back(rate, delays, size):
    clock = HostedClock(rate_sigma=0.02, latency=0.005)
    last = -1.0
    for k, delay in enumerate(delays):
        device = INTERVAL * np.arange(k * size, (k + 1) * size)
        t = clock.stamps(device, float(device[-1]) * rate + delay)
        assert t[0] > last
        assert np.all(np.diff(t) > 0)
        last = t[-1]


# What becomes of the samples


def test_blocks_go_straight_into_a_navigator():
    walk, _ = footnav.simulate(footnav.simulation.Route.straight(3.0), sensor="ideal")
    scale = 32768 / np.repeat([16 * 9.80665, np.radians(2000)], 3)
    raw = np.rint(np.hstack([walk.accel, walk.gyro]) * scale).astype(int)
    counts = np.insert(raw, 3, 0, axis=1).tolist()
    lines = stream([tuple(row) for row in counts])
    pieces = [(0.02 * k, b"".join(lines[4 * k : 4 * k + 4])) for k in range(len(lines) // 4)]
    navigator = footnav.Navigator(rate_hz=200)
    states = track_live(source_of(*pieces), navigator)
    n = sum(map(len, itertools.islice(states, len(pieces) - 1)))
    assert n > 0.8 * len(walk)
    assert navigator.position[0] == pytest.approx(3.0, abs=0.3)


def test_another_full_scale_in_the_midst_is_refused():
    other = bytes((4, 2, 0, 0))
    lines = b"".join(stream([AT_REST] * 300)) + header_line(other) + sample_line(300 * 5000, 300)
    with pytest.raises(
        DataError, match=r"ttyTEST: the settings of the chip changed from 16 g.* to 2 g, 250 deg/s"
    ):
        record(source_of((0.1, lines)), 60)


def test_a_wrong_scale_is_seen_in_the_first_second():
    twice = (0, 0, 4096, 0, 0, 0, 0)
    with pytest.raises(DataError, match="about 2 g where the sensor is at rest"):
        record(source_of((0.1, b"".join(stream([twice] * 300)))), 60)


def test_one_sample_is_no_recording():
    from footnav.capture import Recorder

    recorder = Recorder("ttyTEST")
    recorder.add(Block.from_counts(np.zeros(1), [AT_REST], Setup()))
    with pytest.raises(DataError, match="ttyTEST: 1 samples arrived; a recording needs at least 2"):
        recorder.recording()
