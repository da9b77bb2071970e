"""Reasons why a scene has no exact derivatives by what is learnt.

A field has derivatives by some of its columns. A number of a force block that enters others,
such as an exponent, has no exact derivatives.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from msgspec.structs import fields

from tissuec.compiler.compile import Compiled
from tissuec.forces.fields import Field
from tissuec.learn.parameters.blocks import ParameterBlock
from tissuec.learn.parameters.numbers import derivatives_of, every_field, preserves
from tissuec.learn.parameters.parametrisation import Parametrisation
from tissuec.learn.parameters.substitution import STEP, recompiled
from tissuec.model.blocks import name_of_force
from tissuec.model.inelastic import VISCOSITY
from tissuec.model.network import Network
from tissuec.script.plan import Plan
from tissuec.script.verbs import VERBS
from tissuec.script.verbs.activate import Activate
from tissuec.script.verbs.change import ChangeMemory, ChangeMotion
from tissuec.script.verbs.hold import Fix, Hold
from tissuec.script.verbs.irrigate import EndJet, Irrigate
from tissuec.script.verbs.move import Move, Turn
from tissuec.script.verbs.preserve import Inflate
from tissuec.script.verbs.settle import EndStaticInterval, Settle, StaticInterval
from tissuec.script.verbs.tie import EndRestLengthChange, Loosen, Tie, Tighten


def refusal(shaping: Parametrisation, *, at_rest: bool = False) -> str:
    """Return why the motion, or the net at rest, has no exact derivatives; empty if it has.

    Args:
        shaping: What is learnt, of which scene.
        at_rest: Whether equilibria are meant.
    """
    plan, network = shaping.compiled.plan, shaping.compiled.network
    if reason := refusal_of_script(plan, network, at_rest=at_rest):
        return reason
    if shaping.stretches and any(isinstance(e.action, Activate) for e in plan.every_event):
        return "the shape without stress of active elements is learnt"
    if shaping.stiffens_by_words:
        return "words change the stiffening of tissues"
    if shaping.refusal:
        return f"the {shaping.refusal} has no exact derivatives"
    if shaping.moves and any(isinstance(e.action, Inflate) for e in plan.every_event):
        return "start positions change the volumes that are inflated"
    if (
        network.springs.inelastic is not None
        and network.springs.inelastic.has(VISCOSITY).any()
        and shaping.order.sizes["constants"]
        and not at_rest
    ):
        return "constants of laws are learned beside yielding"
    if reason := _of_contact(shaping, at_rest=at_rest):
        return reason
    if name := not_derived(shaping.compiled, shaping.blocks):
        return f"the {name} has no exact derivatives"
    return ""


def _of_contact(shaping: Parametrisation, *, at_rest: bool) -> str:
    """Return why contact has no exact derivatives by what is learnt."""
    compiled = shaping.compiled
    contact, law = compiled.network.contact, compiled.scene.environment.contact
    if contact is None or law is None:
        return ""
    if shaping.moves:
        return "start positions change what can touch"
    if at_rest and contact.points.min() < compiled.network.body_nodes:
        return "bodies touch one another"
    follows = law.contact_stiffness is None and law.contact_surface_stiffness is None
    arrays = {block.array for block in shaping.blocks if block.group is not None}
    if follows and ("stiffness" in arrays or shaping.order.sizes["constants"]):
        return "the contact stiffness follows from springs whose numbers or laws are learned"
    return ""


def refusal_of_script(plan: Plan, network: Network, *, at_rest: bool = False) -> str:
    """Return why no learning of a scene has exact derivatives; empty if it may have them.

    Args:
        at_rest: Whether equilibria are meant.
    """
    actions = [event.action for event in plan.every_event]
    if any(body.interfaces for body in network.bodies):
        return "ties of an interface follow from the numbers of its elements"
    if network.of_kind("glue"):
        return "glue with a toughness follows from the numbers of elements"
    if at_rest and plan.triggers:
        return "the script waits for a condition"
    for kind in dict.fromkeys(map(type, actions)):
        if not (at_rest and kind is Settle) and (reason := _of_action(kind)):
            return reason
    for name, field in every_field(plan, network).items():
        if isinstance(field.derivatives, str):
            return f"{name} {field.derivatives}"
    names = [action.group.name for action in preserves(plan)]
    if len(set(names)) < len(names):
        return "a volume is preserved by one pressure after another"
    if any(isinstance(action, ChangeMemory) for action in actions):
        return "the script changes how springs relax or yield"
    for event in plan.every_event:
        if isinstance(event.action, Fix | Hold | Move) and event.action.directions is not None:
            if isinstance(event.action, Move):
                return "nodes are moved in some directions"
            if event.time > 0.0 and not at_rest:
                return "nodes are held in some directions during the script"
    if plan.simulation.is_static and not at_rest:
        return "the net is in equilibrium all the time"
    if any(isinstance(action, ChangeMotion) and action.is_spin for action in actions):
        return "a spin is set during the script"
    return ""


def _of_action(kind: type) -> str:
    """Return why the effect of a kind of action has no exact derivatives; empty if it has."""
    if kind in _UNKNOWN:
        return _UNKNOWN[kind]
    module = kind.__module__
    if module.removeprefix("tissuec.script.verbs.") in _DERIVED:
        return ""
    words = (word for word, verb in VERBS.items() if verb.__module__ == module)
    word = next(words, module.rpartition(".")[2])
    return f"the verb {word} has no exact derivatives"


#: Files of verbs whose effect is derived, but for those below.
_DERIVED = (
    "activate", "acting", "change", "cut", "hold", "jaws", "motion", "move", "preserve", "push",
    "stop",
)  # fmt: skip
#: Why the effect of some actions is not.
_UNKNOWN: dict[type, str] = {
    **dict.fromkeys((Irrigate, EndJet), "a jet acts"),
    Tie: "knots can slip",
    **dict.fromkeys((Tighten, Loosen, EndRestLengthChange), "a thread is tightened"),
    Settle: "the net settles during the script",
    **dict.fromkeys(
        (StaticInterval, EndStaticInterval), "the net is in equilibrium during an interval"
    ),
    Turn: "nodes are turned",
}


def not_derived(compiled: Compiled, blocks: Sequence[ParameterBlock]) -> str:
    """Return the first adjusted number whose effect has no exact derivatives; "" without any.

    Args:
        blocks: Of each entry of a fit problem.
    """
    for block in blocks:
        if not block.is_of_force:
            continue
        field = _force(compiled, block.adjust.of)
        if isinstance(field.derivatives, str):
            continue
        value = float(block.start[0])
        key = block.places[0], block.adjust.what
        moved = recompiled(compiled, {key: value + STEP * (abs(value) or 1.0)}, {})
        if _differs(field, _force(moved, block.adjust.of)):
            return block.names[0]
    return ""


def _force(compiled: Compiled, name: str) -> Field:
    """Return the field of a ``force`` block."""
    return next(b.field for b in compiled.network.blocks if b.name == name_of_force(name))


def _differs(field: Field, other: Field) -> bool:
    """Return whether anything but the columns of a field is otherwise in another one."""
    columns = derivatives_of(field).columns
    names = (one.name for one in fields(field) if one.name not in columns)
    pairs: list[tuple[Any, Any]] = [(getattr(field, n), getattr(other, n)) for n in names]
    return not all(np.array_equal(one, two) for one, two in pairs)
