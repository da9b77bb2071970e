"""Additional starts of a search: the best of a random sample of all parameters.

Parameters of one ``adjust`` entry move together; each word of a vocabulary moves by itself.
"""

import numpy as np

from tissuec.learn.fit.evaluations import Evaluator, LostWorkersError, StartError
from tissuec.learn.fit.problem import Problem
from tissuec.learn.parameters.parametrisation import Parametrisation
from tissuec.model.network import Floats

SIZE, AT_REST = 48, 12  # of the sample; at rest, there are no periods to be missed
BEST = 2  # that are taken for each part of the data
FARTHEST = 1.15  # reaches: of logarithms, a factor of 10


def sample(
    problem: Problem,
    shaping: Parametrisation,
    bounds: tuple[Floats, Floats],
    parts: tuple[float, ...],
    evaluator: Evaluator,
) -> Floats:
    """Return the starts with the best predictions, dimensionless, shape (start, parameter).

    Args:
        problem: What is to be solved.
        shaping: Its parameters.
        bounds: Their least and greatest values, shape (parameter,).
        parts: Parts of the data, from its beginning, on which predictions are compared.
        evaluator: Computes the predictions.

    Raises:
        LostWorkersError: A worker died of a prediction.
    """
    random = np.random.default_rng(problem.fit_problem.seed)
    groups = np.append(shaping.groups, np.full(problem.size - shaping.size, -1))
    size = SIZE if problem.fit_problem.axis.nodes is None else AT_REST
    drawn = random.uniform(-FARTHEST, FARTHEST, (size, shaping.groups.max(initial=0) + 2))
    drawn[:, -1] = 0.0  # zeros, whose group is -1
    reaches = np.where(np.isfinite(problem.reaches), problem.reaches, 0.0)
    points = np.clip(drawn[:, groups] * reaches, *bounds)
    chosen: list[int] = []
    every = evaluator.all([StartError(point, part) for point in points for part in parts])
    if any(error is None for error in every):
        raise LostWorkersError("workers died while they compared starts")
    problem.evaluations += 2 * len(every)
    for errors in np.array(every, dtype=float).reshape(-1, len(parts)).T:
        order = [
            k for k in np.argsort(errors, kind="stable").tolist() if np.isfinite(errors[k])
        ]
        chosen += [k for k in order if k not in chosen][:BEST]
    return points[chosen]
