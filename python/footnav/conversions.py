"""Arrays as the tuples that settings hold."""

import numpy as np
from numpy.typing import ArrayLike

from footnav.settings import Matrix, Vector


def as_vector(values: ArrayLike) -> Vector:
    """Return three values as a tuple."""
    x, y, z = np.asarray(values).tolist()
    return x, y, z


def as_matrix(rows: ArrayLike) -> Matrix:
    """Return three rows of three values as tuples."""
    x, y, z = map(as_vector, np.asarray(rows))
    return x, y, z
