"""Scenes with a learn block, and finished learnings of them, made by hand."""

from pathlib import Path

import numpy as np

from tissuec.learn.fit.outcome import Estimates, Fitted, Learnt, UnidentifiableCombination
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request
from tissuec.script.fit_problem import WORDS

BODY = """
body block {{
  mesh is tube {{ axis from (0, 0, 0) cm to (4, 0, 0) cm; radius = 3 mm
    rings = 3; sides = 6; diagonals is both; interior is crossed }}
  tissue is {tissue}
  {regions}
}}
set pressed = nodes of block where x < 1 mm
environment {{ gravity = (0, 0, 0) m/s^2; contact is off; damping = 0 N*s/m }}
script {{ at 0 s: fix pressed }}
simulate {{ duration = 10 ms; integrator is automatic; tolerance = 1e-3 }}
learn {fit_problem} {{
  data = ["one.csv", "two.csv"]
  hold out "two.csv"
  fit = force(pressed) using column "force_N" in N
  {adjust}
  seed = 7
  write "learned/{fit_problem}.tis"
}}
"""
#: Numbers by what they stand for: by which factor each is changed.
CHANGED = 1.2345678


def compiled_of(
    folder: Path, adjust: str, *, tissue="fat", fit_problem="fat", top="", regions="", end=""
):
    """Return the compiled scene of a file in a folder, and the request for it."""
    text = f"language 1\n{top}\n" + BODY.format(
        tissue=tissue, fit_problem=fit_problem, adjust=adjust, regions=regions
    )
    path = folder / "scene.tis"
    path.write_text(text + end, encoding="utf-8")
    for name in ("one.csv", "two.csv"):
        (folder / name).write_text("t_s,force_N\n0,1\n0.001,2\n")
    request = Request.file(path)
    return compile_request(request)[0], request


def estimates(adjust, start, *, factor=CHANGED, part=0.01, names=None, parts=(), told=None):
    """Return estimates of an entry, known to a part of their values."""
    start = np.atleast_1d(np.asarray(start, dtype=float))
    value = start * factor
    half = np.abs(value) * part
    told = np.ones(len(start), dtype=bool) if told is None else np.asarray(told)
    if names is None:
        names = tuple(f"{adjust.what} of {adjust.of}" for _ in start)
    return Estimates(adjust, names, start, value, value - half, value + half, told, parts)


def learnt(fit_problem, every, **changes):
    """Return a learning that came to its end, with one file learnt from and one held out."""
    text = fit_problem.fits[0].text
    facts = {
        "zeros": {},
        "error": 0.5,
        "first_error": 120.0,
        "fitted": (
            Fitted("one.csv", False, 100, 0.031, {text: 0.002}, "ab" * 32),
            Fitted("two.csv", True, 50, 0.042, {text: 0.003}, "cd" * 32),
        ),
        "noise": {text: 0.00201},
        "singular": np.array([100.0, 3.0]),
        "blind": (),
        "method": "least squares, forward sensitivities",
        "stepping": "velocity verlet, 1000 steps of 50 us",
        "stepping_error": 2.1e-5,
        "passes": 3,
        "evaluations": 40,
        "reason": "the error no longer decreases",
        "converged": True,
        "wall_time": 1.5,
    }
    return Learnt(fit_problem=fit_problem, estimates=tuple(every), **(facts | changes))


def starts(compiled, adjust):
    """Return where the numbers of an entry begin."""
    scene, network = compiled.scene, compiled.network
    if adjust.per == "tissue":
        tissue = scene.tissues[adjust.of.lower()]
        if adjust.what in tissue.given:
            return [tissue.given[adjust.what].value]
        laws = tissue.laws.values()
        named = [law.law for law in laws if hasattr(law.law, adjust.what)]
        if named:
            return [getattr(named[0], adjust.what)]
        params = {one.name: one.value for one in scene.constants.parameters()}
        return [float(params[adjust.what].amount)]
    if adjust.per == "region":
        body = scene.bodies[adjust.of.lower()]
        parts = [body.tissue, *(region.tissue or body.tissue for region in body.regions)]
        return [tissue.given[adjust.what].value for tissue in parts]
    arrays = {"spring constant": "stiffness", "mass": "mass", "rest length": "rest"}
    values = network.array(arrays[adjust.what])[adjust.members]
    return values if adjust.per in ("spring", "node") else [values.mean()]


def learnt_of(compiled, **changes):
    """Return a learning in which every number of the first fit problem grew by one factor."""
    fit_problem = compiled.fit_problems[0]
    every = []
    for adjust in fit_problem.adjusts:
        if adjust.what == WORDS:
            continue
        parts = ()
        if adjust.per == "region":
            body = compiled.scene.bodies[adjust.of.lower()]
            parts = ("", *(region.name for region in body.regions))
        start = starts(compiled, adjust)
        names = tuple(f"{adjust.what} {k} of {adjust.of}" for k in range(len(start)))
        names = names if len(start) > 1 else None
        every.append(estimates(adjust, start, parts=parts, names=names))
    return learnt(fit_problem, every, **changes)


BLIND = UnidentifiableCombination(
    "only their ratios can be determined", "give one mass", np.inf
)
