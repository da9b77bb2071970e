"""The verdict on one scene and one method.

Silently wrong is what came to its end without a word and holds no number, or energy from
nowhere, or momentum that no force gave it, or positions further off than ten tolerances and
no twin that tells.
"""

from dataclasses import dataclass, replace
from typing import Literal

from tissuec.bench.ours import AUTOMATIC, EngineSolver
from tissuec.bench.problem import Problem
from tissuec.bench.stress.cells import TOLERANCE, Cell
from tissuec.bench.stress.known import Known, find_known
from tissuec.bench.stress.looking import Look, look
from tissuec.bench.trial import Deadline, Failed, OutOfTime
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.pipeline import Request, compile_request
from tissuec.running.companion import FINER

Kind = Literal["good", "energy", "warned", "refused", "slow", "none", "wrong", "crash"]
MANY = 10.0  # tolerances that a position may be off
# Of the tolerance, which is of positions: energies go with squares, and with velocities that
# methods of low order keep less well.
ENERGIES = 4.0
MADE = 0.5  # part of the energy that a fixed step may not make from nothing


@dataclass(frozen=True, slots=True)
class Verdict:
    """What came of a scene with a method.

    Attributes:
        kind: "good"; "energy" where the motion is chaotic or not known, so that only energy and
            momentum were judged, and are good; "warned" or "refused", whatever the result;
            "slow" beyond the budget; "none" where another method took over; "wrong" without a
            word; "crash".
        why: A sentence for what is not good.
    """

    axis: str
    value: str
    method: str
    kind: Kind
    why: str
    scene: str


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
        try:
            kind, why = self._try(method)
        except CompileError as error:
            kind, why = "refused", str(error)
        except Failed as failure:
            kind, why = "refused", str(failure)
        except OutOfTime:
            kind, why = "slow", f"more than {self.budget:g} s"
        except Exception as error:
            kind, why = "crash", f"{type(error).__name__}: {error}"
        cell = self.cell
        return Verdict(cell.axis, cell.value, method, kind, why, cell.text(method))

    def _try(self, method: str) -> tuple[Kind, str]:
        text = self.cell.text(method)
        compiled, warnings = compile_request(Request(Source("scene.tis", text)))
        problem = Problem.of(compiled)
        # Energies are kept in this run; positions are judged in another one.
        plan = replace(problem.plan, simulation=compiled.plan.simulation)
        seen, why = look(problem, plan, Deadline(self.budget))
        if seen is None:
            return "refused", why
        if method not in (AUTOMATIC, seen.method):
            return "none", f"{seen.method} took over"
        wrong, told = self._energies(seen), ""
        if not wrong:
            wrong, told = self._positions(problem, method)
        if not wrong:
            return ("good" if self._judges(problem) else "energy"), ""
        told = warnings[0].code if warnings else told
        return ("warned", f"{told}; {wrong}") if told else ("wrong", wrong)

    def _energies(self, seen: Look) -> str:
        """Return what is wrong with numbers, energy and momentum; empty if nothing is."""
        if not seen.finite:
            return "positions or velocities are no numbers"
        if self.cell.step is not None:
            made = seen.made > MADE
            return f"{seen.made:.1g} of the energy came from nothing" if made else ""
        if seen.imbalance > ENERGIES * TOLERANCE:
            return f"energy is off by {seen.imbalance:.1e}"
        drift = seen.drift > TOLERANCE
        return f"momentum is off by {seen.drift:.1e}" if drift else ""

    def _positions(self, problem: Problem, method: str) -> tuple[str, str]:
        """Return what is wrong with positions, and what a run says of that.

        Both are empty if nothing is wrong, or nothing is known.
        """
        if not self._judges(problem):
            return "", ""
        truth = self._of(problem).truth
        assert truth is not None
        # As users run it: without energies, which ask for steps of their own.
        solver = EngineSolver(problem, method, tier=None)
        trial = solver.solve(TOLERANCE, Deadline(self.budget))
        error = problem.error(trial.position, truth.position)
        if error <= MANY * TOLERANCE:
            return "", ""
        # Beside a run of theirs goes its twin, whose distance is told.
        twin = solver.solve(TOLERANCE / FINER, Deadline(FINER * self.budget))
        apart = problem.error(trial.position, twin.position)
        told = f"a finer run is {apart:.1e} away" if apart > TOLERANCE else ""
        return f"positions are off by {error:.1e}", told

    def _judges(self, problem: Problem) -> bool:
        return self.cell.step is None and self._of(problem).judges

    def _of(self, problem: Problem) -> Known:
        """Return what is known of the scene; found once for all methods."""
        if self._known is None:
            self._known = find_known(problem, self.budget)
        return self._known
