"""Files as loggers write them become recordings in SI units, or errors that name the line."""

import math
import re
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from footnav.errors import ConfigError, DataError, FootnavError, FootnavWarning
from footnav.io import read
from footnav.io.header import understand
from footnav.recording import STANDARD_GRAVITY

N = 60
HEADER = ["t", "ax", "ay", "az", "gx", "gy", "gz"]


def foot(n=N, rate=100.0):
    """Return an (n, 7) table in SI of a foot that swings: stamps, specific force, angular rate."""
    t = np.arange(n) / rate
    swing = np.sin(2 * np.pi * t / 0.3)
    accel = np.column_stack([8 * swing, 3 * swing, np.full(n, STANDARD_GRAVITY)])
    gyro = np.column_stack([0.5 * swing, 7 * swing, -swing])
    return np.column_stack([t, accel, gyro])


def lines_of(table, delimiter=","):
    return [delimiter.join(map(repr, row)) for row in table.tolist()]


@pytest.fixture
def write(tmp_path):
    """Return a function that writes lines, or bytes, to walk.csv and returns the path."""

    def write_file(content, end="\n"):
        path = tmp_path / "walk.csv"
        data = content if isinstance(content, bytes) else (end.join(content) + end).encode()
        path.write_bytes(data)
        return path

    return write_file


def csv(table, header=HEADER, delimiter=","):
    return [delimiter.join(header), *lines_of(table, delimiter)]


def assert_is(recording, table, rtol=1e-15):
    np.testing.assert_allclose(recording.t, table[:, 0], rtol=rtol, atol=0)
    np.testing.assert_allclose(recording.accel, table[:, 1:4], rtol=rtol, atol=1e-300)
    np.testing.assert_allclose(recording.gyro, table[:, 4:7], rtol=rtol, atol=1e-300)


# --- forms of a table of numbers


def test_canonical_file_is_read_exactly(write):
    table = foot()
    recording = read(write(csv(table)))
    assert_is(recording, table, rtol=0)
    assert recording.name == "walk.csv"
    assert read(write(csv(table)), name="second walk").name == "second walk"


def test_canonical_file_at_rest_and_slow_is_in_si(write):
    table = np.column_stack([np.arange(N) / 8, np.tile([0, 0, 9.8, 0.01, 0.02, 0.03], (N, 1))])
    assert_is(read(write(csv(table))), table, rtol=0)


@pytest.mark.parametrize(
    "dress",
    [
        lambda lines: "\n".join(lines).encode(),
        lambda lines: "\r\n".join(lines).encode(),
        lambda lines: "\r\n\r\n".join(lines).encode(),
        lambda lines: "\r".join(lines).encode(),
        lambda lines: ("\ufeff" + "\n".join(lines)).encode(),
        lambda lines: "\n".join(lines).encode("utf-16"),
        lambda lines: "".join(line + ",\n" for line in lines).encode(),
        lambda lines: "".join([lines[0] + "\n", *(line + ", \n" for line in lines[1:])]).encode(),
        lambda lines: ",\n".join([*lines, ""]).rstrip("\n").encode(),
        lambda lines: "\n".join(
            ["# made by a logger", "", lines[0], "#a note", *lines[1:], "# end", ""]
        ).encode(),
        lambda lines: "\n".join(["# " + lines[0], *lines[1:]]).encode(),
        lambda lines: "\n".join(["Logger 3.1", "Serial,0042", *lines]).encode(),
        lambda lines: "\n".join(re.sub("[^,]+", r'"\g<0>"', line) for line in lines).encode(),
        lambda lines: "\n".join(line.replace(",", " , ") for line in lines).encode(),
    ],
    ids=[
        "lf", "crlf", "blank lines", "cr", "bom", "utf-16", "trailing delimiter",
        "trailing delimiter in rows",
        "trailing delimiter, no newline", "comments", "savetxt header", "preamble", "quotes", "padded",
    ],
)  # fmt: skip
def test_dress_of_a_file_does_not_matter(write, dress):
    table = foot()
    assert_is(read(write(dress(csv(table)))), table, rtol=0)


@pytest.mark.parametrize("delimiter", [";", "\t", " ", "   "])
def test_delimiters(write, delimiter):
    table = foot()
    assert_is(read(write(csv(table, delimiter=delimiter))), table, rtol=0)


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_decimal_commas_beside_another_delimiter(write, delimiter):
    table = foot()
    lines = [line.replace(".", ",") for line in csv(table, delimiter=delimiter)]
    assert_is(read(write(lines)), table, rtol=0)


def test_other_columns_may_hold_anything(write):
    table = foot()
    lines = [f"{k},{line}" + ",left foot" * 9 for k, line in enumerate(lines_of(table))]
    assert_is(read(write([",".join(["", *HEADER, *"abcdefhij"]), *lines])), table, rtol=0)


# --- what the titles mean


@pytest.mark.parametrize(
    ("text", "role", "unit"),
    [
        ("t", "t", None),
        ("Time", "t", None),
        ("timestamp", "t", None),
        ("Time [ms]", "t", "ms"),
        ("timestamp_ns", "t", "ns"),
        ("seconds_elapsed", "t", "seconds"),
        ("millis", "t", "millis"),
        ("ax", "ax", None),
        ("acc_x", "ax", None),
        ("AccX", "ax", None),
        ("accel.y", "ay", None),
        ("xAccel", "ax", None),
        ("Accelerometer Z (g)", "az", "g"),
        ("acceleration x [m/s²]", "ax", "m/s²"),
        ("accX_mps2", "ax", "mps2"),
        ("gyr_y", "gy", None),
        ("gyroscopeZ", "gz", None),
        ("angular_velocity.x", "gx", None),
        ("wz (rad/s)", "gz", "rad/s"),
        ("gyro_x_dps", "gx", "dps"),
        ("IMU Gyro X-axis {deg/s}", "gx", "deg/s"),
        ("Magnetometer X (uT)", "mx", "uT"),
        ("Barometer (hPa)", "pressure", "hPa"),
        ("temp", "temperature", None),
    ],
)
def test_titles_that_are_understood(text, role, unit):
    title = understand(text)
    assert (title.role, title.unit) == (role, unit)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "FreeAcc_X",
        "linear acceleration x",
        "gravity_x",
        "acc_bias_x",
        "q_x",
        "x",
        "gyro",
        "axle",
        "max",
        "Roll",
    ],
)
def test_titles_with_another_meaning_have_no_role(text):
    assert understand(text).role is None


UNITS = {
    "t": [("s", 1.0), ("sec", 1.0), ("ms", 1e-3), ("µs", 1e-6), ("ns", 1e-9)],
    "a": [
        ("m/s^2", 1.0),
        ("m/s2", 1.0),
        ("m/s²", 1.0),
        ("m/s/s", 1.0),
        ("g", STANDARD_GRAVITY),
        ("mg", 9.80665e-3),
    ],
    "g": [
        ("rad/s", 1.0),
        ("rad s^-1", 1.0),
        ("deg/s", math.pi / 180),
        ("°/s", math.pi / 180),
        ("dps", math.pi / 180),
    ],
}


@pytest.mark.parametrize(
    ("kind", "unit", "scale"), [(kind, *unit) for kind, units in UNITS.items() for unit in units]
)
def test_units_in_the_titles(write, kind, unit, scale):
    table = foot()
    names = {"t": ["t"], "a": HEADER[1:4], "g": HEADER[4:]}[kind]
    header = [f"{name} ({unit})" if name in names else name for name in HEADER]
    scaled = table.copy()
    scaled[:, [HEADER.index(name) for name in names]] /= scale
    assert_is(read(write(csv(scaled, header))), table, rtol=1e-14)


def test_latin_1_degree_sign(write):
    table = foot()
    header = ["t", "ax", "ay", "az", "gx (°/s)", "gy (°/s)", "gz (°/s)"]
    table_deg = np.column_stack([table[:, :4], np.degrees(table[:, 4:])])
    assert_is(read(write("\n".join(csv(table_deg, header)).encode("latin-1"))), table, rtol=1e-14)


def test_options_override_the_titles(write):
    table = foot()
    scaled = table * ([1000] + [1 / STANDARD_GRAVITY] * 3 + [180 / np.pi] * 3)
    header = [
        "t (us)",
        *(f"a{axis} (m/s^2)" for axis in "xyz"),
        *(f"g{axis} (rad/s)" for axis in "xyz"),
    ]
    recording = read(write(csv(scaled, header)), t_unit="ms", accel_unit="g", gyro_unit="deg/s")
    assert_is(recording, table, rtol=1e-14)


@pytest.mark.parametrize("t_scale", [1, 1e3, 1e6, 1e9])
@pytest.mark.parametrize("a_scale", [1, 1 / STANDARD_GRAVITY, 1000 / STANDARD_GRAVITY])
@pytest.mark.parametrize("g_scale", [1, 180 / math.pi])
def test_units_are_inferred_from_a_walk(write, t_scale, a_scale, g_scale):
    table = foot()
    scaled = table * ([t_scale] + [a_scale] * 3 + [g_scale] * 3)
    header = ["time", "acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"]
    assert_is(read(write(csv(scaled, header))), table, rtol=1e-13)


@pytest.mark.parametrize(
    ("scale", "option"),
    [
        ([0.015 / 0.0001] + [1] * 6, "t_unit"),
        ([1] + [0.01] * 3 + [1] * 3, "accel_unit"),
        ([1] * 4 + [0.1] * 3, "gyro_unit"),
        ([1] + [1, 1, 1] + [50 / 7.1] * 3, "gyro_unit"),
    ],
    ids=["1.5 s or 1.5 ms", "no gravity", "slow turn", "50 of either"],
)
def test_undecidable_units_are_asked_for(write, scale, option):
    header = ["time", "acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"]
    table = foot()
    if option == "t_unit":
        table[:, 0] = np.arange(N) * 0.15
        scale = [1] * 7
    with pytest.raises(DataError, match=rf"walk\.csv does not state the unit of .*; give {option}"):
        read(write(csv(table * scale, header)))


def test_gyroscope_at_rest_is_undecidable(write):
    table = np.column_stack([np.arange(N) / 100, np.tile([0, 0, 9.8, 0.4, -0.9, 2.5], (N, 1))])
    header = ["time", "acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"]
    with pytest.raises(DataError, match="give gyro_unit"):
        read(write(csv(table, header)))
    recording = read(write(csv(table, header)), gyro_unit="deg/s")
    np.testing.assert_allclose(recording.gyro[0], np.radians([0.4, -0.9, 2.5]))


def test_unknown_and_contradictory_units_are_refused(write):
    table = foot()
    header = ["t", "ax (furlong)", "ay", "az", "gx", "gy", "gz"]
    with pytest.raises(
        DataError,
        match=r"'ax \(furlong\)' states the unit 'furlong'; expected one of m/s\^2, g, mg",
    ):
        read(write(csv(table, header)))
    header = ["t", "ax (g)", "ay (mg)", "az", "gx", "gy", "gz"]
    with pytest.raises(DataError, match="more than one unit: g, mg"):
        read(write(csv(table, header)))


def test_stated_unit_that_the_values_contradict_is_refused(write):
    with pytest.raises(DataError, match=r'walk\.csv: .*in g; read them with accel_unit="g"'):
        read(
            write(
                csv(
                    foot() * ([1] + [0.1] * 3 + [1] * 3),
                    ["t", *(f"a{c} (m/s^2)" for c in "xyz"), "gx", "gy", "gz"],
                )
            )
        )


def test_optional_sensors(write):
    table = foot()
    extra = np.tile([20.0, 5.0, -43.0, 1013.25, 31.5], (N, 1))
    header = [*HEADER, "mag_x", "mag_y", "mag_z", "Barometer (hPa)", "Temperature"]
    recording = read(write(csv(np.column_stack([table, extra]), header)))
    np.testing.assert_allclose(recording.mag[0], [20e-6, 5e-6, -43e-6])
    assert recording.pressure[0] == pytest.approx(101325.0)
    assert recording.temperature[-1] == 31.5


def test_optional_sensor_that_is_impossible_is_left_out_with_a_warning(write):
    lines = [f"{line},1,2,{'' if k == 4 else 3}" for k, line in enumerate(lines_of(foot()))]
    path = write([",".join([*HEADER, "mx", "my", "mz"]), *lines])
    with pytest.warns(
        FootnavWarning, match=r"walk\.csv, line 6: 'mz' is empty.*the magnetometer is left out"
    ):
        assert read(path).mag is None


# --- options


def test_columns_by_title_and_by_number(write):
    table = foot()
    header = ["Clock", "Acc 1", "Acc 2", "Acc 3", "gx", "gy", "gz"]
    columns = {"t": "Clock", "ax": 1, "ay": "Acc 2", "az": 3}
    assert_is(read(write(csv(table, header)), columns=columns), table, rtol=0)


def test_columns_of_a_file_without_titles(write):
    table = foot()
    path = write(lines_of(table))
    with pytest.raises(DataError, match=r"7 columns without titles.*columns=\{\"ax\""):
        read(path)
    columns = {name: k for k, name in enumerate(HEADER)}
    assert_is(read(path, columns=columns), table, rtol=0)


def test_columns_settle_an_ambiguous_title(write):
    table = foot()
    path = write(csv(np.column_stack([table, table[:, 1]]), [*HEADER, "Acc_X"]))
    with pytest.raises(DataError, match=r"'ax' and 'Acc_X' could both be ax"):
        read(path)
    assert_is(read(path, columns={"ax": "ax"}), table, rtol=0)


def test_missing_columns_are_listed(write):
    with pytest.raises(
        DataError, match=r"found the columns 't', 'ax', .*'roll'.* none is recognised as gx, gz"
    ):
        read(write(csv(foot(), ["t", "ax", "ay", "az", "roll", "gy", "yaw"])))


@pytest.mark.parametrize(
    ("columns", "error", "message"),
    [
        ({"ax": "Accx"}, DataError, "no column 'Accx' for ax.*did you mean 'ax'"),
        ({"ax": 7}, DataError, "columns 0 to 6; columns gives 7 for ax"),
        ({"acx": "ax"}, ConfigError, "columns names 'acx'.*did you mean 'ax'"),
        ({"ax": 1.0}, ConfigError, "the title or the number"),
        ({"ax": 1, "ay": "ax"}, ConfigError, "one column two roles"),
    ],
)
def test_wrong_columns_option(write, columns, error, message):
    with pytest.raises(error, match=message):
        read(write(csv(foot())), columns=columns)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"format": "mpu605"}, "format is 'mpu605'; expected one of npz, .*did you mean 'mpu6050'"),
        ({"t_unit": "msec"}, "t_unit is 'msec'.*did you mean 'ms'"),
        ({"accel_unit": "G"}, "accel_unit is 'G'.*did you mean 'g'"),
        ({"gyro_unit": "dps"}, "gyro_unit is 'dps'; expected one of rad/s, deg/s"),
        ({"foot": "Left"}, "foot is 'Left'.*did you mean 'left'"),
        ({"foot": "left"}, "foot has no meaning for a file of format 'csv'"),
        ({"rate_hz": 0}, "rate_hz is 0; expected a positive number"),
        ({"rate_hz": 100.0}, r"walk\.csv has stamps; rate_hz is for files without"),
        ({"accel_range": -16}, "accel_range is -16"),
        ({"gyro_range": "2000"}, "gyro_range is '2000'"),
        ({"axes": "x,y"}, "axes is 'x,y'; expected three of x, y, z"),
        ({"axes": "x,x,z"}, "each of x, y and z must appear once"),
        ({"axes": "y,x,z"}, "mirrors the sensor"),
    ],
)
def test_wrong_options_are_config_errors(write, options, message):
    with pytest.raises(ConfigError, match=message):
        read(write(csv(foot())), **options)


def test_rate_makes_stamps_for_a_file_without(write):
    table = foot()
    path = write(csv(table[:, 1:], HEADER[1:]))
    with pytest.raises(DataError, match=r"no column of time.*rate_hz"):
        read(path)
    np.testing.assert_array_equal(read(path, rate_hz=100).t, np.arange(N) / 100)


def test_axes_turn_every_triad(write):
    table = np.column_stack([foot(), np.tile([20.0, 5.0, -43.0], (N, 1))])
    recording = read(write(csv(table, [*HEADER, "mx", "my", "mz"])), axes="y, -x, z")
    for turned, first in ((recording.accel, 1), (recording.gyro, 4), (recording.mag * 1e6, 7)):
        x, y, z = table[:, first : first + 3].T
        np.testing.assert_allclose(turned, np.column_stack([y, -x, z]), rtol=1e-15)


def test_ranges_are_in_g_and_degrees(write):
    recording = read(write(csv(foot())), accel_range=16, gyro_range=2000)
    assert recording.accel_range == 16 * STANDARD_GRAVITY
    assert recording.gyro_range == pytest.approx(2000 * math.pi / 180)


# --- defects


@pytest.mark.parametrize(
    ("cell", "message"),
    [
        ("abc", "'gy' is 'abc'; expected a number"),
        ("", "'gy' is empty"),
        ("1_000", "'gy' is '1_000'"),
        ("nan", "'gy' is nan; 1 value"),
        ("-inf", "'gy' is -inf"),
        ("1,2", r"8 cell\(s\), expected 7"),
    ],
)
def test_bad_cell_is_named_by_its_line(write, cell, message):
    lines = csv(foot())
    cells = lines[12].split(",")
    lines[12] = ",".join([*cells[:5], cell, cells[6]])
    # A comment and a blank line come before: the line is the one that an editor shows.
    with pytest.raises(DataError, match=rf"^walk\.csv, line 15: .*{message}"):
        read(write(["# logger", "", *lines]))


def test_first_row_of_numbers_may_have_the_bad_cell(write):
    lines = csv(foot())
    lines[1] = lines[1].replace("0.0", "?", 1)
    with pytest.raises(DataError, match=r"line 2: 't' is '\?'"):
        read(write(lines))


def test_short_row_in_the_middle_is_an_error(write):
    lines = csv(foot())
    lines[20] = lines[20][:15]
    with pytest.raises(DataError, match=r"walk\.csv, line 21: . cell\(s\), expected 7"):
        read(write(lines))


@pytest.mark.parametrize("keep", [1, 4, 6])
def test_cut_off_last_line_is_dropped_with_a_warning(write, keep):
    table = foot()
    lines = csv(table)
    lines[-1] = ",".join(lines[-1].split(",")[:keep])
    path = write("\n".join(lines).encode())
    with pytest.warns(
        FootnavWarning,
        match=rf"walk\.csv, line 61: the last line is truncated \({keep} of 7 cells\)",
    ):
        recording = read(path)
    assert_is(recording, table[:-1], rtol=0)


def test_last_cell_cut_to_its_sign_is_dropped_with_a_warning(write):
    table = foot()
    lines = csv(table)
    lines[-1] = ",".join([*lines[-1].split(",")[:-1], "-"])
    with pytest.warns(FootnavWarning, match="the last cell is '-'"):
        recording = read(write("\n".join(lines).encode()))
    assert_is(recording, table[:-1], rtol=0)


def test_time_that_goes_back_is_named_by_its_line(write):
    table = foot()
    table[30:, 0] -= 0.1
    with pytest.raises(DataError, match=r"walk\.csv, line 32: time goes back from 0\.29 to 0\.1"):
        read(write(csv(table)))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", r"walk\.csv is empty"),
        (b" \r\n\n", r"walk\.csv is empty"),
        (b"# only a comment\n", r"walk\.csv is empty"),
        (b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR", r"walk\.csv is binary"),
        (b"t,ax,ay,az,gx,gy,gz\n", r"walk\.csv, line 1: no row of numbers"),
        (
            b"<html>\n<body>not found</body>\n</html>",
            r"line 1: no row of numbers was found; the file begins '<html>'",
        ),
        (b"PK\x03\x04 not an archive", r"walk\.csv cannot be read as a NumPy \.npz file"),
    ],
)
def test_files_that_hold_no_samples(write, data, message):
    with pytest.raises(DataError, match=message):
        read(write(data))


def test_missing_file_and_folder(tmp_path):
    with pytest.raises(DataError, match=r"nowhere\.csv does not exist"):
        read(tmp_path / "nowhere.csv")
    with pytest.raises(DataError, match="is a folder"):
        read(tmp_path)


# --- the formats


def counts(sensors=1):
    """Return rows of ms and counts; the second sensor is mounted the other way round."""
    base = [-8000, 1600, 14000, 160, -32768, 32767]
    both = base + [~count for count in base]
    return [[10 * k, *both[: 6 * sensors]] for k in range(N)]


def rows(table):
    return [",".join(map(str, row)) for row in table]


@pytest.mark.parametrize("accel_range", [2, 4, 8, 16])
@pytest.mark.parametrize("gyro_range", [250, 500, 1000, 2000])
def test_counts_convert_exactly(write, accel_range, gyro_range):
    table = counts()
    for row in table:
        row[1:4] = [c * 2 // accel_range for c in row[1:4]]
    recording = read(write(rows(table), "\r\n\r\n"), accel_range=accel_range, gyro_range=gyro_range)
    np.testing.assert_array_equal(recording.t, np.arange(N) / 100)
    expected = np.array(table[0][1:4]) * accel_range / 32768 * STANDARD_GRAVITY
    np.testing.assert_allclose(recording.accel[0], expected, rtol=1e-15)
    assert recording.gyro[0, 1] == -math.radians(gyro_range)
    assert (recording.accel_range, recording.gyro_range) == (
        accel_range * STANDARD_GRAVITY,
        math.radians(gyro_range),
    )


def test_pair_needs_the_foot(write):
    path = write(rows(counts(2)))
    ranges = {"accel_range": 2, "gyro_range": 250}
    with pytest.raises(ConfigError, match=r"walk\.csv holds the sensors of both feet; give foot="):
        read(path, **ranges)
    left, right = (read(path, foot=foot, **ranges) for foot in ("left", "right"))
    assert left.accel[0, 0] == pytest.approx(-8000 / 32768 * 2 * STANDARD_GRAVITY, rel=1e-15)
    assert right.accel[0, 0] == pytest.approx(7999 / 32768 * 2 * STANDARD_GRAVITY, rel=1e-15)
    np.testing.assert_array_equal(left.t, right.t)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "give accel_range in g: 2, 4, 8, 16"),
        ({"accel_range": 2}, "give gyro_range in deg/s: 250, 500, 1000, 2000"),
        ({"accel_range": 3, "gyro_range": 250}, "accel_range is 3 g; an MPU6050 has 2, 4, 8, 16"),
        ({"accel_range": 2, "gyro_range": 250, "accel_unit": "g"}, "accel_unit has no meaning"),
        ({"accel_range": 2, "gyro_range": 250, "foot": "left"}, "foot has no meaning"),
    ],
)
def test_counts_need_their_ranges(write, options, message):
    with pytest.raises(ConfigError, match=message):
        read(write(rows(counts())), **options)


@pytest.mark.parametrize("value", [32768, -32769, 0.5])
def test_counts_outside_16_bits_are_refused(write, value):
    table = counts()
    table[7][3] = value
    with pytest.raises(
        DataError,
        match=rf"walk\.csv, line 8: column 3 is {value}; expected a count from -32768 to 32767",
    ):
        read(write(rows(table)), format="mpu6050", accel_range=2, gyro_range=250)


def test_counts_with_a_header_or_without_stamps(write):
    ranges = {"format": "mpu6050", "accel_range": 2, "gyro_range": 250}
    plain = read(write(rows(counts())), **ranges)
    titled = read(write(["millis,ax,ay,az,gx,gy,gz", *rows(counts())]), **ranges)
    stampless = read(write(rows(row[1:] for row in counts())), rate_hz=100, **ranges)
    for recording in (titled, stampless):
        np.testing.assert_array_equal(recording.t, plain.t)
        np.testing.assert_array_equal(recording.accel, plain.accel)


def test_counts_with_a_header_are_recognised(write):
    with pytest.raises(DataError, match=r'raw counts of an MPU6050 need format="mpu6050"'):
        read(write(["t,ax,ay,az,gx,gy,gz", *rows(counts())]))


def test_counts_with_the_wrong_number_of_columns(write):
    with pytest.raises(DataError, match="has 13 columns; format 'mpu6050' has ms and 6 counts"):
        read(write(rows(counts(2))), format="mpu6050", accel_range=2, gyro_range=250)


XIO = [
    "Time (s)",
    *(f"Gyroscope {axis} (deg/s)" for axis in "XYZ"),
    *(f"Accelerometer {axis} (g)" for axis in "XYZ"),
]


@pytest.mark.parametrize("form", [None, "xio", "csv"])
def test_x_io_file(write, form):
    table = foot()
    columns = np.column_stack(
        [table[:, 0], np.degrees(table[:, 4:]), table[:, 1:4] / STANDARD_GRAVITY]
    )
    assert_is(read(write(csv(columns, XIO)), format=form), table, rtol=1e-14)


def test_file_that_is_not_from_x_io(write):
    with pytest.raises(
        DataError, match=r"not of format 'xio': expected 'Time \(s\)'.*found 't', 'ax'"
    ):
        read(write(csv(foot())), format="xio")


def save(path, **arrays):
    table = foot()
    np.savez(path, **({"t": table[:, 0], "accel": table[:, 1:4], "gyro": table[:, 4:]} | arrays))
    return path


def test_npz_file(tmp_path):
    arrays = {
        "mag": np.full((N, 3), 30e-6),
        "pressure": np.full(N, 1e5),
        "temperature": np.full(N, 20.0),
        "notes": "hi",
    }
    recording = read(save(tmp_path / "walk.npz", accel_range=156.9, **arrays))
    assert_is(recording, foot(), rtol=0)
    np.testing.assert_array_equal(recording.mag, arrays["mag"])
    np.testing.assert_array_equal(recording.pressure, arrays["pressure"])
    np.testing.assert_array_equal(recording.temperature, arrays["temperature"])
    assert (recording.accel_range, recording.gyro_range) == (156.9, None)


def test_npz_file_with_a_magnetometer_in_microtesla(tmp_path):
    recording = read(save(tmp_path / "walk.npz", mag=np.full((N, 3), 30.0)))
    np.testing.assert_allclose(recording.mag, 30e-6)


def test_npz_file_whose_magnetometer_has_holes(tmp_path):
    mag = np.full((N, 3), 30.0)
    mag[5] = np.nan
    path = save(tmp_path / "walk.npz", mag=mag)
    with pytest.warns(FootnavWarning, match=r"walk\.npz: mag has 1 row"):
        assert read(path).mag is None


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"gyro": np.zeros((N, 2))}, r"walk\.npz: gyro has shape"),
        ({"gyro": np.array(["x"] * N)}, r"walk\.npz: gyro holds <U1"),
        ({"gyro": np.array([None] * N)}, r"walk\.npz cannot be read"),
        ({"accel": np.full((N, 3), 0.6)}, r'walk\.npz: .*accel_unit="g"'),
        ({"gyro": np.float64(1.0)}, r"walk\.npz: gyro has shape \(\)"),
        ({"accel_range": np.ones(2)}, "accel_range has shape"),
    ],
)
def test_npz_file_with_wrong_arrays(tmp_path, arrays, message):
    with pytest.raises(DataError, match=message):
        read(save(tmp_path / "walk.npz", **arrays))


def test_npz_file_with_missing_arrays_or_damage(tmp_path):
    path = tmp_path / "walk.npz"
    np.savez(path, accel=np.ones((N, 3)))
    with pytest.raises(
        DataError, match=r"expected the arrays t, accel and gyro, found accel; missing gyro"
    ):
        read(path)
    np.save(tmp_path / "walk.npy", foot())
    with pytest.raises(DataError, match=r"walk\.npy is not a NumPy \.npz file"):
        read(tmp_path / "walk.npy", format="npz")
    path.write_bytes(save(tmp_path / "whole.npz").read_bytes()[:1500])
    with pytest.raises(DataError, match=r"walk\.npz cannot be read as a NumPy"):
        read(path)


# --- properties

ROTATIONS = ["x,y,z", "y,-x,z", "-x,-y,z", "z,x,y", "-z,y,x", "x,-z,y", "-y,-z,x"]


@st.composite
def formatted_table(draw):
    """Draw samples and one way of writing them down.

    Lines of text, options, and what must come back.
    """
    n = draw(st.integers(2, 12))
    value = st.floats(-50, 50, allow_subnormal=False)
    accel = np.array(draw(st.lists(st.tuples(value, value), min_size=n, max_size=n)))
    accel = np.column_stack([accel / 10, np.full(n, 9.8)])
    gyro = np.array(draw(st.lists(st.tuples(value, value, value), min_size=n, max_size=n)))
    t = np.cumsum(draw(st.lists(st.floats(0.001, 0.05), min_size=n, max_size=n)))
    units = {kind: draw(st.sampled_from(options)) for kind, options in UNITS.items()}
    stated = draw(st.booleans())
    delimiter = draw(st.sampled_from([",", ";", "\t"]))
    order = draw(st.permutations(range(7)))
    axes = draw(st.sampled_from(ROTATIONS))
    table = np.column_stack([t, accel, gyro])
    scaled = table / np.repeat([units[kind][1] for kind in "tag"], [1, 3, 3])
    titles = [f"{name} ({units[name[0]][0]})" if stated else name for name in HEADER]
    lines = csv(scaled[:, order], [titles[k] for k in order], delimiter)
    spelled = {
        "t": {"sec": "s", "µs": "us"},
        "a": {"m/s2": "m/s^2", "m/s²": "m/s^2", "m/s/s": "m/s^2"},
    }
    spelled["g"] = {"rad s^-1": "rad/s", "°/s": "deg/s", "dps": "deg/s"}
    names = {"t": "t_unit", "a": "accel_unit", "g": "gyro_unit"}
    options = (
        {} if stated else {names[k]: spelled[k].get(unit, unit) for k, (unit, _) in units.items()}
    )
    return lines, options | {"axes": axes}, table


def turn(axes, vectors):
    """Turn vectors by an `axes` string, one column at a time."""
    signs = [(-1 if axis[0] == "-" else 1, "xyz".index(axis[-1])) for axis in axes.split(",")]
    return np.column_stack([sign * vectors[:, k] for sign, k in signs])


@pytest.mark.slow
@settings(deadline=None)
@given(case=formatted_table())
def test_any_unit_delimiter_and_order_reads_back(tmp_path_factory, case):
    lines, options, table = case
    path = tmp_path_factory.mktemp("read") / "random.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    recording = read(path, **options)
    np.testing.assert_allclose(recording.t, table[:, 0], rtol=1e-12)
    np.testing.assert_allclose(
        recording.accel, turn(options["axes"], table[:, 1:4]), rtol=1e-14, atol=1e-300
    )
    np.testing.assert_allclose(
        recording.gyro, turn(options["axes"], table[:, 4:]), rtol=1e-14, atol=1e-300
    )


@settings(deadline=None)
@given(
    data=st.binary(max_size=200)
    | st.text("0123456789.,;-\n\t #tagxyz", max_size=200).map(str.encode)
)
def test_no_file_raises_anything_but_our_errors(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("read") / "noise.csv"
    path.write_bytes(data)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FootnavWarning)
        try:
            outcome = read(path).name
        except FootnavError as error:
            outcome = str(error)
    assert "noise.csv" in outcome


# --- real recordings


def test_x_io_walk(data_dir):
    recording = read(data_dir / "xio" / "short_walk.csv")
    assert len(recording) == 16539
    assert np.linalg.norm(recording.accel[:200].mean(axis=0)) == pytest.approx(
        STANDARD_GRAVITY, rel=0.01
    )
    np.testing.assert_allclose(recording.gyro[0], np.radians([-0.1428319, -0.7708032, -0.2320606]))


def test_pairs_of_raw_counts(data_dir):
    paths = sorted((data_dir / "mpu6050").glob("conf-*.csv"))
    assert paths
    for path in paths:
        left_accel, left_gyro, right_accel, right_gyro = map(int, path.name[5:9])
        left = read(path, foot="left", accel_range=2 << left_accel, gyro_range=250 << left_gyro)
        right = read(path, foot="right", accel_range=2 << right_accel, gyro_range=250 << right_gyro)
        assert left.rate_hz == pytest.approx(100.0)
        for recording in (left, right):
            gravity = np.linalg.norm(recording.accel[:100].mean(axis=0))
            assert gravity == pytest.approx(STANDARD_GRAVITY, rel=0.05)


def test_vicon_recordings(data_dir):
    paths = sorted((data_dir / "vicon").glob("*.npz"))
    assert paths
    for path in paths:
        assert read(path).rate_hz == pytest.approx(200.0, rel=0.01)
