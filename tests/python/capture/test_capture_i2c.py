"""The I2C source, against a chip at the level of its registers."""

import sys
from collections import deque

import numpy as np
import pytest

from fake_mpu6050 import FakeMpu6050
from footnav.capture import Block, I2cSource, LossCounters, Setup, record
from footnav.errors import ConfigError, DataError


def source_of(chip: FakeMpu6050, setup: Setup | None = None, address: int = 0x68) -> I2cSource:
    return I2cSource(chip, setup, address, "/dev/i2c-1", chip.clock, chip.sleep)


def read_seconds(
    source: I2cSource, chip: FakeMpu6050, seconds: float, pause: float = 0.0
) -> list[Block]:
    """Read for a time of the host, with a pause after each read."""
    end, blocks = chip.now + seconds, []
    while chip.now < end:
        blocks += source.read()
        chip.sleep(pause)
    return blocks


def numbers(blocks: list[Block]) -> np.ndarray:
    """Return the n of the n-th samples."""
    return np.rint(
        np.concatenate([block.accel[:, 0] / block.setup.accel_range * 32768 for block in blocks])
    ).astype(int)


def times(blocks: list[Block]) -> np.ndarray:
    return np.concatenate([block.t for block in blocks])


@pytest.mark.parametrize(
    "setup",
    [
        Setup(),
        Setup(accel_range_g=2, gyro_range_deg_s=250, dlpf_cfg=1, smplrt_div=0),
        Setup(accel_range_g=8, gyro_range_deg_s=1000, dlpf_cfg=0, smplrt_div=79),
        Setup(accel_range_g=4, gyro_range_deg_s=500, dlpf_cfg=6, smplrt_div=255),
    ],
)
def test_every_sample_is_output_once_and_in_order(setup):
    chip = FakeMpu6050()
    source = source_of(chip, setup)
    blocks = read_seconds(source, chip, 3.0)
    n = numbers(blocks)
    np.testing.assert_array_equal(n, np.arange(n[0], n[0] + len(n)))
    assert len(n) == pytest.approx(3 * setup.rate_hz, abs=0.05 * setup.rate_hz + 2)
    assert bytes(chip.registers[0x19:0x1D]) == setup.registers
    assert source.losses == LossCounters()


def test_samples_are_in_si_units():
    chip = FakeMpu6050()
    recording = record(source_of(chip), 1.0)
    assert recording.accel[0, 2] == pytest.approx(9.80665)
    assert recording.gyro[:, 0] == pytest.approx(
        recording.accel[:, 0] / recording.accel_range * np.radians(2000)
    )
    assert recording.temperature[0] == pytest.approx(36.53)
    assert recording.gyro_range == pytest.approx(np.radians(2000))


@pytest.mark.parametrize("rate", [0.99, 1.0, 1.02])
@pytest.mark.parametrize("pause", [0.0, 0.0173, 0.1])
def test_the_host_disciplines_the_clock_of_the_chip(rate, pause):
    chip = FakeMpu6050(rate)
    blocks = read_seconds(source_of(chip), chip, 30.0, pause)
    t = times(blocks)
    intervals = np.diff(t)
    assert intervals.min() > 0
    np.testing.assert_allclose(intervals, 0.005 * rate, rtol=0.03)
    late = t > 10
    assert np.mean(intervals[late[1:]]) == pytest.approx(0.005 * rate, rel=3e-4)


@pytest.mark.parametrize("absence", [0.3, 0.5, 3.0])
def test_an_overflow_is_counted_and_bridged(absence):
    chip = FakeMpu6050(1.01)
    source = source_of(chip)
    before = read_seconds(source, chip, 5.0)
    chip.sleep(absence)
    after = read_seconds(source, chip, 2.0)
    n, t = numbers(before + after), times(before + after)
    if absence < 0.33:
        assert source.losses == LossCounters()
        return
    assert source.losses.overflows == 1
    gap = int(np.argmax(np.diff(n)))
    assert source.losses.missing == pytest.approx(n[gap + 1] - n[gap] - 1, abs=1)
    assert t[gap + 1] - t[gap] == pytest.approx((n[gap + 1] - n[gap]) * 0.00505, abs=0.006)
    assert np.all(np.delete(np.diff(n), gap) == 1)


def test_an_overflow_while_the_fifo_is_read_is_seen():
    chip = FakeMpu6050()
    source = source_of(chip, Setup(smplrt_div=0))
    read_seconds(source, chip, 1.0)
    # 73 samples fill the FIFO; the rest of a second's worth comes while they are read.
    chip.sleep(0.0725)
    burst = chip.read_i2c_block_data

    def slowly(i2c_addr: int, register: int, length: int) -> list[int]:
        data = burst(i2c_addr, register, length)
        if register == 0x72:
            chip.sleep(0.01)
        return data

    chip.read_i2c_block_data = slowly
    assert source.read() == []
    assert source.losses.overflows == 1


def test_a_transfer_that_fails_costs_only_its_samples():
    chip = FakeMpu6050()
    source = source_of(chip)
    # The second time the bus fails while the FIFO is to be emptied, too.
    chip.failures = deque([chip.now + 1.0, chip.now + 1.5, chip.now + 1.5])
    blocks = read_seconds(source, chip, 3.0)
    assert source.losses.broken == 3
    assert all(
        np.all(block.accel[:, 2] == 2048 / 32768 * block.setup.accel_range) for block in blocks
    )
    steps = np.diff(numbers(blocks))
    assert np.sum(steps > 1) == 2
    assert source.losses.missing == pytest.approx(np.sum(steps - 1), abs=2)


@pytest.mark.parametrize(
    ("chip", "message"),
    [
        (
            FakeMpu6050(who_am_i=0x71),
            "WHO_AM_I at 0x68 reads 0x71, an MPU9250; expected 0x68, an MPU6050",
        ),
        (FakeMpu6050(who_am_i=0x55), "reads 0x55, an unknown chip"),
        (FakeMpu6050(who_am_i=0xFF), "reads 0xff, nothing, as with a loose wire"),
        (FakeMpu6050(address=0x69), "no chip answers at 0x68; one does at 0x69: use that address"),
        (FakeMpu6050(address=0x20), r"no chip answers at 0x68; check VCC, GND, SDA and SCL"),
        (
            FakeMpu6050(deaf_registers=frozenset({0x1C})),
            "0x1c read 04 02 18 00 after 04 02 18 18 was written",
        ),
        (
            FakeMpu6050(failures=deque([100.15])),
            "stopped answering while it was set up: .*Remote I/O error",
        ),
    ],
)
def test_a_chip_that_cannot_be_used_is_named(chip, message):
    with pytest.raises(DataError, match=r"/dev/i2c-1: .*" + message):
        source_of(chip)


def test_the_other_address():
    chip = FakeMpu6050(address=0x69)
    assert len(read_seconds(source_of(chip, address=0x69), chip, 0.2)) > 2
    with pytest.raises(
        ConfigError, match="address is 0x70; an MPU6050 has 0x68, or 0x69 with AD0 high"
    ):
        source_of(chip, address=0x70)


def test_a_chip_in_sleep_mode_is_reported():
    chip = FakeMpu6050()
    source = source_of(chip)
    read_seconds(source, chip, 0.5)
    chip._power_on()
    with pytest.raises(
        DataError, match=r"no sample for 1\.0 s: the chip answers, but takes no samples"
    ):
        read_seconds(source, chip, 2.0)


def test_a_chip_that_was_unplugged_is_reported():
    chip = FakeMpu6050()
    source = source_of(chip)
    read_seconds(source, chip, 0.5)
    chip.address = 0
    with pytest.raises(
        DataError,
        match=r"no sample for 1\.0 s: transfers fail: .*Remote I/O error; check the wires",
    ):
        read_seconds(source, chip, 2.0)


def test_a_host_that_is_too_slow_is_reported():
    chip = FakeMpu6050()
    source = source_of(chip)
    with pytest.raises(DataError, match="its FIFO overflows repeatedly; lower the rate"):
        read_seconds(source, chip, 5.0, pause=0.6)


def test_a_bus_that_is_not_there():
    with pytest.raises(
        DataError, match=r"/dev/i2c-99 cannot be opened: No such file or directory; switch I2C on"
    ):
        I2cSource.open(99)


def test_without_smbus2_the_error_has_the_command_that_installs_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "smbus2", None)
    with pytest.raises(ConfigError, match="smbus2 is missing: pip install smbus2"):
        I2cSource.open(1)


def test_the_bus_is_closed_at_the_end():
    chip = FakeMpu6050()
    with source_of(chip):
        pass
    assert chip.closed


def test_the_driver_uses_members_of_smbus2():
    import inspect

    smbus2 = pytest.importorskip("smbus2")
    for name in ("read_byte_data", "write_byte_data", "read_i2c_block_data"):
        real, fake = (
            list(inspect.signature(getattr(bus, name)).parameters)
            for bus in (smbus2.SMBus, FakeMpu6050)
        )
        assert real[: len(fake)] == fake
