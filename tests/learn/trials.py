"""Small scenes with what was measured of them, and the models that predict it."""

from pathlib import Path

import numpy as np

from tests.hand_net import span
from tests.learn.lessons import NONE, fit_problem
from tissuec.compiler.compile import Compiled
from tissuec.core.source import Source
from tissuec.core.structs import replace
from tissuec.core.units import FORCE, LENGTH, STIFFNESS
from tissuec.learn.derivatives.dynamic_model import DynamicModel
from tissuec.learn.derivatives.finite_differences import FiniteDifferenceModel
from tissuec.learn.derivatives.methods import choose
from tissuec.learn.derivatives.motion import Motion
from tissuec.learn.derivatives.observables import look_of
from tissuec.learn.parameters.parametrisation import Parametrisation
from tissuec.measurements.experiment import Experiment, Series
from tissuec.model.network import Floats
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request
from tissuec.script.fit_problem import Adjust, Data, Fit
from tissuec.script.measures import MEASURES, Subject

#: A sheet of four by three nodes, held at its left side.
SHEET = """language 1
tissue felt {{ spring constant = 40 N/m; viscosity = 60 mN*s/m; mass = 2 g {tissue} }}
body sheet {{ mesh is sheet {{ corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm
  second edge = (0, 30, 0) mm; columns = 3; rows = 4; diagonals is both }}
  tissue is felt; {body} }}
set left = nodes of sheet where y < 1 mm
set right = nodes of sheet where y > 29 mm
set middle = nodes of sheet where y between 8 mm and 22 mm
{sets}
environment {{ gravity = (0, 0, -9.81) m/s^2; contact is {contact}; damping = 1 mN*s/m }}
script {{
  at 0 s: fix left
{script}
}}
simulate {{ duration = 100 ms; {simulate} }}
"""
PRECISE = "integrator is dop853; tolerance = 1e-8"


def sheet(
    script="", *, tissue="", body="", sets="", contact="off", simulate=PRECISE, file=None
) -> Compiled:
    """Return a scene of the sheet, compiled; what is given is put where it belongs.

    Args:
        file: Where it is written, if it has tables beside it.
    """
    text = SHEET.format(
        script=script, tissue=tissue, body=body, sets=sets, contact=contact, simulate=simulate
    )
    if file is None:
        return compile_request(Request(Source("sheet.tis", text)))[0]
    file.write_text(text)
    return compile_request(Request.file(file))[0]


def adjust(what, of, *, per="tissue", members=NONE, low=0.0, high=np.inf):
    return Adjust(
        what,
        of,
        per,
        np.asarray(members),
        None,
        STIFFNESS,
        low,
        high,
        None,
        span(f"{what} {of}"),
    )


def subject(compiled, name):
    """Return a set of nodes, or a tool, as what is measured."""
    if name in compiled.scene.tools:
        return Subject(name, None, NONE)
    return Subject(name, compiled.nodes_of(name), compiled.springs_of(name))


def fit(compiled, measure, *names, along=None, columns=0):
    """Return a fit of a measure, or of "positions"."""
    return Fit(
        text=f"{measure}({', '.join(names)})",
        measure=MEASURES.get(measure),
        subjects=tuple(subject(compiled, name) for name in names),
        along=None if along is None else np.array(along, dtype=float),
        dimension=FORCE if measure == "force" else LENGTH,
        columns=(None,) * columns,
        every=None,
        noise=None,
        weight=1.0,
        free_zero=False,
        span=span(f"fit = {measure} of {names} along {along}"),
    )


def series(one, times):
    """Return a series without values, in the shape of what would have been measured."""
    times = np.asarray(times, dtype=float)
    nodes = one.subjects[0].nodes if one.measure is None else None
    form = "" if one.measure is None else one.measure.form.partition("(")[0]
    shape: tuple[int, ...] = ()
    if nodes is not None:
        shape = (len(nodes), 3) if one.along is None else (len(nodes),)
    elif one.along is None and (form == "position" or len(one.columns) == 3):
        shape = (3,)
    return Series(one, times, nodes, np.zeros((len(times), *shape)))


def measured_at(all_series, numbers):
    """Return the series with numbers as values, one behind the other."""
    found, start = [], 0
    for one in all_series:
        size = one.values.size
        found.append(
            replace(one, values=numbers[start : start + size].reshape(one.values.shape))
        )
        start += size
    return tuple(found)


def differing(compiled, adjusts, all_series) -> FiniteDifferenceModel:
    asked = replace(fit_problem(*(s.fit for s in all_series)), adjusts=tuple(adjusts))
    return FiniteDifferenceModel(Parametrisation(compiled, asked), tuple(all_series))


def moving(compiled, adjusts, all_series, *, method="dop853", step=None):
    """Return a model with exact derivatives, what happens being found already."""
    asked = replace(fit_problem(*(s.fit for s in all_series)), adjusts=tuple(adjusts))
    shaping = Parametrisation(compiled, asked)
    stop = max(one.times[-1] for one in all_series)
    network = compiled.network
    chosen = choose(
        method,
        step,
        network,
        plan=compiled.plan,
        duration=stop,
    )
    looks = tuple(look_of(one.fit, one.nodes) for one in all_series)
    model = DynamicModel(shaping, tuple(all_series), looks, *chosen)
    model.freeze(np.zeros(shaping.size))
    return model


def experiment(all_series) -> Experiment:
    return Experiment(
        "sheet.csv", "", tuple(all_series), Data(Path("sheet.csv"), (), False, span())
    )


def difference(
    motion: Motion, vector: Floats, way: Floats, weight: Floats, step: float = 2e-2
) -> float:
    """Return the derivative of a weighted sum of places along a way, of sixth order."""

    def value(factor: float) -> float:
        return float((motion.forward(vector + factor * way).x * weight).sum())

    parts = (1, 45.0), (2, -9.0), (3, 1.0)
    return sum(w * (value(k * step) - value(-k * step)) for k, w in parts) / (60.0 * step)
