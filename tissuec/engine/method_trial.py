"""Trials of integrators against others that may come further, by pace.

Whether a scene is stiff is not to be seen from its fastest rates: what counts is how much
larger than these allow the steps could be, and that shows in trying. So where stability limits
the steps of an explicit method, the other kind is tried for a while, where accuracy limits
those of a low order, order 8, and the one that comes further in its time continues. That time
is predicted from counts, not taken by a clock, so that a run gives the same bytes again; the
costs were measured. Each look is later than the last by a factor, so that trials stay a small
part of the whole.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import asdict

from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.method_choice import MethodChoice
from tissuec.engine.unknowns import SolvingCost
from tissuec.kernels.records import Progress
from tissuec.mechanics.state import State
from tissuec.model.network import FRICTION

STEPS = 30  # of a window: the first one after a change lets steps grow, the second is measured
GLANCE = 12  # force evaluations after which a trial is checked
BOUND = 0.35  # part of the stability limit from which on it counts as what limits the steps
# Predicted time to come below which nothing is tried [s]: about what translating another method
# takes at its first use.
WORTHWHILE = 0.5
# The same where more than springs acts: what is left of solving equations sets off motions that
# explicit steps leave alone, such as a ring that crumples under a sling.
PATIENT = 60.0
TRIALS = 20.0  # times as much as a trial costs must be to come
BETTER = 1.1  # times as far that the other method must come
OVERDAMPED = 5.0  # damping ratio from which a stabilised method is worth a trial
HELD = 0.7  # part of the stability limit that explicit steps of a stiff net come to
# Time of a force evaluation per spring and per node with all that follows from it.
SPRING, NODE, CALL = 4e-9, 6e-9, 3e-7


class MethodTrial(Struct):
    """The state of the trial; all of it goes into checkpoints.

    Attributes:
        look: Force evaluations at which to look again.
        length: Of the next window of the continuing method, in force evaluations.
        window: Of the window under way; short in a trial, whose evaluations may cost more.
        end: Force evaluations at which it ends.
        allowance: What each window of a trial may cost if it falls behind [s], 0 outside of
            trials.
        warming: Whether the window under way only lets steps grow.
        time: When the window began [s].
        spent: Predicted cost until then [s].
        rival: The other method, if it was tried; its pace is in simulated seconds per second.
        rival_pace: What it reached.
    """

    look: int = 0
    length: int = 0
    window: int = 0
    end: int = 0
    allowance: float = 0.0
    warming: bool = True
    time: float = 0.0
    spent: float = 0.0
    rival: str = ""
    rival_pace: float = 0.0

    def begin(self, now: Progress, effort: np.ndarray, name: str, cost: float) -> None:
        """Open a window after any change, or the first one.

        Args:
            now: Between two steps.
            effort: Counts as in ``Work.effort``, dimensionless, shape (5,).
            name: Name of the present method.
            cost: Predicted so far [s].
        """
        self.length = self.length or STEPS * INTEGRATORS[name].evaluations
        self._open(now, effort, cost, self.window or self.length, warming=True)

    def decide(
        self,
        now: Progress,
        effort: np.ndarray,
        cost: float,
        name: str,
        duration: float,
        candidate: Callable[[float], tuple[str, float] | None],
    ) -> MethodChoice | None:
        """Return the method to change to, or None to keep the present one.

        Args:
            now: Between two steps.
            effort: As ``Work.effort``, shape (5,).
            cost: Predicted so far [s].
            name: Name of the present method.
            duration: Of the run [s].
            candidate: Given the pace of the present method, in simulated seconds per second,
                returns another one that may be faster, and the predicted cost of a trial [s].
        """
        if effort[0] < self.look:
            return None
        pace = (now.time - self.time) / max(cost - self.spent, 1e-12)
        behind = self.rival_pace > BETTER * pace
        # Equations that are hard to solve may cost many times as much as was predicted.
        lost = behind and cost - self.spent > self.allowance > 0.0
        if effort[0] < self.end and not lost:
            self.look = min(int(effort[0]) + GLANCE, self.end)
            return None
        if self.warming and not lost:
            self._open(now, effort, cost, self.window, warming=False)
            return None
        ahead = duration - now.time
        change, window, allowance = None, self.length, 0.0
        if self.rival and behind:
            gain = self.rival_pace / pace if pace else np.inf
            reason = (
                f"it advances {gain:.2g} times as fast as {name}, estimated from "
                "operation counts"
            )
            change, self.rival, self.rival_pace = (
                MethodChoice(self.rival, reason, {}),
                name,
                pace,
            )
            self.length *= 4
            window = self.length
        elif not self.rival and (found := self._worth_trying(pace, ahead, candidate)):
            other, price = found
            change = MethodChoice(other, _why_tried(name, other), {})
            self.rival, self.rival_pace = name, pace
            window, allowance = STEPS * INTEGRATORS[other].evaluations, 0.5 * price
        else:
            # What the other method was worth then is forgotten, so that it is tried again.
            self.length, self.rival = 2 * self.length, ""
            window = self.length
        self.allowance = allowance
        self._open(now, effort, cost, window, warming=change is not None)
        return change

    def _worth_trying(
        self, pace: float, ahead: float, candidate: Callable[[float], tuple[str, float] | None]
    ) -> tuple[str, float] | None:
        """Return another method and what its trial costs [s], if enough time [s] is ahead."""
        found = candidate(pace) if ahead > WORTHWHILE * pace else None
        return found if found is not None and pays(found[1], ahead, pace) else None

    def _open(
        self, now: Progress, effort: np.ndarray, cost: float, window: int, *, warming: bool
    ) -> None:
        self.window, self.end = window, int(effort[0]) + window
        self.look = min(self.end, int(effort[0]) + GLANCE) if self.allowance else self.end
        self.time, self.spent, self.warming = now.time, cost, warming

    def state(self) -> dict[str, Any]:
        """Return all of it for a checkpoint."""
        return asdict(self)

    @classmethod
    def restore(cls, saved: Mapping[str, Any]) -> "MethodTrial":
        """Return the value of ``state``; numbers may be those of NumPy."""
        fresh = cls()
        return cls(**{name: type(value)(saved[name]) for name, value in asdict(fresh).items()})


def pays(price: float, ahead: float, pace: float) -> bool:
    """Return whether so much is to come that a trial may be worth what it costs.

    Args:
        price: Predicted time of the trial [s].
        ahead: What is to be simulated yet [s].
        pace: Simulated seconds per second of the present method.
    """
    return ahead > TRIALS * price * pace


def evaluation_time(state: State, springs: int) -> float:
    """Return the predicted time of a compiled force evaluation [s].

    Args:
        springs: That act.
    """
    embedding, coupling = state.embedding, state.coupling
    beside = sum(field.seconds for field in state.fields if field is not embedding)
    beside += 0.0 if coupling is None else coupling.seconds
    network, contact = state.network, state.contact
    rows = network.row_count - len(state.parked[0])
    if contact is not None:  # what is in reserve for cuts has no place
        rows += len(contact.memory) - len(network.remembering(FRICTION))
    return CALL + SPRING * springs + NODE * rows + beside


def cost_of(effort: np.ndarray, evaluation: float, solving: SolvingCost) -> float:
    """Return the predicted time of compiled steps so far [s].

    Args:
        effort: As ``Work.effort``, shape (5,).
        evaluation: Predicted time of a force evaluation [s].
        solving: Of the matrix of implicit steps.
    """
    return float(
        effort[0] * evaluation + effort[1] * solving.factor + effort[2] * solving.solution
    )


def of_other_order(
    name: str, first: str, step: float, facts: Callable[[], Mapping[str, float]]
) -> str | None:
    """Return an explicit method of another order that may come further, else None.

    Order 8 where its steps may be longer, and from it back to the method that was the first,
    where stability limits them.

    Args:
        name: Of the present method.
        first: Of the method that the run began with.
        step: The present step [s].
        facts: Returns what ``measured_facts`` does, which takes time.
    """
    high, low = INTEGRATORS["dop853"], INTEGRATORS[first]
    special = low.implicit or low.stabilised or low.conservative
    if special or first == "dop853" or name not in (first, "dop853"):
        return None
    limit = high.stability_limit(facts()["omega"], facts()["zeta"])
    if name == "dop853":
        return first if step > BOUND * limit else None
    is_longer = HELD * limit / high.evaluations > BETTER * step / low.evaluations
    return "dop853" if is_longer else None


def candidate_for(
    name: str,
    step: float,
    pace: float,
    facts: Callable[[], Mapping[str, float]],
    evaluation: float,
    *,
    direct: bool,
    overdamped: Callable[[float], bool],
) -> str | None:
    """Return a method that may be faster: implicit for explicit at its limit, or back.

    Solved by conjugate gradients, implicit steps of solid blocks cost more than explicit ones
    even there; overdamped nets are left to stabilised methods.

    Args:
        name: Of the present method.
        step: Its present step [s].
        pace: Its simulated seconds per second.
        facts: Returns what ``measured_facts`` does, which takes time.
        evaluation: Predicted time of a force evaluation [s].
        direct: Whether the matrix of implicit steps has a factor of acceptable size.
        overdamped: Returns whether the damping ratio of the net may exceed a given one.
    """
    member, explicit = INTEGRATORS[name], INTEGRATORS["dop853"]
    if not (member.implicit or direct or overdamped(OVERDAMPED)):
        return None
    omega, zeta = facts()["omega"], facts()["zeta"]
    limit = explicit.stability_limit(omega, zeta)
    if member.implicit:
        foreseen = HELD * limit / (explicit.evaluations * evaluation)
        return "dop853" if foreseen > BETTER * pace else None
    if member.stabilised and direct:
        return "esdirk43"  # the number of stages grows with the step, and no limit shows
    if step < BOUND * member.stability_limit(omega, zeta):
        return None
    if not direct:
        return "rkc2" if zeta > OVERDAMPED else None
    return "esdirk43"


def step_time(name: str, evaluation: float, solving: Callable[[], SolvingCost]) -> float:
    """Return the predicted time of a compiled step [s].

    Args:
        name: Name of the integrator.
        evaluation: Predicted time of a force evaluation [s].
        solving: Returns the cost of the matrix of implicit steps.
    """
    member = INTEGRATORS[name]
    if not member.implicit:
        return member.evaluations * evaluation
    return trial_cost(name, evaluation, solving()) / (2 * STEPS)


def trial_cost(name: str, evaluation: float, solving: SolvingCost) -> float:
    """Return the predicted time of both windows of a trial [s].

    Args:
        name: Name of the integrator.
        evaluation: Predicted time of a force evaluation [s].
        solving: Of the matrix of implicit steps.
    """
    member = INTEGRATORS[name]
    steps, solutions = 2 * STEPS, member.evaluations if member.implicit else 0
    effort = np.array([member.evaluations, int(member.implicit), solutions]) * steps
    return cost_of(effort, evaluation, solving)


def _why_tried(name: str, other: str) -> str:
    """Return why another method is tried instead of the present one."""
    if INTEGRATORS[name].implicit:
        return f"explicit steps at the stability limit may advance faster than {name}"
    if other == "dop853":
        return f"accuracy limits the steps of {name}, and order 8 may allow longer ones"
    return f"stability, not accuracy, limits the steps of {name}"
