"""The verdict on one scene and one method.

Silently wrong is what came to its end without a word and holds no number, or energy from
nowhere, or momentum that no force gave it, or positions further off than ten tolerances and
no companion run that tells.
"""

from collections.abc import Sequence
from typing import Literal

import numpy as np
from msgspec import Struct

from benchmarks.rivals.walk import state_at_start
from benchmarks.stability.cells import FRAMES, TOLERANCE, Cell
from benchmarks.stability.known import Known, find_known
from benchmarks.stability.looking import Look, look
from tissuec.analysis.bench_solvers import (
    BenchProblem,
    Deadline,
    EngineSolver,
    OutOfTime,
    SolverFailed,
)
from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.source import Source
from tissuec.core.structs import replace
from tissuec.engine.execution.companion import FINER
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.method_choice import measured_facts
from tissuec.mechanics.settling import Unsettled, settle
from tissuec.model.network import Floats
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request
from tissuec.script.plan import AUTOMATIC, RELAXATION

Kind = Literal[
    "good", "energy", "measured", "warned", "refused", "slow", "none", "wrong", "crash"
]
MANY = 10.0  # tolerances that a position may be off
# Of the tolerance, which is of positions: energies go with squares, and with velocities that
# methods of low order keep less well.
ENERGIES = 4.0
SUITED = 0.5  # step of a method that promises nothing, times the fastest rate of the net
MADE = 0.5  # part of the energy that a fixed step may not make from nothing


class Verdict(Struct, frozen=True):
    """What came of a scene with a method.

    Attributes:
        kind: "good"; "energy" where the motion is chaotic or not known, so that only energy and
            momentum were judged, and are good; "measured" of a method that promises nothing;
            "warned" or "refused", whatever the result;
            "slow" beyond the budget; "none" where another method took over; "wrong" without a
            word; "crash".
        why: A sentence for what is not good.
        error: Of positions, where that is measured.
    """

    axis: str
    value: str
    method: str
    kind: Kind
    why: str
    scene: str
    error: float | None = None


class Court:
    """Judges all methods on one scene.

    Args:
        budget: Time of the processor for a run [s].
    """

    def __init__(self, cell: Cell, budget: float):
        self.cell, self.budget = cell, budget
        self._known: Known | None = None

    def judge(self, method: str) -> Verdict:
        """Return the verdict on a method."""
        cell, error = self.cell, None
        try:
            cell = self._suited(method)
            attempt = self._rest if method == RELAXATION else self._try
            kind, why, error = attempt(cell, method)
        except (CompileError, SolverFailed, Unsettled) as failure:
            kind, why = "refused", str(failure)
        except OutOfTime:
            kind, why = "slow", f"more than {self.budget:g} s"
        except Exception as failure:
            kind, why = "crash", f"{type(failure).__name__}: {failure}"
        return Verdict(cell.axis, cell.value, method, kind, why, cell.text(method), error)

    def _suited(self, method: str) -> Cell:
        """Return the scene, with a fixed step where the method asks for one."""
        cell = self.cell
        if method == RELAXATION and cell.step is None:
            return replace(cell, step=cell.duration / FRAMES)
        if cell.step is not None or method == AUTOMATIC or INTEGRATORS[method].promises:
            return cell
        scene = Request(Source("scene.tis", cell.text(AUTOMATIC)))
        state = state_at_start(BenchProblem.of(compile_request(scene)[0]))
        facts, frame = measured_facts(state), cell.duration / FRAMES
        rate = max(facts["omega"], facts["damping"])
        return replace(cell, step=min(frame, SUITED / rate) if rate else frame)

    def _look(self, cell: Cell, method: str) -> tuple[BenchProblem, Look, Sequence[Diagnostic]]:
        """Return what is to be judged, a run that keeps energies, and warnings of its text.

        Positions are judged in another run.

        Raises:
            Failed: The run did not come to its end.
        """
        compiled, warnings = compile_request(Request(Source("scene.tis", cell.text(method))))
        problem = BenchProblem.of(compiled)
        plan = replace(problem.plan, simulation=compiled.plan.simulation)
        seen, why = look(problem, plan, Deadline(self.budget))
        if seen is None:
            raise SolverFailed(why)
        return problem, seen, warnings

    def _try(self, cell: Cell, method: str) -> tuple[Kind, str, float | None]:
        problem, seen, warnings = self._look(cell, method)
        if method not in (AUTOMATIC, seen.method):
            return "none", f"{seen.method} took over", None
        wrong, told = self._energies(cell, seen), ""
        if not wrong and cell is not self.cell and self._judges(problem):
            return "measured", "", self._error(problem, seen.position)
        if not wrong and cell is self.cell:
            wrong, told = self._positions(problem, method)
        if not wrong:
            return ("good" if self._judges(problem) else "energy"), "", None
        told = min((one.code for one in warnings), default=told)
        return ("warned", f"{told}; {wrong}", None) if told else ("wrong", wrong, None)

    def _rest(self, cell: Cell, method: str) -> tuple[Kind, str, float | None]:
        """Measure how far a net rests from where Newton's method balances its forces."""
        if not cell.rests:
            return "none", "what is driven does not rest", None
        problem, seen, _ = self._look(cell, method)
        state = state_at_start(problem)
        settle(state, np.ones(problem.network.node_count, dtype=bool))
        rest = np.broadcast_to(state.position, seen.position.shape)
        return "measured", "", problem.error(seen.position[-1:], rest[-1:])

    def _energies(self, cell: Cell, seen: Look) -> str:
        """Return what is wrong with numbers, energy and momentum; empty if nothing is."""
        if not seen.finite:
            return "positions or velocities are no numbers"
        if cell.step is not None:
            made = seen.made > MADE
            return f"{seen.made:.1g} of the energy came from nothing" if made else ""
        if seen.imbalance > ENERGIES * TOLERANCE:
            return f"energy is off by {seen.imbalance:.1e}"
        drift = seen.drift > TOLERANCE
        return f"momentum is off by {seen.drift:.1e}" if drift else ""

    def _positions(self, problem: BenchProblem, method: str) -> tuple[str, str]:
        """Return what is wrong with positions, and what a run says of that.

        Both are empty if nothing is wrong, or nothing is known.
        """
        if not self._judges(problem):
            return "", ""
        solver = EngineSolver(problem, method)
        trial = solver.solve(TOLERANCE, Deadline(self.budget))
        error = self._error(problem, trial.position)
        if error <= MANY * TOLERANCE:
            return "", ""
        # Beside a run of users goes its companion, whose distance is told.
        finer = solver.solve(TOLERANCE / FINER, Deadline(FINER * self.budget))
        apart = problem.error(trial.position, finer.position)
        told = f"a finer run is {apart:.1e} away" if apart > TOLERANCE else ""
        return f"positions are off by {error:.1e}", told

    def _error(self, problem: BenchProblem, position: Floats) -> float:
        truth = self._of(problem).truth
        assert truth is not None
        return problem.error(position, truth.position)

    def _judges(self, problem: BenchProblem) -> bool:
        return self.cell.step is None and self._of(problem).judges

    def _of(self, problem: BenchProblem) -> Known:
        """Return what is known of the scene; found once for all methods."""
        if self._known is None:
            self._known = find_known(problem, self.budget)
        return self._known
