"""Robust least squares with the standard deviation of every parameter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from footnav.errors import NumericalError
from footnav.recording import Floats

OUTLIER = 3.0
"""Residual, in standard deviations, beyond which its weight decreases."""


@dataclass(frozen=True, slots=True)
class Fit:
    """Result of a fit.

    Attributes
    ----------
    parameters : ndarray, shape (p,)
        The parameters.
    covariance : ndarray, shape (p, p)
        Their covariance.
    residual : float
        Weighted root mean square of the residuals, in their own unit.
    condition : float
        Condition number of the Jacobian with its columns scaled to length one.
    """

    parameters: Floats
    covariance: Floats
    residual: float
    condition: float

    @property
    def std(self) -> Floats:
        """Standard deviation of each parameter, shape (p,)."""
        return np.sqrt(np.diag(self.covariance))


def fit(residuals: Callable[[Floats], Floats], start: Floats, std: Floats) -> Fit:
    """Find the parameters with the smallest residuals.

    A soft L1 fit identifies the outliers, whose weight is then that of Huber (scipy's
    `least_squares`).  The given standard deviations are inflated by a common factor where the
    residuals are larger: by their median for the limit of an outlier, and by chi-square for the
    covariance.

    Parameters
    ----------
    residuals : callable
        Residuals, shape (m,), of parameters, shape (p,).
    start : ndarray, shape (p,)
        Parameters to start from.
    std : ndarray, shape (m,)
        Standard deviations of the residuals, larger than zero.

    Returns
    -------
    Fit

    Raises
    ------
    NumericalError
        The search did not converge.
    """
    from scipy.optimize import least_squares

    def standardized(parameters: Floats) -> Floats:
        return residuals(parameters) / std

    rough = least_squares(standardized, start, method="lm", x_scale="jac")
    absolute = least_squares(standardized, rough.x, loss="soft_l1", x_scale="jac")
    inflation = _inflation(absolute.fun, len(start))
    found = least_squares(
        standardized, absolute.x, loss="huber", f_scale=OUTLIER * inflation, x_scale="jac"
    )
    if not (found.success and np.isfinite(found.x).all()):
        raise NumericalError(f"the fit did not converge: {found.message}")
    weight = np.minimum(1.0, OUTLIER * inflation / np.maximum(np.abs(found.fun), 1e-300))
    jacobian = np.sqrt(weight)[:, None] * _jacobian(standardized, found.x)
    squares = float((weight * found.fun**2).sum())
    spare = max(len(found.fun) - len(found.x), 1)
    covariance = np.linalg.pinv(jacobian.T @ jacobian) * max(1.0, squares / spare)
    return Fit(
        parameters=found.x,
        covariance=covariance,
        residual=float(np.sqrt((weight * (found.fun * std) ** 2).mean())),
        condition=_condition(jacobian),
    )


def _inflation(deviations: Floats, parameters: int) -> float:
    """Return the scatter of the residuals in standard deviations.

    A fit of absolute values makes some of them zero.
    """
    others = np.sort(np.abs(deviations))[parameters:]
    return max(1.0, 1.4826 * float(np.median(others))) if len(others) else 1.0


def _jacobian(function: Callable[[Floats], Floats], at: Floats) -> Floats:
    """Return central differences; the Jacobian of a robust loss is already weighted."""
    step = 1e-6 * np.maximum(np.abs(at), 1e-2)
    columns = [(function(at + d) - function(at - d)) / (2 * d.sum()) for d in np.diag(step)]
    return np.column_stack(columns)


def _condition(jacobian: Floats) -> float:
    lengths = np.linalg.norm(jacobian, axis=0)
    if not lengths.all():
        return float("inf")
    return float(np.linalg.cond(jacobian / lengths))
