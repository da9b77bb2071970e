"""The integrator of a run: which one begins, when another one takes over, and why."""

import numpy as np

from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.method import MethodChange
from tissuec.engine.method_choice import MethodChoice, choose, measured_facts
from tissuec.engine.method_trial import (
    PATIENT,
    MethodTrial,
    candidate_for,
    cost_of,
    evaluation_time,
    of_other_order,
    pays,
    step_time,
    trial_cost,
)
from tissuec.engine.stability import may_be_overdamped, sums_at_nodes
from tissuec.engine.stepper import Stepper
from tissuec.engine.unknowns import SolvingCost
from tissuec.kernels.records import OUTSIZE, UNDERFLOW, UNSOLVED
from tissuec.mechanics.state import State
from tissuec.script.plan import AUTOMATIC


class MethodControl:
    """Chooses the integrator of a stepper, and changes it between steps.

    Attributes:
        changes: The integrators in turn.
        trial: Whether another one comes further.
        facts: As ``measured_facts`` gives them, if they are known.
    """

    def __init__(self, stepper: Stepper):
        self._stepper, self._method = stepper, stepper.method
        self._choice: MethodChoice | None = None
        self.changes: list[MethodChange] = []
        self.trial = MethodTrial()
        self.facts: dict[str, float] | None = None
        self._spent, self._counted = 0.0, np.zeros(5, dtype=np.int64)

    @property
    def cost(self) -> float:
        """Return the predicted time of all steps so far, each at what it cost then [s]."""
        if not self.begun:
            return 0.0
        return self._spent + self._cost_of(self._stepper.work.effort - self._counted)

    def book_cost(self) -> None:
        """Add up the cost so far, before what a step costs changes."""
        if self.begun:
            self._spent = self.cost
            self._counted = self._stepper.work.effort.copy()

    @property
    def begun(self) -> bool:
        """Return whether there is an integrator."""
        return self._choice is not None

    @property
    def choice(self) -> MethodChoice:
        """Return the present integrator, and why it was chosen.

        Raises:
            ValueError: There is none yet.
        """
        if self._choice is None:
            raise ValueError("the integrator is chosen by the first restart")
        return self._choice

    @property
    def is_free(self) -> bool:
        """Return whether the method is ours to change."""
        return self._method.name == AUTOMATIC and self._method.step is None

    def install(self, choice: MethodChoice) -> None:
        """Go over to an integrator; the state stays where it is."""
        self.book_cost()
        now = self._stepper.progress.time
        self.changes.append(MethodChange(now, choice.name, choice.reason))
        self._choice = choice
        self._stepper.install(INTEGRATORS[choice.name])

    def begin(self, state: State, choice: MethodChoice | None = None) -> None:
        """Install the integrator to begin with; by default, one that goes with the state."""
        inputs = self._stepper.inputs

        def implicit_step() -> float:
            evaluation = self._evaluation_time
            return step_time("esdirk43", evaluation, inputs.solving_cost) / evaluation

        self.install(choice or choose(state, self._method, inputs.is_direct, implicit_step))

    def yield_to_losses(self, state: State) -> None:
        """Go over to a method for motions that lose energy, if the present one is for none."""
        if self._stepper.integrator.conservative and (refusal := state.loss):
            reason = f"{refusal}, which {self.choice.name} does not support"
            self.install(MethodChoice("dop853", reason, {}))

    def equip(self, state: State, *, begins: bool = False) -> None:
        """Give the integrator what depends on the net: unknowns or the fastest rate.

        Args:
            state: The present one.
            begins: Whether the integrator was chosen for this state, by facts of it.
        """
        stepper = self._stepper
        if stepper.integrator.implicit:
            stepper.work = stepper.work._replace(solver=stepper.inputs.solver())
        if stepper.integrator.stabilised:
            stepper.work.rate[0], stepper.cap = self._pace(state)
        self.facts = dict(self.choice.facts) or None if begins else None
        self.trial.begin(stepper.progress, stepper.work.effort, self.choice.name, self._cost)

    def contend(self, state: State) -> None:
        """Go over to another method if that comes further, where the choice is ours."""
        stepper = self._stepper
        if not self.is_free:
            return
        if stepper.progress.pending or stepper.evaluations < self.trial.look:
            return
        change = self.trial.decide(
            stepper.progress,
            stepper.work.effort,
            self._cost,
            self.choice.name,
            self._method.duration,
            lambda pace: self._candidate(state, pace),
        )
        if change is not None:
            self._change(change, state)

    def rescue(self, reason: int, state: State) -> bool:
        """Go on explicitly where an implicit method failed that was our own choice.

        Args:
            reason: Why the loop over steps returned.
            state: Of the run.
        """
        failed = reason in (UNSOLVED, UNDERFLOW, OUTSIZE)
        implicit = self._stepper.integrator.implicit
        if not (failed and implicit and self._method.name == AUTOMATIC):
            return False
        why = f"{self.choice.name} could not solve the equations of a step"
        self.trial.rival = ""
        self._change(MethodChoice("dop853", why, {}), state)
        return True

    def _candidate(self, state: State, pace: float) -> tuple[str, float] | None:
        """Return a method that may come further, and the predicted time of its trial [s].

        Args:
            state: Of the run.
            pace: Simulated seconds per second of the present method.
        """
        stepper, name, evaluation = self._stepper, self.choice.name, self._evaluation_time
        step = stepper.progress.step
        stepper.synchronise(state)
        ahead, first = self._method.duration - stepper.progress.time, self.changes[0].method
        price = trial_cost(first if name == "dop853" else "dop853", evaluation, self._solving)
        # The facts are measured only if a trial would pay.
        if pays(price, ahead, pace):
            found = of_other_order(name, first, step, lambda: self._known_facts(state))
            if found is not None:
                return found, price
        if state.fields and not stepper.integrator.implicit and ahead < PATIENT * pace:
            return None
        direct, solving = stepper.inputs.is_direct(), stepper.inputs.solving_cost()
        found = candidate_for(
            name, step, pace, lambda: self._known_facts(state), evaluation,
            direct=direct,
            overdamped=lambda ratio: may_be_overdamped(state, sums_at_nodes(state), ratio),
        )  # fmt: skip
        if found is None:
            return None
        return found, trial_cost(found, evaluation, solving)

    def _known_facts(self, state: State) -> dict[str, float]:
        """Return the facts, measured where they are not known yet."""
        self.facts = self.facts or measured_facts(state)
        return self.facts

    def _change(self, choice: MethodChoice, state: State) -> None:
        """Go over to another method between two steps."""
        stepper = self._stepper
        stepper.synchronise(state)
        was_implicit = stepper.integrator.implicit
        self.install(choice)
        stepper.forget_net()
        self.equip(state)
        if was_implicit and not stepper.integrator.implicit:
            stepper.update(step=min(stepper.first_step(), stepper.progress.step))
        stepper.limit_step()

    @property
    def _cost(self) -> float:
        """Return the predicted time of all steps so far, at what they cost now [s]."""
        return self._cost_of(self._stepper.work.effort)

    def _cost_of(self, effort: np.ndarray) -> float:
        """Return the predicted time of some steps, at what they cost now [s]."""
        return cost_of(effort, self._evaluation_time, self._solving)

    def evaluations_in(self, time: float) -> int:
        """Return how many force evaluations are predicted to take a time [s], at least one."""
        return 1 + int(time / self._evaluation_time)

    @property
    def _solving(self) -> SolvingCost:
        """Return the cost of the matrix of the present method; nothing if it has none."""
        stepper = self._stepper
        if not stepper.integrator.implicit:
            return SolvingCost(0.0, 0.0)
        return stepper.inputs.solving_cost()

    @property
    def _evaluation_time(self) -> float:
        """Return the predicted time of a force evaluation [s]."""
        inputs = self._stepper.inputs
        if inputs.evaluation is None:
            inputs.evaluation = evaluation_time(inputs.state, len(inputs.springs.ids))
        return inputs.evaluation

    def _pace(self, state: State) -> tuple[float, float]:
        """Return the fastest rate [1/s] of a state, and the longest step at it [s]."""
        facts = measured_facts(state)
        omega, zeta = facts["omega"], facts["zeta"]
        if not omega:
            return facts["damping"], np.inf
        fastest = omega * (zeta + np.sqrt(zeta * zeta - 1.0)) if zeta > 1.0 else omega
        return float(fastest), self._stepper.integrator.stability_limit(omega, zeta)
