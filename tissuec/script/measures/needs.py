"""Needs of measures and fields, declared once for messages and tables.

A measure names what it needs in ``needs``, and a field of frames likewise. What a body lacks by
its kind is an error where it is measured; what a scene lacks, such as a pressure, a warning.
"""

from collections.abc import Mapping, Sequence
from typing import Literal, TypeAlias

from msgspec import Struct

#: What can be measured: bodies by what they are made of, and what is chosen from them.
Kind: TypeAlias = Literal[
    "net", "thread", "wall", "solid", "nodes of a set", "springs of a set", "tool"
]
BODIES: tuple[Kind, ...] = ("net", "thread", "wall", "solid")
#: Kinds in the order of tables, as they are headed there.
KINDS: Mapping[Kind, str] = {
    "net": "net of springs", "thread": "thread, bars", "wall": "wall of elements",
    "solid": "solid of elements", "nodes of a set": "set of nodes",
    "springs of a set": "set of springs, joint", "tool": "tool",
}  # fmt: skip
YES = "yes"
WHOLE, STRAINED = "of whole elements", "with springs or whole elements"
_PRESSED = "if it is pressed or keeps its volume"
_OUTSIDE = "if touched, joined or pressed"
_HELD_SET = "if held, pushed, touched, joined or pressed"
_FREE = "unless it is fixed"
_DIVIDED = "if it is cut or may rupture"


class Need(Struct, frozen=True):
    """Something without which a measure is always 0.

    Attributes:
        kinds: Where it is found, and on which condition; other kinds never have it.
        text: What it is, after "needs", where a body lacks it by its kind.
        absent: Why A is without it, where the scene decides.
        hint: A way out.
        result: What the measure is then.
    """

    kinds: Mapping[Kind, str]
    text: str = ""
    absent: str = ""
    hint: str = ""
    result: str = "is always 0"


NEEDS: Mapping[str, Need] = {
    "springs": Need(
        {"net": YES, "thread": YES, "nodes of a set": "with springs in it",
         "springs of a set": YES},
        text="springs that bear a tension, and edges of elements bear none",
        hint="measure stress(A) in elements, or force(A) of nodes that are held",
    ),
    "elements": Need(
        {"wall": YES, "solid": YES, "nodes of a set": "of elements", "tool": YES},
        text="nodes of solid elements",
        hint="solids consist of elements if their tissue has a Young's modulus",
    ),
    "whole elements": Need(
        {"wall": YES, "solid": YES, "nodes of a set": WHOLE, "tool": YES},
        text="elements all of whose nodes are in A",
        hint="name a body, or a set with all nodes of some elements; stress(A) is the mean "
        "around any nodes",
    ),
    "strained": Need(
        {**dict.fromkeys(KINDS, YES), "nodes of a set": STRAINED},
        text="springs, or elements all of whose nodes are in A",
        hint="name a body, or a set with all nodes of some elements; length(A) tells how far "
        "edges of elements along a line are stretched",
    ),
    "cells": Need(
        dict.fromkeys(KINDS, "if its volume is preserved"),
        absent="nothing preserves the volume of A",
        hint="write hydrostatic pressure, which elements have",
        result="has no value",
    ),
    "inside": Need(
        {"net": "unless it is flat", "wall": "unless it is flat", "solid": YES},
        text="a body that encloses a volume",
        hint="threads, bars and flat sheets enclose none",
    ),
    "pressure": Need(
        {"net": _PRESSED, "wall": _PRESSED, "solid": YES, "nodes of a set": "of elements",
         "tool": YES},
        text="a body, or nodes of solid elements",
        absent="nothing presses A or preserves its volume",
        hint="for example: at 0 s: press inside of A with 2 kPa",
    ),
    "load": Need(
        dict.fromkeys(KINDS, "if it is pressed"),
        absent="no action presses A by this name",
        hint="name what the script presses",
    ),
    "support": Need(
        {"net": _OUTSIDE, "thread": _OUTSIDE, "wall": _OUTSIDE, "solid": _OUTSIDE,
         "nodes of a set": YES, "tool": YES},
        absent="inner forces of whole bodies cancel, and no other one acts on A",
        hint="name the set of nodes that is held, such as one that is fixed",
    ),
    "hold": Need(
        {**dict.fromkeys(KINDS, YES), "nodes of a set": _HELD_SET},
        absent="nothing holds, pushes, joins or touches A",
        hint="name the set that is fixed, held or moved",
        result="comes from the weight and inertia of its nodes alone",
    ),
    "motion": Need(
        {**dict.fromkeys(KINDS, YES), "nodes of a set": _FREE},
        absent="A is fixed at 0 s and never freed",
        hint="name nodes that can move",
    ),
    "lines": Need(
        {"net": YES, "thread": YES, "nodes of a set": YES, "springs of a set": YES},
        text="springs that form a line, and the edges of elements fill their body",
        hint="name nodes along one edge: set edge = nodes of BODY where y == 0 mm and "
        "z == 0 mm; or measure the distance(A, B) of two sets",
    ),
    "sections": Need(
        {"solid": "if it is cut or tears by faces"},
        text="a solid of elements",
        absent="no blade divides elements of A, and it has no rupture by faces",
        hint="cut a solid, or write rupture by faces in it; gap(A) is taken of all bodies",
    ),
    "division": Need(
        {**dict.fromkeys(KINDS, _DIVIDED), "tool": YES},
        absent="A is in one piece, and nothing cuts it or lets it rupture",
        hint="cut it, or write rupture is allowed in its body; between two sets, measure "
        "distance(A, B)",
    ),
    "energy": Need(
        {**dict.fromkeys(KINDS, YES), "nodes of a set": "with springs or elements in it"},
        absent="no spring and no element has all of its nodes in A",
        hint="name a body, or a set with all nodes of some springs or elements",
    ),
    "faces": Need(
        dict.fromkeys(KINDS, "if contact acts on faces"),
        absent="contact acts on nodes, which have no area",
        hint="remove: contact places is nodes, or use elements",
    ),
    "yielding": Need(
        dict.fromkeys(KINDS, "if it yields"),
        absent="nothing in A yields",
        hint="give the tissue a yield stress, or one of springs a yield force",
    ),
}  # fmt: skip

_HELD = "what it holds or consists of"
#: Kinds that can be named, by what a measure takes.
TAKEN: Mapping[str, Mapping[Kind, str]] = {
    "nodes": {**dict.fromkeys((*BODIES, "nodes of a set"), YES), "tool": _HELD},
    "springs": dict.fromkeys((*BODIES, "nodes of a set", "springs of a set"), YES),
    "any": {**dict.fromkeys(KINDS, YES), "tool": _HELD},
    "body": dict.fromkeys(BODIES, YES),
    "cut faces": {"solid": YES},
    "jaws": {"tool": "forceps with jaws"},
}


def meaning(takes: str, needs: Sequence[str], kind: Kind) -> str:
    """Return where something has a meaning for a kind: "yes", a condition, or "" for nowhere.

    Args:
        takes: What it can be taken of.
        needs: Names of ``NEEDS``.
    """
    found = [TAKEN[takes].get(kind, ""), *(NEEDS[one].kinds.get(kind, "") for one in needs)]
    if not all(found):
        return ""
    return ", ".join(dict.fromkeys(one for one in found if one != YES)) or YES
