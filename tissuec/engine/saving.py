"""What an engine is resumed from, as numbers and arrays by name."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from msgspec.structs import asdict, astuple

from tissuec.engine.method import MethodChange
from tissuec.engine.method_choice import MethodChoice
from tissuec.engine.method_control import MethodControl
from tissuec.engine.method_trial import MethodTrial
from tissuec.engine.stepper import ContactListing, Stepper
from tissuec.kernels.records import Progress
from tissuec.mechanics.state import State


def saved_engine(stepper: Stepper, control: MethodControl) -> dict[str, Any]:
    """Return everything that a run needs between two steps besides its state."""
    now, work, listing = stepper.progress, stepper.work, stepper.listing
    around = listing.around
    return {
        **asdict(now),
        "segment": np.nan if stepper.segment is None else stepper.segment,
        "stretch": stepper.inputs.start,
        "acceleration": stepper.inputs.outwards(work.a[now.current]),
        "origin": stepper.inputs.positions(work.origin),
        "drift": stepper.inputs.outwards(work.drift),
        "ledger": work.ledger[now.current].copy(),
        "power": work.power[1].copy(),
        "trend": work.trend.copy(),
        "effort": work.effort.copy(),
        "doubt": work.doubt.copy(),
        "rate": work.rate[0],
        "cap": stepper.cap,
        "facts": json.dumps(control.facts),
        "made": work.solver.made[0],
        "made_time": work.solver.made[3],
        "made_at": work.solver.at.copy(),
        "made_speed": work.solver.speed.copy(),
        "bound": stepper.task.bound,
        "tier": stepper.backend,
        **{f"listed {name}": value for name, value in asdict(listing).items()},
        "listed around": np.zeros((0, 3)) if around is None else around,
        "slipping": stepper.slipping.copy(),
        **{f"contest {name}": value for name, value in control.trial.state().items()},
        "changes": json.dumps([astuple(change) for change in control.changes]),
        "method": control.choice.name,
        "reason": control.choice.reason,
    }


def restore_control(control: MethodControl, kept: Mapping[str, Any]) -> None:
    """Set which integrators there were, and what is known of the present state and a trial."""
    control.trial = MethodTrial.restore(
        {name.removeprefix("contest "): value for name, value in kept.items()}
    )
    control.facts = json.loads(str(kept["facts"]))
    control.changes = [MethodChange(*change) for change in json.loads(str(kept["changes"]))]


def saved_choice(kept: Mapping[str, Any]) -> MethodChoice:
    """Return the integrator that a run was saved with."""
    return MethodChoice(str(kept["method"]), str(kept["reason"]), {})


def restore_stepper(stepper: Stepper, state: State, kept: Mapping[str, Any]) -> None:
    """Set the numbers of a stepper that has loaded a state.

    Args:
        stepper: With the integrator that it was saved with.
        state: The one that belongs to the checkpoint.
        kept: What ``saved_engine`` returned; numbers may come back as those of NumPy.
    """
    inputs, present = stepper.inputs, asdict(stepper.progress)
    numbers = {name: type(value)(kept[name]) for name, value in present.items()}
    stepper.progress = Progress(**numbers | {"filled": 0, "current": 0})
    stepper.backend = str(kept["tier"])
    _restore_arrays(stepper, state, kept)
    stepper.asked = stepper.evaluations
    segment = float(kept["segment"])
    stepper.segment = None if np.isnan(segment) else segment
    inputs.start, inputs.until = float(kept["stretch"]), segment
    stepper.cap = float(kept["cap"])
    # Steps are cut by how far nodes are from where they were listed: so those lists again.
    around = np.asarray(kept["listed around"])
    stepper.listing = ContactListing(
        at=float(kept["listed at"]),
        around=around if len(around) else None,
        step=int(kept["listed step"]),
        share=float(kept["listed share"]),
        is_tried=bool(kept["listed is_tried"]),
    )
    stepper.task = stepper.task._replace(bound=float(kept["bound"]))
    stepper.limit_step()
    stepper.let_slip(np.asarray(kept["slipping"]))


def _restore_arrays(stepper: Stepper, state: State, kept: Mapping[str, Any]) -> None:
    work, inwards = stepper.work, stepper.inputs.inwards
    if stepper.integrator.implicit:
        work.solver.at[:] = kept["made_at"]
        work.solver.speed[:] = kept["made_speed"]
        work.solver.made[:4] = kept["made"], 0.0, 1.0, kept["made_time"]
    work.effort[:], work.doubt[:] = kept["effort"], kept["doubt"]
    work.a[0] = inwards(np.asarray(kept["acceleration"]))
    work.v[0] = inwards(state.velocity)
    work.origin[:] = inwards(np.asarray(kept["origin"]))
    work.drift[:] = inwards(np.asarray(kept["drift"]))
    work.ledger[0], work.power[1] = kept["ledger"], kept["power"]
    work.trend[:], work.rate[0] = kept["trend"], kept["rate"]
