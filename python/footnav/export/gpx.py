"""GPX 1.1: the track with elevation and, when the start is known, time."""

from collections.abc import Sequence
from datetime import datetime, timedelta, timezone
from typing import Any, BinaryIO

from footnav.errors import ConfigError
from footnav.export.geographic import geodetic
from footnav.export.track import Track
from footnav.optional import require


def write_gpx(
    traj: Track,
    file: BinaryIO,
    *,
    origin: Sequence[float] | None = None,
    start_time: datetime | None = None,
) -> None:
    """Write one track of one segment, a point for each sample.

    `start_time` is that of the first sample.
    """
    gpx = require("gpxpy.gpx", "gpxpy")
    times = _times(traj, start_time)
    document = gpx.GPX()
    document.creator = "footnav"
    track = gpx.GPXTrack(name=traj.name or None)
    segment = gpx.GPXTrackSegment()
    document.tracks.append(track)
    track.segments.append(segment)
    for (longitude, latitude, height), time in zip(
        geodetic(traj, origin).tolist(), times, strict=True
    ):
        segment.points.append(gpx.GPXTrackPoint(latitude, longitude, elevation=height, time=time))
    file.write(document.to_xml().encode())


def _times(traj: Track, start_time: Any) -> Sequence[datetime | None]:
    if start_time is None:
        return [None] * len(traj)
    if not isinstance(start_time, datetime) or start_time.utcoffset() is None:
        raise ConfigError(
            f"start_time is {start_time!r}: expected a datetime with a time zone, such as "
            "timezone.utc"
        )
    start = start_time.astimezone(timezone.utc)
    return [start + timedelta(seconds=seconds) for seconds in (traj.t - traj.t[0]).tolist()]
