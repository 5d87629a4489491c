"""The command line: status, files and streams; and the files of a recording that it writes."""

import csv
import json
import subprocess
import sys
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import footnav
from command_line import CommandResult
from footnav.cli.console import reporting
from footnav.cli.track import FORMATS
from footnav.export.recording import save_recording
from footnav.trajectory import load_trajectory


@pytest.fixture(scope="module")
def recording() -> footnav.Recording:
    """Five metres straight ahead along the sensor's x axis."""
    return footnav.simulate(footnav.simulation.Route.straight(5.0), sensor="ideal", seed=3)[0]


@pytest.fixture
def walk(recording: footnav.Recording, tmp_path: Path) -> Path:
    path = tmp_path / "walk.csv"
    save_recording(recording, path)
    return path


def cells(path: Path, *titles: str) -> np.ndarray:
    """Columns of a CSV file, shape (n, len(titles))."""
    with path.open() as file:
        return np.array([[float(row[title]) for title in titles] for row in csv.DictReader(file)])


def write_pair(path: Path) -> None:
    """Write the counts of two feet, 8 g and 1000 deg/s; the right foot walks further."""
    feet = [
        footnav.simulate(footnav.simulation.Route.straight(way), sensor="ideal")[0]
        for way in (4.0, 6.0)
    ]
    n = min(map(len, feet))
    scale = 32768 / np.repeat([8 * 9.80665, np.radians(1000)], 3)
    counts = [np.rint(np.hstack([foot.accel, foot.gyro])[:n] * scale) for foot in feet]
    np.savetxt(path, np.column_stack([5 * np.arange(n), *counts]), fmt="%d", delimiter=",")


RANGES = ("--accel-range", 8, "--gyro-range", 1000)


# Files of a recording


@pytest.mark.parametrize("suffix", [".csv", ".npz"])
def test_a_saved_recording_reads_back_to_the_bit(recording, tmp_path, suffix):
    n = len(recording)
    rng = np.random.default_rng(0)
    saved = footnav.Recording(
        recording.t + 0.1,
        recording.accel,
        recording.gyro,
        mag=rng.normal(0, 3e-5, (n, 3)),
        pressure=rng.normal(1e5, 10, n),
        temperature=rng.normal(20, 1, n),
    )
    save_recording(saved, tmp_path / f"walk{suffix}")
    back = footnav.read(tmp_path / f"walk{suffix}")
    for channel in ("t", "accel", "gyro", "mag", "pressure", "temperature"):
        np.testing.assert_array_equal(getattr(back, channel), getattr(saved, channel), strict=True)


def test_csv_has_the_canonical_header(recording, tmp_path):
    save_recording(recording, tmp_path / "walk.csv")
    header = "t (s),ax (m/s^2),ay (m/s^2),az (m/s^2),gx (rad/s),gy (rad/s),gz (rad/s)"
    assert (tmp_path / "walk.csv").read_text().partition("\n")[0] == header


def test_npz_keeps_the_full_scales(recording, tmp_path):
    saved = replace(recording, accel_range=80.0, gyro_range=20.0)
    save_recording(saved, tmp_path / "walk.npz")
    back = footnav.read(tmp_path / "walk.npz")
    assert (back.accel_range, back.gyro_range) == (80.0, 20.0)


def test_an_unknown_suffix_of_a_recording_names_the_known_ones(recording, tmp_path):
    with pytest.raises(
        footnav.ConfigError,
        match=r"walk\.mat: unknown suffix '\.mat', expected one of \.csv, \.npz",
    ):
        save_recording(recording, tmp_path / "walk.mat")


def test_a_recording_that_cannot_be_written_leaves_nothing(recording, tmp_path):
    with pytest.raises(footnav.FootnavError, match=r"absent/walk\.csv: cannot be written"):
        save_recording(recording, tmp_path / "absent" / "walk.csv")
    assert list(tmp_path.iterdir()) == []


# footnav itself


def test_version(run):
    assert run("--version") == CommandResult(0, f"footnav {footnav.__version__}\n", "")


def test_help_names_every_command(run):
    help_page = run("--help")
    assert help_page.status == 0
    assert all(f" {command} " in help_page.out for command in ("demo", "track", "simulate", "info"))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["trak"], '"trak"'),
        (["track"], "See: footnav track --help"),
        (["track", "walk.csv", "--rate-hx", "3"], "--rate-hx"),
        (["track", "walk.csv", "--rate-hz", "fast"], '"fast"'),
        (["track", "walk.csv", "--rate-hz", "-1"], "--rate-hz is -1.0; expected a positive number"),
        (["track", "walk.csv", "--axes", "x,x,z"], "each of x, y and z must appear once"),
        (["track", "walk.csv", "--columns", "t"], "expected each role once with its column"),
        (["track", "walk.csv", "--columns", "t=0,t=1"], "expected each role once with its column"),
        (
            ["track", "walk.csv", "--columns", "time=0"],
            "columns names 'time'; expected one of t, ax",
        ),
        (["track", "walk.csv", "--formats", "csv,cvs"], "did you mean 'csv'?"),
        (["track", "walk.csv", "--preset", "mpu"], "mpu6050"),
        (["track", "walk.csv", "--preset", "mpu6050", "--config", "shoe.toml"], "leave one out"),
        (["track", "walk.csv", "--config", "absent.toml"], "absent.toml: No such file"),
        (["track", "walk.csv", "--origin", "91", "0", "0"], "91"),
        (
            ["track", "walk.csv", "--heading-deg", "9", "--heading-from-magnetometer"],
            "leave one out",
        ),
        (["track", "walk.csv", "other.csv", "--name", "mine"], "there are 2 files"),
        (["track", "a/walk.csv", "b/walk.csv"], "a/walk.csv and b/walk.csv would have one name"),
        (["simulate", "star"], '"star"'),
        (["simulate", "square", "10", "20"], "square takes 1 size, not 2"),
        (["simulate", "square", "-3"], "square with size -3: expected a positive number"),
        (["simulate", "straight", "nan"], "straight with size nan"),
        (["simulate", "straight", "5", "--seed", "-1"], "-1"),
        (["simulate", "straight", "5", "--rate-hz", "0"], "rate_hz = 0"),
        (["simulate", "stairs", "1.5"], "1.5"),
        (["simulate", "square", "--gait", "hop"], '"hop": the known ones are walk'),
        (["simulate", "square", "--out", "walk.mat"], "expected one of .csv, .npz"),
        (["simulate", "square", "--truth", "truth.mat"], "truth.mat: unknown suffix"),
        (["simulate", "square", "--out", "one.csv", "--truth", "one.csv"], "two files are needed"),
        (["info", "walk.csv", "--foot", "third"], "expected one of left, right"),
    ],
)
def test_misuse_is_status_2_and_one_line(run, walk, arguments, message):
    result = run(*arguments)
    assert (result.status, result.out) == (2, "")
    assert result.err.startswith("footnav: ")
    assert result.err.count("\n") == 1
    assert message in result.err
    assert list(Path().iterdir()) == [Path("walk.csv")]


def test_other_warnings_are_shown_as_usual(capsys):
    def work() -> None:
        with reporting("walk.csv"):
            warnings.warn("old", DeprecationWarning, stacklevel=1)
            warnings.warn("walk.csv, line 3: odd", footnav.FootnavWarning, stacklevel=1)

    with pytest.warns(DeprecationWarning, match="old"):
        work()
    assert capsys.readouterr().err == "walk.csv: warning: line 3: odd\n"


# footnav track


@pytest.mark.slow
def test_track_writes_table_and_picture_beside_the_current_directory(run, walk, recording):
    result = run("track", walk)
    assert (result.status, result.err) == (0, "")
    expected = footnav.track(recording)
    np.testing.assert_array_equal(
        cells(Path("walk.track.csv"), "px", "py", "pz"), expected.position
    )
    assert Path("walk.track.png").read_bytes().startswith(b"\x89PNG")
    assert result.out.startswith("walk: ")
    assert f"{expected.distance:.2f} m in {len(expected.strides)} strides" in result.out
    assert "written        walk.track.csv, walk.track.png" in result.out


@pytest.mark.slow
def test_every_format_can_be_written(run, walk):
    options = ("--origin", 45, 7, 0, "--heading-deg", 90)
    result = run(
        "track", walk, *options, "--formats", ",".join(FORMATS), "--out", "a/b", "--name", "mine"
    )
    assert (result.status, result.err) == (0, "")
    assert {path.name for path in Path("a/b").iterdir()} == {
        f"mine.track.{form}" for form in FORMATS
    }


def test_the_origin_may_lie_in_the_south_west(run, walk):
    assert (
        run("track", walk, "--formats", "geojson", "--origin", "-33.5", "-70.25", "520").status == 0
    )
    line = json.loads(Path("walk.track.geojson").read_text())["features"][0]
    np.testing.assert_allclose(line["geometry"]["coordinates"][0], [-70.25, -33.5, 520], atol=1e-9)


def test_a_map_without_an_origin_warns_once(run, walk):
    result = run("track", walk, "--formats", "geojson,kml")
    assert result.status == 0
    assert result.err.startswith("walk.csv: warning: the track has no origin")
    assert result.err.count("\n") == 1


@pytest.mark.parametrize(("heading", "column"), [(0, "py"), (90, "px")])
def test_heading_is_clockwise_from_north(run, walk, heading, column):
    run("track", walk, "--formats", "csv", "--heading-deg", heading)
    assert cells(Path("walk.track.csv"), column)[-1] == pytest.approx(5.0, abs=0.3)


def test_heading_from_the_magnetometer(run, recording):
    to_the_right = np.tile([0.0, -2e-5, -4e-5], (len(recording), 1))
    save_recording(replace(recording, mag=to_the_right), "magnetic.csv")
    assert (
        run("track", "magnetic.csv", "--formats", "csv", "--heading-from-magnetometer").status == 0
    )
    # North is to the right, so the walk leads to the west.
    assert cells(Path("magnetic.track.csv"), "px")[-1] == pytest.approx(-5.0, abs=0.3)


def test_without_a_magnetometer_there_is_no_heading_from_it(run, walk):
    result = run("track", walk, "--heading-from-magnetometer")
    assert (result.status, result.err) == (1, "footnav: walk.csv has no magnetometer\n")


def test_settings_come_from_the_file(run, walk):
    Path("shoe.toml").write_text('[output]\nframe = "ned"\n')
    assert run("track", walk, "--formats", "csv", "--config", "shoe.toml").status == 0
    assert Path("walk.track.csv").read_text().startswith("t,pn,pe,pd,")


def test_reading_options_reach_the_reader(run, walk, recording):
    table = np.column_stack(
        [1e3 * recording.t, recording.accel / 9.80665, np.degrees(recording.gyro)]
    )
    np.savetxt("odd.txt", table, header="when,1,2,3,a,b,c", comments="", delimiter=",")
    columns = "t=when,ax=1,ay=2,az=3,gx=a,gy=b,gz=c"
    units = ("--t-unit", "ms", "--accel-unit", "g", "--gyro-unit", "deg/s")
    assert run("track", "odd.txt", "--columns", columns, *units, "--formats", "csv").status == 0
    np.testing.assert_allclose(
        cells(Path("odd.track.csv"), "px", "py", "pz"), footnav.track(recording).position, atol=1e-6
    )


@pytest.mark.slow
def test_one_failing_file_does_not_stop_the_others(run, walk):
    Path("broken.csv").write_text("t,ax,ay,az,gx,gy,gz\n0,1,2,three,4,5,6\n")
    result = run("track", "broken.csv", "absent.csv", walk)
    assert result.status == 1
    assert [line.partition(":")[0] for line in result.err.splitlines()] == ["footnav", "footnav"]
    assert "broken.csv, line 2: 'az' is 'three'" in result.err
    assert "absent.csv does not exist" in result.err
    assert Path("walk.track.csv").exists()
    assert not Path("broken.track.csv").exists()


def test_a_warning_is_one_line(run, recording):
    rows = np.r_[0:400, 500 : len(recording)]
    gappy = footnav.Recording(recording.t[rows], recording.accel[rows], recording.gyro[rows])
    save_recording(gappy, "gappy.csv")
    result = run("track", "gappy.csv", "--formats", "csv")
    assert result.status == 0
    (warning,) = result.err.splitlines()
    assert warning.startswith("gappy.csv: warning: samples are missing in 1 place")


def test_several_walks_are_compared_in_a_table(run, walk, recording):
    save_recording(recording, "other [1].csv")
    out = run("track", walk, "other [1].csv", "--formats", "csv").out
    rows = {
        line[1:10].strip(): line[10:].split() for line in out[out.index(" walk ") :].splitlines()
    }
    expected = footnav.track(recording)
    for name in ("walk", "other [1]"):
        assert (float(rows[name][0]), int(rows[name][2])) == (
            round(expected.distance, 2),
            len(expected.strides),
        )


def test_both_feet_of_a_pair_are_tracked(run):
    write_pair(Path("pair.csv"))
    result = run("track", "pair.csv", *RANGES, "--formats", "npz")
    assert result.status == 0
    left, right = (load_trajectory(f"pair-{foot}.track.npz") for foot in ("left", "right"))
    assert left.position[-1, 0] == pytest.approx(4.0, abs=0.2)
    assert right.position[-1, 0] > 4.5
    assert (left.name, right.name) == ("pair-left", "pair-right")


@pytest.mark.parametrize("stated", [(), ("--format", "mpu6050-pair")])
def test_one_foot_of_a_pair(run, stated):
    write_pair(Path("pair.csv"))
    assert (
        run("track", "pair.csv", *RANGES, *stated, "--foot", "left", "--formats", "npz").status == 0
    )
    assert {path.name for path in Path().iterdir()} == {"pair.csv", "pair.track.npz"}
    assert load_trajectory("pair.track.npz").position[-1, 0] == pytest.approx(4.0, abs=0.2)


def test_the_error_of_a_pair_without_ranges_names_the_options(run):
    write_pair(Path("pair.csv"))
    result = run("track", "pair.csv")
    assert (result.status, result.out) == (1, "")
    assert "give --accel-range in g: 2, 4, 8, 16" in result.err


def test_without_matplotlib_there_are_tracks_but_no_pictures(run, walk, monkeypatch):
    monkeypatch.setattr("footnav.cli.track.find_spec", lambda _: None)
    result = run("track", walk)
    assert result.status == 0
    assert result.err == (
        "footnav: warning: no pictures, since matplotlib is missing: pip install footnav[plot]\n"
    )
    assert {path.name for path in Path().iterdir()} == {"walk.csv", "walk.track.csv"}


def test_a_folder_that_cannot_be_made_is_an_error(run, walk):
    result = run("track", walk, "--out", walk / "tracks")
    assert result.status == 1
    assert "walk.csv/tracks: cannot be created" in result.err


def test_a_real_recording_with_gaps(run, data_dir):
    result = run(
        "track", data_dir / "xio" / "short_walk.csv", "--preset", "ngimu", "--formats", "npz"
    )
    assert result.status == 0
    assert all(line.startswith("short_walk.csv: warning: ") for line in result.err.splitlines())
    assert "205 samples repeat the stamp of the one before" in result.err
    assert np.linalg.norm(load_trajectory("short_walk.track.npz").position[-1, :2]) < 0.5


def test_a_real_pair_of_feet(run, data_dir):
    pair = data_dir / "mpu6050" / "conf-2222-coleta02-22-06-21-10ds_05.csv"
    assert run("track", pair, *RANGES, "--preset", "mpu6050", "--formats", "npz").status == 0
    for foot in ("left", "right"):
        track = load_trajectory(f"{pair.stem}-{foot}.track.npz")
        assert track.distance == pytest.approx(21, abs=1)
        assert np.linalg.norm(track.position[-1, :2]) < 0.5


# footnav demo


@pytest.mark.slow
def test_demo_leaves_a_walk_that_can_be_tracked_again(run):
    result = run("demo")
    assert (result.status, result.err) == (0, "")
    names = {"recording.csv", "track.csv", "track.geojson", "track.png", "table.txt"}
    assert {path.name for path in Path("demo").iterdir()} == names
    again = footnav.track(footnav.read("demo/recording.csv"), footnav.Config.preset("mpu6050"))
    np.testing.assert_array_equal(cells(Path("demo/track.csv"), "px", "py", "pz"), again.position)
    for line in Path("demo/table.txt").read_text().splitlines():
        assert line in result.out


@pytest.mark.slow
def test_demo_prints_the_errors_of_its_track(run):
    run("demo", "--out", "d", "--seed", 2)
    recording, truth = footnav.simulate(footnav.simulation.Route.square(10.0), seed=2)
    expected = footnav.evaluate(footnav.track(recording, footnav.Config.preset("mpu6050")), truth)
    table = Path("d/table.txt").read_text()
    rows = {line[1:35].strip(): line[35:].split() for line in table.splitlines()}
    assert float(rows["mean horizontal error"][0]) == pytest.approx(
        expected.euclidean_mean, abs=5e-4
    )
    assert float(rows["closing error, horizontal"][0]) == pytest.approx(
        expected.closing_error.horizontal, abs=5e-4
    )
    assert float(rows["closing error, vertical"][0]) == pytest.approx(
        expected.closing_error.vertical, abs=5e-4
    )
    assert float(rows["closing error, of the distance"][0]) == pytest.approx(
        expected.percent_of_distance, abs=5e-3
    )
    assert float(rows["distance"][2]) == pytest.approx(truth.distance, abs=5e-3)
    assert int(rows["strides"][1]) == len(truth.strides)


def test_demo_without_matplotlib_is_an_error(run, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert run("demo") == CommandResult(
        1, "", "footnav: matplotlib is missing: pip install footnav[plot]\n"
    )
    assert list(Path().iterdir()) == []


# footnav simulate


def test_simulate_writes_the_recording_and_the_truth(run):
    result = run(
        "simulate",
        "rectangle",
        4,
        2,
        "--seed",
        7,
        "--rate-hz",
        100,
        "--out",
        "r.npz",
        "--truth",
        "t.npz",
    )
    assert (result.status, result.err) == (0, "")
    recording, truth = footnav.simulate(
        footnav.simulation.Route.rectangle(4.0, 2.0), seed=7, rate_hz=100
    )
    np.testing.assert_array_equal(footnav.read("r.npz").accel, recording.accel)
    np.testing.assert_array_equal(load_trajectory("t.npz").position, truth.position)
    assert f"r.npz: {len(recording):,} samples" in result.out


@pytest.mark.parametrize(
    "route", ["square", "straight", "rectangle", "figure-of-eight", "out-and-back", "stairs"]
)
def test_every_route_has_a_usual_size(run, route):
    assert run("simulate", route, "--sensor", "ideal", "--rate-hz", 50).status == 0
    assert footnav.read(f"{route}.csv").rate_hz == pytest.approx(50)


# footnav info


def test_info_prints_the_remedies(run, recording):
    late = footnav.Recording(recording.t[700:], recording.accel[700:], recording.gyro[700:])
    save_recording(late, "late.csv")
    result = run("info", "late.csv", "absent.csv")
    assert result.status == 1
    assert result.err == "footnav: absent.csv does not exist\n"
    assert result.out == f"{footnav.diagnose(footnav.read('late.csv'))}\n\n"
    assert "stand still for a second or more" in result.out


def test_info_examines_both_feet(run):
    write_pair(Path("pair.csv"))
    result = run("info", "pair.csv", *RANGES)
    assert result.status == 0
    assert "pair.csv, left foot\n" in result.out
    assert "pair.csv, right foot\n" in result.out


# The process


def footnav_process(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "footnav", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def test_process_that_is_misused(tmp_path):
    process = footnav_process(tmp_path, "info", "walk.csv", "--verbatim")
    assert (process.returncode, process.stdout) == (2, "")
    assert process.stderr.count("\n") == 1
    assert "--verbatim" in process.stderr
    assert process.stderr.endswith("See: footnav info --help\n")


def test_process_without_its_file(tmp_path):
    process = footnav_process(tmp_path, "track", "absent.csv")
    assert (process.returncode, process.stdout) == (1, "")
    assert process.stderr == "footnav: absent.csv does not exist\n"


def test_process_with_one_file_of_two(walk):
    (walk.parent / "empty.csv").touch()
    process = footnav_process(walk.parent, "track", "empty.csv", "walk.csv", "--formats", "csv")
    assert (process.returncode, process.stderr) == (1, "footnav: empty.csv is empty\n")
    assert process.stdout.startswith("walk: ")
    assert (walk.parent / "walk.track.csv").exists()


@pytest.mark.slow
def test_process_with_a_closed_pipe(walk):
    command = [sys.executable, "-m", "footnav", "info", str(walk)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 1
