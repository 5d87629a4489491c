"""Arrays as the tuples that settings hold."""

import numpy as np

from footnav.config import Matrix, Vector
from footnav.recording import Floats


def as_vector(values: Floats) -> Vector:
    """Return three values as a tuple."""
    x, y, z = np.asarray(values).tolist()
    return x, y, z


def as_matrix(rows: Floats) -> Matrix:
    """Return three rows of three values as tuples."""
    x, y, z = map(as_vector, rows)
    return x, y, z
