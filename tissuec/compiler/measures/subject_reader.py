"""Subjects of measures: sets, bodies, tools and points, and what each measure takes."""

from typing import NoReturn

import numpy as np

from tissuec.compiler.measures.subjects import has_by_kind
from tissuec.compiler.sets import Groups, unnamed
from tissuec.core.errors import enumerated
from tissuec.core.hints import alternatives
from tissuec.core.source import Span
from tissuec.core.units import LENGTH, show
from tissuec.lang import syntax as s
from tissuec.scene.model import Scene
from tissuec.scene.sentences import KINDS
from tissuec.script.measures import MEASURES, Measure, Subject
from tissuec.script.measures.cut_faces import CUT_FACES
from tissuec.script.measures.needs import NEEDS, STRAINED, WHOLE, YES
from tissuec.script.verbs.cut import SCISSORS


class SubjectReader:
    """Reads what measures are taken of.

    Args:
        groups: The sets and bodies.
        scene: The scene.
    """

    def __init__(self, groups: Groups, scene: Scene):
        self.groups, self.tools = groups, scene.tools
        self.scope, self.findings = scene.constants, scene.constants.findings
        self.touching = scene.environment.contact is not None

    def is_subject(self, name: s.Name) -> bool:
        """Return whether a name is a tool, a set, a body or a joint."""
        return name.key in self.tools or self.groups.is_known(name)

    def refuse_unknown(self, argument: s.Argument) -> NoReturn:
        """Reject an argument that is no subject."""
        if isinstance(argument.value, s.Name):
            tools = (tool.name for tool in self.tools.values())
            self.groups.refuse_parted(argument.value, tools)
        if (name := s.as_name(argument.value)) is not None and name.listed:
            self._refuse_union(name)
        self._no_subject(argument.value.span.text, argument.span)

    def _refuse_union(self, union: s.Name) -> NoReturn:
        """Reject a union by the first of its names that is neither a set nor a body."""
        name = next(one for one in union.listed if not self.groups.is_known(one))
        if name.key not in self.tools:
            self._no_subject(name.text, name.span)
        message = f'"{name.text}" is a tool; a union contains sets or bodies'
        hint = f"measure {name.text} on its own"
        self.findings.reject("TIS312", message, name.span, hint=hint)

    def _no_subject(self, text: str, span: Span) -> NoReturn:
        self.findings.pass_over_doubtful(s.key_of(text))
        if text in KINDS:
            unnamed(text, span, self.findings)
        known = [tool.name for tool in self.tools.values()]
        known += self.groups.names_of_sets()
        known += self.groups.names_of_parts()
        self.findings.reject(
            "TIS301",
            f'there is no set, body or tool called "{text}"',
            span,
            hint=alternatives(
                text,
                known,
                what="sets, bodies, joints and tools"
                if self.groups.named_joints
                else "sets, bodies and tools",
            ),
        )

    def subject(self, measure: type[Measure], name: s.Name) -> Subject:
        """Return a tool, a set or a body as the subject of a measure, or reject it."""
        none = np.zeros(0, dtype=np.int64)
        if getattr(measure, "of_contact", False) and not self.touching:
            self.findings.reject(
                "TIS702",
                f"{measure.form} is always 0: contact is off",
                name.span,
                hint="write contact is tools only, or contact is everywhere, in environment",
            )
        self._refuse_others(measure, name)
        if name.key in self.tools:
            tool = self.tools[name.key]
            if measure.takes == "springs":
                self.findings.reject(
                    "TIS702", f"{measure.form} needs springs, not a tool", name.span
                )
            feels = getattr(measure, "feels_blades", False) and tool.kind == SCISSORS
            if not tool.holds_nodes and not feels:
                self.findings.reject(
                    "TIS405",
                    f"{tool.name} is {tool.kind} and holds no nodes to measure",
                    name.span,
                    hint="measure a set or a body",
                )
            return Subject(tool.name, None, none)
        if not self.groups.is_known(name):
            if name.listed:
                self._refuse_union(name)
            self._no_subject(name.text, name.span)
        if self.groups.is_springs(name):
            if measure.takes == "nodes":
                self.findings.reject(
                    "TIS702", f"{measure.form} needs nodes, not springs", name.span
                )
            springs = self.groups.springs(name)
            return Subject(springs.name, none, springs.indices, is_springs=True)
        nodes = self.groups.nodes(name)
        return Subject(nodes.name, nodes.indices, self.groups.springs(name).indices)

    def point(self, measure: type[Measure], name: s.Name, at: s.Clause) -> Subject:
        """Return a point of a body as a subject, or reject it."""
        if not getattr(measure, "at_points", False):
            known = [m.form for m in MEASURES.values() if getattr(m, "at_points", False)]
            message = f"{measure.form} has no value at a point"
            hint = f"{enumerated(known, 'and')} have one"
            self.findings.reject("TIS702", message, at.span, hint=hint)
        placed = self.groups.bodies.get(name.key)
        if placed is None or not placed.drawing.mesh.elements:
            known = [b.drawing.body.name for b in self.groups.bodies.values()
                     if b.drawing.mesh.elements]  # fmt: skip
            hint = alternatives(name.text, known, what="there are")
            message = "a point is one of a body of elements"
            self.findings.reject("TIS702", message, name.span, hint=hint)
        value = self.scope.evaluate(at.value)
        if not value.is_vector or value.dimension != LENGTH:
            self.findings.reject(
                "TIS702", "a point is a vector with a unit, of where it is as drawn", at.span,
                hint="for example: at (1, 2, 3) mm",
            )  # fmt: skip
        from tissuec.compiler.measures.points import place_of_point  # where it is asked
        from tissuec.geometry.inside import distance_from

        mesh, body = placed.drawing.mesh, placed.drawing.body
        place = place_of_point(mesh.elements, mesh.position, value.amount)
        if place.is_outside:
            beside = distance_from(value.amount, mesh.position[mesh.skin])
            self._refuse_outside(beside, body.name, at)
        nodes = placed.nodes[place.nodes]
        return Subject(
            f"{body.name} {at.span.one_line}", nodes, nodes[:0], False, place.weights,
            place.of_points,
        )  # fmt: skip

    def _refuse_outside(self, beside: float, body: str, at: s.Clause) -> NoReturn:
        message = f"this point is {show(beside, LENGTH, digits=3)} outside of {body} as drawn"
        hint = (
            "write a point inside of an element; corners of curved surfaces lie outside of them"
        )
        self.findings.reject("TIS702", message, at.value.span, hint=hint)

    def _refuse_others(self, measure: type[Measure], name: s.Name) -> None:
        """Reject subjects that never have the measured tension, stress, volume or grip."""
        if not self.is_subject(name):
            return
        needed, known = "", list[str]()
        if measure.takes in ("body", CUT_FACES):
            needed, known = "a body", self.groups.names_of_bodies()
        elif measure.takes == "jaws":
            forceps = [tool for tool in self.tools.values() if tool.may_be("forceps")]
            known = [tool.name for tool in forceps if tool.shapes or tool.entries is None]
            needed = "forceps with jaws"
        if needed and not any(s.key_of(each) == name.key for each in known):
            hint = alternatives(name.text, known, what="there are")
            message = f"{measure.form} needs {needed}"
            self.findings.reject("TIS702", message, name.span, hint=hint)
        for key in getattr(measure, "needs", ()):
            need, bodies = NEEDS[key], self.groups.bodies.values()
            if not need.text or self._has(key, name):
                continue
            own = self.groups.bodies.get(name.key)
            if not all(one.drawing.body.is_whole for one in ([own] if own else bodies)):
                self.findings.stop()  # its tissue, which makes it a solid or not, was rejected
            known = [b.drawing.body.name for b in bodies if has_by_kind(key, b.drawing)]
            others = alternatives(name.text, known, what="there are")
            # Where any set will do, it is one of the body that is meant.
            is_of_sets = need.kinds.get("nodes of a set") in (YES, WHOLE, STRAINED)
            hint = need.hint if is_of_sets else others or need.hint
            message = f"{measure.form} needs {need.text}"
            self.findings.reject("TIS702", message, name.span, hint=hint)

    def _has(self, need: str, name: s.Name) -> bool:
        """Return whether a subject has by its kind what a measure needs."""
        bodies = self.groups.bodies
        if name.key in bodies:
            return has_by_kind(need, bodies[name.key].drawing)
        if name.key in self.tools:
            if "tool" not in NEEDS[need].kinds or need == "strained":
                return True  # reported elsewhere, or known when it holds something
            return any(bool(one.drawing.mesh.elements) for one in bodies.values())
        lines = self.groups.springs(name).indices
        if need in ("springs", "strained") and len(self.groups.own_springs(lines)):
            return True
        if need in ("springs", "strained", "whole elements"):
            is_whole = need != "springs" and not self.groups.is_springs(name)
            return is_whole and self.groups.has_whole_elements(self.groups.nodes(name).indices)
        if self.groups.is_springs(name) or NEEDS[need].kinds.get("nodes of a set") == YES:
            return True  # springs are reported elsewhere
        return self.groups.has_elements(self.groups.nodes(name).indices)
