"""Control-C ends every long call before its work is complete."""

import _thread
import operator
import os
import signal
import threading
import time
from collections import deque
from functools import partial

import numpy as np
import pytest

import footnav
from footnav import Config, Recording, _core, detect, simulate, simulate_rest, track, track_many
from footnav.config import Output, Smoother
from footnav.detectors import GraphTheoretic
from footnav.simulation import SensorErrors

PATIENCE = 60.0
"""s; a test without an interrupt fails after this time."""


@pytest.fixture(scope="module")
def walk():
    """Walk 250 m."""
    return simulate([[0, 0], [250, 0]], sensor=SensorErrors.preset("mpu6050"), seed=1)[0]


def interrupt_as_it_begins(monkeypatch, name):
    """Simulate control-C just before the core begins; return a list of completed calls.

    All of it is one call of the interpreter, which cannot check for interrupts itself.
    """
    complete, core = [], getattr(_core, name)

    def call(*arguments):
        steps = [_thread.interrupt_main, partial(core, *arguments), partial(complete.append, name)]
        deque(map(operator.methodcaller("__call__"), steps), maxlen=0)

    monkeypatch.setattr(_core, name, call)
    return complete


@pytest.mark.parametrize(
    ("name", "work"),
    [
        ("simulate", lambda _: simulate([[0, 0], [250, 0]], seed=1)),
        ("simulate_rest", lambda _: simulate_rest(200.0, "mpu6050", seed=1)),
        ("detect", lambda walk: detect(walk, GraphTheoretic())),
    ],
)
def test_the_core_checks_for_interrupts(monkeypatch, walk, name, work):
    complete = interrupt_as_it_begins(monkeypatch, name)
    with pytest.raises(KeyboardInterrupt):
        work(walk)
    assert complete == []


@pytest.mark.parametrize("config", [Config(), Config(output=Output(strides=True))])
def test_a_batch_ends_between_two_blocks(walk, config):
    shares = []

    def press_control_c(share):
        shares.append(share)
        signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        track(walk, config, progress=press_control_c)
    assert len(shares) == 1
    assert shares[0] < 1.0


def test_a_smoother_is_cancelled_in_its_backward_pass(walk):
    shares = []

    def press_control_c(share):
        shares.append(share)
        if shares.count(1.0) == 2:
            signal.raise_signal(signal.SIGINT)

    whole = []
    track(walk, Config(smoother=Smoother(kind="rts")), progress=whole.append)
    with pytest.raises(KeyboardInterrupt):
        track(walk, Config(smoother=Smoother(kind="rts")), progress=press_control_c)
    assert shares.count(1.0) == 2 < whole.count(1.0)


@pytest.fixture
def endless(monkeypatch):
    """Let all recordings but those named "short" run until their thread is cancelled.

    Returns events for the start and for the end of one, and a list of
    those that have not.
    """
    begun, ended, given_up = threading.Event(), threading.Event(), []

    def track_endlessly(recording, config, *, progress):
        if recording.name == "short":
            return track(recording)
        begun.set()
        try:
            for _ in range(int(PATIENCE / 0.01)):
                progress(0.5)
                time.sleep(0.01)
            given_up.append(recording)
        finally:
            ended.set()

    monkeypatch.setattr(footnav.many, "track_quietly", track_endlessly)
    return begun, ended, given_up


def rest(name):
    """Return a recording of 3 s of rest."""
    return Recording(
        np.arange(300) / 100, np.tile([0.0, 0.0, 9.81], (300, 1)), np.zeros((300, 3)), name=name
    )


def test_threads_end_with_the_one_that_waits_for_them(endless):
    begun, ended, given_up = endless

    def press_control_c():
        begun.wait(PATIENCE)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=press_control_c).start()
    with pytest.raises(KeyboardInterrupt):
        list(track_many([rest("long")]))
    assert ended.wait(PATIENCE)
    assert given_up == []


def test_threads_end_with_the_iteration(endless):
    begun, ended, given_up = endless
    outcomes = track_many([rest("short"), rest("long")])
    assert len(next(outcomes).trajectory) == 300
    assert begun.wait(PATIENCE)
    outcomes.close()
    assert ended.wait(PATIENCE)
    assert given_up == []
