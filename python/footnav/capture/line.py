"""Decoder of the lines that the sketch `mpu6050_stream` sends.

A line is a letter, big-endian upper-case hexadecimal digits, and the CRC-16 of all characters
before it; see the table in `docs/capture.md`.  All lines of a kind have one length, so that a valid
line is found after corrupt bytes.
"""

import binascii
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from footnav.capture.source import LossCounters
from footnav.errors import ConfigError
from footnav.mpu6050 import MPU6050_ID, Setup, wrong_chip

PROTOCOL = 1
"""Supported version of the protocol."""

_SAMPLE, _HEADER, _FAULT = b"S", b"H", b"X"
_FORMS = {
    _SAMPLE: struct.Struct(">IH7h"),
    _HEADER: struct.Struct(">BHB4s"),
    _FAULT: struct.Struct(">BB"),
}
_LENGTHS = {kind: 1 + 2 * form.size + 4 for kind, form in _FORMS.items()}
_LONGEST = max(_LENGTHS.values())

_CRC_SEED = 0xFFFF
"""Initial value of CRC-16/IBM-3740, polynomial 0x1021: it detects every burst of up to 16 bits and
all but one in 65,536 of the other errors; a CRC-8 would accept one corrupt line in 256."""

_STAMPS, _NUMBERS = 2**32, 2**16

_MAX_SILENCE_US = 60_000_000
"""A longer pause counts as a restart: the sequence numbers wrap after 65,536 samples, 65 s at 1
kHz.
"""

_CLOCK_TOLERANCE = 0.1
"""Maximum relative difference of the clocks of sensor and board; the stamp after a restart nearly
always differs by more.
"""

_OTHER_CHIP = 2
_FAULTS = {
    1: (
        "the sensor does not answer; check VCC, GND, SDA and SCL, and ADDRESS in the sketch (0x69 "
        "with AD0 high)"
    ),
    3: (
        "the sensor gives no data-ready signal; check the wire from INT to the board's "
        "INTERRUPT_PIN"
    ),
    4: "the sensor does not keep its settings; check its supply and its wires",
}


@dataclass(frozen=True, slots=True)
class Sample:
    """One line of a sample, not yet scaled.

    Attributes
    ----------
    run : int
        Number of restarts of the device before it.
    stamp_us : int
        Time of the sample, µs of the device's clock, with the wraps of the 32 bits of a line
        removed.
    counts : tuple of 7 ints
        Accelerometer, thermometer and gyroscope, in the order of the registers.
    setup : Setup
        Settings of the chip.
    """

    run: int
    stamp_us: int
    counts: tuple[int, ...]
    setup: Setup


@dataclass(frozen=True, slots=True)
class _StreamPosition:
    """Position of the newest sample in the stream: as in its line, and unwrapped."""

    run: int
    stamp: int
    number: int
    stamp_us: int


class Decoder:
    """Decodes the bytes of a serial line, in any division and with any corruption, to samples.

    Attributes
    ----------
    losses : LossCounters
        Losses so far.
    fault : str or None
        Fault that the device reports, or reason why its samples cannot be used; None after a valid
        sample.
    device : int or None
        Number of the sensor in the sketch; None before the first header.
    """

    losses: LossCounters
    fault: str | None
    device: int | None

    def __init__(self) -> None:
        self.losses = LossCounters()
        self.fault = None
        self.device = None
        self._pending = b""
        self._synchronous = False
        self._setup: Setup | None = None
        self._last: _StreamPosition | None = None

    def feed(self, data: bytes) -> list[Sample]:
        """Process the next bytes.

        Parameters
        ----------
        data : bytes
            Any number of bytes.

        Returns
        -------
        list of Sample
            The samples whose lines end within `data`.
        """
        *lines, rest = (self._pending + data).split(b"\n")
        # Bytes further back than the longest line belong to no incomplete line.
        self._pending = rest[-_LONGEST - 1 :]
        return [sample for line in lines for sample in self._decode(line)]

    def _decode(self, line: bytes) -> Iterator[Sample]:
        fields = _parse(line.removesuffix(b"\r"))
        # A capture starts within a line, which is not an error of the link.
        began, self._synchronous = not self._synchronous, True
        if fields is None:
            self._count(broken=not began)
            return
        kind, values = fields
        if kind == _SAMPLE:
            yield from self._sample(*values)
        elif kind == _HEADER:
            self._header(*values)
        else:
            self.fault = _explain(*values)

    def _header(self, protocol: int, device: int, chip: int, registers: bytes) -> None:
        self.device, self._setup = device, None
        if protocol != PROTOCOL:
            self.fault = (
                f"the sketch has version {protocol} of the protocol; expected {PROTOCOL}: upload "
                "it again"
            )
        elif chip != MPU6050_ID:
            self.fault = _explain(_OTHER_CHIP, chip)
        else:
            try:
                self._setup = Setup.from_registers(registers)
            except ConfigError as error:
                self.fault = f"the sketch's settings are wrong: {error}"

    def _sample(self, stamp: int, number: int, *counts: int) -> Iterator[Sample]:
        if self._setup is None:
            self._count(unscaled=1)
            return
        self._last = self._unwrap(stamp, number, self._setup.rate_hz)
        self.fault = None
        yield Sample(self._last.run, self._last.stamp_us, counts, self._setup)

    def _unwrap(self, stamp: int, number: int, rate_hz: float) -> _StreamPosition:
        """Unwrap stamp and number of a sample, and detect a restart."""
        last = self._last
        if last is None:
            return _StreamPosition(0, stamp, number, stamp)
        steps, elapsed = (number - last.number) % _NUMBERS, (stamp - last.stamp) % _STAMPS
        if not _is_continuous(steps, elapsed, rate_hz):
            self._count(restarts=1)
            return _StreamPosition(last.run + 1, stamp, number, stamp)
        self._count(missing=steps - 1)
        return _StreamPosition(last.run, stamp, number, last.stamp_us + elapsed)

    def _count(self, **more: int) -> None:
        if any(more.values()):
            self.losses = self.losses.plus(**more)


def _explain(fault: int, detail: int) -> str:
    if fault == _OTHER_CHIP:
        return f"WHO_AM_I of the sensor reads {wrong_chip(detail)}"
    return _FAULTS.get(fault, f"the sketch reports fault {fault}, which is unknown")


def _is_continuous(steps: int, elapsed_us: int, rate_hz: float) -> bool:
    """Whether number and stamp are consistent with a device without a restart."""
    interval = 1e6 / rate_hz
    slack = interval + _CLOCK_TOLERANCE * steps * interval
    return (
        steps > 0 and elapsed_us <= _MAX_SILENCE_US and abs(elapsed_us - steps * interval) <= slack
    )


def _parse(line: bytes) -> tuple[bytes, tuple[Any, ...]] | None:
    """Return the letter and the fields of the valid line at the end of `line`, or None."""
    for kind, length in _LENGTHS.items():
        text = line[-length:]
        if len(text) == length and text.startswith(kind) and _is_valid(text):
            return kind, _FORMS[kind].unpack(bytes.fromhex(text[1:-4].decode()))
    return None


_DIGITS = frozenset(b"0123456789ABCDEF")


def _is_valid(text: bytes) -> bool:
    return _DIGITS.issuperset(text[1:]) and binascii.crc_hqx(text[:-4], _CRC_SEED) == int(
        text[-4:], 16
    )
