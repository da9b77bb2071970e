"""Tableaus: coefficients of methods, for steps of the engine and for derivatives of steps."""

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from tissuec.engine.integrators import Integrator, hermite
from tissuec.forces.accelerations import place
from tissuec.kernels.records import Floats, Net, Tableau, Work
from tissuec.kernels.stages import combine


def runge_kutta(
    weights: Floats, *estimates: Floats, nodes: Floats | None = None, result: int | None = None
) -> Tableau:
    """Return the tableau of a Runge-Kutta method for y' = f(y); coefficients are dimensionless.

    Args:
        weights: A, with rows for the result and for stages after it, shape (stage, stage).
        estimates: Weights of none, one or two estimates of the error, shape (stage,) each. Of
            two, e5 and e3, the error is e5² / √(e5² + 0.01 e3²), as in DOP853.
        nodes: c, if the sums of the weights are wrong by rounding, shape (stage,).
        result: Number of the stage that is the result; the last one if not given.
    """
    errors = [(estimate @ weights, estimate) for estimate in estimates]
    c = weights.sum(axis=1) if nodes is None else nodes
    return nystrom(weights @ weights, weights, c, errors, result=result)


def nystrom(
    for_x: Floats,
    for_v: Floats,
    nodes: Floats,
    errors: Sequence[tuple[Floats, Floats]] = (),
    *,
    result: int | None = None,
    carries: bool = False,
) -> Tableau:
    """Return the tableau of a Runge-Kutta-Nyström method for x'' = a(x, v).

    Coefficients are dimensionless.

    Args:
        for_x, for_v: X and V of ``Tableau``, shape (stage, stage).
        nodes: c, shape (stage,).
        errors: Weights of none, one or two estimates of the error, of x and of v.
        result: Number of the stage that is the result; the last one if not given.
        carries: See ``Tableau``.
    """
    stages = len(nodes)
    (of_x, of_v), (error_x, error_v) = (
        np.zeros((2, stages, stages + 1)),
        np.zeros((2, 2, stages + 1)),
    )
    of_x[:, 0], of_x[:, 1:], of_v[:, 1:] = nodes, for_x, for_v
    for number, (of_position, of_velocity) in enumerate(errors):
        error_x[number, 1:], error_v[number, 1:] = of_position, of_velocity
    last = stages - 1 if result is None else result
    return Tableau(of_x, of_v, error_x, error_v, last, carries)


def enter_stage(
    then: float,
    h: float,
    stage: int,
    current: int,
    x: Floats,
    v: Floats,
    work: Work,
    net: Net,
) -> None:
    """Set x and v to those of a stage, by the accelerations found so far.

    Args:
        then: Time of the stage [s].
    """
    for_x, for_v = work.tableau.for_x[stage], work.tableau.for_v[stage]
    combine(work.x[current], work.v[current], h, for_x, for_v, current, x, v, work)
    place(then, x, v, net)


class RungeKutta(Integrator):
    """Common base of members with a tableau of Runge-Kutta.

    One with stages after its result says how they combine inside of a step: ``dense_x`` and
    ``dense_v``. Of others, what is inside follows from both ends.
    """

    evaluations: ClassVar[int]
    rows: ClassVar[int]
    end_row: ClassVar[int]
    dense_x: ClassVar[Floats]
    dense_v: ClassVar[Floats]
    embedded_x: ClassVar[Floats]
    prepare = staticmethod(hermite.prepare)

    def __init_subclass__(cls) -> None:
        """Derive what follows from the tableau."""
        super().__init_subclass__()
        tableau = getattr(cls, "tableau", None)
        if tableau is None:
            return
        cls.rows = len(tableau.for_x) + 1
        cls.end_row = tableau.result + (0 if tableau.carries else 1)
        if not hasattr(cls, "evaluations"):
            cls.evaluations = cls.end_row - 1
        if not hasattr(cls, "dense_x"):
            cls.rows += 2
            cls.dense_x = hermite.dense_x(cls.rows, cls.end_row)
            cls.dense_v = hermite.dense_v(cls.rows, cls.end_row)
        if not hasattr(cls, "embedded_x"):
            cls.embedded_x = np.zeros((0, cls.rows))
