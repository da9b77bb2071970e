"""How to cite the scene of a run, the program, and the method."""

from collections.abc import Iterator

from tissuec.core.citation import PAPER, SOFTWARE
from tissuec.view.report.content import ReportContent
from tissuec.view.report.markup import Content, Section, pairs


def section(content: ReportContent) -> Section:
    """Return the citations of the scene, the program and the method."""
    return Section("cite", "Cite as", pairs(_sources(content)))


def _sources(content: ReportContent) -> Iterator[tuple[Content, Content]]:
    manifest = content.manifest
    if text := manifest.get("cite"):
        yield "scene", text
    elif author := manifest.get("author"):
        place = ", ".join(filter(None, (manifest.get("laboratory"), manifest.get("licence"))))
        yield "scene", f"{author}: {content.title}{f' ({place})' if place else ''}."
    yield "program", SOFTWARE
    yield "method", PAPER
