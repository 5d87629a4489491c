"""Files of a track: one module for each format, written atomically."""

from footnav.export.save import save

__all__ = ["save"]
