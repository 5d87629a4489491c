"""Live capture from an MPU6050, at an Arduino on a serial port or on an I2C bus.

Examples
--------
>>> from footnav.capture import SerialSource, record
>>> with SerialSource.open("/dev/ttyUSB0") as source:  # doctest: +SKIP
...     recording = record(source, seconds=60)
"""

from footnav.capture.block import Block
from footnav.capture.guide import Guide, Plan, Stage
from footnav.capture.i2c_source import I2cSource
from footnav.capture.line import Decoder, Sample
from footnav.capture.recorder import Recorder, record, track_live
from footnav.capture.serial_source import SerialSource
from footnav.capture.source import LossCounters, Source, stream
from footnav.mpu6050 import Setup

__all__ = [
    "Block",
    "Decoder",
    "Guide",
    "I2cSource",
    "LossCounters",
    "Plan",
    "Recorder",
    "Sample",
    "SerialSource",
    "Setup",
    "Source",
    "Stage",
    "record",
    "stream",
    "track_live",
]
