"""GeoJSON (RFC 7946): the track as a line, with points for start, end and stances."""

import json
from collections.abc import Sequence
from typing import Any, BinaryIO

import numpy as np

from footnav.export.geographic import geodetic
from footnav.export.track import Track
from footnav.strides import find_stances
from footnav.summary import Summary


def write_geojson(
    traj: Track,
    file: BinaryIO,
    *,
    origin: Sequence[float] | None = None,
    stances: bool = False,
) -> None:
    """Write a FeatureCollection; the line has the summary in SI units, each point its stamp."""
    places = geodetic(traj, origin).tolist()
    features = [
        _feature("LineString", places, _properties(traj.summary())),
        _feature("Point", places[0], {"kind": "start", "t": float(traj.t[0])}),
        _feature("Point", places[-1], {"kind": "end", "t": float(traj.t[-1])}),
    ]
    if stances:
        first, last = find_stances(traj.t, traj.zero_velocity)
        middle = (first + last) // 2
        features += [
            _feature("Point", places[k], {"kind": "stance", "t": float(traj.t[k])}) for k in middle
        ]
    collection = {"type": "FeatureCollection", "features": features}
    file.write(json.dumps(collection, allow_nan=False).encode())


def _feature(geometry: str, coordinates: list[Any], properties: dict[str, Any]) -> dict[str, Any]:
    return {
        "type": "Feature",
        "geometry": {"type": geometry, "coordinates": coordinates},
        "properties": properties,
    }


def _properties(summary: Summary) -> dict[str, Any]:
    """Numbers of the summary; null for those that are unknown, since JSON has no nan."""
    numbers = {
        "samples": summary.samples,
        "duration": summary.duration,
        "distance": summary.distance,
        "strides": summary.strides,
        "stride_length": summary.stride_length,
        "cadence": summary.cadence,
        "closing_horizontal": summary.closing.horizontal,
        "closing_vertical": summary.closing.vertical,
        "horizontal_std": summary.horizontal_std,
        "vertical_std": summary.vertical_std,
    }
    known = {key: number if np.isfinite(number) else None for key, number in numbers.items()}
    return {"kind": "track", "name": summary.name, **known}
