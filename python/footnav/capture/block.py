"""A block of samples."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footnav.io.mpu6050 import FULL_SCALE_COUNTS
from footnav.mpu6050 import Setup, temperature_degc
from footnav.recording import Floats


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """A block of samples in SI units.

    Attributes
    ----------
    t : ndarray of shape (n,)
        Time since the first sample of the capture, s.
    accel : ndarray of shape (n, 3)
        Specific force along the sensor's axes, m/s².
    gyro : ndarray of shape (n, 3)
        Angular rate about the sensor's axes, rad/s.
    temperature : ndarray of shape (n,)
        Temperature of the chip, degrees Celsius.
    setup : Setup
        Settings of the chip.
    """

    t: Floats
    accel: Floats
    gyro: Floats
    temperature: Floats
    setup: Setup

    @classmethod
    def from_counts(cls, t: Floats, counts: ArrayLike, setup: Setup) -> "Block":
        """Scale raw counts.

        Parameters
        ----------
        t : ndarray of shape (n,)
            Stamps, s.
        counts : array_like of shape (n, 7)
            Accelerometer, thermometer and gyroscope, in the order of the registers.
        setup : Setup
            Settings of the chip.

        Returns
        -------
        Block
            In SI units.
        """
        raw: NDArray[np.float64] = np.asarray(counts, dtype=np.float64).reshape(-1, 7)
        return cls(
            t=t,
            accel=raw[:, :3] / FULL_SCALE_COUNTS * setup.accel_range,
            gyro=raw[:, 4:] / FULL_SCALE_COUNTS * setup.gyro_range,
            temperature=temperature_degc(raw[:, 3]),
            setup=setup,
        )

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.t)
