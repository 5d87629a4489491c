"""Recordings in the layout of the EuRoC MAV dataset."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from footnav.errors import ConfigError, DataError
from footnav.io import read

HEADER = (
    "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
    "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]"
)
FIRST = 1403636579758555392
INTERVAL = 5000001
ROWS = [
    f"{FIRST + k * INTERVAL},-0.1,0.25,{0.01 * k},{0.5 - 0.125 * k},-0.75,9.8" for k in range(8)
]


@pytest.fixture
def write(tmp_path):
    """Return a function that writes a text to imu.csv and returns the path."""

    def write_file(text):
        path = tmp_path / "imu.csv"
        path.write_bytes(text.encode())
        return path

    return write_file


def lines(header=HEADER, rows=ROWS):
    return "\n".join([header, *rows, ""])


def assert_is_sample(recording):
    k = np.arange(len(ROWS))
    np.testing.assert_array_equal(recording.t, k * INTERVAL / 1e9)
    np.testing.assert_array_equal(recording.gyro[:, :2], np.tile([-0.1, 0.25], (len(k), 1)))
    np.testing.assert_array_equal(recording.gyro[:, 2], 0.01 * k)
    np.testing.assert_array_equal(recording.accel[:, 0], 0.5 - 0.125 * k)
    np.testing.assert_array_equal(recording.accel[:, 1:], np.tile([-0.75, 9.8], (len(k), 1)))


@pytest.mark.parametrize("form", [None, "euroc"])
@pytest.mark.parametrize(
    "text",
    [
        lines(),
        lines().replace("\n", "\r\n"),
        "\ufeff" + lines(),
        lines().rstrip("\n"),
        lines().replace(",", ", "),
        lines(header=HEADER.replace("#", "# ")),
        lines(header=HEADER.removeprefix("#")),
        lines(header=HEADER.replace(" [ns]", "")),
        lines(header=re.sub(r" \[.*?\]", "", HEADER)),
        lines(header=HEADER.replace(" [", "[")),
        lines(rows=[*ROWS[:3], "", "# a note", *ROWS[3:], ""]),
    ],
    ids=[
        "as published", "crlf", "bom", "no newline at the end", "spaces after commas",
        "space after #", "no #", "timestamp without unit", "no units", "no space before units",
        "blank and comment lines",
    ],
)  # fmt: skip
def test_spellings_are_read_exactly(write, text, form):
    assert_is_sample(read(write(text), format=form))


def without(k):
    return lambda line: ",".join(cell for i, cell in enumerate(line.split(",")) if i != k)


def rotated(line):
    stamp, *cells = line.split(",")
    return ",".join([stamp, *cells[3:], *cells[:3]])


@pytest.mark.parametrize("form", [None, "euroc"])
@pytest.mark.parametrize("change", [rotated, without(6), without(0)])
def test_permuted_or_missing_columns_are_refused(write, change, form):
    text = "\n".join(map(change, lines().splitlines()))
    with pytest.raises(
        DataError,
        match=r"^imu\.csv, line 1: .*timestamp, w_RS_S_x, .* in this order; found .*columns=\{",
    ):
        read(write(text), format=form)


def test_permuted_columns_can_be_named(write):
    text = "\n".join(map(rotated, lines().splitlines()))
    columns = {role: k for k, role in enumerate(["t", "ax", "ay", "az", "gx", "gy", "gz"])}
    units = {"t_unit": "ns", "accel_unit": "m/s^2", "gyro_unit": "rad/s"}
    recording = read(write(text), columns=columns, **units)
    np.testing.assert_array_equal(recording.accel[0], [0.5, -0.75, 9.8])


@pytest.mark.parametrize(
    ("unit", "other"), [("ns", "us"), ("rad s^-1", "deg s^-1"), ("m s^-2", "g")]
)
def test_other_units_are_refused(write, unit, other):
    with pytest.raises(DataError, match=rf"^imu\.csv, line 1: .*'{re.escape(other)}'.*convert"):
        read(write(lines(header=HEADER.replace(unit, other, 1))))


@pytest.mark.parametrize("keep", [1, 4, 6])
def test_truncated_last_line_is_refused(write, keep):
    rows = [*ROWS[:-1], ",".join(ROWS[-1].split(",")[:keep])]
    with pytest.raises(
        DataError, match=rf"^imu\.csv, line 9: {keep} cell\(s\), expected 7.*truncated: remove it"
    ):
        read(write(lines(rows=rows).rstrip("\n")))


@pytest.mark.parametrize(
    ("row", "message"),
    [
        (ROWS[3] + ",1", r"8 cell\(s\), expected 7.*; repair or remove the line"),
        (ROWS[3].replace("0.25", "abc"), "'w_RS_S_y' is 'abc'; expected a number"),
        (ROWS[3].replace("9.8", ""), "'a_RS_S_z' is empty"),
        (ROWS[3].replace("9.8", "nan"), "'a_RS_S_z' is nan"),
        (ROWS[3].replace(",", ".0,", 1), r"the timestamp is '\d+\.0'; expected an integer in ns"),
        ("1.4036365797e+18" + ROWS[3][19:], "the timestamp is .*without point or exponent"),
        (str(FIRST) + ROWS[3][19:], "time goes back by 10000002 ns; sort the rows"),
    ],
)
def test_defective_row_is_named_by_its_line(write, row, message):
    with pytest.raises(DataError, match=rf"^imu\.csv, line 5: {message}"):
        read(write(lines(rows=[*ROWS[:3], row, *ROWS[4:]])))


def test_header_without_rows_is_refused(write):
    with pytest.raises(DataError, match=r"imu\.csv has no row of samples"):
        read(write(HEADER + "\n"))


@pytest.mark.parametrize(
    "option",
    [
        {"t_unit": "ns"},
        {"accel_unit": "g"},
        {"gyro_unit": "deg/s"},
        {"foot": "left"},
        {"rate_hz": 200},
    ],
)
def test_options_that_do_not_fit_are_refused(write, option):
    with pytest.raises(ConfigError, match=next(iter(option))):
        read(write(lines()), **option)


def test_ground_truth_is_not_taken_for_an_imu(write):
    header = "#timestamp, b_w_RS_S_x [rad s^-1], b_a_RS_S_x [m s^-2]"
    with pytest.raises(DataError, match="3 columns without titles"):
        read(write("\n".join([header, f"{FIRST},0.1,0.2", f"{FIRST + INTERVAL},0.1,0.2"])))


VALUE = st.floats(-5, 5)


@settings(deadline=None)
@given(
    first=st.integers(0, 2**62),
    intervals=st.lists(st.integers(100_000, 400_000_000), min_size=1, max_size=12),
    data=st.data(),
)
def test_written_samples_are_read_back(tmp_path_factory, first, intervals, data):
    elapsed = np.cumsum([0, *intervals])
    n = len(elapsed)
    sensors = np.array(data.draw(st.lists(st.tuples(*[VALUE] * 5), min_size=n, max_size=n)))
    sensors = np.column_stack([sensors, np.full(n, 9.8)])
    rows = [
        ",".join([str(first + int(ns)), *map(repr, row)])
        for ns, row in zip(elapsed, sensors.tolist(), strict=True)
    ]
    path = tmp_path_factory.mktemp("euroc") / "imu.csv"
    path.write_text(lines(rows=rows))
    recording = read(path)
    np.testing.assert_array_equal(recording.t, elapsed / 1e9)
    np.testing.assert_array_equal(np.column_stack([recording.gyro, recording.accel]), sensors)
