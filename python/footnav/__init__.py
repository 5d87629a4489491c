"""Foot-mounted inertial navigation: from the IMU on a shoe to the wearer's track.

Examples
--------
>>> import footnav
>>> recording = footnav.read("walk.csv")  # doctest: +SKIP
>>> footnav.track(recording).save("track.geojson")  # doctest: +SKIP
"""

import lazy_loader

# What footnav offers, and where it comes from, stands in __init__.pyi, which type checkers and
# editors read too.  A module is loaded when one of its names is first used.
_name, _, __all__ = lazy_loader.attach_stub(__name__, __file__)
_module, _, _modules = lazy_loader.attach(
    __name__,
    submodules=[
        "calibration",
        "config",
        "detection",
        "detectors",
        "diagnosis",
        "errors",
        "evaluation",
        "export",
        "health",
        "io",
        "many",
        "mpu6050",
        "navigator",
        "noise",
        "recording",
        "simulation",
        "protocols",
        "strides",
        "stillness",
        "tracking",
        "trajectory",
    ],
)


def __getattr__(name: str) -> object:
    return _module(name) if name in _modules else _name(name)


def __dir__() -> list[str]:
    return sorted([*__all__, *_modules])
