"""The noise of measurements: how large it is, and how it is correlated in time.

The errors of a fit are taken as ``σ (√(1 - ν) u + √ν w)``: u is a process whose correlation
falls by the factor ρ from row to row (that of Ornstein and Uhlenbeck), w is white, and ν is its
share. A row that is missing, or several median steps later, counts as so many rows. Components
and experiments have errors of their own with the same σ, ρ and ν.

What the residuals say of (σ, ρ, ν) is their restricted likelihood (H. D. Patterson, R.
Thompson, Biometrika 58:545, 1971): that of those combinations of measurements which the
parameters do not change. It is not biased by the parameters that were fitted, as the
correlation of residuals is. 17 rows cannot determine ρ well; so no single noise is used, but a
sample of all that the residuals allow, from a prior that is uniform in arcsin ρ and in log σ
(H. Jeffreys, Theory of Probability, 1961, for ρ of a stationary process), with a quarter for
white noise, which is common. Of several fits, each is judged with what the others tell the
parameters by their weights.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded, solve_banded
from scipy.stats import chi2

from tissuec.learn.fit.linearised import LinearisedFit
from tissuec.learn.fit.problem import Problem
from tissuec.model.network import Floats, Indices

LEAST_CORRELATED = -0.95  # correlations of neighbours are above
FARTHEST = 0.1  # rows by which 1 - ρ is divided at least, of the longest series
SHARES = ((0.0, 0.7), (0.35, 0.15), (0.7, 0.15))  # of white noise, and how likely they are
WHITE = 0.25  # how likely it is that there is no correlation
CELLS, LEVELS = 16, 5  # of the correlation, and how often these are made smaller
ENOUGH = 5.0  # cells that share what is likely: more are no better
UNLIKELY = 14.0  # below the most likely logarithm: less than a millionth
DRAWS = 2000  # of the noise
ITERATIONS = 6  # of a standard deviation, with what it changes of the parameters
MOST_CLAIMED = 1e5  # times its noise: a fit with next to no weight still contributes a bit
DEAREST = 1e8  # products for one noise; beyond, parameters take what they do of white noise
ROUNDING = 1e-13  # of data: errors are no smaller


class NoiseDraws(NamedTuple):
    """A sample of the noise of one fit, each entry as likely as the others.

    Attributes:
        size: Standard deviations [unit of the fit], shape (draw,).
        correlation: Factors of the correlation from row to row, shape (draw,).
        white: Shares of white noise, shape (draw,).
        variance: Variances of the parameters by this noise, shape (draw, parameter).
    """

    size: Floats
    correlation: Floats
    white: Floats
    variance: Floats


class Chains(NamedTuple):
    """The numbers of a fit as series in time, one after the other.

    Attributes:
        order: Their places among all counted numbers, shape (number,).
        apart: Rows since the number before in the same series; infinite for the first one of a
            series, shape (number,).
    """

    order: Indices
    apart: Floats

    @property
    def longest(self) -> int:
        """Return the most numbers in a series."""
        starts = np.append(np.flatnonzero(np.isinf(self.apart)), len(self.apart))
        return int(np.diff(starts).max(initial=1))

    def neighbours(self, correlation: float) -> Floats:
        """Return the dimensionless correlation of each number with the one before.

        The shape is (number,).
        """
        known = np.isfinite(self.apart)
        found = np.zeros(len(self.apart))
        found[known] = np.power(correlation, self.apart[known])
        return found

    def path(
        self, size: float, correlation: float, white: float, random: np.random.Generator
    ) -> Floats:
        """Return errors of such a noise, in the order of the chains, shape (number,).

        Args:
            size: Standard deviation in SI units, which are those of the errors.
            correlation: Factor from row to row.
            white: Share of white noise.
            random: Source of random numbers.
        """
        near, many = self.neighbours(correlation), len(self.order)
        drive, jitter = random.standard_normal(many), random.standard_normal(many)
        own: Floats = 1.0 / np.sqrt(1.0 - near**2)
        bands: Floats = np.stack([own, -np.append(near[1:] * own[1:], 0.0)])
        slow = solve_banded((1, 0), bands, drive)
        return size * (np.sqrt(1.0 - white) * slow + np.sqrt(white) * jitter)


class _Correlation:
    """The matrix R of a noise of standard deviation 1, by its tridiagonal parts.

    Without white noise, ``R⁻¹ = Q`` is tridiagonal; with a share ν of it
    ``R = (1 - ν) Q⁻¹ + ν``, so ``R⁻¹ = M⁻¹ Q`` with ``M = (1 - ν) + ν Q``.
    """

    def __init__(self, chains: Chains, correlation: float, white: float):
        near = chains.neighbours(correlation)
        own = 1.0 / (1.0 - near**2)
        # Upper form of SciPy: the first row is right above the diagonal.
        self._bands = np.stack([-near * own, own])
        self._bands[1, :-1] += (near**2 * own)[1:]
        self._white = white
        self.log_determinant = -float(np.log(own).sum())
        self._mixed: Any = None
        if white > 0.0:
            mixed = white * self._bands
            mixed[1] += 1.0 - white
            self._mixed = cholesky_banded(mixed)
            self.log_determinant += 2.0 * float(np.log(self._mixed[1]).sum())

    def solved(self, columns: Floats) -> Floats:
        """Return R⁻¹ times some columns, shape (number, column)."""
        above, own = self._bands[0, 1:, None], self._bands[1, :, None]
        found = own * columns
        found[:-1] += above * columns[1:]
        found[1:] += above * columns[:-1]
        return found if self._mixed is None else cho_solve_banded((self._mixed, False), found)

    def squares(self, columns: Floats) -> Floats:
        """Return aᵀRa of each column a, shape (column,)."""
        factor: Floats = cholesky_banded(self._bands)
        slow = (columns * cho_solve_banded((factor, False), columns)).sum(axis=0)
        return (1.0 - self._white) * slow + self._white * np.square(columns).sum(axis=0)


class _Cell(NamedTuple):
    """A noise that is possible.

    Attributes:
        likely: Logarithm of how likely it is, with its part of the prior.
        size: Most likely standard deviation; with ``freedom`` degrees of freedom.
        matrix: JᵀR⁻¹J, shape (direction, direction).
        slope: JᵀR⁻¹e, shape (direction,).
    """

    correlation: float
    white: float
    likely: float
    size: float
    freedom: float
    matrix: Floats
    slope: Floats


class _Fit(NamedTuple):
    """What the noise of one fit is found from.

    Attributes:
        rows: Derivatives of its predictions by the identified directions, shape
            (number, direction); None where they are too many.
        taken: How many of its numbers the parameters take, if its noise is white.
        left: Predictions less measurements, shape (number,).
        answer: Change of parameters with each measurement, shape (number, parameter).
        given: Its standard deviation, if that is known.
        floor: Standard deviation that it has at least.
    """

    chains: Chains
    rows: Floats | None
    taken: float
    left: Floats
    answer: Floats
    given: float | None
    floor: float


class _Others(NamedTuple):
    """Information from other fits and expected values about the parameters.

    Attributes:
        matrix: JᵀJ in units of standard deviations, shape (direction, direction).
        slope: Jᵀe likewise, shape (direction,).
    """

    matrix: Floats
    slope: Floats


def chains_of(problem: Problem) -> list[Chains]:
    """Return the series of each fit of a problem, as far as they count."""
    counted = problem.counted
    place = np.where(counted, np.cumsum(counted) - 1, -1)
    found = [([np.zeros(0, dtype=np.int64)], [np.zeros(0)]) for _ in problem.fit_problem.fits]
    numbers = np.arange(len(problem.data), dtype=float)
    for series in problem.of_series(numbers):
        for column in series.T.astype(np.int64):
            mine = column[counted[column]]
            if len(mine):
                order, apart = found[problem.fit_of[mine[0]]]
                order.append(place[mine])
                apart.append(_apart(problem, mine))
    return [Chains(np.concatenate(order), np.concatenate(apart)) for order, apart in found]


def _apart(problem: Problem, numbers: Indices) -> Floats:
    """Return how many rows each number of a series is after the last one, the first infinite.

    With times, a row is the median time between two; so what was measured long after counts as
    little correlated.
    """
    by_row = problem.fit_problem.axis.nodes is not None
    places = problem.rows[numbers] if by_row else problem.times[numbers]
    steps = np.diff(places.astype(float))
    usual = 1.0 if by_row or not len(steps) else float(np.median(steps)) or 1.0
    return np.append(np.inf, np.maximum(1.0, np.round(steps / usual)))


def noise_of(fit: LinearisedFit) -> list[NoiseDraws]:
    """Return a sample of the noise of each fit of a problem, by what is left of the data."""
    problem, rows = fit.problem, fit.rows @ fit.directions
    is_dear = rows.size * rows.shape[1] > DEAREST
    fits = list[_Fit]()
    for k, chains in enumerate(chains_of(problem)):
        mine, own = chains.order, rows[chains.order]
        taken = float(np.square(own / fit.noise[k]).sum())
        floor, given = ROUNDING * float(problem.spread[k]), problem.fit_problem.fits[k].noise
        known, answer = None if is_dear else own, fit.answer[:, mine].T
        fits.append(_Fit(chains, known, taken, fit.left[mine], answer, given, floor))
    random = np.random.default_rng(problem.fit_problem.seed)
    found = list[NoiseDraws]()
    for k, one in enumerate(fits):
        cells = _cells(one, _others(fit, rows, k), float(fit.noise[k]))
        found.append(_drawn(one, cells, random))
    return found


def _others(fit: LinearisedFit, rows: Floats, k: int) -> _Others:
    """Return the information about the parameters from the other fits, by their weights.

    With ``error is absolute``, a precise fit in a large unit may count for nothing. It would
    still show by how much the estimate is wrong, and make intervals wide where that is much:
    they would contain the truth too often. So each fit has the noise that its weight claims.
    """
    ahead, problem = fit.expected @ fit.directions, fit.problem
    scales = problem.scales
    claimed = np.minimum(fit.noise[k] * scales[k] / scales, MOST_CLAIMED * fit.noise)
    claimed[k] = np.inf
    own = rows / claimed[problem.fits][:, None]
    left = fit.left / claimed[problem.fits]
    return _Others(own.T @ own + ahead.T @ ahead, own.T @ left + ahead.T @ fit.surprise)


def _cells(fit: _Fit, others: _Others, size: float) -> list[_Cell]:
    """Return the noises that are possible, with smaller cells where they are likely."""
    first = np.arcsin(LEAST_CORRELATED)
    last = np.arcsin(1.0 - FARTHEST / max(fit.chains.longest, 2))
    found = [_weighed(fit, 0.0, 0.0, float(np.log(WHITE * (last - first))), others, size)]
    for white, prior in SHARES:
        low, high = (first if white == 0.0 else 0.0), last
        cells = list[_Cell]()
        for level in range(LEVELS):
            width = (high - low) / CELLS
            angles = low + width * (np.arange(CELLS) + 0.5)
            log_prior = float(np.log((1.0 - WHITE) * prior * width))
            cells = [
                _weighed(fit, float(np.sin(a)), white, log_prior, others, size) for a in angles
            ]
            likely = np.array([one.likely for one in cells])
            likely -= likely.max()
            weights = np.exp(likely)
            if weights.sum() ** 2 / np.square(weights).sum() >= ENOUGH or level == LEVELS - 1:
                break
            kept = np.flatnonzero(likely > -UNLIKELY)
            low, high = (
                max(low, angles[kept[0]] - width),
                min(high, angles[kept[-1]] + width),
            )
        found += cells
    return found


def _weighed(
    fit: _Fit, correlation: float, white: float, log_prior: float, others: _Others, size: float
) -> _Cell:
    """Return a noise with its restricted likelihood.

    The standard deviation is integrated: its square is that of χ² with as many degrees of
    freedom as there are numbers, less those that the parameters take. With other fits the
    parameters take a part only, which depends on the standard deviation and is iterated.
    """
    known, many = _Correlation(fit.chains, correlation, white), len(fit.left)
    square = float(fit.left @ known.solved(fit.left[:, None])[:, 0]) + many * fit.floor**2
    if fit.given is not None:
        size = fit.given
    if fit.rows is None:
        freedom = max(many - fit.taken, 1.0)
        size = size if fit.given is not None else float(np.sqrt(square / freedom))
        likely = -freedom * np.log(size) - 0.5 * square / size**2 - 0.5 * known.log_determinant
        none = np.zeros(0)
        return _Cell(correlation, white, log_prior + float(likely), size, freedom, none, none)
    weighed = known.solved(fit.rows)
    matrix, slope = weighed.T @ fit.rows, weighed.T @ fit.left
    move, rest, freedom = np.zeros(len(slope)), square, float(many)
    for _ in range(ITERATIONS):
        inverse = np.linalg.inv(matrix + size**2 * others.matrix)
        freedom = max(many - float(np.sum(inverse * matrix)), 1.0)
        move = -inverse @ (slope + size**2 * others.slope)
        rest = square + float(2.0 * move @ slope + move @ matrix @ move)
        before, rest = size, max(rest, many * fit.floor**2)
        if fit.given is None:
            size = float(np.sqrt(rest / freedom))
        if abs(size - before) <= 1e-3 * size:
            break
    bound = float(move @ others.matrix @ move + 2.0 * move @ others.slope)
    determinant = float(np.linalg.slogdet(matrix / size**2 + others.matrix)[1])
    misfit = rest / size**2 + bound + known.log_determinant + determinant
    likely = log_prior - 0.5 * misfit - many * float(np.log(size))
    return _Cell(correlation, white, likely, size, freedom, matrix, slope)


def _drawn(fit: _Fit, cells: Sequence[_Cell], random: np.random.Generator) -> NoiseDraws:
    """Return a sample of some noises; it is stratified, so that it scatters little."""
    likely = np.array([one.likely for one in cells])
    weights = np.exp(likely - likely.max())
    steps = (np.arange(DRAWS) + 0.5) / DRAWS
    shares = np.cumsum(weights) / weights.sum()
    chosen: Indices = np.searchsorted(shares, steps).clip(max=len(cells) - 1)
    order = random.permutation(DRAWS)
    chosen = chosen[order]
    size = np.array([one.size for one in cells])[chosen]
    if fit.given is None:
        freedom = np.array([one.freedom for one in cells])[chosen]
        size = size * np.sqrt(freedom / chi2.ppf(random.permutation(steps), freedom))
    variance = np.zeros((len(cells), fit.answer.shape[1]))
    for k in map(int, np.unique(chosen)):
        known = _Correlation(fit.chains, cells[k].correlation, cells[k].white)
        variance[k] = known.squares(fit.answer)
    return NoiseDraws(
        size,
        np.array([one.correlation for one in cells])[chosen],
        np.array([one.white for one in cells])[chosen],
        size[:, None] ** 2 * variance[chosen],
    )
