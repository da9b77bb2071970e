"""Kinds of tools, each with its entries and shapes, and usual names of instruments.

A member is a ``Struct`` whose fields are the entries of ``tool NAME { kind is … }``. Its shapes
move rigidly with the tool, except that jaws may close.
"""

from collections.abc import Mapping
from typing import ClassVar, Literal, Protocol

import numpy as np
from msgspec import Struct

from tissuec.core.fields import DirectionIfAny, LengthIfAny
from tissuec.core.registry import Family
from tissuec.model.network import Floats


class Shape(Struct, frozen=True, eq=False):
    """A capsule (all points near a line), a half-space behind a plane, an opening, or an edge.

    Attributes:
        kind: Of all of them; openings and edges touch nothing.
        points: Ends of an edge, or of the line of a capsule, equal for a sphere; a point of a
            plane, or of an opening, and one straight in front of it [m], shape (2, 3).
        radius: Of a capsule or an opening, and of an edge as it is drawn [m].
        part: What it is called in messages and logs, such as "upper jaw"; empty for the whole.
    """

    kind: Literal["capsule", "plane", "opening", "edge"]
    points: Floats
    radius: float = 0.0
    part: str = ""


def capsule(start: Floats, stop: Floats, radius: float, part: str = "") -> Shape:
    """Return all points within a radius of the line between two points.

    Args:
        start: One end of the line [m], shape (3,).
        stop: The other end [m], shape (3,).
        radius: The radius [m].
        part: Name of the part of the tool, such as a jaw.
    """
    return Shape("capsule", np.array([start, stop]), radius, part)


class ToolKind(Protocol):
    """Interface of members of ``TOOLS``; their fields are entries in the language."""

    def shapes(self) -> tuple[Shape, ...]:
        """Return its shapes as drawn; nothing if it only acts on nodes by name.

        Raises:
            ValueError: The entries are impossible together, and why.
        """
        ...


class HandTool(Struct, frozen=True, eq=False, kw_only=True):
    """A tool with a handle, which has no effect on a run.

    Attributes:
        shaft: in pictures: direction from the tissue to the handle; without it, one that leads
            out of the tissue
    """

    shaft: DirectionIfAny = None

    def check_shaft(self) -> None:
        """Check the direction of the shaft.

        Raises:
            ValueError: It is zero.
        """
        if self.shaft is not None and not np.any(self.shaft):
            raise ValueError('"shaft" cannot be (0, 0, 0)')


class NamedTool(HandTool, frozen=True, eq=False, kw_only=True):
    """A tool that acts on nodes or springs by name, and is drawn where it does.

    Attributes:
        size: in pictures: about the length of what it works with, a seventh of the whole;
            without it, as the tissue needs
    """

    grasps: ClassVar[bool] = False  # whether it can hold nodes

    size: LengthIfAny = None

    def shapes(self) -> tuple[Shape, ...]:
        """Return nothing: it touches no tissue.

        Raises:
            ValueError: The direction of the shaft is zero.
        """
        self.check_shaft()
        return ()


TOOLS: Family[type[ToolKind]] = Family("tissuec.script.tools", "tool")


#: Groups of kinds that sentences can name instead of a kind.
GROUPS = ("grasping", "cutting")


def kinds_in(group: str) -> tuple[str, ...]:
    """Return the kinds of tools in a group; the kind itself where it is none.

    Tools of "grasping" hold nodes by name, those of "cutting" can be named in a cut.
    """
    if group == "grasping":
        return tuple(kind for kind in TOOLS if getattr(TOOLS[kind], "grasps", False))
    return ("scissors", "scalpel") if group == "cutting" else (group,)


#: Kinds by a name in small letters, the best one first.
KINDS_OF: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(
        ("haemostat", "hemostat", "artery forceps", "bulldog", "clip"), ("clamp", "forceps")
    ),
    **dict.fromkeys(
        ("grasper", "gripper", "tweezers", "pincers", "pliers", "dissector", "jaws", "hand"),
        ("forceps",),
    ),
    **dict.fromkeys(("needle holder", "needle driver"), ("needle", "forceps")),
    **dict.fromkeys(("knife", "blade", "shears", "cutter", "lancet", "saw"), ("scissors",)),
    **dict.fromkeys(("retractor", "spatula", "lever", "elevator"), ("hook", "probe")),
    **dict.fromkeys(
        ("rod", "ball", "sphere", "stick", "finger", "indenter", "palpator", "trocar"),
        ("probe",),
    ),
    **dict.fromkeys(
        ("syringe", "irrigator", "catheter", "cannula", "tube", "jet"), ("nozzle",)
    ),
    **dict.fromkeys(("table", "floor", "wall", "bed", "plate", "support"), ("plane",)),
}
