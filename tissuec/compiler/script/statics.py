"""What cannot be static, or stepped by a method: whole runs, and intervals of them."""

from tissuec.core.errors import Note
from tissuec.core.units import TIME, show
from tissuec.model.network import Network
from tissuec.scene.model import Scene
from tissuec.scene.reading.findings import Findings
from tissuec.script.plan import RELAXATION, Plan
from tissuec.script.verbs.settle import StaticInterval


def refuse_method(scene: Scene, network: Network, findings: Findings) -> None:
    """Reject a method that does not step the internal variables of springs and elements."""
    name = scene.simulation.integrator
    if scene.simulation.is_static and network.relaxes:
        said = f"{name} does not support {_relaxing(network)}: it ignores time"
        hint = "write integrator is automatic, or the name of another method such as dop853"
        findings.add("TIS306", said, scene.simulation.span, hint=hint)
    if name == RELAXATION and scene.glues:
        said = f"{name} moves nodes by the springs at them, which glued nodes do not have alone"
        hint = "write integrator is equilibrium"
        findings.add("TIS306", said, scene.simulation.span, hint=hint)


def refuse_intervals(scene: Scene, network: Network, plan: Plan, findings: Findings) -> None:
    """Reject static intervals of tissue that needs time, of static runs, and in one another.

    Args:
        network: Its net.
        plan: The plan of its script.
        findings: Where errors are added.
    """
    name = scene.simulation.integrator
    for interval in plan.static_intervals:
        if scene.simulation.is_static:
            said = f"settle over an interval has no effect: {name} is always static"
            hint = "remove it, or write integrator is automatic"
        elif network.relaxes:
            said = f"{_relaxing(network)} cannot settle over an interval: they need time"
            hint = "let them move instead, as slowly as they need, or settle at one time"
        else:
            continue
        findings.add("TIS306", said, interval.span, hint=hint)
    _refuse_overlaps(plan, findings)


def _refuse_overlaps(plan: Plan, findings: Findings) -> None:
    """Reject static intervals that begin within an earlier one."""
    begin = end = -1.0
    earlier = None
    for event in plan.events:
        one = event.action
        if not isinstance(one, StaticInterval):
            continue
        stop = event.time + one.duration
        if earlier is not None and event.time < end:
            whole = f"from {show(begin, TIME)} to {show(max(stop, end), TIME)}"
            findings.add(
                "TIS403",
                f"everything is static already at {show(event.time, TIME)}",
                one.span,
                hint=f"write one interval: {whole}: settle",
                notes=(Note("the other interval", earlier.span),),
            )
        else:
            begin = event.time
        if stop > end:
            end, earlier = stop, one


def _relaxing(network: Network) -> str:
    """Return the relaxing or yielding tissue, in words for messages."""
    what = "springs" if network.springs.inelastic is not None else "elements"
    return f"{what} that relax or yield"
