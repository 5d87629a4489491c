"""The decoder of the serial line.

Every sample that was sent and arrived whole, no other, and a count of the rest.
"""

import itertools
import random
import re
import shutil
import struct
import subprocess
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from footnav.capture import Decoder, LossCounters, Setup
from footnav.errors import ConfigError
from stream_lines import (
    AT_REST,
    close,
    crc16,
    fault_line,
    header_line,
    sample_line,
    stream,
)

ROOT = Path(__file__).parents[3]
SKETCH = ROOT / "examples" / "arduino" / "mpu6050_stream"


def decode(*pieces: bytes) -> tuple[Decoder, list[tuple[int, ...]]]:
    """Decode pieces, and return the counts."""
    decoder = Decoder()
    samples = [sample for piece in pieces for sample in decoder.feed(piece)]
    return decoder, [sample.counts for sample in samples]


def numbered(n: int, first: int = 0) -> list[tuple[int, ...]]:
    return [(first + k, -k, k % 7, k, 0, 1, -1) for k in range(n)]


LINES = stream(numbered(6))


# What a line means


def test_a_sample_has_the_values_of_its_line():
    (sample,) = Decoder().feed(
        header_line() + sample_line(123_456, 7, (1, -2, 3, -4, 5, -6, -32768))
    )
    assert (sample.run, sample.stamp_us, sample.counts) == (
        0,
        123_456,
        (1, -2, 3, -4, 5, -6, -32768),
    )
    assert sample.setup == Setup(accel_range_g=16, gyro_range_deg_s=2000, dlpf_cfg=2, smplrt_div=4)


@given(
    st.sampled_from((2, 4, 8, 16)),
    st.sampled_from((250, 500, 1000, 2000)),
    st.integers(0, 6),
    st.integers(0, 255),
)
def test_settings_round_trip_through_the_registers(accel, gyro, dlpf, divider):
    setup = Setup(accel_range_g=accel, gyro_range_deg_s=gyro, dlpf_cfg=dlpf, smplrt_div=divider)
    assert Setup.from_registers(setup.registers) == setup


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"accel_range_g": 3}, "accel_range_g is 3; an MPU6050 has 2, 4, 8, 16"),
        ({"gyro_range_deg_s": 300}, "gyro_range_deg_s is 300; an MPU6050 has 250, 500, 1000, 2000"),
        ({"dlpf_cfg": 7}, "dlpf_cfg is 7; an MPU6050 has 0 to 6"),
        ({"smplrt_div": 256}, "smplrt_div is 256; an MPU6050 has 0 to 255"),
    ],
)
def test_the_chip_has_only_these_settings(settings, message):
    with pytest.raises(ConfigError, match=re.escape(message)):
        Setup(**settings)


def test_a_rate_that_the_chip_does_not_have_names_the_nearest():
    assert Setup.at_rate(125).smplrt_div == 7
    assert Setup.at_rate(1000, dlpf_cfg=0).smplrt_div == 7
    with pytest.raises(ConfigError, match=r"rate_hz is 300; .* the nearest is 333\.333"):
        Setup.at_rate(300)
    with pytest.raises(ConfigError, match="rate_hz is nan; expected a positive number"):
        Setup.at_rate(float("nan"))


# Damage


@pytest.mark.slow
@given(st.lists(st.integers(0, len(b"".join(LINES))), max_size=8))
def test_cutting_the_bytes_changes_nothing(cuts):
    data = b"".join(LINES)
    pieces = [data[a:b] for a, b in itertools.pairwise([0, *sorted(cuts), len(data)])]
    assert decode(*pieces)[1] == numbered(6)


damage = st.lists(
    st.tuples(st.floats(0, 1), st.integers(0, 60), st.binary(max_size=60)), max_size=6
)


def corrupt(data: bytes, damages: list[tuple[float, int, bytes]]) -> bytes:
    """Replace stretches of the bytes by others, longer or shorter."""
    for place, length, garbage in damages:
        start = int(place * len(data))
        data = data[:start] + garbage + data[start + length :]
    return data


def valid_ends(data: bytes) -> set[bytes]:
    """Find the lines whose checksum is right, independently of the decoder."""
    ends = (line[-45:] for line in data.replace(b"\r\n", b"\n").split(b"\n"))
    return {
        end
        for end in ends
        if re.fullmatch(rb"S[0-9A-F]{44}", end) and crc16(end[:-4]) == int(end[-4:], 16)
    }


@pytest.mark.slow
@given(damage, st.integers(1, 50))
def test_corrupt_lines_give_no_sample_and_later_ones_are_read(damages, size):
    data = corrupt(b"".join(LINES), damages)
    decoder, counts = decode(*(data[k : k + size] for k in range(0, len(data), size)))
    sound = {struct.unpack(">7h", bytes.fromhex(end[13:-4].decode())) for end in valid_ends(data)}
    assert set(counts) <= sound
    assert len(counts) + decoder.losses.unscaled == len(
        [*filter(None, map(valid_end_of, data.split(b"\n")[:-1]))]
    )
    later = [
        sample.counts
        for line in stream(numbered(3, 100), stamp=30_000, number=6)
        for sample in decoder.feed(line)
    ]
    assert later == numbered(3, 100)


def valid_end_of(line: bytes) -> bytes | None:
    return next(iter(valid_ends(line)), None)


def test_every_wrong_character_is_found():
    line = sample_line(5000, 1, (100, -200, 300, -400, 500, -600, 700))
    likely = {*b"0123456789ABCDEFSHX\n\r"}
    for place in range(len(line) - 1):
        for value in (likely | {line[place] ^ 1 << bit for bit in range(8)}) - {line[place]}:
            decoder = Decoder()
            decoder.feed(header_line())
            assert decoder.feed(line[:place] + bytes([value]) + line[place + 1 :]) == []
            assert decoder.losses.broken >= 1


@given(st.integers(0, 43), st.binary(min_size=2, max_size=2))
def test_every_burst_of_sixteen_bits_is_found(place, burst):
    line = sample_line(5000, 1)
    harmed = line[:place] + burst + line[place + 2 :]
    decoder = Decoder()
    decoder.feed(header_line())
    assert harmed == line or decoder.feed(harmed) == []


def test_a_good_line_is_found_behind_bytes_without_an_end():
    decoder, counts = decode(header_line(), b"\x00" * 10_000 + LINES[1])
    assert (counts, decoder.losses.broken) == (numbered(1), 0)
    assert len(decoder._pending) == 0


def test_garbage_without_end_is_not_kept():
    decoder, _ = decode(b"x" * 10_000)
    assert len(decoder._pending) < 64


def test_lines_that_end_as_windows_ends_them_are_read():
    assert decode(b"".join(LINES).replace(b"\n", b"\r\n"))[1] == numbered(6)


# What is counted


def test_a_capture_may_begin_within_a_line():
    data = b"".join(stream(numbered(3)))[9:] + b"".join(stream(numbered(3), stamp=15_000, number=3))
    decoder, counts = decode(data)
    assert counts == numbered(3)
    assert decoder.losses == LossCounters(unscaled=3)


def test_lost_and_broken_lines_are_missing_numbers():
    lines = stream(numbered(10))
    lines[5] = lines[5].replace(b"0", b"1", 1)
    del lines[8:10]
    decoder, counts = decode(*lines)
    assert len(counts) == 7
    assert decoder.losses == LossCounters(missing=3, broken=1)


@pytest.mark.parametrize(
    ("stamp", "number"), [(2**32 - 7_500, 40), (0, 2**16 - 2), (2**32 - 7_500, 2**16 - 2)]
)
def test_stamps_and_numbers_are_unwrapped(stamp, number):
    decoder = Decoder()
    samples = decoder.feed(b"".join(stream(numbered(5), stamp, number)))
    assert [sample.stamp_us for sample in samples] == [stamp + 5000 * k for k in range(5)]
    assert decoder.losses == LossCounters()


@pytest.mark.parametrize("silence", [0.01, 1, 50])
def test_a_silence_across_the_end_of_the_counters_is_a_loss(silence):
    lost = round(silence * 200)
    before = stream(numbered(1), 2**32 - 1000, 2**16 - 1)
    after = sample_line(2**32 - 1000 + 5000 * (lost + 1), 2**16 + lost)
    decoder = Decoder()
    samples = decoder.feed(b"".join([*before, after]))
    assert samples[1].stamp_us - samples[0].stamp_us == 5000 * (lost + 1)
    assert decoder.losses == LossCounters(missing=lost)


@pytest.mark.parametrize("minutes", [0.1, 20, 35, 50, 71])
def test_a_restart_of_the_device_is_detected(minutes):
    stamp = round(minutes * 60e6)
    before, after = stream(numbered(5), stamp, stamp // 5000), stream(numbered(5), 900_000)
    decoder = Decoder()
    samples = decoder.feed(b"".join(before + after))
    assert [sample.run for sample in samples] == [0] * 5 + [1] * 5
    assert samples[5].stamp_us == 900_000
    assert decoder.losses == LossCounters(restarts=1)


def test_clocks_that_disagree_by_some_percent_are_one_run():
    lines = [*stream(numbered(2)), sample_line(int(5000 * 0.96 * 1000), 1000)]
    assert decode(*lines)[0].losses == LossCounters(missing=998)


# Faults of the device


@pytest.mark.parametrize(
    ("line", "fault"),
    [
        (fault_line(1), "the sensor does not answer"),
        (fault_line(2, 0x71), "WHO_AM_I of the sensor reads 0x71, an MPU9250; expected 0x68"),
        (fault_line(3), "no data-ready signal; check the wire from INT"),
        (fault_line(4), "does not keep its settings"),
        (fault_line(99), "fault 99, which is unknown"),
        (header_line(protocol=2), "version 2 of the protocol; expected 1"),
        (header_line(chip=0x70), "reads 0x70, an MPU6500"),
        (header_line(bytes((4, 7, 0, 0))), "the sketch's settings are wrong: dlpf_cfg is 7"),
    ],
)
def test_faults_are_reported(line, fault):
    decoder, counts = decode(line, sample_line(0, 0))
    assert fault in decoder.fault
    assert counts == []
    decoder.feed(header_line() + sample_line(5000, 1))
    assert decoder.fault is None


# The sketch itself


@pytest.fixture(scope="module")
def compiler() -> str:
    found = shutil.which("g++")
    if not found:
        pytest.skip("g++ is missing, with which the sketch is compiled for this machine")
    return found


def build(compiler: str, source: str, folder: Path) -> Path:
    program = folder / Path(source).stem
    includes = [f"-I{SKETCH}", f"-I{ROOT / 'tests' / 'python' / 'capture' / 'arduino'}"]
    strict = ["-std=c++11", "-Wall", "-Wextra", "-Werror", "-O1"]
    subprocess.run(
        [
            compiler,
            *strict,
            *includes,
            ROOT / "tests" / "python" / "capture" / "arduino" / source,
            "-o",
            program,
        ],
        check=True,
    )
    return program


@pytest.fixture(scope="module")
def board(compiler, tmp_path_factory):
    """Run the sketch on a simulated board.

    Case, first stamp in µs and duration in, bytes of the serial port out.
    """
    program = build(compiler, "board.cpp", tmp_path_factory.mktemp("board"))

    def run(case: str, first_micros: int, seconds: float) -> bytes:
        command = [str(program), case, str(first_micros), str(seconds)]
        return subprocess.run(command, check=True, capture_output=True).stdout

    return run


def test_the_checksum_is_the_catalogued_one():
    assert crc16(b"123456789") == 0x29B1


def test_the_sketch_writes_the_lines_that_are_read(compiler, tmp_path):
    rng = random.Random(1)
    cases, expected = [], []
    for _ in range(200):
        stamp, number, registers = rng.getrandbits(32), rng.getrandbits(16), rng.randbytes(14)
        cases.append(f"S {stamp} {number} {' '.join(map(str, registers))}")
        expected.append(sample_line(stamp, number, struct.unpack(">7h", registers)))
    cases += ["H 65535 104 4 2 24 24", "X 2 113"]
    expected += [header_line(device=65535), fault_line(2, 113)]
    program = build(compiler, "encode.cpp", tmp_path)
    written = subprocess.run(
        [program], input="\n".join(cases).encode(), check=True, capture_output=True
    ).stdout
    assert written == b"".join(expected)


def test_the_example_in_the_guide_is_a_line():
    examples = re.findall(
        r"^([SHX][0-9A-F]{8,})$", (ROOT / "docs" / "capture.md").read_text(), re.MULTILINE
    )
    assert {example[0] for example in examples} == set("SHX")
    assert all(close(example[:-4]).decode().strip() == example for example in examples)


@pytest.mark.slow
def test_the_sketch_sends_every_sample_across_the_wrap_of_its_clock(board):
    decoder = Decoder()
    samples = decoder.feed(board("sound", 2**32 - 2_000_000, 4.0))
    assert decoder.losses == LossCounters()
    assert decoder.device == 1
    counts = [sample.counts[0] for sample in samples]
    assert counts == list(range(counts[0], counts[0] + len(samples)))
    assert len(samples) > 750
    # The simulated board notices the interrupt as soon as the time of a byte on the bus is over.
    steps = [b.stamp_us - a.stamp_us for a, b in itertools.pairwise(samples)]
    assert all(step == 5000 for step in steps)
    assert samples[-1].stamp_us > 2**32
    assert samples[0].setup == Setup()


@pytest.mark.parametrize(
    ("case", "fault"),
    [("absent", "does not answer"), ("other", "0x71"), ("silent", "no data-ready signal")],
)
def test_the_sketch_reports_faults(board, case, fault):
    decoder = Decoder()
    assert decoder.feed(board(case, 0, 1.5)) == []
    assert fault in decoder.fault


def test_the_sketch_sets_the_chip_up_again_when_its_supply_dips(board):
    decoder = Decoder()
    samples = decoder.feed(board("dip", 0, 3.0))
    assert decoder.losses.restarts == 1
    assert [sample.run for sample in samples][:: len(samples) - 1] == [0, 1]
    assert samples[-1].stamp_us > 2_500_000


def test_at_rest_is_one_g():
    from footnav.capture import Block

    block = Block.from_counts([0.0], [AT_REST], Setup())
    assert block.accel[0] == pytest.approx([0, 0, 9.80665])
    assert block.temperature[0] == pytest.approx(30.177, abs=1e-3)
