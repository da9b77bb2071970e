"""The functions of ``kernels.sensitivity`` and ``kernels.stepping``, compiled."""

from collections.abc import Callable

from tissuec.compiled.calls import Shipped
from tissuec.compiled.laws import partial_address
from tissuec.compiled.record_tables import tabulated
from tissuec.kernels import sensitivity, stepping
from tissuec.kernels.derivative_records import Laws
from tissuec.laws import Law
from tissuec.laws.partial import ARGUMENTS


def _shipped(function: Callable[..., None]) -> Shipped:
    return Shipped(function, "derivatives")


acceleration = _shipped(sensitivity.acceleration)
blocks = _shipped(sensitivity.blocks)
pull_back = _shipped(sensitivity.pull_back)
push_forward = _shipped(sensitivity.push_forward)
begin_dues = _shipped(stepping.begin_dues)
combine_stage = _shipped(stepping.combine_stage)
enter_stage = _shipped(stepping.enter_stage)
leave_step = _shipped(stepping.leave_step)
step_back = _shipped(stepping.step_back)
step_change = _shipped(stepping.step_change)
step_forward = _shipped(stepping.step_forward)
weigh_stage = _shipped(stepping.weigh_stage)


def compiled_laws(laws: tuple[Law, ...], constants: int) -> Laws:
    """Return laws as kernels call them.

    Args:
        laws: The first is the linear one.
        constants: How many of their constants may change.
    """
    curved = len(laws) > 1
    places = {name: partial_address(name, laws, constants) for name in ARGUMENTS if curved}
    return tabulated(Laws(curved, **places))
