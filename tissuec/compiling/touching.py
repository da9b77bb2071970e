"""Tools that have a shape: their nodes behind those of the bodies, and what they touch."""

from collections.abc import Sequence
from dataclasses import replace
from math import sqrt
from typing import NoReturn

import numpy as np

from tissuec.contact import Contact
from tissuec.core.source import Span
from tissuec.core.units import LENGTH, STIFFNESS, show
from tissuec.network import Floats, Indices, Network, Origin, Provenance, ToolPart
from tissuec.scene.findings import Findings
from tissuec.scene.model import Environment, Tool

SOFTEST_LAYER = 0.1  # of the mean length of a spring
THINNEST = 0.5  # of the radius of the thinnest tool


def with_tools(network: Network, tools: Sequence[Tool], *, rubbed: bool) -> Network:
    """Return a network with the nodes that carry the shapes of tools, and bristles.

    Args:
        rubbed: Whether there is friction, which is remembered at each node of a body.
    """
    shaped = [tool for tool in tools if tool.shapes]
    if not shaped:
        return network
    points = [np.concatenate([shape.points for shape in tool.shapes]) for tool in shaped]
    ends = network.node_count + np.cumsum([0, *map(len, points)])
    parts = tuple(
        ToolPart(tool.name, slice(int(start), int(stop)), tool.span)
        for tool, start, stop in zip(shaped, ends, ends[1:], strict=False)
    )
    home = network.position if rubbed else network.position[:0]
    memory = slice(int(ends[-1]), int(ends[-1]) + len(home))
    added = np.concatenate([*points, home])
    spans = [tool.span for tool, p in zip(shaped, points, strict=True) for _ in p]
    spans += [shaped[0].span] * len(home)
    grams = np.ones(len(added))
    return replace(
        network,
        position=np.concatenate([network.position, added]),
        velocity=np.concatenate([network.velocity, np.zeros_like(added)]),
        mass=np.concatenate([network.mass, 1e-3 * grams]),
        node_ids=np.concatenate([network.node_ids, np.arange(len(added))]),
        provenance={**network.provenance, "mass": _joined(network.provenance["mass"], spans)},
        tools=parts,
        memory=memory,
    )


def _joined(provenance: Provenance, spans: Sequence[Span]) -> Provenance:
    origins = tuple(Origin(span, "tool") for span in spans)
    more = len(provenance.origins) + np.arange(len(spans), dtype=np.int32)
    return Provenance(np.concatenate([provenance.index, more]), (*provenance.origins, *origins))


def contact_of(
    network: Network, tools: Sequence[Tool], environment: Environment, findings: Findings
) -> Contact | None:
    """Return what tools touch, None if nothing does."""
    shapes = [shape for tool in tools for shape in tool.shapes]
    law, nodes = environment.contact, np.arange(network.body_nodes)
    if law is None or not shapes:
        if not findings.errors:  # else what is missing may be what was wrong
            _warn_of_contact_in_vain(tools, environment, findings)
        return None
    radius = np.array([s.radius if s.kind == "capsule" else -1.0 for s in shapes])
    stiffness = law.stiffness or _stiffness(network, environment, findings)
    layer = law.layer or _layer(network, radius, environment, findings)
    start = network.tools[0].nodes.start
    points: Indices = start + np.arange(2 * len(shapes)).reshape(-1, 2)
    mass = float(network.mass[nodes].mean()) if len(nodes) else 1.0
    return Contact(
        nodes=nodes,
        points=points,
        radius=radius,
        stiffness=stiffness,
        layer=layer,
        damping=law.damping,
        friction=law.friction,
        memory=np.arange(network.memory.start, network.memory.stop),
        rate=sqrt(stiffness / mass),
        span=environment.span,
    )


def _warn_of_contact_in_vain(
    tools: Sequence[Tool], environment: Environment, findings: Findings
) -> None:
    if environment.contact is not None:
        text = "no tool has a shape that could touch"
        hint = (
            "for example: tool probe { kind is probe; radius = 3 mm; centre = (0, 0, 10) mm }"
        )
        findings.add("W406", text, environment.span, hint=hint)
        return
    for tool in tools:
        if tool.shapes:
            text = f"{tool.name} has a shape, but contact is off: it touches nothing"
            hint = "write: environment { contact is tools only; … }"
            findings.add("W406", text, tool.span, hint=hint)


def _stiffness(network: Network, environment: Environment, findings: Findings) -> float:
    """Return the mean over the nodes of what their springs resist with [N/m]."""
    steep = network.behaviour().steepness(np.zeros(network.spring_count))
    each = np.bincount(network.ends.ravel(), np.repeat(steep, 2), network.body_nodes)
    if each.any():
        return float(each[each > 0.0].mean())
    _unknown("contact stiffness", show(1e3, STIFFNESS), environment, findings)


def _layer(
    network: Network, radius: Floats, environment: Environment, findings: Findings
) -> float:
    """Return a tenth of the mean length of a spring, and no more than thin tools allow [m]."""
    ends = network.position[network.ends]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    thin = THINNEST * radius[radius > 0.0]
    if len(lengths):
        return min(SOFTEST_LAYER * float(lengths.mean()), float(thin.min(initial=np.inf)))
    if len(thin):
        return SOFTEST_LAYER * float(thin.min())
    _unknown("contact layer", show(1e-3, LENGTH), environment, findings)


def _unknown(name: str, example: str, environment: Environment, findings: Findings) -> NoReturn:
    findings.reject(
        "TIS304",
        f'environment needs "{name}", because no spring tells it',
        environment.span,
        hint=f"for example: {name} = {example}",
    )
