"""Usual names of instruments, and the kinds of tools that act as they do."""

from collections.abc import Mapping

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
    **dict.fromkeys(
        ("scalpel", "knife", "blade", "shears", "cutter", "lancet", "saw"), ("scissors",)
    ),
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
