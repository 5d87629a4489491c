"""Sources of live samples, and counters of their losses."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Protocol

from footnav.capture.block import Block

if TYPE_CHECKING:
    from typing_extensions import Self


@dataclass(frozen=True, slots=True)
class LossCounters:
    """Losses since the start of a capture; all zero on an intact link.

    Attributes
    ----------
    missing : int
        Samples that did not arrive: gaps in the sequence numbers of the lines, or the duration of a
        FIFO overflow in samples.
    broken : int
        Lines of a serial link whose checksum or form is wrong, or failed transfers on an I2C bus;
        their samples also count as missing.
    unscaled : int
        Samples before the header with their full scale, which are discarded.
    restarts : int
        Restarts of the device, as by its reset button; the losses meanwhile are unknown.
    overflows : int
        Overflows of the FIFO of a sensor on an I2C bus.
    """

    missing: int = 0
    broken: int = 0
    unscaled: int = 0
    restarts: int = 0
    overflows: int = 0

    def plus(self, **more: int) -> LossCounters:
        """Return the counters increased by `more`."""
        return dataclasses.replace(
            self, **{label: getattr(self, label) + count for label, count in more.items()}
        )

    def __str__(self) -> str:
        """Return the counters that are not zero."""
        counts = {
            "missing": self.missing,
            "broken": self.broken,
            "without a scale": self.unscaled,
            "restarts": self.restarts,
            "overflows": self.overflows,
        }
        return (
            ", ".join(f"{count} {label}" for label, count in counts.items() if count)
            or "nothing lost"
        )


class Source(Protocol):
    """A sensor with live samples, such as on a serial line or on an I2C bus."""

    @property
    def name(self) -> str:
        """Name in messages, such as that of the port."""
        ...

    @property
    def losses(self) -> LossCounters:
        """Losses since the start of the capture."""
        ...

    def read(self) -> Sequence[Block]:
        """Return the blocks that have arrived, within a tenth of a second.

        Often one, possibly none.

        Raises
        ------
        DataError
            The sensor cannot be read, or gave no samples for too long.
        """
        ...


class CloseOnExit(ABC):
    """Base of sources that are closed at the end of a `with` statement."""

    @abstractmethod
    def close(self) -> None:
        """Release the hardware."""

    def __enter__(self) -> Self:
        """Return the source."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the source."""
        self.close()


def stream(source: Source) -> Iterator[Block]:
    """Iterate over the blocks of a source, without end.

    Parameters
    ----------
    source : Source
        The sensor.

    Yields
    ------
    Block
        At least one sample.

    Raises
    ------
    DataError
        The sensor cannot be read, or gave no samples for too long.

    Examples
    --------
    >>> for block in stream(source):  # doctest: +SKIP
    ...     navigator.push_block(block.t, block.accel, block.gyro)
    """
    while True:
        yield from source.read()
