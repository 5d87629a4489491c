"""Calibration of the sensors from recordings on a table.

`calibrate_accel` and `calibrate_six_position` take a recording of rests in many poses,
`calibrate_gyro` one at rest, `calibrate_temperature` one that warms up at rest, `calibrate_mag` one
with rotations about all axes.  Each returns a `SensorCalibration`, which corrects recordings and
provides settings of the navigator.
"""

from footnav.calibration.accel import calibrate_accel
from footnav.calibration.formats import read_calibration
from footnav.calibration.gyro import calibrate_gyro
from footnav.calibration.imucal import load_imucal
from footnav.calibration.kalibr import KalibrImu, load_kalibr, save_kalibr
from footnav.calibration.mag import calibrate_mag
from footnav.calibration.model import SensorCalibration, TemperatureModel, Triad, load_calibration
from footnav.calibration.simulation import simulate_poses
from footnav.calibration.six_position import calibrate_six_position
from footnav.calibration.temperature import calibrate_temperature

__all__ = [
    "KalibrImu",
    "SensorCalibration",
    "TemperatureModel",
    "Triad",
    "calibrate_accel",
    "calibrate_gyro",
    "calibrate_mag",
    "calibrate_six_position",
    "calibrate_temperature",
    "load_calibration",
    "load_imucal",
    "load_kalibr",
    "read_calibration",
    "save_kalibr",
    "simulate_poses",
]
