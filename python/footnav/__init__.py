"""Foot-mounted inertial navigation: from the IMU on a shoe to the wearer's track.

Examples
--------
>>> import footnav
>>> recording = footnav.read("walk.csv")  # doctest: +SKIP
>>> footnav.track(recording).save("track.geojson")  # doctest: +SKIP
"""

import lazy_loader

# The public names and their modules are in __init__.pyi, which type checkers and editors read too.
# A module is loaded at the first use of one of its names.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
