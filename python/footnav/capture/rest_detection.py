"""Rest detection in a capture: whether the sensor is at rest, as the blocks of samples arrive."""

from collections.abc import Iterator
from dataclasses import dataclass

from footnav.capture.block import Block
from footnav.recording import Floats
from footnav.rest_detection import CAPTURE, RestDetector


@dataclass(frozen=True, slots=True, eq=False)
class Window:
    """Consecutive samples of `footnav.rest_detection.CAPTURE.block`.

    Attributes
    ----------
    duration : float
        Length, s.
    at_rest : bool
        Whether the sensor is at rest.
    accel : ndarray, shape (3,)
        Mean specific force, m/s².
    """

    duration: float
    at_rest: bool
    accel: Floats


class RestMonitor:
    """Divides a capture into windows, whatever the lengths of its blocks."""

    def __init__(self) -> None:
        self._detector: RestDetector | None = None
        self._samples = 0
        self._end = 0.0

    def feed(self, block: Block) -> Iterator[Window]:
        """Add the next samples.

        Parameters
        ----------
        block : Block
            Samples.

        Yields
        ------
        Window
            Each that ends within `block`.
        """
        if self._detector is None:
            self._detector = RestDetector(CAPTURE, block.setup.rate_hz)
            self._end = float(block.t[0])
        found = self._detector.push_block(block.t, block.accel, block.gyro)
        ends = block.t[found.last - self._samples].tolist()
        self._samples += len(block)
        for end, at_rest, accel in zip(ends, found.at_rest.tolist(), found.accel, strict=True):
            yield Window(duration=end - self._end, at_rest=at_rest, accel=accel)
            self._end = end
