"""Scenes and results that cross to other processes."""

import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

import tissuec
from tests.api.scenes import PULL
from tissuec.pipeline import compile_request, simulate
from tissuec.scene.request import Request

ROOT = Path(__file__).parents[2]
#: With conditions, expectations, tools, rules, joints and threads among them.
SCENES = sorted((ROOT / "library" / "scenes").glob("*.tis"))
WAITING = (
    PULL.replace(
        "at 0.15 s: cut far spring", "when length(far spring) > 10.4 mm: cut far spring"
    )
    + "expect count(springs of far spring) >= 0 over run\n"
)


def copied(value):
    return pickle.loads(pickle.dumps(value))


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_every_scene_can_be_pickled(path):
    compiled = tissuec.compile(path)
    again = copied(compiled)
    assert np.array_equal(again.network.springs.stiffness, compiled.network.springs.stiffness)
    assert not again.network.position.flags.writeable
    assert len(again.plan.events) == len(compiled.plan.events)
    assert again.scene.metadata == compiled.scene.metadata


def test_a_copied_scene_runs_bit_for_bit_like_the_original(tmp_path):
    """Conditions and expectations are judged in copies, too."""
    request = Request(tissuec.compile(WAITING).scene.source)
    compiled, _ = compile_request(request)
    results = [
        simulate(one, tmp_path / f"{number}.vtkhdf", request=request)
        for number, one in enumerate((compiled, copied(compiled)))
    ]
    first, second = (tissuec.load(result.path) for result in results)
    assert np.array_equal(first.position[:], second.position[:])
    assert [event.kind for event in first.events].count("cut") == 1
    assert first.events == second.events
    assert first.expectations == second.expectations


def test_a_result_is_pickled_as_its_path(tmp_path):
    run = tissuec.run(PULL, out=tmp_path / "pull.vtkhdf")
    content = pickle.dumps(run)
    assert len(content) < 500
    run.close()
    assert pickle.loads(content).path == tmp_path / "pull.vtkhdf"


def test_a_temporary_result_outlives_the_process_that_made_it():
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        run = pool.submit(tissuec.run, PULL, pull=5e-4).result()
    folder = run.path.parent
    assert run.position.shape == (21, 3, 3)
    assert run.save(folder / "kept.vtkhdf").exists()
    del run
    assert not folder.exists()


def test_a_compiled_scene_is_shown_in_a_line(tmp_path):
    assert repr(tissuec.compile(WAITING)).startswith('<Compiled "scene": ')
    assert len(repr(tissuec.compile(WAITING))) < 100
