"""Files of a track: one module a format, written whole or not at all."""

from footnav.export.save import save

__all__ = ["save"]
