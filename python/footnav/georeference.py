"""Relation of the navigation frame to the Earth, as the settings state it."""

from footnav.config import Config
from footnav.geodesy import Georeference


def georeference(config: Config) -> Georeference:
    """Return origin, frame of the tables and knowledge of the heading that the settings state."""
    output, alignment = config.output, config.alignment
    heading_known = alignment.heading_deg is not None or alignment.magnetic_field is not None
    return Georeference(output.origin, output.frame, heading_known)
