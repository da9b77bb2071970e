"""Lists of what is near in contact: results do not depend on how far they reach."""

import pytest

from tests.contact.test_faces_friction import RUBBED
from tests.validate.scenes import compiled_scene
from tests.whole_runs import (
    carried_out,
    every_array,
    same_on_threads,
    same_when_resumed,
)
from tissuec.engine import stepper
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.engine.stepper import ContactListing
from tissuec.forces.contact.contact import Contact

RUBBED_IN_FRAMES = RUBBED.replace("output {", "output { trajectory every 1 ms;")


def listed_nearby(monkeypatch):
    """Have pairs listed nearby, and again after few steps, and spare no places."""
    for name, value in {"MANY": 0, "NARROW": 0.01, "OFTEN": 10, "SELDOM": 20}.items():
        monkeypatch.setattr(stepper, name, value)
    monkeypatch.setattr("tissuec.engine.kernel_inputs.FEW", 2)
    return watched(monkeypatch)


def watched(monkeypatch):
    """Return the pairs of each list, and the bristles of each time that they get places."""
    pairs, kept = [], []
    table, keep = Contact.table, KernelInputs.keep

    def counted(self, *of):
        made = table(self, *of)
        pairs.append(made.touches.shape.size)
        return made

    def placed(self, bristles):
        kept.append(None if bristles is None else len(bristles))
        keep(self, bristles)

    monkeypatch.setattr(Contact, "table", counted)
    monkeypatch.setattr(KernelInputs, "keep", placed)
    return pairs, kept


def arrays(text):
    """Return all arrays of a run as bytes, and its statistics."""
    outcome, recording = carried_out(compiled_scene(text))
    assert outcome.kind == "done"
    found = [one.tobytes() for one in every_array("force of ball", recording)]
    return found, outcome.statistics


@pytest.mark.parametrize(
    "method",
    [
        *("dop853", "velocity verlet", "rkc2"),
        *(pytest.param(m, marks=pytest.mark.slow) for m in ("rkn4", "esdirk43", "automatic")),
    ],
)
def test_results_are_the_same_however_far_lists_reach(method, monkeypatch):
    text = RUBBED_IN_FRAMES.replace(
        "tolerance = 1e-4", f"tolerance = 1e-3; integrator is {method}"
    )
    with monkeypatch.context() as patch:
        patch.setattr(stepper, "MANY", 10**9)
        pairs, _ = watched(patch)
        expected, before = arrays(text)
    fewer, kept = listed_nearby(monkeypatch)
    found, after = arrays(text)
    assert found == expected
    assert (after.accepted, after.rejected) == (before.accepted, before.rejected)
    if method in ("esdirk43", "rkc2"):
        assert len(fewer) == len(pairs)
    else:
        assert len(fewer) > len(pairs) and min(fewer) < 0.1 * min(pairs) and len(kept) > 3


@pytest.mark.parametrize("count", [2, 3, 5])
def test_a_run_with_short_lists_that_is_resumed_gives_the_same_bytes(count, monkeypatch):
    pairs, kept = listed_nearby(monkeypatch)
    compiled = compiled_scene(RUBBED_IN_FRAMES)
    _, (first, _) = same_when_resumed(compiled, "force of ball", count)
    assert 0.0 < first.state.time < 0.03 and len(pairs) > 20 and len(kept) > 5


def test_threads_do_the_same_with_short_lists(monkeypatch):
    listed_nearby(monkeypatch)
    monkeypatch.setattr("tissuec.forces.contact.contact.WORTHWHILE", 1)
    monkeypatch.setattr("tissuec.engine.layout._threads", lambda _, permitted, *__: permitted)
    assert len(same_on_threads(RUBBED_IN_FRAMES, 2).position) > 20


def test_lists_reach_further_where_they_are_left_soon_and_less_where_late():
    one = ContactListing(at=1.0, share=0.25, is_tried=True)
    assert one.end(2.0, stepper.OFTEN - 1, 5000) and one.share == 0.5
    assert one.end(2.0, stepper.OFTEN, 5000) and one.share == 0.5
    assert one.end(2.0, stepper.SELDOM + 1, 10) and one.share == 0.5
    assert one.end(2.0, stepper.SELDOM + 1, 5000) and one.share == 0.25
    # A single step leaves them.
    assert one.end(1.0, 0, 5000) and one.share == 1.0
    assert not one.end(1.0, 0, 5000)
    assert not one.narrow(5000) and not ContactListing().narrow(stepper.MANY)
