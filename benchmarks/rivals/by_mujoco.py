"""MuJoCo, where it is installed: spatial tendons between point bodies are the same springs.

A tendon between two sites with stiffness c, damping d and spring length L0 pulls with
c (L - L0) + d dL/dt, as a spring of ours does; a body on three slides is a mass point. MuJoCo
steps with a fixed step, so that a tolerance here only orders the steps that are tried.
"""

import time as clock
from importlib import import_module
from math import ceil
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from benchmarks.rivals.walk import state_at_start
from tissuec.analysis.bench_solvers import BenchProblem, Deadline, SolverFailed, SolverRun
from tissuec.mechanics.state import State
from tissuec.model.topology import join_nodes_of

INTEGRATORS = ("Euler", "implicitfast", "RK4")
ORDERS = {"Euler": 1.0, "implicitfast": 1.0, "RK4": 4.0}
STAGES = {"Euler": 1, "implicitfast": 1, "RK4": 4}
LARGEST = 2000  # nodes; its arrays grow with the square of their number


def refusal(problem: BenchProblem) -> str:
    """Return why MuJoCo cannot solve a scene; empty if it can."""
    state = state_at_start(problem)
    if not state.springs.behaviour.is_linear:
        return "the scene has nonlinear springs"
    if any(event.time > 0.0 for event in problem.plan.events):
        return "the scene has actions after 0 s"
    if state.motions:
        return "MuJoCo cannot drive nodes along paths with a given velocity"
    loads = state.loads.values()
    if any(term.profile.kind != "constant" for load in loads for term in load.terms):
        return "the scene has a time-dependent force"
    if problem.network.node_count > LARGEST:
        return f"the net has more than {LARGEST} nodes"
    return ""


class MujocoSolver(Struct, frozen=True, eq=False):
    """One of MuJoCo's integrators; 1 % of a period at tolerance 1e-2, finer by its order."""

    problem: BenchProblem
    integrator: str
    ours: bool = False

    @property
    def name(self) -> str:
        return f"MuJoCo {self.integrator}"

    def solve(self, tolerance: float, deadline: Deadline) -> SolverRun:
        """Return a run at a tolerance; see ``BenchSolver``.

        Raises:
            SolverFailed: The motion is not finite, or ended early.
        """
        mujoco: Any = import_module("mujoco")

        state = state_at_start(self.problem)
        model = mujoco.MjModel.from_xml_string(self._text(state))
        data = mujoco.MjData(model)
        free = np.flatnonzero(~state.held)
        data.qpos[:] = 0.0
        data.qvel[:] = state.velocity[free].ravel()
        for load in state.loads.values():
            data.xfrc_applied[1 + load.nodes, :3] += load.at(0.0)
        started = clock.process_time()
        step = self._step(tolerance)
        position: list[NDArray[np.float64]] = []
        steps, time = 0, 0.0
        for when in self.problem.times:
            count = ceil((when - time) / step * (1.0 - 1e-9))
            model.opt.timestep = (when - time) / count if count else step
            for chunk in range(0, count, 1000):
                deadline.check()
                mujoco.mj_step(model, data, nstep=min(1000, count - chunk))
            steps, time = steps + count, when
            position.append(self._position(state, free, data))
        seconds = clock.process_time() - started
        if not np.isfinite(position[-1]).all() or data.time < 0.99 * time:
            raise SolverFailed("MuJoCo's motion grew without bounds")
        return SolverRun(seconds, STAGES[self.integrator] * steps, np.array(position))

    def _step(self, tolerance: float) -> float:
        """Return the step for a tolerance [s]."""
        network = self.problem.network
        joined = np.zeros(network.node_count)
        np.add.at(joined, network.springs.ends.ravel(), np.repeat(network.springs.stiffness, 2))
        period = 2.0 * np.pi / np.sqrt((2.0 * joined / network.mass).max())
        fine = (tolerance / 1e-2) ** (1.0 / ORDERS[self.integrator])
        return float(0.1 * period * fine)

    def _position(self, state: State, free: np.ndarray, data: Any) -> np.ndarray:
        position = state.position.copy()
        position[free] += data.qpos.reshape(-1, 3)
        return position

    def _text(self, state: State) -> str:
        """Return the model: a body for each node, a tendon for each living spring."""
        gravity = _numbers(state.gravity)
        bodies = "\n".join(
            _body(node, state) for node in range(self.problem.network.node_count)
        )
        tendons = "\n".join(_tendon(spring, state) for spring in _acting(state))
        return f"""<mujoco>
<option integrator="{self.integrator}" gravity="{gravity}" timestep="1e-4" jacobian="sparse">
<flag contact="disable" constraint="disable"/></option>
<worldbody>{bodies}</worldbody>
<tendon>{tendons}</tendon>
</mujoco>"""


def _acting(state: State) -> np.ndarray:
    return np.flatnonzero(state.alive_springs & ~join_nodes_of(state.springs.ends, state.held))


def _body(node: int, state: State) -> str:
    mass, place = float(state.mass[node]), _numbers(state.position[node])
    drag = float(state.braking[node])
    slides = "".join(
        f'<joint type="slide" axis="{axis}" damping="{drag!r}"/>'
        for axis in ("1 0 0", "0 1 0", "0 0 1")
    )
    inertia = " ".join([repr(mass)] * 3)  # of no effect: nothing turns
    return (
        f'<body name="b{node}" pos="{place}">'
        f'<inertial pos="0 0 0" mass="{mass!r}" diaginertia="{inertia}"/>'
        f'{"" if state.held[node] else slides}<site name="s{node}"/></body>'
    )


def _tendon(spring: int, state: State) -> str:
    first, second = state.springs.ends[spring]
    return (
        f'<spatial stiffness="{float(state.springs.stiffness[spring])!r}" '
        f'damping="{float(state.springs.damping[spring])!r}" '
        f'springlength="{float(state.springs.rest[spring])!r}">'
        f'<site site="s{first}"/><site site="s{second}"/></spatial>'
    )


def _numbers(vector: np.ndarray) -> str:
    return " ".join(repr(float(value)) for value in vector)
