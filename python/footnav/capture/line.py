"""The lines that the sketch `mpu6050_stream` sends: bytes in, samples out.

A line is a letter, big-endian upper-case hexadecimal digits, and the CRC-16 of all characters
before it; the guide `docs/capture.md` has the table.  All lines of a kind have one length, so that
a good line is found behind any garbage.
"""

import binascii
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from footnav.capture.source import Losses
from footnav.errors import ConfigError
from footnav.mpu6050 import MPU6050_ID, Setup, wrong_chip

PROTOCOL = 1
"""Version of the lines that this decoder understands."""

_SAMPLE, _HEADER, _FAULT = b"S", b"H", b"X"
_FORMS = {
    _SAMPLE: struct.Struct(">IH7h"),
    _HEADER: struct.Struct(">BHB4s"),
    _FAULT: struct.Struct(">BB"),
}
_LENGTHS = {kind: 1 + 2 * form.size + 4 for kind, form in _FORMS.items()}
_LONGEST = max(_LENGTHS.values())

_CRC_SEED = 0xFFFF
"""Initial value of CRC-16/IBM-3740, polynomial 0x1021: it finds every error within 16 bits of a line, and leaves one in
65,536 of all others, where a CRC-8 would let one broken line in 256 pass as a sample."""

_STAMPS, _NUMBERS = 2**32, 2**16

_MAX_SILENCE_US = 60_000_000
"""A longer silence is taken as a restart: 65,536 samples, after which their numbers repeat, last 65 s at 1 kHz."""

_CLOCK_TOLERANCE = 0.1
"""Two cheap clocks, the sensor's and the board's, never differ by this much; a stamp after a restart nearly always."""

_OTHER_CHIP = 2
_FAULTS = {
    1: "the sensor does not answer; check VCC, GND, SDA and SCL, and ADDRESS in the sketch (0x69 with AD0 high)",
    3: "the sensor gives no data-ready signal; check the wire from INT to the board's INTERRUPT_PIN",
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
        When the sensor had it ready, µs of the device's clock; counts on where the 32 bits of a
        line begin anew.
    counts : tuple of 7 ints
        Accelerometer, thermometer and gyroscope, in the order of the registers.
    setup : Setup
        How the chip was set.
    """

    run: int
    stamp_us: int
    counts: tuple[int, ...]
    setup: Setup


@dataclass(frozen=True, slots=True)
class _Place:
    """Where the newest sample stands: as its line says, and unwrapped."""

    run: int
    stamp: int
    number: int
    stamp_us: int


class Decoder:
    """Turns the bytes of a serial line into samples, however they are cut and whatever happened to them.

    Attributes
    ----------
    losses : Losses
        What was lost so far.
    trouble : str or None
        What the device complains of, or why its samples cannot be used; None once a sample came
        through.
    device : int or None
        Number that the sketch gives to its sensor; None before its first header.
    """

    losses: Losses
    trouble: str | None
    device: int | None

    def __init__(self) -> None:
        self.losses = Losses()
        self.trouble = None
        self.device = None
        self._pending = b""
        self._synchronous = False
        self._setup: Setup | None = None
        self._last: _Place | None = None

    def feed(self, data: bytes) -> list[Sample]:
        """Take the next bytes in.

        Parameters
        ----------
        data : bytes
            Any number of bytes.

        Returns
        -------
        list of Sample
            The samples whose lines ended within `data`.
        """
        *lines, rest = (self._pending + data).split(b"\n")
        # What lies further back than the longest line belongs to no line that is still to end.
        self._pending = rest[-_LONGEST - 1 :]
        return [sample for line in lines for sample in self._decode(line)]

    def _decode(self, line: bytes) -> Iterator[Sample]:
        fields = _parse(line.removesuffix(b"\r"))
        # A capture begins in the midst of a line, which is no fault of the link.
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
            self.trouble = _explain(*values)

    def _header(self, protocol: int, device: int, chip: int, registers: bytes) -> None:
        self.device, self._setup = device, None
        if protocol != PROTOCOL:
            self.trouble = f"the sketch speaks version {protocol} of the protocol; expected {PROTOCOL}: flash it anew"
        elif chip != MPU6050_ID:
            self.trouble = _explain(_OTHER_CHIP, chip)
        else:
            try:
                self._setup = Setup.from_registers(registers)
            except ConfigError as error:
                self.trouble = f"the sketch's settings are wrong: {error}"

    def _sample(self, stamp: int, number: int, *counts: int) -> Iterator[Sample]:
        if self._setup is None:
            self._count(unscaled=1)
            return
        self._last = self._follow(stamp, number, self._setup.rate_hz)
        self.trouble = None
        yield Sample(self._last.run, self._last.stamp_us, counts, self._setup)

    def _follow(self, stamp: int, number: int, rate_hz: float) -> _Place:
        """Find where a sample stands behind the one before, whether stamps or numbers began anew."""
        last = self._last
        if last is None:
            return _Place(0, stamp, number, stamp)
        steps, elapsed = (number - last.number) % _NUMBERS, (stamp - last.stamp) % _STAMPS
        if not _agree(steps, elapsed, rate_hz):
            self._count(restarts=1)
            return _Place(last.run + 1, stamp, number, stamp)
        self._count(missing=steps - 1)
        return _Place(last.run, stamp, number, last.stamp_us + elapsed)

    def _count(self, **more: int) -> None:
        if any(more.values()):
            self.losses = self.losses.plus(**more)


def _explain(fault: int, detail: int) -> str:
    if fault == _OTHER_CHIP:
        return f"WHO_AM_I of the sensor reads {wrong_chip(detail)}"
    return _FAULTS.get(fault, f"the sketch reports fault {fault}, which is unknown")


def _agree(steps: int, elapsed_us: int, rate_hz: float) -> bool:
    """Whether a number and a stamp can be those of one device that ran on."""
    interval = 1e6 / rate_hz
    slack = interval + _CLOCK_TOLERANCE * steps * interval
    return (
        steps > 0 and elapsed_us <= _MAX_SILENCE_US and abs(elapsed_us - steps * interval) <= slack
    )


def _parse(line: bytes) -> tuple[bytes, tuple[Any, ...]] | None:
    """Return the letter and the fields of the good line that stands at the end of `line`, or None."""
    for kind, length in _LENGTHS.items():
        text = line[-length:]
        if len(text) == length and text.startswith(kind) and _is_sound(text):
            return kind, _FORMS[kind].unpack(bytes.fromhex(text[1:-4].decode()))
    return None


_DIGITS = frozenset(b"0123456789ABCDEF")


def _is_sound(text: bytes) -> bool:
    return _DIGITS.issuperset(text[1:]) and binascii.crc_hqx(text[:-4], _CRC_SEED) == int(
        text[-4:], 16
    )
