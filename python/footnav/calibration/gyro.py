"""Bias of the gyroscope at rest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footnav.calibration.model import SensorCalibration, Triad
from footnav.calibration.provenance import as_recordings, check_setup, provenance
from footnav.calibration.static import BLOCK, Rests, check_rest
from footnav.conversions import as_vector
from footnav.mpu6050 import Setup
from footnav.recording import Floats, Recording


def calibrate_gyro(
    recordings: Recording | Sequence[Recording], *, device: str = "", setup: Setup | None = None
) -> SensorCalibration:
    """Measure the bias of the gyroscope at rest.

    Parameters
    ----------
    recordings : Recording or sequence of Recording
        At rest from the first sample to the last, a second or more each.
    device : str
        Name of the device.
    setup : Setup, optional
        Registers of the MPU6050.

    Returns
    -------
    SensorCalibration
        With `gyro`, whose matrix is the identity.

    Raises
    ------
    DataError
        A recording moves; the message names the axis, the value and the limit.
    """
    walks = as_recordings(recordings)
    check_setup(walks, setup)
    for recording in walks:
        check_rest(recording)
    means = np.concatenate([_block_means(recording) for recording in walks])
    # The bias drifts, so that blocks far apart differ by more than noise: halves are compared, too.
    halves = (
        np.abs(means[: len(means) // 2].mean(axis=0) - means[len(means) // 2 :].mean(axis=0)) / 2
    )
    std = np.maximum(means.std(axis=0, ddof=1) / np.sqrt(len(means)), halves)
    gyro = _bias_only(means.mean(axis=0), std, len(means), "bias only: the recording has no turns")
    return SensorCalibration(
        device=device, mpu6050=setup, gyro=gyro.replace(**provenance(walks, "gyro"))
    )


def bias_of_rests(rests: Rests) -> Triad:
    """Return the mean bias of the rests, with a note that nothing else is observable."""
    return _bias_only(
        rests.gyro.mean(axis=0),
        std_of_bias(rests),
        len(rests),
        "bias only: between its rests the recording turns too little about some axis, or for too "
        "long",
    )


def _bias_only(bias: Floats, std: Floats, observations: int, note: str) -> Triad:
    return Triad(
        bias=as_vector(bias), bias_std=as_vector(std), observations=observations, note=note
    )


def std_of_bias(rests: Rests) -> Floats:
    """Return the scatter between the rests, which contains bias drift and g-sensitivity."""
    if len(rests) < 2:
        return np.full(3, rests.gyro_std[0])
    scatter: Floats = rests.gyro.std(axis=0, ddof=1)
    return scatter


def _block_means(recording: Recording) -> Floats:
    length = max(1, round(BLOCK * recording.rate_hz))
    means: Floats = (
        recording.gyro[: len(recording) // length * length].reshape(-1, length, 3).mean(axis=1)
    )
    return means
