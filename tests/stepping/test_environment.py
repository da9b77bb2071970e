"""Scenes as environments of gymnasium, and controllers on stepped runs."""

import numpy as np
import pytest

import tissuec
from tests.stepping.strip import STRIP
from tissuec.core.errors import CompileError, TissueError

gymnasium = pytest.importorskip("gymnasium")

OBSERVED = {"force of tongs": (0.0, 1.0), "position(right edge along (1, 0, 0))": (0.0, 1.0)}
PULL = "move tongs by ({} mm, 0, 0) using constant speed"
GOAL = 10e-3  # [N]


def environment(text=STRIP, *, ends="ruptured(strip) > 0", **more):
    given = {
        "observations": OBSERVED, "actions": {PULL: (-0.5, 0.5)}, "step": "25 ms",
        "reward": "-abs(force(tongs) - 10 mN)", "ends": ends,
    }  # fmt: skip
    return tissuec.environment(text, **given | more)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_the_checker_of_gymnasium_passes():
    from gymnasium.utils.env_checker import check_env

    check_env(environment(), skip_render_check=True)


def test_an_episode_is_the_run_of_the_recorded_script():
    env = environment()
    env.reset(seed=1)
    for number in (0.2, 0.1, -0.05):
        seen, reward, *_ = env.step(np.array([number]))
    assert seen[0] == env.run.measure("force of tongs") > 0.0
    assert reward == pytest.approx(-abs(seen[0] - GOAL), abs=1e-15)
    env.run.run_until(1.0)
    again = tissuec.run(env.run.script(), companion="off")
    assert np.array_equal(again.position[-1], env.run.position)


@pytest.mark.filterwarnings("error")
def test_the_last_action_ends_with_the_scene():
    env = environment(step="300 ms")
    env.reset()
    for _ in range(4):
        *_, over, info = env.step(np.array([0.1]))
    assert over and info["time"] == 1.0
    assert "  from 0.9 s to 1.0 s: move tongs by (0.1 mm, 0, 0)" in env.run.script()


def test_episodes_are_alike_and_end_with_the_scene():
    env = environment()

    def episode():
        env.reset()
        seen = []
        for _ in range(100):
            observation, reward, ended, over, info = env.step(np.array([0.02]))
            seen.append((*observation, reward))
            if ended or over:
                return seen, ended, over, info
        raise AssertionError("the scene lasts 40 steps")

    (one, ended, over, info), (two, *_) = episode(), episode()
    assert one == two and len(one) == 40
    assert over and not ended and info["time"] == 1.0


def test_a_tear_ends_an_episode_with_its_reason():
    env = environment(STRIP.replace("breaking force = 40 mN", "breaking force = 1 mN"))
    env.reset()
    for _ in range(40):
        *_, ended, over, info = env.step(np.array([0.5]))
        if ended:
            break
    assert ended and not over
    assert info["reason"] == "ruptured(strip) > 0"


def test_a_motion_that_diverges_ends_an_episode():
    text = STRIP.replace("tolerance = 1e-4", "step = 25 ms; integrator is velocity verlet")
    env = environment(text.replace("rupture is allowed", ""), ends="")
    env.reset()
    for _ in range(40):
        seen, reward, ended, _, info = env.step(np.array([0.5]))
        if ended:
            break
    assert ended and reward == 0.0 and np.isfinite(seen).all()
    assert "diverged" in info["reason"]
    env.reset()
    assert env.run.time == 0.0


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        ({"observations": ["weight of tongs"]}, CompileError, "weight"),
        ({"reward": "force of tong"}, CompileError, "tong"),
        ({"ends": "force(tongs)"}, CompileError, "force"),
        ({"actions": {"move tongs by (1, 0, 0) mm": (0, 1)}}, ValueError, "needs one {}"),
        ({"actions": {PULL: (1.0, -1.0)}}, ValueError, "must ascend"),
        ({"actions": {PULL.replace("tongs", "tong"): (0, 1)}}, CompileError, "tong"),
    ],
)
def test_mistakes_are_told_before_the_first_episode(change, error, said):
    with pytest.raises(error, match=said):
        environment(**change)


def test_without_gymnasium_the_extra_is_named(monkeypatch):
    import sys

    monkeypatch.delitem(sys.modules, "tissuec.api.environment", raising=False)
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    with pytest.raises(TissueError, match=r"tissuec\[gymnasium\]"):
        environment()


def test_a_controller_holds_a_force_within_two_percent():
    sim = tissuec.start(STRIP.replace("duration = 1 s", "duration = 0.6 s"))
    held = []
    while not sim.ended:
        wrong = GOAL - sim.measure("force of tongs")
        way = float(np.clip(0.05 * wrong, -2e-4, 2e-4))  # [m], a proportional controller
        sim.move("tongs", by=(way, 0.0, 0.0), over="10 ms")
        sim.step("10 ms")
        if sim.time > 0.4:
            held.append(sim.measure("force of tongs"))
    assert np.abs(np.array(held) - GOAL).max() < 0.02 * GOAL


def test_a_planner_lifts_without_tearing():
    """Of three ways ahead, forks take the longest that nothing breaks in."""
    sim = tissuec.start(STRIP.replace("breaking force = 40 mN", "breaking force = 1 mN"))
    for _ in range(8):
        for way in (0.4e-3, 0.1e-3, 0.0):
            ahead = sim.fork()
            ahead.move("tongs", by=(way, 0.0, 0.0), over="50 ms")
            ahead.step("50 ms")
            if ahead.alive.all():
                break
        sim.move("tongs", by=(way, 0.0, 0.0), over="50 ms")
        sim.step("50 ms")
    assert sim.alive.all()
    greedy = tissuec.start(sim.compiled.scene.source.text)
    greedy.move("tongs", by=(3.2e-3, 0.0, 0.0), over="0.4 s")
    greedy.run_until(0.4)
    assert not greedy.alive.all()


@pytest.mark.parametrize(
    "action", [[np.nan], [np.inf], [0.0, 1.0], [], 0.5, np.zeros((1, 1)), None]
)
def test_an_action_that_is_none_does_nothing(action):
    env = environment()
    env.reset()
    before = env.run.script()
    with pytest.raises(ValueError, match="an action is 1 finite number"):
        env.step(action)
    assert env.run.script() == before and env.run.time == 0.0
