"""The scenes that are shipped, held against SciPy: their beginnings, and slowly the whole."""

from pathlib import Path

import numpy as np
import pytest

from tests.validate.scenes import quantity, silent
from tissuec.core.structs import replace
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request
from tissuec.script.plan import Output
from tissuec.validate import engine_run
from tissuec.validate.validation import validate

FOLDER = Path(__file__).resolve().parents[2] / "library" / "scenes"
SCENES = sorted(path.stem for path in FOLDER.glob("*.tis"))
LONG = {
    "artery",
    "breast_lumps",
    "indentation",
    "ligature",
    "liver",
    "suture",
    "tubal_ligation",
}  # scenes whose beginnings take long, too
#: Scenes whose reference takes more than a quarter of an hour, because their tissue is stiff or
#: because slings rub on it all the time.
TOO_LONG = {"breast_lumps", "tubal_ligation"}
#: How much of a scene its beginning is, where a tenth takes more than some seconds.
PARTS = {
    "artery": 0.0125,
    "bladder": 0.005,
    "breast_lumps": 0.04,
    "indentation": 0.05,
    "ligature": 0.01,
    "liver": 0.015,
    "palpation": 0.005,
    "rupture": 0.0125,
    "sterilisation": 0.025,
    "suture": 0.025,
}
NO_OUTPUT = Output(np.zeros(0, dtype=np.int64), np.inf, False, (), np.inf)


def shipped(name):
    return compile_request(Request.file(FOLDER / f"{name}.tis"))[0]


def beginning(compiled, part):
    """Return the first part of a scene, looked at rarely."""
    plan = compiled.plan
    duration = part * plan.simulation.duration
    short = replace(
        plan,
        simulation=replace(plan.simulation, duration=duration),
        output=NO_OUTPUT,
        expectations=(),
    )
    return replace(compiled, plan=short)


def assert_as_good_as_can_be_known(found):
    """Where a motion amplifies roundings, as a buckling one does, nobody knows it better."""
    if found.verdict == "undecided":
        assert found.comparison.known.is_sensitive
    else:
        assert found.verdict in ("kept", "nothing promised"), found.reasons


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in SCENES],
)
def test_beginning_of_a_shipped_scene_keeps_its_promise(name, monkeypatch):
    # Steps that land on a hundred output times would be shorter than their errors ask for.
    monkeypatch.setattr(engine_run, "WITHOUT_OUTPUT", 21)
    found = validate(
        beginning(shipped(name), PARTS.get(name, 0.1)),
        method="DOP853",
        rtol=None,
        progress=silent,
    )
    assert_as_good_as_can_be_known(found)
    # A fixed step promises nothing; those that are shipped are worth looking at all the same.
    assert quantity(found, "position").error < 1e-2
    assert quantity(found, "energy balance").error < 1e-2


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(set(SCENES) - TOO_LONG))
def test_whole_shipped_scene_keeps_its_promise_as_far_as_it_can_be_known(name):
    found = validate(shipped(name), method="DOP853", rtol=None, progress=silent)
    assert_as_good_as_can_be_known(found)
    assert not found.comparison.ruptures.misses
    assert not found.comparison.triggers.misses
