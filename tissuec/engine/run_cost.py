"""The predicted time of a run, counted from array sizes so that it is reproducible.

It is that of the whole command ``tissuec run`` without the companion run, as processor time on
one core, with kernels that were compiled before. Besides steps (``method_trial``) and
equilibria (``static_cost``) it has parts whose constants are chosen so that the totals agree
with the shipped scenes (``benchmarks.plans``):

- start: modules are imported, the file is begun and closed, doubts are looked for;
- preparation: the text is compiled and checked, and rates of the net are bounded;
- events: the state is changed, with energies before and after, and its arrays are made anew;
- output: samples are measured and written.

The last two evaluate forces and energies, some of them in Python, which takes a multiple of a
compiled evaluation.
"""

from typing import NamedTuple

from tissuec.engine.execution.recorder import sample_times
from tissuec.engine.integrators import Integrator
from tissuec.mechanics.state import State
from tissuec.results.size import ForeseenEvents, moments
from tissuec.script.plan import EQUILIBRIUM, Plan
from tissuec.script.verbs.irrigate import Irrigate

START, OF_ELEMENTS = 0.5, 0.35  # of all runs, and more where there are elements [s]
# Of preparation [s]: for each node, spring and element.
NODE, SPRING, ELEMENT = 4e-5, 4e-5, 4e-5
# Steps by a tolerance, over those at the limit of stability: shorter ones where something
# begins or ends, and those that are tried again.
MORE = 1.25
FIRST = 200.0  # evaluations of a run whose first steps are cautious
IN_JETS = 2.5  # times as many while a jet blows, which begins and ends at single triangles
# Of an event, a frame, and a row of a log [s], and in evaluations of the forces.
EVENT, EVENT_EVALUATIONS = 3e-3, 400.0
FRAME, FRAME_EVALUATIONS = 1e-3, 10.0
ROW, ROW_EVALUATIONS = 1e-5, 2.5
LEDGER_EVALUATIONS = 15.0  # of a sample where energies are kept
# Of energies of an element, by NumPy, at an event and at a sample [s].
EVENT_ELEMENT, LEDGER_ELEMENT = 1e-4, 8e-6


class RunCost(NamedTuple):
    """The time of the parts of a run [s].

    Attributes:
        motion: Of all steps; NaN where only the tolerance decides how many there are.
        equilibria: Of all equilibria.
    """

    start: float
    preparation: float
    motion: float
    equilibria: float
    events: float
    output: float

    @property
    def seconds(self) -> float:
        """Return the time of all parts [s]."""
        return sum(self)

    @property
    def solving(self) -> float:
        """Return the time of steps and equilibria [s]."""
        return self.motion + self.equilibria


def run_cost(
    state: State,
    plan: Plan,
    foreseen: ForeseenEvents,
    evaluation: float,
    motion: float,
    equilibria: float,
) -> RunCost:
    """Return the predicted time of a run.

    Args:
        state: After the events at 0 s.
        plan: Of the run.
        foreseen: The events after the start.
        evaluation: Time of an evaluation of the forces [s].
        motion: Time of all steps [s].
        equilibria: Time of all equilibria [s].
    """
    net = state.network
    elements = sum(each.item_count for each in net.elements)
    output, duration = plan.output, plan.simulation.duration
    frames = moments(duration, output.every) if len(output.frames) else 0
    rows = sum(moments(duration, log.every) for log in output.logs)
    kept = len(sample_times(plan)) if plan.needs_ledger else 0
    stored = elements if plan.needs_ledger else 0
    in_samples = FRAME_EVALUATIONS * frames + ROW_EVALUATIONS * rows + LEDGER_EVALUATIONS * kept
    return RunCost(
        start=START + OF_ELEMENTS * (elements > 0),
        preparation=NODE * net.body_nodes + SPRING * net.spring_count + ELEMENT * elements,
        motion=motion,
        equilibria=equilibria,
        events=foreseen.times
        * (EVENT + EVENT_EVALUATIONS * evaluation + EVENT_ELEMENT * stored),
        output=FRAME * frames
        + ROW * rows
        + LEDGER_ELEMENT * stored * kept
        + in_samples * evaluation,
    )


def motion_seconds(
    plan: Plan, state: State, integrator: type[Integrator] | None, steps: float, step: float
) -> float:
    """Return the time of all steps [s].

    Args:
        plan: Of the run.
        state: After the events at 0 s.
        integrator: None for statics: equilibria are no part of this, relaxations are.
        steps: At the limit of stability, or of the fixed step; NaN if it is not known.
        step: Time of one at the start [s].
    """
    if integrator is None:
        return 0.0 if plan.simulation.integrator == EQUILIBRIUM else steps * step
    each, duration, jets = integrator.evaluations, plan.simulation.duration, 0.0
    for event in plan.every_event:
        action = event.action
        if not isinstance(action, Irrigate):
            continue
        lasts = max(min(action.profile.stop, duration - event.time), 0.0)
        more = IN_JETS * lasts / duration
        known = state.jets.get(action.nozzle)
        if known is not None and known.span == action.span:  # at 0 s: once in ``step``
            more -= 1.0
        jets += more * each * action.jet(state, action.profile).seconds
    if plan.simulation.step is not None:
        return steps * (step + jets)
    return MORE * steps * (step + jets) + FIRST / each * step
