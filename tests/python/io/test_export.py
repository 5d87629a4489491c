"""Files of a track, read back by other readers than footnav's own."""

import csv
import dataclasses
import io
import json
import sys
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import gpxpy
import numpy as np
import pyarrow.feather
import pyarrow.parquet
import pytest
from hypothesis import given, settings
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from analytic_tracks import COLUMNS, HEALTH, assert_same, walk
from footnav.errors import ConfigError, DataError, FootnavError, FootnavWarning
from footnav.export import save
from footnav.files import replacing
from footnav.trajectory import Trajectory, load_trajectory

ORIGIN = (43.66, -79.39, 100.0)
SUFFIXES = [".csv", ".npz", ".tum", ".geojson", ".gpx", ".kml", ".parquet", ".feather"]
GEOGRAPHIC = [".geojson", ".gpx", ".kml"]


@pytest.fixture
def traj() -> Trajectory:
    """Five strides with all that a track can carry."""
    return dataclasses.replace(walk(5, name="a <walk> & é", origin=ORIGIN), health=HEALTH)


def enu_of(longitude: Any, latitude: Any, height: Any) -> Any:
    """East, north, up of `ORIGIN` by way of Earth-centred coordinates, WGS-84."""

    def ecef(lat: Any, lon: Any, h: Any) -> Any:
        a, f = 6378137.0, 1 / 298.257223563
        lat, lon = np.radians(lat), np.radians(lon)
        e2 = f * (2 - f)
        n = a / np.sqrt(1 - e2 * np.sin(lat) ** 2)
        return np.array(
            [
                (n + h) * np.cos(lat) * np.cos(lon),
                (n + h) * np.cos(lat) * np.sin(lon),
                (n * (1 - e2) + h) * np.sin(lat),
            ]
        )

    lat0, lon0 = np.radians(ORIGIN[:2])
    delta = ecef(latitude, longitude, height) - ecef(*ORIGIN)[:, None]
    east = [-np.sin(lon0), np.cos(lon0), 0]
    north = [-np.sin(lat0) * np.cos(lon0), -np.sin(lat0) * np.sin(lon0), np.cos(lat0)]
    up = [np.cos(lat0) * np.cos(lon0), np.cos(lat0) * np.sin(lon0), np.sin(lat0)]
    return (np.array([east, north, up]) @ delta).T


def read_csv(path: Path) -> tuple[list[str], Any]:
    """Header and numbers."""
    with path.open(newline="") as file:
        header, *rows = csv.reader(file)
    return header, np.array(rows, float)


def test_csv_holds_every_digit(traj: Trajectory, tmp_path: Path) -> None:
    """Reading the text gives back the same numbers, to the bit."""
    dataclasses.replace(traj, origin=None).save(tmp_path / "walk.csv")
    header, rows = read_csv(tmp_path / "walk.csv")
    assert ",".join(header) == "t,px,py,pz,vx,vy,vz,qx,qy,qz,qw,zero_velocity,std_x,std_y,std_z"
    parts = [
        traj.t,
        traj.position,
        traj.velocity,
        traj.quaternion,
        traj.zero_velocity,
        traj.position_std,
    ]
    np.testing.assert_array_equal(rows, np.column_stack(parts))


@pytest.mark.parametrize("frame", ["enu", "ned"])
def test_csv_has_geodetic_positions_where_they_are_known(
    traj: Trajectory, tmp_path: Path, frame: str
) -> None:
    """Latitude, longitude and height, whatever the frame of the rest.

    None where x may not be east.
    """
    traj.save(tmp_path / "walk.csv", frame=frame)
    header, rows = read_csv(tmp_path / "walk.csv")
    assert header[15:] == ["latitude_deg", "longitude_deg", "height"]
    np.testing.assert_array_equal(rows[:, 15:], traj.geodetic())
    replace(traj, heading_known=False).save(tmp_path / "turned.csv")
    assert "height" not in read_csv(tmp_path / "turned.csv")[0]


def test_geodetic_is_the_inverse_of_local_coordinates(traj: Trajectory) -> None:
    """Latitude first, and the origin that is given counts."""
    latitude, longitude, height = replace(traj, origin=(1.0, 2.0, 3.0)).geodetic(ORIGIN).T
    np.testing.assert_allclose(enu_of(longitude, latitude, height), traj.position, atol=1e-4)
    assert traj[:1].geodetic().shape == (1, 3)
    assert traj[:0].geodetic().shape == (0, 3)


def test_geodetic_without_origin_or_heading_is_reported(traj: Trajectory) -> None:
    """An origin, a possible one, and a heading."""
    with pytest.raises(
        ConfigError, match=r"no origin: set output\.origin in the configuration, or geodetic\(\("
    ):
        replace(traj, origin=None).geodetic()
    with pytest.raises(ConfigError, match="latitude is 91"):
        traj.geodetic((91, 0, 0))
    with pytest.warns(FootnavWarning, match=r"alignment\.heading_deg") as warned:
        replace(traj, heading_known=False).geodetic()
    assert warned[0].filename == __file__


@given(position=arrays(np.float64, (3, 3)))
@settings(max_examples=50, deadline=None)
def test_any_number_round_trips_through_csv(
    position: Any, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Denormals, infinities and nan too."""
    path = tmp_path_factory.mktemp("csv") / "walk.csv"
    dataclasses.replace(walk(2)[:3], position=position).save(path)
    np.testing.assert_array_equal(read_csv(path)[1][:, 1:4], position)


def test_ned_is_a_rotation_of_the_vectors(traj: Trajectory, tmp_path: Path) -> None:
    """Vectors in ENU have the same direction in NED, in the sensor frame as well."""
    mounting = Rotation.from_euler("xyz", [0.3, -0.7, 1.1])
    traj = dataclasses.replace(
        traj, quaternion=(Rotation.from_quat(traj.quaternion) * mounting).as_quat()
    )
    traj.save(tmp_path / "walk.csv", frame="ned")
    header, rows = read_csv(tmp_path / "walk.csv")
    assert header[1:7] == ["pn", "pe", "pd", "vn", "ve", "vd"]
    assert header[12:15] == ["std_n", "std_e", "std_d"]
    to_ned = Rotation.from_matrix([[0, 1, 0], [1, 0, 0], [0, 0, -1]])
    np.testing.assert_allclose(rows[:, 1:4], to_ned.apply(traj.position.copy()), atol=1e-12)
    np.testing.assert_allclose(rows[:, 4:7], to_ned.apply(traj.velocity.copy()), atol=1e-12)
    np.testing.assert_array_equal(rows[:, 12:15], traj.position_std[:, [1, 0, 2]])
    axes = Rotation.from_quat(traj.quaternion).as_matrix()
    np.testing.assert_allclose(
        Rotation.from_quat(rows[:, 7:11]).as_matrix(), to_ned.as_matrix() @ axes, atol=1e-12
    )


@pytest.mark.parametrize("suffix", [".csv", ".tum"])
def test_frame_of_the_track_is_the_default(traj: Trajectory, tmp_path: Path, suffix: str) -> None:
    """A track set to NED is written in NED, and an option overrides it."""
    ned = dataclasses.replace(traj, frame="ned")
    a, b, c, d = (tmp_path / (name + suffix) for name in "abcd")
    ned.save(a)
    traj.save(b, frame="ned")
    ned.save(c, frame="enu")
    traj.save(d)
    assert a.read_bytes() == b.read_bytes() != c.read_bytes() == d.read_bytes()


def test_npz_round_trip_is_exact(traj: Trajectory, tmp_path: Path) -> None:
    """All arrays to the bit, and everything else, without pickle."""
    traj = dataclasses.replace(traj, frame="ned")
    traj.save(tmp_path / "walk.npz")
    back = load_trajectory(tmp_path / "walk.npz")
    assert_same(back, traj)
    assert back.health == HEALTH
    bare = walk(2)[:0]
    bare.save(tmp_path / "bare.npz")
    assert_same(load_trajectory(tmp_path / "bare.npz"), bare)


def test_npz_that_is_none_is_named(tmp_path: Path) -> None:
    """Missing, text, another archive, and one with pickled objects."""
    (tmp_path / "text.npz").write_text("t,px\n")
    np.savez(tmp_path / "other.npz", t=np.arange(3.0))
    pickled: dict[str, Any] = {column: np.array([{}]) for column in COLUMNS}
    np.savez(tmp_path / "pickled.npz", about=np.array("{}"), **pickled)
    for name in ("missing.npz", "text.npz", "other.npz", "pickled.npz"):
        with pytest.raises(DataError, match=name):
            load_trajectory(tmp_path / name)


def test_tum_has_the_format_of_the_benchmark(traj: Trajectory, tmp_path: Path) -> None:
    """Blank-separated stamp, position and quaternion, scalar last."""
    traj.save(tmp_path / "walk.tum")
    rows = np.loadtxt(tmp_path / "walk.tum")
    np.testing.assert_array_equal(rows, np.column_stack([traj.t, traj.position, traj.quaternion]))


def test_parquet_holds_the_columns(traj: Trajectory, tmp_path: Path) -> None:
    """Names as in the CSV, numbers to the bit, flags as bool."""
    traj.save(tmp_path / "walk.parquet", frame="ned")
    traj.save(tmp_path / "walk.csv", frame="ned")
    table = pyarrow.parquet.read_table(tmp_path / "walk.parquet")
    header, rows = read_csv(tmp_path / "walk.csv")
    assert table.column_names == header
    assert table["zero_velocity"].type == "bool"
    np.testing.assert_array_equal(
        np.column_stack([table[name].to_numpy() for name in header]), rows
    )


@pytest.mark.parametrize("frame", ["enu", "ned"])
def test_feather_holds_the_table_of_parquet(traj: Trajectory, tmp_path: Path, frame: str) -> None:
    """Names, types and numbers, to the bit."""
    traj.save(tmp_path / "walk.feather", frame=frame)
    traj.save(tmp_path / "walk.parquet", frame=frame)
    table = pyarrow.feather.read_table(tmp_path / "walk.feather")
    assert table.equals(pyarrow.parquet.read_table(tmp_path / "walk.parquet"))
    assert len(table) == len(traj)


def coordinates(path: Path) -> Any:
    """Longitude, latitude, height of the line in a geographic file, (n, 3)."""
    if path.suffix == ".geojson":
        return np.array(json.loads(path.read_text())["features"][0]["geometry"]["coordinates"])
    if path.suffix == ".gpx":
        points = gpxpy.parse(path.read_text()).tracks[0].segments[0].points
        return np.array([[p.longitude, p.latitude, p.elevation] for p in points])
    line = ET.parse(path).find(".//{*}LineString/{*}coordinates")
    assert line is not None
    assert line.text is not None
    return np.array([place.split(",") for place in line.text.split()], float)


@pytest.mark.parametrize("suffix", GEOGRAPHIC)
def test_places_on_earth(traj: Trajectory, tmp_path: Path, suffix: str) -> None:
    """Going back from the file to metres gives the track, whichever way the origin was given."""
    path = tmp_path / f"walk{suffix}"
    traj.save(path)
    np.testing.assert_allclose(enu_of(*coordinates(path).T), traj.position, atol=1e-4)
    whole = path.read_bytes()
    dataclasses.replace(traj, origin=(1.0, 2.0, 3.0)).save(path, origin=ORIGIN)
    assert path.read_bytes() == whole


@pytest.mark.parametrize("suffix", GEOGRAPHIC)
def test_missing_origin_is_reported(traj: Trajectory, tmp_path: Path, suffix: str) -> None:
    """Latitude 0, longitude 0 is assumed, with a warning that names the remedy."""
    path = tmp_path / f"walk{suffix}"
    with pytest.warns(FootnavWarning, match=r"output\.origin .*save\(\.\.\., origin="):
        dataclasses.replace(traj, origin=None).save(path)
    np.testing.assert_allclose(coordinates(path)[0], 0, atol=1e-9)


@pytest.mark.parametrize("suffix", [".geojson", ".gpx", ".kml"])
def test_unknown_heading_is_reported(traj: Trajectory, tmp_path: Path, suffix: str) -> None:
    """A map of a track whose x axis is not east is turned."""
    turned = replace(traj, heading_known=False)
    with pytest.warns(FootnavWarning, match=r"alignment\.heading_deg"):
        turned.save(tmp_path / f"walk{suffix}", origin=(45.0, 7.0, 0.0))


@pytest.mark.parametrize("suffix", GEOGRAPHIC)
def test_impossible_origin_is_refused(traj: Trajectory, tmp_path: Path, suffix: str) -> None:
    """And no file is left."""
    with pytest.raises(ConfigError, match="latitude is 91"):
        traj.save(tmp_path / f"walk{suffix}", origin=(91, 0, 0))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", GEOGRAPHIC)
def test_a_line_needs_two_finite_points(traj: Trajectory, tmp_path: Path, suffix: str) -> None:
    """Too short a track, or one with nan, has no place on a map."""
    with pytest.raises(DataError, match="needs two samples"):
        traj[:1].save(tmp_path / f"walk{suffix}")
    position = traj.position.copy()
    position[5, 1] = np.nan
    with pytest.raises(DataError, match="row 5: position is"):
        dataclasses.replace(traj, position=position).save(tmp_path / f"walk{suffix}")


def test_geojson_is_a_feature_collection(traj: Trajectory, tmp_path: Path) -> None:
    """A line with the summary, points for the ends, and for the stances on demand."""
    traj.save(tmp_path / "walk.geojson", stances=True)
    collection = json.loads((tmp_path / "walk.geojson").read_text())
    line, *points = collection["features"]
    assert collection["type"] == "FeatureCollection"
    assert line["properties"]["name"] == traj.name
    assert line["properties"]["distance"] == traj.distance
    assert [p["properties"]["kind"] for p in points] == ["start", "end", *["stance"] * 6]
    assert points[1]["geometry"]["coordinates"] == line["geometry"]["coordinates"][-1]
    traj.save(tmp_path / "walk.geojson")
    assert len(json.loads((tmp_path / "walk.geojson").read_text())["features"]) == 3


def test_geojson_has_null_for_what_is_unknown(traj: Trajectory, tmp_path: Path) -> None:
    """JSON has no nan."""
    still = dataclasses.replace(traj, zero_velocity=np.zeros(len(traj), bool))
    still.save(tmp_path / "walk.geojson")
    text = (tmp_path / "walk.geojson").read_text()
    assert "NaN" not in text
    assert json.loads(text)["features"][0]["properties"]["stride_length"] is None


def test_gpx_carries_time_when_the_start_is_known(traj: Trajectory, tmp_path: Path) -> None:
    """Stamps count from the first sample, in UTC; without a start there are none."""
    start = datetime(2024, 5, 6, 9, 8, 7, tzinfo=timezone(timedelta(hours=2)))
    late = dataclasses.replace(traj, t=traj.t + 1000)
    late.save(tmp_path / "walk.gpx", start_time=start)
    points = gpxpy.parse((tmp_path / "walk.gpx").read_text()).tracks[0].segments[0].points
    elapsed = [(p.time - start).total_seconds() for p in points if p.time]
    np.testing.assert_allclose(elapsed, traj.t, atol=1e-6)
    assert "07:08:07Z" in (tmp_path / "walk.gpx").read_text()
    traj.save(tmp_path / "walk.gpx")
    assert "<time>" not in (tmp_path / "walk.gpx").read_text()


@pytest.mark.parametrize("start", [datetime(2024, 5, 6), "2024-05-06", 0])
def test_start_time_needs_a_zone(traj: Trajectory, tmp_path: Path, start: Any) -> None:
    """A wall clock of nowhere is refused."""
    with pytest.raises(ConfigError, match="start_time is"):
        traj.save(tmp_path / "walk.gpx", start_time=start)


def test_kml_follows_the_order_of_its_schema(traj: Trajectory, tmp_path: Path) -> None:
    """Readers that validate want tessellate, altitudeMode, coordinates; names are escaped."""
    traj.save(tmp_path / "walk.kml")
    root = ET.parse(tmp_path / "walk.kml").getroot()
    line = root.find(".//{*}LineString")
    assert root.tag == "{http://www.opengis.net/kml/2.2}kml"
    assert root.findtext("{*}Document/{*}name") == traj.name
    assert line is not None
    assert [child.tag.partition("}")[2] for child in line] == [
        "tessellate",
        "altitudeMode",
        "coordinates",
    ]
    assert [
        p.findtext("{*}name") for p in root.iter("{http://www.opengis.net/kml/2.2}Placemark")
    ] == [
        "track",
        "start",
        "end",
    ]


def test_unknown_suffix_names_the_known_ones(traj: Trajectory, tmp_path: Path) -> None:
    """Case does not matter, the suffix does."""
    with pytest.raises(ConfigError, match=r"unknown suffix '\.xlsx', expected one of \.csv, \.npz"):
        traj.save(tmp_path / "walk.xlsx")
    traj.save(tmp_path / "WALK.CSV")
    assert (tmp_path / "WALK.CSV").exists()


@pytest.mark.parametrize(
    ("suffix", "option", "hint"),
    [(".csv", "fram", "did you mean 'frame'"), (".npz", "frame", "no options")],
)
def test_options_that_do_not_apply_are_refused(
    traj: Trajectory, tmp_path: Path, suffix: str, option: str, hint: str
) -> None:
    """Nothing is ignored in silence."""
    with pytest.raises(ConfigError, match=hint):
        traj.save(tmp_path / f"walk{suffix}", **{option: "ned"})


@pytest.mark.parametrize("frame", ["NED", "xyz", ""])
def test_unknown_frame_is_refused(traj: Trajectory, tmp_path: Path, frame: str) -> None:
    """And no file is left."""
    with pytest.raises(ConfigError, match="expected 'enu' or 'ned'"):
        traj.save(tmp_path / "walk.csv", frame=frame)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".tum", ".parquet", ".feather"])
def test_empty_track_is_an_empty_table(tmp_path: Path, suffix: str) -> None:
    """A stream that has not begun can be saved."""
    save(walk(2)[:0], tmp_path / f"walk{suffix}")
    assert (tmp_path / f"walk{suffix}").exists()


class FullDisk(io.FileIO):
    """A file that has room for 100 bytes, then fails."""

    error: BaseException = OSError(28, "No space left on device")

    def write(self, data: Any) -> int:
        """Write what fits."""
        if self.tell() + len(data) > 100:
            super().write(bytes(data)[: 100 - self.tell()])
            raise self.error
        return super().write(data)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize(
    "error", [OSError(28, "No space left on device"), KeyboardInterrupt(), ValueError("bug")]
)
def test_old_file_is_unchanged_after_a_failure(
    traj: Trajectory,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    suffix: str,
    error: BaseException,
) -> None:
    """A full disk, an interrupt or a bug midway leave what was there, and nothing beside it."""
    path = tmp_path / f"walk{suffix}"
    path.write_text("old")
    monkeypatch.setattr(FullDisk, "error", error)
    monkeypatch.setattr(Path, "open", lambda self, mode: FullDisk(self, mode))
    with pytest.raises(FootnavError if isinstance(error, OSError) else type(error)) as caught:
        traj.save(path)
    monkeypatch.undo()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
    if isinstance(error, OSError):
        assert str(path) in str(caught.value)


def test_writer_that_fails_midway_leaves_nothing(tmp_path: Path) -> None:
    """Bytes that were written before the failure are gone."""
    path = tmp_path / "walk.csv"

    def interrupted() -> None:
        with replacing(path) as file:
            file.write(b"half")
            file.flush()
            assert len(list(tmp_path.iterdir())) == 1
            raise RuntimeError("midway")

    with pytest.raises(RuntimeError, match="midway"):
        interrupted()
    assert not list(tmp_path.iterdir())


def no_folder(folder: Path) -> Path:
    """Name a file in a folder that does not exist."""
    return folder / "missing" / "walk.csv"


def file_as_folder(folder: Path) -> Path:
    """Name a file below another file."""
    (folder / "file").write_text("")
    return folder / "file" / "walk.csv"


def folder_as_file(folder: Path) -> Path:
    """Name a folder."""
    (folder / "walk.csv").mkdir()
    return folder / "walk.csv"


@pytest.mark.parametrize("place", [no_folder, file_as_folder, folder_as_file])
def test_place_that_cannot_be_written_is_named(
    traj: Trajectory, tmp_path: Path, place: Callable[[Path], Path]
) -> None:
    """The message has the path and the reason, and no temporary file stays."""
    path = place(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(FootnavError, match=r"walk\.csv: cannot be written: "):
        traj.save(path)
    assert sorted(tmp_path.rglob("*")) == before


def test_folder_without_permission_is_named(
    traj: Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Simulated, since the superuser may write anywhere."""

    def denied(*_: Any, **__: Any) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", denied)
    with pytest.raises(FootnavError, match=r"walk\.csv: cannot be written: Permission denied"):
        traj.save(tmp_path / "walk.csv")


def test_permissions_and_links_are_kept(traj: Trajectory, tmp_path: Path) -> None:
    """Permissions of a file stay, and a link still points at its target."""
    target, link = tmp_path / "target.csv", tmp_path / "link.csv"
    target.write_text("old")
    target.chmod(0o600)
    link.symlink_to(target)
    traj.save(link)
    assert link.is_symlink()
    assert target.stat().st_mode & 0o777 == 0o600
    assert target.read_text().startswith("t,px")


@pytest.mark.parametrize(
    ("module", "suffix", "cure"),
    [
        ("pyarrow", ".parquet", r"footnav\[parquet\]"),
        ("pyarrow", ".feather", r"footnav\[parquet\]"),
        ("pyarrow.feather", ".feather", r"footnav\[parquet\]"),
        ("gpxpy.gpx", ".gpx", "gpxpy"),
        ("pymap3d", ".kml", "pymap3d"),
    ],
)
def test_missing_library_names_its_cure(
    traj: Trajectory,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    module: str,
    suffix: str,
    cure: str,
) -> None:
    """The message is a command that helps."""
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(FootnavError, match=f"pip install {cure}"):
        traj.save(tmp_path / f"walk{suffix}")
    assert not list(tmp_path.iterdir())
