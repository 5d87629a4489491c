"""An MPU6050 at an Arduino, on a serial port."""

from __future__ import annotations

import errno
import itertools
import os
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

import numpy as np

from footnav.capture.block import Block
from footnav.capture.clock import HostedClock
from footnav.capture.line import Decoder, Sample
from footnav.capture.silence import Silence
from footnav.capture.source import CloseOnExit, LossCounters
from footnav.errors import ConfigError, DataError
from footnav.optional import require

if TYPE_CHECKING:
    from typing_extensions import Self

BAUD = 250_000
"""Bits per second, as in the sketch."""

POLL_INTERVAL = 0.05
"""Maximum wait for bytes, s."""

MAX_SILENCE = 5.0
"""Maximum time without samples, s; an Arduino that is reset as its port is opened takes up to 2 s.
"""

_RATE_SIGMA, _LATENCY = 0.005, 0.005
"""Error of the ceramic resonator of an Uno; latency of USB bridges, 1 to 16 ms, s."""


class Port(Protocol):
    """The members of `serial.Serial` that are used."""

    @property
    def in_waiting(self) -> int:
        """Number of bytes that can be read immediately."""
        ...

    def read(self, size: int = 1) -> bytes:
        """Wait for `size` bytes, up to the time-out of the port, and return those that arrived."""
        ...

    def close(self) -> None:
        """Release the port."""
        ...


class SerialSource(CloseOnExit):
    """A board with the sketch `mpu6050_stream` on a serial port; a `footnav.capture.Source`.

    Parameters
    ----------
    port : Port
        An open port with a time-out; `SerialSource.open` opens one.
    name : str
        Name in messages.
    clock : callable
        The host's time, s; monotonic.
    """

    name: str

    def __init__(self, port: Port, name: str, clock: Callable[[], float] = time.monotonic) -> None:
        self.name = name
        self._port = port
        self._now = clock
        self._decoder = Decoder()
        self._clock = HostedClock(_RATE_SIGMA, _LATENCY)
        self._run: int | None = None
        self._received = 0
        self._silence = Silence()

    @classmethod
    def open(cls, port: str, baud: int = BAUD) -> Self:
        """Open a port.

        Parameters
        ----------
        port : str
            Its name, such as "/dev/ttyUSB0", "/dev/ttyACM0" or "COM3".
        baud : int
            Bits per second, as in the sketch.

        Returns
        -------
        SerialSource
            To be closed after use, or used in a `with` statement.

        Raises
        ------
        ConfigError
            pyserial is missing.
        DataError
            The port cannot be opened; the message names those that exist.
        """
        serial = require("serial", "pyserial", ConfigError)
        try:
            opened = serial.Serial(port, baud, timeout=POLL_INTERVAL)
            opened.reset_input_buffer()
        except (OSError, ValueError) as error:
            raise DataError(f"{port} cannot be opened: {_reason(error)}; {_ports_text()}") from None
        return cls(opened, port)

    def close(self) -> None:
        """Close the port."""
        self._port.close()

    @property
    def losses(self) -> LossCounters:
        """Losses since the start of the capture."""
        return self._decoder.losses

    @property
    def device(self) -> int | None:
        """Number of the sensor in the sketch; None before the first header."""
        return self._decoder.device

    def read(self) -> list[Block]:
        """Return the samples that have arrived, within `POLL_INTERVAL`.

        Returns
        -------
        list of Block
            Possibly none; more than one after a restart.

        Raises
        ------
        DataError
            The port disappeared, the board reports a fault, or no sample arrived for `MAX_SILENCE`.
        """
        data = self._receive()
        host = self._now()
        samples = self._decoder.feed(data)
        self._received += len(data)
        if samples:
            self._silence.reset()
        else:
            self._check_alive(host)
        alike = itertools.groupby(samples, lambda sample: (sample.run, sample.setup))
        return [self._block(list(group), host) for _, group in alike]

    def _receive(self) -> bytes:
        try:
            # Wait for one byte, and read all that arrived with it.
            return self._port.read(1) + self._port.read(self._port.in_waiting)
        except OSError as error:
            raise DataError(
                f"{self.name} disappeared: {_reason(error)}; was it unplugged?"
            ) from None

    def _block(self, samples: list[Sample], host: float) -> Block:
        run, setup = samples[0].run, samples[0].setup
        device = np.array([sample.stamp_us for sample in samples]) * 1e-6
        if self._run in (None, run):
            t = self._clock.stamps(device, host)
        else:
            t = self._clock.restart(device, host, 1 / setup.rate_hz)
        self._run = run
        return Block.from_counts(t, [sample.counts for sample in samples], setup)

    def _check_alive(self, host: float) -> None:
        fault, silence = self._decoder.fault, self._silence.update(host)
        if fault and self._run is None:
            raise DataError(f"{self.name}: {fault}")
        if silence > MAX_SILENCE:
            raise DataError(
                f"{self.name}: no sample for {silence:.0f} s; {fault or self._likely_cause()}"
            )

    def _likely_cause(self) -> str:
        """Return the likely cause when no samples arrive."""
        if not self._received:
            return (
                "no bytes arrive: is this the board's port, and is the sketch mpu6050_stream "
                "uploaded?"
            )
        if self._run is None and not self.losses.unscaled:
            return (
                f"{self._received} bytes arrived, but no line of the sketch: do the baud rates "
                "agree?"
            )
        if self._run is None:
            return (
                "samples arrive, but never the header with their full scale: do the versions of "
                "the sketch agree?"
            )
        return "the board stopped sending: check its supply and its cable"


def _reason(error: Exception) -> str:
    """Return the reason of the system, which pyserial wraps in a message of its own."""
    number = getattr(error, "errno", None)
    text = os.strerror(number) if number else str(error)
    return f"{text} (on Linux, join the group dialout)" if number == errno.EACCES else text


def _ports_text() -> str:
    from serial.tools.list_ports import comports

    ports = ", ".join(port.device for port in comports())
    return (
        f"the ports of this machine are {ports}"
        if ports
        else "this machine has no serial port: is the board plugged in?"
    )
