"""Scene to Network and Plan: meshes are built, sets chosen, sentences become actions.

The same text gives the same bytes: nothing here reads the clock, the machine or a random
number.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.compiler.ambient_damping import with_drag
from tissuec.compiler.bodies.arrays import BodyArrays, build_body
from tissuec.compiler.bodies.drawn import Drawing, draw
from tissuec.compiler.bodies.threads import idle_knots, renumbered
from tissuec.compiler.expectations import split_expectations
from tissuec.compiler.materials.cutting_resistance import joined_resistance
from tissuec.compiler.materials.internal_variables import (
    inelastic_of,
    with_element_memory,
    with_memory,
)
from tissuec.compiler.measures.conditions import Conditions
from tissuec.compiler.output.block import OutputReader
from tissuec.compiler.script.holds import check_holds
from tissuec.compiler.script.inflations import check_inflations
from tissuec.compiler.script.plan import Script, ScriptReader
from tissuec.compiler.script.statics import refuse_intervals, refuse_method
from tissuec.compiler.sets import Groups, PlacedBody
from tissuec.core.arrays import behind_one_another, uniform
from tissuec.core.names import key_of
from tissuec.core.structs import replace
from tissuec.core.units import LENGTH, show
from tissuec.engine.integrators import INTEGRATORS
from tissuec.geometry.affine import Affine
from tissuec.lang.syntax import Expect
from tissuec.laws import is_open
from tissuec.meshes.generators import Celled, Generator
from tissuec.model.blocks import OF_ELEMENTS, FieldBlock
from tissuec.model.guides import Guides
from tissuec.model.network import (
    BodyPart,
    Indices,
    JointPart,
    Network,
    Provenance,
    numbers_in,
)
from tissuec.model.phantoms import Phantoms
from tissuec.model.resistance import CuttingResistance, SurfaceFriction
from tissuec.model.springs import NUMBERS, Springs
from tissuec.results.recording import NamedGroup, members
from tissuec.scene.environment import Environment
from tissuec.scene.model import Body, Scene, Tool
from tissuec.scene.reading.findings import Findings
from tissuec.script.fit_problem import FitProblem
from tissuec.script.plan import Expectation, Plan, ScheduledAction, Simulation
from tissuec.script.verbs import Demanding, may_break
from tissuec.script.verbs.settle import Settle
from tissuec.script.verbs.tie import Tie

if TYPE_CHECKING:
    from tissuec.compiler.bodies.joints import JointArrays
    from tissuec.compiler.symmetry import WrittenPlane
    from tissuec.scene.learning.model import VocabularyFit


class Compiled(Struct, frozen=True, eq=False):
    """A scene in arrays, ready to run.

    Attributes:
        groups: Sets and bodies by name, for checks and reports.
        fit_problems: The learn blocks that fit data, in the order of the text.
        vocabulary_fits: Those that fit words to numbers of tissues.
    """

    scene: Scene
    network: Network
    plan: Plan
    groups: Groups
    fit_problems: tuple[FitProblem, ...] = ()
    vocabulary_fits: "tuple[VocabularyFit, ...]" = ()

    def __repr__(self) -> str:
        name, network = self.scene.source.name, self.network
        return f'<Compiled "{name}": {network.size}, {self.plan.simulation.duration:g} s>'

    def named_groups(self) -> Iterator[NamedGroup]:
        """Yield sets, regions, and the nodes that carry the shapes of tools."""
        yield from self.groups.named()
        for tool in self.network.tools:
            nodes = numbers_in(tool.nodes)
            yield NamedGroup(tool.name, "nodes", nodes)

    def nodes_of(self, name: str) -> Indices:
        """Return the numbers of the nodes of a set or body, shape (node,).

        A region is named with its body: "scar of liver".

        Raises:
            ValueError: There is none of that name.
        """
        return members(self.network, tuple(self.named_groups()), name, "nodes")

    def springs_of(self, name: str) -> Indices:
        """Return the numbers of the springs of a set, body or joint, shape (spring,).

        Of nodes, those with both ends among them.

        Raises:
            ValueError: There is none of that name.
        """
        return members(self.network, tuple(self.named_groups()), name, "springs")


class Bodies:
    """The bodies of a scene.

    Attributes:
        drawings: Of those that can be drawn.
        built: Those that are right altogether.
    """

    def __init__(self, drawings: Sequence[Drawing], built: Sequence[BodyArrays]):
        self.drawings, self.built = drawings, built

    @property
    def are_whole(self) -> bool:
        """Return whether all are right, so that nodes and springs have their numbers."""
        return len(self.built) == len(self.drawings)

    @cached_property
    def network(self) -> Network:
        """Return their network, without joints."""
        return join(self.built)


def compile_scene(scene: Scene, findings: Findings, bodies: Bodies | None = None) -> Compiled:
    """Return the network and the plan of a scene.

    A scene that was found wrong is compiled as far as it is right, so that its other mistakes
    are found too.

    Args:
        bodies: Those of the scene, if they are built already.

    Raises:
        CompileError: The scene, its meshes, sets, the script or the outputs are wrong; holds
            every finding.
    """
    bodies = bodies or build_bodies(scene, findings)
    # Contact comes first: its nodes must directly follow those of the bodies.
    tools = sorted(scene.tools.values(), key=lambda tool: not tool.may_touch)
    groups = Groups(scene.declarations, _place(bodies), scene.constants)
    joints = _joints(scene, groups, findings)
    is_joined = joints and bodies.are_whole
    joined = join(bodies.built, joints) if is_joined else bodies.network
    planes: tuple[WrittenPlane, ...] = ()
    if scene.environment.planes and bodies.are_whole:
        from tissuec.compiler.symmetry import read_planes  # where there are any

        planes = read_planes(scene, joined, findings)
        joined = replace(joined, mirrored=tuple(one.mirror for one in planes))
    braked = with_drag(joined, scene.environment, findings)
    network = with_memory(_with_tools(braked, tools, scene.environment))
    network = with_element_memory(network)
    refuse_method(scene, network, findings)
    _refuse_forces(network, findings)
    groups.choose_all()
    conditions = Conditions(groups, scene)
    expects, of_learning = split_expectations(scene.declarations.expects)
    plan = _plan(scene, network, conditions, expects, is_whole=bodies.are_whole)
    refuse_intervals(scene, network, plan, findings)
    blocks, guides = _blocks(
        scene, network, conditions, plan, planes, is_whole=bodies.are_whole
    )
    fit_problems: tuple[FitProblem, ...] = ()
    vocabulary_fits: tuple[VocabularyFit, ...] = ()
    if scene.fit_problems or scene.vocabulary_fits or of_learning:
        from tissuec.compiler.learning.problems import (
            compile_learn_blocks,  # where something is learnt
        )

        fit_problems, vocabulary_fits = compile_learn_blocks(scene, conditions, of_learning)
    findings.raise_errors()
    assert len(bodies.built) == len(scene.declarations.of("body"))  # only errors leave out any
    whole = replace(network.with_blocks(*blocks), guides=guides)
    return Compiled(scene, whole, plan, groups, fit_problems, vocabulary_fits)


def _refuse_forces(network: Network, findings: Findings) -> None:
    """Reject laws whose force is no number for springs as they are drawn."""
    springs = network.springs
    if len(springs.laws) == 1 or any(map(is_open, springs.laws)):
        return
    between = np.diff(network.position[springs.ends], axis=1)[:, 0]
    elongation = np.linalg.norm(between, axis=1) - springs.rest
    force = springs.behaviour.pull(elongation)
    for spring in np.flatnonzero(~np.isfinite(force))[:1]:
        owner, drawn = network.owner(spring), show(float(elongation[spring]), LENGTH)
        findings.add(
            "TIS504",
            f"the force of spring {springs.ids[spring]} of {owner.name} is not a number "
            f"as drawn, {drawn} longer than its rest length",
            owner.span,
            hint="use a law that grows less steeply, or draw the spring closer to its rest "
            "length",
        )


def build_bodies(scene: Scene, findings: Findings) -> Bodies:
    """Return the bodies of a scene, and report the errors of others."""
    drawings: list[Drawing] = []
    built: list[BodyArrays] = []
    for key, declared in scene.declarations.of("body").items():
        drawing: Drawing | None = None
        with findings.item():
            if key in scene.bodies:
                drawing = draw(scene.bodies[key], scene.constants)
                drawings.append(drawing)
                if drawing.body.is_whole:
                    built.append(_built(drawing, scene, findings))
        if drawing is None:
            findings.doubt(declared.name)
    return Bodies(drawings, built)


def _built(drawing: Drawing, scene: Scene, findings: Findings) -> BodyArrays:
    if drawing.body.elements is None:
        return build_body(drawing, findings)
    from tissuec.compiler.bodies.phantoms import cut_counts, with_phantoms
    from tissuec.compiler.elements.build import build_elements  # most nets have no elements

    planes = [said.plane for said in scene.environment.planes]
    body = drawing.body
    cuts = cut_counts(scene)[key_of(body.name)] + body.tears_by_faces
    is_cut = cuts > 0 or bool(body.interfaces)
    built = build_elements(drawing, findings, planes, is_cut=is_cut)
    return with_phantoms(built, cuts) if is_cut else built


def join(bodies: Sequence[BodyArrays], joints: "Sequence[JointArrays]" = ()) -> Network:
    """Return the network of several bodies, one after the other, and of their joints."""
    nodes = np.cumsum([0, *(len(body.mesh.position) for body in bodies)]).tolist()
    parts: Sequence[BodyArrays | JointArrays] = [*bodies, *joints]
    springs = np.cumsum([0, *(len(part.springs.ids) for part in parts)]).tolist()
    ends = [b.mesh.ends if b.elements else b.mesh.ends[:0] for b in bodies]
    edges = np.cumsum([springs[-1], *map(len, ends)]).tolist()
    counts = [
        sum(one.item_count for one in body.elements) + body.reserve.elements for body in bodies
    ]
    elements = np.cumsum([edges[-1], *counts]).tolist()
    # Joints know the nodes of the net.
    firsts = [*nodes[: len(bodies)], *(0 for _ in joints)]
    joined = Springs.joined(
        [part.springs.behind(first) for part, first in zip(parts, firsts, strict=True)]
    )
    inelastic = inelastic_of([part.memory for part in parts], np.diff(springs).tolist())

    def every(
        pick: Callable[[BodyArrays], NDArray[Any]], kind: type, shape: tuple[int, ...] = ()
    ) -> NDArray[Any]:
        return behind_one_another([pick(body) for body in bodies], kind, shape)

    skins = [_shifted(b.mesh.skin, n) for b, n in zip(bodies, nodes, strict=False)]
    skin = behind_one_another(skins, np.int32, (3,))
    position = every(lambda b: b.mesh.position, np.float64, (3,))
    blocks = _element_blocks(bodies, position, nodes, edges, elements)
    every_end = map(_shifted, ends, nodes)
    body_parts = tuple(
        map(_body_part, bodies, *map(pairwise, (nodes, springs, edges, elements)))
    )
    return Network(
        position=position,
        velocity=every(lambda b: b.velocity, np.float64, (3,)),
        mass=uniform(every(lambda b: b.mass, np.float64)),
        weighing=_weighing(bodies),
        springs=replace(joined, inelastic=inelastic),
        skin=skin,
        node_ids=every(lambda b: b.node_ids, np.int64),
        bodies=body_parts,
        phantoms=_phantoms(body_parts),
        provenance={
            name: _join_provenance([p.provenance[name] for p in parts if name in p.provenance])
            for name in ("mass", *NUMBERS)
        }
        | _breaking(bodies),
        joints=tuple(map(_joint_part, joints, pairwise(springs[len(bodies) :]))),
        blocks=tuple(blocks),
        skin_elements=_skin_elements(skin, blocks, body_parts),
        friction=SurfaceFriction.joined([body.friction for body in bodies]),
        cutting=_cutting(bodies, parts, blocks, elements[0]),
        edges=behind_one_another([*every_end], np.int32, (2,)),
    )


def _weighing(bodies: Sequence[BodyArrays]) -> NDArray[np.float64] | None:
    """Return weights over those that masses would have; None if none differs."""
    if all(body.weighing is None for body in bodies):
        return None
    each = [np.ones_like(b.mass) if b.weighing is None else b.weighing for b in bodies]
    return np.concatenate(each)


# Most nets have no elements, and need none of what places them.


def _breaking(bodies: Sequence[BodyArrays]) -> dict[str, Provenance]:
    """Return where the limits of elements come from, as "breaking", if there are any."""
    known = [body.breaking for body in bodies if body.breaking is not None]
    return {"breaking": _join_provenance(known)} if known else {}


def _element_blocks(
    bodies: Sequence[BodyArrays],
    position: NDArray[np.float64],
    nodes: Sequence[int],
    edges: Sequence[int],
    elements: Sequence[int],
) -> list[FieldBlock]:
    """Return the blocks of elements, and of the bending of walls of them.

    Args:
        bodies: The bodies, whose first nodes, edges and elements are ``nodes``, ``edges``
            and ``elements``.
        position: Of all nodes [m], shape (node, 3).
    """
    blocks: list[FieldBlock] = []
    for body, n, edge, one in zip(bodies, nodes, edges, elements, strict=False):
        blocks += [each.placed(n, one).block for each in body.elements]
        if body.bends is not None:
            first = one if body.body.may_rupture or body.reserve.nodes else None
            blocks.append(body.bends.block(position, n, body.mesh.ends + n, edge, first))
    return blocks


def _phantoms(bodies: Sequence[BodyPart]) -> tuple[Phantoms, ...]:
    if not any(body.reserve.nodes for body in bodies):
        return ()
    from tissuec.compiler.bodies.phantoms import phantoms_of_bodies

    return phantoms_of_bodies(bodies)


def _skin_elements(
    skin: NDArray[np.int32], blocks: Sequence[FieldBlock], bodies: Sequence[BodyPart]
) -> Indices | None:
    if not blocks:
        return None
    from tissuec.compiler.elements.limits import skin_elements

    return skin_elements(skin, blocks, {body.name for body in bodies if body.reserve.nodes})


def _cutting(
    bodies: Sequence[BodyArrays],
    parts: "Sequence[BodyArrays | JointArrays]",
    blocks: Sequence[FieldBlock],
    first: int,
) -> CuttingResistance | None:
    """Return the resistance to cuts; None if blades need no energy anywhere.

    Args:
        first: The first of all elements as an entity.
    """
    every = [
        np.append(b.element_resistance, np.zeros(b.reserve.elements))
        for b in bodies
        if b.element_resistance is not None
    ]
    each = behind_one_another(every, float)
    fields = {block.name: block.field for block in blocks if block.kind in OF_ELEMENTS}
    elements = {name: each[field.walls - first] for name, field in fields.items()}
    return joined_resistance([part.resistance for part in parts], elements)


def _body_part(
    body: BodyArrays,
    nodes: tuple[int, int],
    springs: tuple[int, int],
    edges: tuple[int, int],
    elements: tuple[int, int],
) -> BodyPart:
    """Return a body with the ranges of its nodes, springs, edges and elements."""
    mesh = body.body.mesh
    return BodyPart(
        body.body.name,
        slice(*nodes),
        slice(*springs),
        body.body.span,
        body.mesh.grid,
        body.bending,
        _cells(mesh, body.body.whole_placement),
        renumbered(body.thread, springs[0]),
        divided=body.mesh.tetrahedra,
        elements=slice(*elements),
        edges=slice(*edges),
        is_wall=body.body.is_wall,
        is_solid=body.mesh.volume is not None,
        regions=_regions(body.body),
        element_region=body.element_region,
        density=body.density,
        interfaces=body.interfaces,
        reserve=body.reserve,
    )


def _regions(body: Body) -> tuple[tuple[str, str], ...]:
    """Return the regions of a body with their tissues, as ``BodyPart`` has them."""
    parts = [
        ("", body.tissue),
        *((one.name, one.tissue or body.tissue) for one in body.regions),
    ]
    return tuple((name, "" if tissue is None else tissue.name) for name, tissue in parts)


def _cells(
    mesh: Generator | None, placement: Affine | None
) -> Callable[[], tuple[NDArray[np.int32], NDArray[np.int32]]] | None:
    """Return the function that computes the cells of a body; None if there are no cells.

    Faces of cells point outwards.
    """
    if not isinstance(mesh, Celled):
        return None
    if placement is None or not placement.is_mirrored:
        return mesh.cell_nodes
    from tissuec.meshes.placement import reversed_faces  # where bodies are mirrored

    def mirrored() -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        faces, inner = mesh.cell_nodes()
        return reversed_faces(faces), inner

    return mirrored


def _with_tools(network: Network, tools: Sequence[Tool], environment: Environment) -> Network:
    if environment.contact is None and not any(tool.shapes for tool in tools):
        return network
    from tissuec.compiler.contact.build import with_tools  # where something can touch

    return with_tools(network, tools, environment)


def _joints(scene: Scene, groups: Groups, findings: Findings) -> "list[JointArrays]":
    if not scene.declarations.of("joint"):
        return []
    from tissuec.compiler.bodies.joints import build_joints

    return build_joints(scene, groups, findings)


def _joint_part(joint: "JointArrays", springs: tuple[int, int]) -> JointPart:
    """Return a joint with the first and the last but one of its springs."""
    return JointPart(joint.joint.name, slice(*springs), joint.joint.span)


def _shifted(nodes: NDArray[np.int32], first: int) -> NDArray[np.int32]:
    """Return nodes of a body as those of the network."""
    return nodes + np.int32(first) if first else nodes


def _join_provenance(parts: Sequence[Provenance]) -> Provenance:
    starts = np.cumsum([0, *(len(part.origins) for part in parts)])
    index = [part.index + np.int32(start) for part, start in zip(parts, starts, strict=False)]
    origins = tuple(origin for part in parts for origin in part.origins)
    joined = np.concatenate([np.zeros(0, np.int32), *index])
    if len(joined) and (joined == joined[0]).all():
        joined = np.broadcast_to(joined[0], joined.shape)  # takes no room
    return Provenance(joined, origins)


def _place(bodies: Bodies) -> Mapping[str, PlacedBody]:
    placed: dict[str, PlacedBody] = {}
    sizes = {body.body.name: len(body.mesh.position) for body in bodies.built}
    node = spring = edge = 0
    for drawing in bodies.drawings:
        first = edge if drawing.is_elements else spring
        size = sizes.get(drawing.body.name, len(drawing.mesh.position))
        placed[key_of(drawing.body.name)] = PlacedBody(drawing, node, first, size)
        node += size
        if drawing.is_elements:
            edge += len(drawing.mesh.ends)
        else:
            spring += len(drawing.mesh.ends)
    return placed


def _events(script: Script) -> list[ScheduledAction]:
    """Return the events of a script, also those after conditions."""
    return [
        *script.events,
        *(event for trigger in script.triggers for event in trigger.events),
    ]


def _can_break(network: Network, script: Script) -> bool:
    """Return whether a spring or element can break or slip, from the start or later."""
    limits = (network.springs.strength, network.springs.crush)
    fields = (block.field for block in network.blocks)
    if any(field.breakable is not None for field in fields):
        return True
    if any(body.interfaces for body in network.bodies):
        return True
    return any(bool(np.isfinite(limit).any()) for limit in limits) or any(
        may_break(event.action, network) for event in _events(script)
    )


def _adds_energy(simulation: Simulation) -> bool:
    """Return whether the method is one whose energies must be booked to be judged."""
    named = simulation.integrator in INTEGRATORS
    return named and not INTEGRATORS[simulation.integrator].promises


def _script(
    scene: Scene, network: Network, conditions: Conditions, *, is_whole: bool
) -> Script:
    """Return the script of a scene; the arguments are those of ``_plan``."""
    block, findings = scene.declarations.single.get("script"), conditions.findings
    if block is None:
        return Script()
    groups, duration = conditions.groups, conditions.duration
    reader = ScriptReader(groups, scene.tools, conditions, scene.constants, duration=duration)
    script = reader.read(block.items)
    # What was left out may hold what is moved or released; nodes of tools follow all
    # bodies.
    shaped = all(tool.entries is not None for tool in scene.tools.values())
    if script.is_whole and (is_whole or not network.tools):
        held = check_holds(script.events, script.triggers, network.tools, shaped=shaped)
        findings.extend(held)
        findings.extend(check_inflations(script.events, script.triggers))
    actions = {id(event.action): event.action for event in _events(script)}
    for action in actions.values():  # each once, however often it is repeated
        if not (is_whole and shaped and isinstance(action, Demanding)):
            continue
        if flaw := action.flaw(network):
            findings.add("TIS309", flaw, action.span, hint=getattr(flaw, "hint", ""))
    return script


def _blocks(
    scene: Scene,
    network: Network,
    conditions: Conditions,
    plan: Plan,
    planes: "Sequence[WrittenPlane]",
    *,
    is_whole: bool,
) -> tuple[list[FieldBlock], Guides | None]:
    """Return glue, contact, forces, and the guides of planes; see ``_plan`` for arguments."""
    findings, contact, guides = conditions.findings, None, None
    found = list[FieldBlock]()
    if scene.embeddings and is_whole:
        from tissuec.compiler.bodies import gluing  # where there is any

        with findings.item():
            embedding = gluing.embedding_block(scene, network, conditions.groups, findings)
            gluing.refuse_held(
                embedding.field, (e.action for e in plan.every_event), network, findings
            )
            found.append(embedding)
            network = network.with_blocks(embedding)
    if network.phantoms:
        from tissuec.compiler.bodies.phantoms import parked  # where solids are cut

        found = [parked(network)]
        network = network.with_blocks(*found)
    if scene.peeling and is_whole:
        from tissuec.compiler.bodies.peeling import glue_blocks  # where there is any

        glued = glue_blocks(scene, network, conditions.groups, findings)
        found += glued
        network = network.with_blocks(*glued)
    with findings.item():
        tools = [tool for tool in scene.tools.values() if tool.may_touch]
        settles = any(e.time == 0.0 and isinstance(e.action, Settle) for e in plan.events)
        contact = None
        if scene.environment.contact is not None:
            from tissuec.compiler.contact.build import contact_of

            law = scene.environment
            contact = contact_of(
                network, tools, law, findings, balances=plan.balances, settles=settles
            )
    touching = None if contact is None else contact.block
    found += [] if touching is None else [touching]
    if scene.forces and is_whole:
        from tissuec.compiler.forces import force_blocks  # where there are any

        found += force_blocks(scene, network, conditions.groups, findings)
    if planes:
        from tissuec.compiler.symmetry import guides_of_planes, shared_contact

        guides = guides_of_planes(planes, network, plan, findings)
        if contact is not None and scene.environment.contact is not None:
            shared = shared_contact(contact, guides, scene.environment.contact).block
            found[found.index(touching)] = shared
    return found, guides


def _plan(
    scene: Scene,
    network: Network,
    conditions: Conditions,
    expects: Sequence[Expect],
    *,
    is_whole: bool,
) -> Plan:
    """Return the plan of a scene.

    Args:
        expects: What is expected of the run.
        is_whole: Whether ``network`` has all bodies that the groups of ``conditions`` know.
    """
    groups, findings, duration = conditions.groups, conditions.findings, conditions.duration
    single = scene.declarations.single
    script = _script(scene, network, conditions, is_whole=is_whole)
    ties = (event.action for event in _events(script) if isinstance(event.action, Tie))
    outputs = OutputReader(
        groups, conditions, scene.constants,
        nodes=network.body_nodes, duration=duration,
        idle=idle_knots(network, {tie.group.name for tie in ties}),
    )  # fmt: skip
    output = outputs.read(single["output"].items if "output" in single else ())
    expectations: list[Expectation] = []
    for item in expects:
        with findings.item():
            expectations.append(conditions.expectation(item))
    plan = Plan(
        simulation=scene.simulation,
        gravity=scene.environment.entries.gravity,
        drag=scene.environment.entries.damping,
        events=tuple(script.events),
        triggers=tuple(script.triggers),
        output=output,
        expectations=tuple(expectations),
        needs_ledger=conditions.needs_ledger or _adds_energy(scene.simulation),
        breakable=_can_break(network, script) or bool(scene.peeling),
    )
    if outputs.asked and is_whole and not findings.errors:
        from tissuec.compiler.output.frame_fields import check_fields  # where there are any

        kinds = {force.kind for force in scene.forces.values()}
        touched = scene.environment.touched
        check_fields(outputs.asked, network, plan, kinds, touched, findings)
    return plan
