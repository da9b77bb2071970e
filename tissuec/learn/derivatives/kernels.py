"""Derivatives of accelerations and of steps, compiled."""

from collections.abc import Callable

from tissuec.compiled.calls import Shipped
from tissuec.compiled.laws import partial_address
from tissuec.compiled.record_tables import tabulated
from tissuec.engine.integrators import derivatives_kernel as steps
from tissuec.forces import accelerations_derivatives_kernel as accelerations
from tissuec.forces import springs_derivatives_kernel as springs
from tissuec.kernels.derivative_records import Laws
from tissuec.laws import Law
from tissuec.laws.partial import ARGUMENTS


def _shipped(function: Callable[..., None]) -> Shipped:
    return Shipped(function, "derivatives")


acceleration = _shipped(accelerations.acceleration)
blocks = _shipped(springs.blocks)
pull_back = _shipped(accelerations.pull_back)
push_forward = _shipped(accelerations.push_forward)
begin_dues = _shipped(steps.begin_dues)
combine_stage = _shipped(steps.combine_stage)
enter_stage = _shipped(steps.enter_stage)
leave_step = _shipped(steps.leave_step)
step_back = _shipped(steps.step_back)
step_change = _shipped(steps.step_change)
step_forward = _shipped(steps.step_forward)
weigh_stage = _shipped(steps.weigh_stage)


def compiled_laws(laws: tuple[Law, ...], constants: int) -> Laws:
    """Return laws as kernels call them.

    Args:
        laws: The first is the linear one.
        constants: How many of their constants may change.
    """
    curved = len(laws) > 1
    places = {name: partial_address(name, laws, constants) for name in ARGUMENTS if curved}
    return tabulated(Laws(curved, **places))
