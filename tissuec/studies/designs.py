"""Designs: the values of all factors for each run.

Random designs fill the unit cube by ``scipy.stats.qmc``, and each factor turns its part into a
value by the inverse of its distribution function. Points depend on the seed alone.
"""

from collections.abc import Callable, Sequence
from itertools import product
from typing import Any

import numpy as np

from tissuec.core.errors import TissueError, counted
from tissuec.model.network import Floats
from tissuec.scene.study.entries import GRID, INDICES, LATIN, LIST, ONE_AT_A_TIME, SOBOL
from tissuec.scene.study.factors import rounded
from tissuec.scene.study.model import Cell, Distribution, Factor, Levels, Study, called

MOST_RUNS = 10_000_000

#: Values of the factors of one run; None where the scene has its own.
Point = tuple[Cell | None, ...]


def points_of(study: Study) -> list[Point]:
    """Return the values of the factors for every run, in order.

    Raises:
        TissueError: There are too many runs.
    """
    count = run_count(study)
    if count > MOST_RUNS:
        hint = "use fewer steps, or a random design such as latin hypercube"
        raise TissueError(f"{called(study.name)} has {counted(count, 'run')}; {hint}")
    if study.rows is not None:
        return list(study.rows)
    return _DESIGNS[study.design](study)


def run_count(study: Study) -> int:
    """Return the number of runs of a study."""
    if study.rows is not None:
        return len(study.rows)
    lengths = [len(_levels(factor)) for factor in study.factors if _is_listed(factor)]
    match study.design:
        case "grid":
            return int(np.prod(lengths, dtype=object))
        case "list":
            return lengths[0]
        case "one at a time":
            return 1 + sum(lengths)
        case "sobol indices":
            return study.settings.runs * (len(study.factors) + 2)
        case _:
            return study.settings.runs


def _is_listed(factor: Factor) -> bool:
    return isinstance(factor.spread, Levels)


def _levels(factor: Factor) -> Sequence[Cell]:
    assert isinstance(factor.spread, Levels)
    return factor.spread.values


def _grid(study: Study) -> list[Point]:
    return list(product(*map(_levels, study.factors)))


def _list(study: Study) -> list[Point]:
    return list(zip(*map(_levels, study.factors), strict=True))


def _one_at_a_time(study: Study) -> list[Point]:
    nothing: Point = (None,) * len(study.factors)
    return [
        nothing,
        *(
            (*nothing[:place], value, *nothing[place + 1 :])
            for place, factor in enumerate(study.factors)
            for value in _levels(factor)
        ),
    ]


def _latin_hypercube(study: Study) -> list[Point]:
    from scipy.stats import qmc

    sampler: Any = qmc.LatinHypercube(len(study.factors), **_seeded(study))
    return _placed(study, sampler.random(study.settings.runs))


def _sobol(study: Study) -> list[Point]:
    return _placed(study, _sobol_points(study, len(study.factors)))


def _sobol_indices(study: Study) -> list[Point]:
    """Return A, B, and for each factor A with its column of B: (factor + 2) blocks of runs."""
    width = len(study.factors)
    both = _sobol_points(study, 2 * width)
    a, b = both[:, :width], both[:, width:]
    blocks = [a, b]
    for place in range(width):
        mixed = a.copy()
        mixed[:, place] = b[:, place]
        blocks.append(mixed)
    return _placed(study, np.concatenate(blocks))


def _sobol_points(study: Study, width: int) -> Floats:
    """Return points of a scrambled Sobol sequence in the unit cube, shape (run, factor)."""
    from scipy.stats import qmc

    sampler: Any = qmc.Sobol(width, scramble=True, **_seeded(study))
    # A part of a power of two is not balanced; the manual says so.
    count = study.settings.runs
    return sampler.random_base2((count - 1).bit_length())[:count]


def _seeded(study: Study) -> dict[str, Any]:
    """Return the argument that seeds a sampler, which SciPy 1.15 has renamed."""
    from inspect import signature

    from scipy.stats import qmc

    name = "rng" if "rng" in signature(qmc.LatinHypercube).parameters else "seed"
    return {name: np.random.default_rng(study.settings.seed)}


def _placed(study: Study, unit: Floats) -> list[Point]:
    """Return points of the unit cube, shape (run, factor), as values of the factors."""
    columns = [value_at(factor, unit[:, place]) for place, factor in enumerate(study.factors)]
    return list(zip(*columns, strict=True))


def value_at(factor: Factor, part: Floats) -> list[Cell]:
    """Return values of a factor below which parts of its distribution are.

    Args:
        factor: The factor; of listed values each is as likely as the others.
        part: From 0 to 1, dimensionless, shape (run,).
    """
    if isinstance(factor.spread, Levels):
        values = factor.spread.values
        places = np.minimum((part * len(values)).astype(int), len(values) - 1)
        return [values[place] for place in places]
    assert isinstance(factor.spread, Distribution)
    return [rounded(value) for value in _drawn(factor.spread, part).tolist()]


def _drawn(spread: Distribution, part: Floats) -> Floats:
    """Return values of a distribution in the unit of its factor, shape (run,)."""
    from scipy import stats

    numbers = spread.numbers
    match spread.kind:
        case "normal":
            family: Any = stats.norm(*numbers)
        case "lognormal":
            family = stats.lognorm(np.log(numbers[1]), scale=numbers[0])
        case "triangular":
            low, mode, high = numbers
            family = stats.triang((mode - low) / (high - low), low, high - low)
        case _:
            family = stats.uniform(numbers[0], numbers[1] - numbers[0])
    below = 0.0 if spread.low is None else family.cdf(spread.low)
    until = 1.0 if spread.high is None else family.cdf(spread.high)
    return family.ppf(below + part * (until - below))


_DESIGNS: dict[str, Callable[[Study], list[Point]]] = {
    GRID: _grid,
    LIST: _list,
    ONE_AT_A_TIME: _one_at_a_time,
    LATIN: _latin_hypercube,
    SOBOL: _sobol,
    INDICES: _sobol_indices,
}
