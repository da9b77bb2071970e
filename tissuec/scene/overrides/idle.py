"""Entries of tissues that are set from outside, but of which no body is made."""

from collections.abc import Iterator

from tissuec.core.errors import Diagnostic, Note
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene.model import Scene, Tissue
from tissuec.scene.overrides.entries import SET
from tissuec.scene.reading.graded import graded_by


def idle_overrides(scene: Scene) -> Iterator[Diagnostic]:
    """Yield W505: an entry of a tissue that is set, and reaches no body and no joint.

    Args:
        scene: Without errors, so that all bodies are there.
    """
    used = tissues_in_use(scene)
    reached = {span for tissue in used for span in _entries(tissue)}
    names = {tissue.name for tissue in used}
    for declared in scene.declarations.of("tissue").values():
        if not isinstance(declared.item, s.Block):
            continue
        if declared.name.text in names:
            yield from _graded(scene, declared.name.text, declared.item)
            continue
        for item in declared.item.items:
            if item.span.source.name == SET and item.span not in reached:
                yield Diagnostic(
                    "W505",
                    f"no body is made of {declared.name.text}, so this has no effect",
                    item.span,
                    f"tissues in use: {', '.join(sorted(names)) or 'none'}",
                )


def _graded(scene: Scene, tissue: str, block: s.Block) -> Iterator[Diagnostic]:
    """Yield W505: numbers of a tissue that are set, of which a body has a formula of the place.

    Args:
        scene: With the bodies.
        tissue: Its name.
        block: Of the tissue.
    """
    for item in block.items:
        if item.span.source.name != SET or not isinstance(item, s.Assign):
            continue
        one = graded_by(scene.bodies.values(), tissue, item.name.key)
        if one is not None:
            yield Diagnostic(
                "W505",
                f"the {one.quantity.name} of {tissue} depends on the place, so this has no "
                "effect there",
                item.span,
                "change the formula instead, for example by a param in it",
                (Note("the formula", one.span),),
            )


def tissues_in_use(scene: Scene) -> tuple[Tissue, ...]:
    """Return the tissues that some body or joint is made of, each once."""
    tissues = {joint.tissue.name: joint.tissue for joint in scene.joints.values()}
    for body in scene.bodies.values():
        tissues |= {tissue.name: tissue for tissue in body.tissues}
    return tuple(tissues.values())


def _entries(tissue: Tissue) -> Iterator[Span]:
    """Yield where the entries are written that a tissue has or inherits."""
    evidence = (*tissue.known, *tissue.curves)
    laws = tissue.written_laws.values()
    for several in (tissue.facts, tissue.given.values(), laws, evidence):
        yield from (one.span for one in several)
