"""KML 2.2: the track as a line on the ground, for globe viewers."""

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from typing import BinaryIO

from footnav.export.geographic import geodetic
from footnav.export.track import Track

_NAMESPACE = "http://www.opengis.net/kml/2.2"


def write_kml(traj: Track, file: BinaryIO, *, origin: Sequence[float] | None = None) -> None:
    """Write the line and its two ends.

    The coordinates have heights but are drawn on the ground: globe viewers hide points below their
    terrain.
    """
    places = geodetic(traj, origin).tolist()
    root = ET.Element("kml", xmlns=_NAMESPACE)
    document = ET.SubElement(root, "Document")
    ET.SubElement(document, "name").text = traj.name or "track"
    _placemark(document, "track", "LineString", places)
    _placemark(document, "start", "Point", places[:1])
    _placemark(document, "end", "Point", places[-1:])
    ET.ElementTree(root).write(file, encoding="utf-8", xml_declaration=True)


def _placemark(document: ET.Element, name: str, geometry: str, places: list[list[float]]) -> None:
    placemark = ET.SubElement(document, "Placemark")
    ET.SubElement(placemark, "name").text = name
    shape = ET.SubElement(placemark, geometry)
    if geometry == "LineString":
        ET.SubElement(shape, "tessellate").text = "1"
    ET.SubElement(shape, "altitudeMode").text = "clampToGround"
    ET.SubElement(shape, "coordinates").text = " ".join(
        f"{lon!r},{lat!r},{height!r}" for lon, lat, height in places
    )
