"""Where live samples come from, and what was lost on the way."""

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
class Losses:
    """What did not arrive since the capture began; all zero on a sound link.

    Attributes
    ----------
    missing : int
        Samples that the sensor took and that never came: numbers missing in the sequence of the
        lines, or the time of a full FIFO in samples.
    broken : int
        Lines of a serial link whose checksum or form is wrong, or transfers on an I2C bus that
        failed; the samples in them count as missing, too.
    unscaled : int
        Samples that came before the line that names their full scale, and were left out.
    restarts : int
        Times that the device began anew, as after a touch of its reset button; what was lost
        meanwhile is not known.
    overflows : int
        Times that the FIFO of a sensor on an I2C bus was full before it was read.
    """

    missing: int = 0
    broken: int = 0
    unscaled: int = 0
    restarts: int = 0
    overflows: int = 0

    def plus(self, **more: int) -> Losses:
        """Return these counters, each with what is `more`."""
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
    """A sensor whose samples come live; the serial line and the I2C bus are two."""

    @property
    def name(self) -> str:
        """What messages call it, such as the name of the port."""
        ...

    @property
    def losses(self) -> Losses:
        """What was lost since the capture began."""
        ...

    def read(self) -> Sequence[Block]:
        """Return the blocks that have come, after a tenth of a second at the latest; often one, possibly none.

        Raises
        ------
        DataError
            The sensor cannot be read, or has been silent for too long.
        """
        ...


class Closing(ABC):
    """Closes itself at the end of a `with` statement."""

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
    """Give the blocks of a source as they come, without end.

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
        The sensor cannot be read, or has been silent for too long.

    Examples
    --------
    >>> for block in stream(source):  # doctest: +SKIP
    ...     navigator.push_block(block.t, block.accel, block.gyro)
    """
    while True:
        yield from source.read()
