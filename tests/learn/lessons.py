"""Lessons, fits and a net for tests of learning from data, made by hand."""

import numpy as np

from tests.hand_net import make_net, span
from tissuec.core.units import FORCE, LENGTH
from tissuec.script.fit_problem import Data, DataAxis, DataColumn, Fit, FitProblem
from tissuec.script.measures import MEASURES, Subject

NONE = np.zeros(0, dtype=np.int64)
#: A row of four nodes, whose ids are 100 to 103.
NET = make_net([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]], [[0, 1], [1, 2], [2, 3]])


def column(name, unit=1.0):
    return DataColumn(name, unit, span(name))


def fit(measure, *names, nodes=(0, 1, 2, 3), unit=1.0, along=None, every=None, of="net"):
    """Return a fit of a measure, or of "positions"; ``names`` are those of columns."""
    subject = Subject(of, np.array(nodes), NONE)
    return Fit(
        text=f"{measure}({of})",
        measure=MEASURES.get(measure),
        subjects=(subject,),
        along=None if along is None else np.array(along, dtype=float),
        dimension=FORCE if measure == "force" else LENGTH,
        columns=tuple(column(name, 1.0 if name == "node" else unit) for name in names),
        every=every,
        noise=None,
        weight=1.0,
        free_zero=False,
        span=span(f"fit = {measure}({of})"),
    )


def fit_problem(*fits, time=None, moved=None):
    """Return a fit problem of fits, whose axis is a column of time, or of displacements."""
    axis = DataAxis(None if moved is None else np.array(moved), time, span("axis"))
    return FitProblem(
        name="fat",
        data=(),
        axis=axis,
        fits=fits,
        adjusts=(),
        last_part=0.0,
        revise=(),
        passes=10,
        bootstrap=None,
        seed=0,
        tolerance=1e-9,
        integrator="automatic",
        step=None,
        method="automatic",
        scaled=True,
        write=None,
        demands=(),
        span=span("learn fat"),
    )


def data(path):
    return Data(path, (), False, span(f'"{path.name}"'))
