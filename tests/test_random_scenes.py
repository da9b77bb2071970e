"""Scenes that nobody prepared, against SciPy: each keeps its promise or says what is off."""

import pytest

from tests.random_scenes import random_scene
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.engine.execution.companion import Companion
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request
from tissuec.validate.validation import validate


def verdict_of(seed):
    """Return what validation says of a seed's scene, "refused" if it does not compile."""
    source = Source(f"seed{seed}.tis", random_scene(seed))
    try:
        compiled, _ = compile_request(Request(source))
    except CompileError:
        return "refused"
    found = validate(compiled, method="DOP853", rtol=None, progress=lambda *_: None).verdict
    return "told" if found == "broken" and is_told(compiled) else found


def is_told(compiled):
    """Return whether a run says, by its companion, that positions are not known so well."""
    network, plan = compiled.network, compiled.plan
    beside = Companion(network, plan, "inline")
    run(network, plan, Recorder(network, plan, MemoryRecording(), tap=beside.take))
    return beside.estimate().since is not None


@pytest.mark.parametrize(
    ("first", "count"),
    [(0, 3), *(pytest.param(k, 40, marks=pytest.mark.slow) for k in range(0, 400, 40))],
)
def test_random_scenes_keep_their_promises(first, count):
    verdicts = [verdict_of(seed) for seed in range(first, first + count)]
    # Some contradict themselves and are refused; in some motion is chaotic.
    assert set(verdicts) <= {"kept", "told", "refused", "undecided"}
    assert verdicts.count("kept") > 0.75 * len(verdicts)
