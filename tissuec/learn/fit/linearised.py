"""A fit near its result: how parameters follow from small changes of what was measured.

With the derivatives J, the weights W by which residuals were minimised and the rows P of
expected values, a change e of the measurements changes the parameters by
``(JᵀWJ + PᵀP)⁻¹ JᵀW e``: what the covariance follows from for any weights and any noise. (P. J.
Huber, Proc. 5th Berkeley Symp. 1:221, 1967; H. White, Econometrica 48:817, 1980.)

Singular vectors of J in units of the noise whose singular values are as good as none are
combinations that the data does not determine; those with small ones are hidden by its noise.
(A. Raue et al., Bioinformatics 25:1923, 2009, on identifiability.)
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr, svd

from tissuec.learn.fit.problem import Problem
from tissuec.model.network import Floats

ROUNDING = 1e-7  # of the largest singular value: derivatives are no better than that
VAGUE = 1.0  # standard deviation of a logarithm from which nothing is known: a factor e


class LinearisedFit(NamedTuple):
    """Derivatives at the result of a fit, and their analysis.

    Attributes:
        left: Predictions less measurements in SI units, shape (counted,).
        rows: Their derivatives, shape (counted, parameter).
        expected: Derivatives of parameters in deviations of what was expected, shape
            (prior, parameter).
        surprise: By how many of its deviations each parameter differs from that, shape
            (prior,).
        noise: Standard deviation of each fit in SI units, if white, shape (fit,).
        singular: Singular values in units of the noise, descending, shape (parameter,).
        turned: Their combinations of parameters, shape (direction, parameter).
        is_dark: Whether a direction changes nothing that was measured, shape (direction,).
        is_vague: Whether the noise hides what it changes, shape (direction,).
        directions: The others, in units of their standard deviations, shape
            (parameter, direction).
        answer: Change of the parameters with each measurement, shape (parameter, counted).
        firm: The same with each expected value, in its deviations, shape (parameter, prior).
    """

    problem: Problem
    left: Floats
    rows: Floats
    expected: Floats
    surprise: Floats
    noise: Floats
    singular: Floats
    turned: Floats
    is_dark: NDArray[np.bool_]
    is_vague: NDArray[np.bool_]
    directions: Floats
    answer: Floats
    firm: Floats

    @property
    def basis(self) -> Floats:
        """Return predictions that parameters can change, orthonormal in units of the noise.

        The shape is (counted, direction); only without expected values is it orthonormal.
        """
        return self.rows @ self.directions / self.noise[self.problem.fits][:, None]

    def with_column(self, column: Floats) -> "LinearisedFit":
        """Return the fit with a further parameter, the last.

        Args:
            column: Derivatives of the predictions by it, in SI units, shape (counted,).
        """
        rows = np.column_stack([self.rows, column])
        expected = np.column_stack([self.expected, np.zeros(len(self.expected))])
        return _solved(self.problem, self.left, rows, expected, self.surprise)


def linearised(problem: Problem, theta: Floats) -> LinearisedFit:
    """Return the fit near some parameters.

    Args:
        problem: Residuals of all experiments.
        theta: Result of the search on the whole horizon, dimensionless, shape (parameter,).
    """
    left, places = problem.left(theta), [prior.place for prior in problem.priors]
    spread = np.array([prior.spread for prior in problem.priors])
    expected = np.zeros((len(places), problem.size))
    expected[np.arange(len(places)), places] = 1.0 / spread
    surprise = (theta[places] - np.array([prior.value for prior in problem.priors])) / spread
    return _solved(problem, left, problem.derivatives(theta), expected, surprise)


def _solved(
    problem: Problem, left: Floats, rows: Floats, expected: Floats, surprise: Floats
) -> LinearisedFit:
    size = rows.shape[1]
    noise = white_noise(problem, left, size)
    own = rows / noise[problem.fits][:, None]
    _, singular, turned = svd(np.concatenate([own, expected]), full_matrices=False)
    singular = np.pad(singular, (0, size - len(singular)))
    turned = np.concatenate([turned, _completed(turned, size)])
    is_dark = singular <= ROUNDING * singular.max(initial=0.0)
    is_vague = ~is_dark & (singular * VAGUE <= 1.0)
    told = ~(is_dark | is_vague)
    directions = (turned[told] / singular[told, None]).T
    # In these directions the least squares of the fit are solved, with its own weights.
    scale = problem.scale
    weighed = np.concatenate([scale[:, None] * rows, problem.trust * expected]) @ directions
    inverse: Any = np.linalg.pinv(weighed.T @ weighed, hermitian=True)
    found = directions @ inverse @ weighed.T
    answer, firm = found[:, : len(left)] * scale, found[:, len(left) :] * problem.trust
    return LinearisedFit(
        problem, left, rows, expected, surprise, noise, singular, turned, is_dark, is_vague,
        directions, answer, firm,
    )  # fmt: skip


def white_noise(problem: Problem, left: Floats, parameters: int) -> Floats:
    """Return the standard deviation of each fit in SI units, shape (fit,).

    Those that were not given are those of the residuals, of which the parameters take a part.

    Args:
        problem: Residuals of all experiments.
        left: Predictions less measurements in SI units, shape (counted,).
        parameters: How many parameters were fitted.
    """
    total = max(len(left), 1)
    freedom = max(len(left) - parameters, 1)
    noise = np.empty(len(problem.fit_problem.fits))
    for k, fit in enumerate(problem.fit_problem.fits):
        mine = left[problem.fits == k]
        found = np.sqrt(np.sum(mine**2) / max(len(mine) * freedom / total, 1e-300))
        floor = 1e-13 * problem.spread[k]
        noise[k] = max(float(found), floor) if fit.noise is None else fit.noise
    return noise


def _completed(turned: Floats, size: int) -> Floats:
    """Return further directions, at right angles to those that there are."""
    if len(turned) == size:
        return turned[:0]
    found: Any = qr(turned.T, mode="full")
    return found[0][:, len(turned) :].T
