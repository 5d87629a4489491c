"""Least squares that outliers do not spoil, with the standard deviation of every parameter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from footnav.errors import NumericalError
from footnav.recording import Floats

OUTLIER = 3.0
"""Residual, in standard deviations, from which on its weight falls."""


@dataclass(frozen=True, slots=True)
class Fit:
    """What a fit found.

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
    """Find the parameters that make residuals small.

    A sum of absolute values tells the outliers, whose weight then falls as Huber's does (scipy's
    `least_squares`).  The standard deviations that are given are enlarged, all by the same factor,
    where the residuals turn out larger: by their median, to set the limit of an outlier, and by
    chi-square in the end.

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
        The search did not converge, or the residuals say nothing of some parameter.
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
    """Return how far residuals scatter, in standard deviations; a fit of absolute values meets some of them exactly."""
    others = np.sort(np.abs(deviations))[parameters:]
    return max(1.0, 1.4826 * float(np.median(others))) if len(others) else 1.0


def _jacobian(function: Callable[[Floats], Floats], at: Floats) -> Floats:
    """Return central differences; those of a robust loss are already weighted."""
    step = 1e-6 * np.maximum(np.abs(at), 1e-2)
    columns = [(function(at + d) - function(at - d)) / (2 * d.sum()) for d in np.diag(step)]
    return np.column_stack(columns)


def _condition(jacobian: Floats) -> float:
    lengths = np.linalg.norm(jacobian, axis=0)
    if not lengths.all():
        return float("inf")
    return float(np.linalg.cond(jacobian / lengths))
