"""Entries of tissues that are set from outside, but of which no body is made."""

from collections.abc import Iterator

from tissuec.core.errors import Diagnostic
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene.entry_overrides import SET
from tissuec.scene.model import Scene, Tissue


def idle_overrides(scene: Scene) -> Iterator[Diagnostic]:
    """Yield W505: an entry of a tissue that is set, and reaches no body and no joint.

    Args:
        scene: Without errors, so that all bodies are there.
    """
    used = tissues_in_use(scene)
    reached = {span for tissue in used for span in _entries(tissue)}
    names = {tissue.name for tissue in used}
    for declared in scene.declarations.of("tissue").values():
        if declared.name.text in names or not isinstance(declared.item, s.Block):
            continue
        for item in declared.item.items:
            if item.span.source.name == SET and item.span not in reached:
                yield Diagnostic(
                    "W505",
                    f"no body is made of {declared.name.text}, so this has no effect",
                    item.span,
                    f"tissues in use: {', '.join(sorted(names)) or 'none'}",
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
